"""GAPartNet: 20,000 points of a view in the camera's frame, with the part that each lies on and its place in that part's box."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...annotate.cameras import Cameras
from ...annotate.states import joint_values, read_states
from ...annotate.views import make_views
from ...records import dataclass
from ...robot.robots import Robots
from ..clouds import norms, similarity_error
from ..entry import Entry
from ..findings import Findings, read_table
from ..pictures import part_colours
from ..pth import pth_bytes, read_pth
from .parts import CLASSES, GAPart, gaparts, owners

if TYPE_CHECKING:
    from ...runtime.batch import Batch

ROOT, POINTS, NONE = "GAPartNet_All", 20000, -100
EVERY = ("train", "val", "test_intra", "test_inter")
STATES = "rest,random:1"
CAMERAS = Cameras(
    count=2, width=400, height=400, fov=35.0, azimuth=(-60.0, 60.0), elevation=(10.0, 60.0), points=POINTS
)
_KINDS = (np.float32, np.float32, np.int32, np.int32, np.float32, np.int32)
_NAMES = ("points", "colours", "classes", "instances", "coordinates", "pixels")


@dataclass(frozen=True, slots=True)
class Shot:
    """One view: what a ``pth`` holds, and where the cloud's box has its ``center`` and how far it reaches (``radius``)."""

    name: str
    arrays: tuple[np.ndarray, ...]
    radius: float
    center: np.ndarray


def _shots(batch: Batch, entry: Entry) -> Iterator[tuple[str, Shot]]:
    """The split and the views of each object that show a part; two views in each of two states of the joints."""
    assert entry.term is not None
    values = joint_values(batch, read_states(STATES))
    cloud = make_views(batch, CAMERAS, values).cloud
    robots, parts = Robots(batch, physics=False), gaparts(batch, entry.term)
    poses = [batch.pose(state) for state in values]
    first = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    for i, number in enumerate(batch.numbers.tolist()):
        colour = part_colours(robots, i)
        for state, (turn, shift) in enumerate(poses):
            for view in range(CAMERAS.count):
                at = i, state, view
                link = cloud["link"][at].astype(np.int64)
                row = first[i] + link
                still = np.einsum("nji,nj->ni", turn[row], cloud["points"][at] - shift[row])
                kind, instance, npcs = _labels(parts[i], link, cloud["instance"][at].astype(np.int64), still)
                if (instance >= 0).any():
                    place = cloud["camera"][at].astype(np.float64)
                    center = (place.min(axis=0) + place.max(axis=0)) / 2
                    radius = float(norms(place - center).max())
                    held = (
                        (place - center) / radius,
                        colour[cloud["instance"][at]],
                        kind,
                        instance,
                        npcs,
                        cloud["pixel"][at],
                    )
                    arrays = tuple(np.asarray(a, dtype=t) for a, t in zip(held, _KINDS, strict=True))
                    name = f"{entry.term.name}_{entry.token(number)}_{view:02d}_{state:03d}"
                    yield entry.split(number), Shot(name, arrays, radius, center)


