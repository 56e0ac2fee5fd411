"""Completion: whole clouds and what a depth camera sees of them, as PCN has them, and whole clouds as ShapeNet-55 has them."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from ..annotate.cameras import Cameras
from ..annotate.views import see_points
from .clouds import draw, fit_diagonal, shapenet_axes
from .entry import SPLITS, Entry
from .findings import Findings
from .pcd import pcd_bytes, read_pcd

if TYPE_CHECKING:
    from ..runtime.batch import Batch

WHOLE, PARTIAL, LEAST = 16384, 4096, 2048  # PoinTr pads what has fewer than 2,048 points with zeros
_WHOLE_55 = 8192
VIEWS = {"train": 8, "val": 1, "test": 1}
# PCN's depth images: 160 x 120 pixels, a focal length of 100, one unit from the middle of an object whose diagonal is 1
_FOV = 2 * float(np.degrees(np.arctan(60 / 100)))
_AWAY = 2 * float(np.sin(np.radians(_FOV / 2)))
_CAMERAS = Cameras(
    count=max(VIEWS.values()),
    width=160,
    height=120,
    fov=_FOV,
    azimuth=(-180.0, 180.0),
    elevation=(-90.0, 90.0),
    distance=(_AWAY, _AWAY),
    points=PARTIAL,
)


def clouds(batch: Batch) -> tuple[np.ndarray, np.ndarray]:
    """Whole clouds (B, n, 3) and partial ones (B, V, k, 3), in ShapeNet's axes, the whole cloud's diagonal 1."""
    whole = draw(batch, WHOLE).position
    fit = fit_diagonal(whole)
    seen = see_points(batch, _CAMERAS).astype(np.float64)
    placed = shapenet_axes(fit.apply(whole)), shapenet_axes(fit.apply(seen))
    return placed[0].astype(np.float32), placed[1].astype(np.float32)


def pcn_files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """``<split>/complete/<synset>/<object>.pcd`` and ``<split>/partial/<synset>/<object>/00.pcd``, eight of a training object."""
    assert entry.term is not None
    tax = entry.term.data["synset"]
    for number, whole, seen in zip(batch.numbers.tolist(), *clouds(batch), strict=True):
        split, token = entry.split(number), entry.token(number)
        yield f"{split}/complete/{tax}/{token}.pcd", pcd_bytes(whole)
        for place, view in _partial(split, tax, token).items():
            yield place, pcd_bytes(seen[view])


def _partial(split: str, tax: str, token: str) -> dict[str, int]:
    """The files of partial clouds and the view that each is: PoinTr reads a folder of them, SnowflakeNet's test a file."""
    named = {f"{split}/partial/{tax}/{token}/{view:02d}.pcd": view for view in range(VIEWS[split])}
    return named | ({f"{split}/partial/{tax}/{token}.pcd": 0} if split == "test" else {})


def pcn_index(entries: Sequence[Entry]) -> dict[str, bytes]:
    """``PCN.json``: the objects of each split, by class."""
    classes: dict[str, dict[str, Any]] = {}
    for entry in entries:
        assert entry.term is not None
        tax = entry.term.data["synset"]
        own = classes.setdefault(
            tax, {"taxonomy_id": tax, "taxonomy_name": entry.term.name, **{split: [] for split in SPLITS}}
        )
        for split in SPLITS:
            own[split] += entry.tokens(split)
    return {"PCN.json": (json.dumps([classes[tax] for tax in sorted(classes)], indent=1) + "\n").encode()}


def shapenet_files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """``shapenet_pc/<synset>-<object>.npy``: 8,192 points."""
    for number, whole in zip(batch.numbers.tolist(), _whole_55(batch), strict=True):
        stream = io.BytesIO()
        np.lib.format.write_array(stream, whole, version=(1, 0), allow_pickle=False)
        yield f"shapenet_pc/{_name_55(entry, entry.token(number))}", stream.getvalue()


def _whole_55(batch: Batch) -> np.ndarray:
    """Clouds (B, n, 3) in ShapeNet's axes and size."""
    whole = draw(batch, _WHOLE_55).position
    return shapenet_axes(fit_diagonal(whole).apply(whole)).astype(np.float32)


def _name_55(entry: Entry, token: str) -> str:
    assert entry.term is not None
    return f"{entry.term.data['synset']}-{token}.npy"


def shapenet_index(entries: Sequence[Entry]) -> dict[str, bytes]:
    """``ShapeNet-55/train.txt`` and ``test.txt``, which the loader reads; ``val.txt`` is kept from both."""
    return {
        f"ShapeNet-55/{split}.txt": "".join(
            f"{_name_55(entry, token)}\n" for entry in entries for token in entry.tokens(split)
        ).encode()
        for split in SPLITS
    }


# ---------------------------------------------------------------- reading back


def check_pcn(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as loaders do, and compare with the model."""
    assert entry.term is not None
    tax = entry.term.data["synset"]
    listed = {own["taxonomy_id"]: own for own in json.loads((folder / "PCN.json").read_text("utf-8"))}
    for number, whole, seen in zip(batch.numbers.tolist(), *clouds(batch), strict=True):
        split, token = entry.split(number), entry.token(number)
        found.of(token, token in listed.get(tax, {}).get(split, ()), "not in the list of its split")
        place = f"{split}/complete/{tax}/{token}.pcd"
        read = read_pcd(folder / place)
        found.of(place, len(read) == WHOLE, f"{len(read)} points, where readers need {WHOLE}")
        found.near(place, "points", read, whole, 1e-6)
        tree = cKDTree(read)
        for place, view in _partial(split, tax, token).items():
            part = read_pcd(folder / place)
            found.of(place, len(part) >= LEAST, f"{len(part)} points: fewer than {LEAST} are padded with zeros")
            off = float(tree.query(part)[0].max()) if len(part) else 0.0
            found.of(place, off < 0.05, f"{off:.3f} off the whole cloud: another frame or size")
            found.near(place, "points", part, seen[view], 1e-6)


def check_55(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    listed = {split: (folder / f"ShapeNet-55/{split}.txt").read_text("utf-8").split() for split in SPLITS}
    for number, whole in zip(batch.numbers.tolist(), _whole_55(batch), strict=True):
        name = _name_55(entry, entry.token(number))
        found.of(name, name in listed[entry.split(number)], "not in the list of its split")
        read = np.load(folder / "shapenet_pc" / name, allow_pickle=False)
        found.of(name, read.dtype == np.float32, f"{read.dtype} instead of float32")
        found.near(name, "points", read, whole, 1e-6)