def _labels(
    parts: Sequence[GAPart], link: np.ndarray, instance: np.ndarray, still: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Classes (n,), instances (n,) numbered as they show themselves, and coordinates (n, 3) of points at joint values 0."""
    kind, which, npcs = np.zeros(len(link), np.int64), np.full(len(link), NONE), np.zeros((len(link), 3))
    owner = owners(parts, link, instance)
    for place, k in enumerate(np.unique(owner[owner >= 0]).tolist()):
        at = owner == k
        kind[at], which[at], npcs[at] = parts[k].kind, place, parts[k].npcs(still[at])
    return kind, which, npcs


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """``pth/``, ``meta/`` (radius and centre) and ``gt/`` (1000 times the class and the instance) of each view."""
    for split, shot in _shots(batch, entry):
        root = f"{ROOT}/{_folder(entry, split)}"
        kind, instance = shot.arrays[2], shot.arrays[3]
        told = np.where(instance >= 0, 1000 * kind + instance, NONE)
        yield f"{root}/pth/{shot.name}.pth", pth_bytes(shot.arrays)
        yield f"{root}/meta/{shot.name}.txt", _lines("%.17g", [shot.radius, *shot.center.tolist()])
        yield f"{root}/gt/{shot.name}.txt", _lines("%d", told.tolist())


def _folder(entry: Entry, split: str) -> str:
    """The folder of a split. What is tested of a category is ``inter`` where none of it is for training."""
    test = "test_intra" if entry.shares[0] else "test_inter"
    return test if split == "test" else split


def _lines(form: str, values: Sequence[float]) -> bytes:
    return "".join(f"{form}\n" % value for value in values).encode()


def index(entries: Sequence[Entry]) -> dict[str, bytes]:
    """The folders of all splits, and the list of views without a part, of which there are none: loaders want it to say something."""
    folders = {f"{ROOT}/{split}/{kind}/": b"" for split in EVERY for kind in ("pth", "meta", "gt")}
    return folders | {"nopart.txt": b"none\n"}


# ---------------------------------------------------------------- reading back


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as loaders do, and compare with the model."""
    found.of("nopart.txt", bool((folder / "nopart.txt").read_text("utf-8").strip()), "empty, which loaders cannot read")
    for split, shot in _shots(batch, entry):
        root, name = folder / ROOT / _folder(entry, split), shot.name
        arrays = read_pth(root / "pth" / f"{name}.pth")
        if not found.of(name, len(arrays) == len(_KINDS), f"{len(arrays)} arrays, not {len(_KINDS)}"):
            continue
        for what, read, model in zip(_NAMES, arrays, shot.arrays, strict=True):
            found.of(name, read.dtype == model.dtype, f"{what} are {read.dtype}, not {model.dtype}")
            found.near(name, what, read, model, 1e-6)
        place, _, kind, instance, npcs, _ = arrays
        if place.shape == (POINTS, 3) and kind.shape == instance.shape == (POINTS,) and npcs.shape == (POINTS, 3):
            _traps(name, place, kind, instance, npcs, found)
        else:
            found.of(name, False, f"{len(place)} points, where readers need {POINTS}")
        meta = read_table(root / "meta" / f"{name}.txt", np.float64)
        told = read_table(root / "gt" / f"{name}.txt", np.int64)
        found.near(name, "radius and centre", meta, np.array([shot.radius, *shot.center]), 1e-9)
        found.same(name, "numbers of gt", told, np.where(instance >= 0, 1000 * kind + instance, NONE))


def _traps(
    name: str, place: np.ndarray, kind: np.ndarray, instance: np.ndarray, npcs: np.ndarray, found: Findings
) -> None:
    """What loaders do not notice."""
    radius = float(norms(place.astype(np.float64)).max())
    found.of(name, abs(radius - 1) < 1e-5, f"the farthest point is at {radius:.4f}, not at 1")
    found.of(name, 0 <= kind.min() and kind.max() < len(CLASSES), "a class that there is not")
    shown = np.unique(instance[instance != NONE])
    found.of(name, len(shown) > 0, "no part, which loaders cannot take")
    found.of(name, shown.tolist() == list(range(len(shown))), "instances are not numbered from 0 on")
    found.of(name, bool(((kind > 0) == (instance >= 0)).all()), "a class without an instance, or the reverse")
    found.of(name, float(np.abs(npcs).max()) <= 0.5, "coordinates beyond 0.5")
    for k in shown.tolist():
        at = instance == k
        if not found.of(name, len(np.unique(kind[at])) == 1, f"instance {k} has several classes"):
            continue
        off = similarity_error(npcs[at].astype(np.float64), place[at].astype(np.float64))
        found.of(name, off < 5e-3, f"coordinates of instance {k} are not its points moved and scaled: {off:.4f} off")
