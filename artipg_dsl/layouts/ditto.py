"""Ditto: clouds of an object before and after one of its joints has moved, with the joint and what is within which part.

``Shape2Motion/<category>_<split>/scenes/<object>_<joint>.npz``: loaders take the part's number from the word `Shape2Motion` in the path:
the base is part 0 and what joint k moves part k + 1. Frame: the object's (z up), metres.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .. import random
from ..annotate.cameras import Cameras
from ..annotate.seen import links_around
from ..annotate.soup import make_soup
from ..annotate.states import rest_values
from ..annotate.views import make_views
from ..errors import UserError
from ..export.containers import npz_bytes
from ..geometry.vectors import cross
from ..records import dataclass
from .clouds import norms, turn_about
from .entry import SPLITS, Entry
from .findings import Findings

if TYPE_CHECKING:
    from ..runtime.batch import Batch

ROOT, MOST, PROBES = "Shape2Motion", 4, 20000
_CAMERAS = Cameras(
    count=6, width=160, height=160, fov=35.0, azimuth=(-180.0, 180.0), elevation=(10.0, 60.0), points=2048
)
_LEAST = {"revolute": np.radians(15.0), "prismatic": 0.02}  # radians; of the diagonal of the object
_APART = 0.3  # of the range: how far the two states are apart, at least
_SEEN = 0.005  # of the surface, of the points of each cloud and of the places within: less that moves teaches nothing
_ROOM, _NEAR = 0.1, 0.02  # around the box, and beside the surface, of the diagonal


@dataclass(frozen=True, slots=True)
class Scene:
    """A joint of object ``i`` by its row in the table, ``index`` among those that its object has scenes of, ``tried`` among those
    that were tried; ``start`` and ``end`` the values before and after."""

    i: int
    joint: int
    index: int
    tried: int
    start: float
    end: float


@dataclass(frozen=True, slots=True)
class _Held:
    """What a scene was tried by: both clouds, which of their points and of the links move, places, and which link is around each."""

    points: Sequence[np.ndarray]
    masks: Sequence[np.ndarray]
    moved: np.ndarray
    probes: np.ndarray
    around: np.ndarray


def scenes(batch: Batch) -> list[list[Scene]]:
    """Those that are tried, of each object: its first joints that turn or slide far enough, carry enough and move nothing
    beside it."""
    joints, rest = batch.joints(), rest_values(batch)
    key = random.key(batch.seed, "ditto")
    made = make_soup(batch, 0, len(batch))
    first = np.searchsorted(batch.links().owner, np.arange(len(batch) + 1))
    found: list[list[Scene]] = [[] for _ in range(len(batch))]
    for i in range(len(batch)):
        own = slice(int(made.start[i]), int(made.start[i + 1]))
        corner, link = made.corner[own], made.link[own] - first[i]
        diagonal = float(norms(np.ptp(corner.reshape(-1, 3), axis=0)))
        area = norms(cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
        for j in np.flatnonzero(np.asarray(joints.owner) == i).tolist():
            kind, reach = joints.kind[j], float(joints.high[j] - joints.low[j])
            unit = diagonal if kind == "prismatic" else 1.0
            if kind not in _LEAST or not reach >= _LEAST[kind] * unit or len(found[i]) == MOST:
                continue
            carried = _carried(batch, i, j, int(first[i + 1] - first[i]))
            if area[carried[link]].sum() < _SEEN * area.sum() or _moves_others(batch, rest, j):
                continue
            near, far, turn = random.uniform(key, int(batch.numbers[i]), np.arange(3) + 3 * len(found[i])).tolist()
            span = (1 - _APART) / 2
            ends = joints.low[j] + reach * np.array([near * span, 1 - far * span])
            start, end = ends if turn < 0.5 else ends[::-1]
            found[i].append(Scene(i, j, len(found[i]), len(found[i]), float(start), float(end)))
    return found


def _moves_others(batch: Batch, rest: np.ndarray, joint: int) -> bool:
    """Whether other joints follow one, or it cannot be moved by itself."""
    joints, values = batch.joints(), rest.copy()
    values[joint] = (joints.low[joint] + joints.high[joint]) / 2
    moved, still = batch.settle(values), batch.settle(rest)
    other = np.arange(len(rest)) != joint
    return bool(np.abs(moved - still)[other].max(initial=0.0) > 1e-9 or abs(moved[joint] - values[joint]) > 1e-9)


def arrays(batch: Batch) -> Iterator[tuple[Scene, dict[str, np.ndarray]]]:
    """Each scene with what its file holds."""
    tried, rest = scenes(batch), rest_values(batch)
    every = max(map(len, tried))
    if not every:
        return
    values = np.tile(rest, (2 * every, 1))
    for scene in (scene for own in tried for scene in own):
        values[2 * scene.tried, scene.joint], values[2 * scene.tried + 1, scene.joint] = scene.start, scene.end
    poses = [batch.pose(state) for state in values]
    cloud = make_views(batch, _CAMERAS, values).cloud
    made = make_soup(batch, 0, len(batch))
    first = np.searchsorted(batch.links().owner, np.arange(len(batch) + 1))
    for all_tried in tried:
        kept: list[tuple[Scene, _Held]] = []
        for scene in all_tried:
            at = [(scene.i, 2 * scene.tried + k) for k in range(2)]
            points = [cloud["points"][a].reshape(-1, 3).astype(np.float64) for a in at]
            moved = _carried(batch, scene.i, scene.joint, int(first[scene.i + 1] - first[scene.i]))
            masks = [moved[cloud["link"][a].reshape(-1).astype(np.int64)] for a in at]
            probes = _probes(batch, scene, points[0])
            around = links_around(made, scene.i, *poses[2 * scene.tried], probes)[first[scene.i] : first[scene.i + 1]]
            inside = around[moved].any(axis=0)[around.any(axis=0)]
            if len(inside) and min(mask.mean() for mask in (*masks, inside)) >= _SEEN:
                kept.append((replace(scene, index=len(kept)), _Held(points, masks, moved, probes, around)))
        own = [scene for scene, _ in kept]
        for scene, held in kept:
            part = _parts(batch, own, int(first[scene.i]), int(first[scene.i + 1]))
            axis, pivot = _placed(batch, scene, poses[2 * scene.tried], int(first[scene.i]))
            within = np.zeros((len(own) + 1, len(held.probes)), dtype=bool)
            np.logical_or.at(within, np.where(held.moved, scene.index + 1, part), held.around)
            yield scene, _file(batch, scene, held.points, held.masks, axis, pivot, held.probes, within)


def _file(
    batch: Batch,
    scene: Scene,
    points: Sequence[np.ndarray],
    moved: Sequence[np.ndarray],
    axis: np.ndarray,
    pivot: np.ndarray,
    probes: np.ndarray,
    within: np.ndarray,
) -> dict[str, np.ndarray]:
    slides = batch.joints().kind[scene.joint] == "prismatic"
    other = []
    for cloud, mask, step in zip(points, moved, (scene.end - scene.start, scene.start - scene.end), strict=True):
        gone = cloud + step * axis if slides else turn_about(cloud, pivot, axis, step)
        other.append(np.where(mask[:, None], gone, cloud))
    return {
        "pc_start": points[0].astype(np.float32),
        "pc_end": points[1].astype(np.float32),
        "pc_start_end": other[0].astype(np.float32),
        "pc_end_start": other[1].astype(np.float32),
        "pc_seg_start": moved[0],
        "pc_seg_end": moved[1],
        "state_start": np.array(scene.start),
        "state_end": np.array(scene.end),
        "screw_axis": axis,
        "screw_moment": cross(pivot, axis),
        "joint_type": np.array(int(slides)),
        "joint_index": np.array(scene.index),
        "start_p_occ": probes.astype(np.float32),
        "start_occ_list": within,
        "start_occ_density": np.ones((len(probes), 1)),
    }


def _above(batch: Batch, i: int) -> dict[int, int]:
    """The joint, by its row, that holds each link of an object."""
    joints = batch.joints()
    return {int(joints.child[j]): j for j in np.flatnonzero(np.asarray(joints.owner) == i).tolist()}


def _parts(batch: Batch, own: Sequence[Scene], first: int, stop: int) -> np.ndarray:
    """The part (L,) of each link of an object: 1 more than the index of the scene whose joint carries it, 0 for the base."""
    above, parent = _above(batch, own[0].i), batch.joints().parent
    numbers = {scene.joint: scene.index + 1 for scene in own}
    found = np.zeros(stop - first, dtype=np.int64)
    for link in range(stop - first):
        at = link
        while at in above and above[at] not in numbers:
            at = int(parent[above[at]])
        found[link] = numbers[above[at]] if at in above else 0
    return found


def _carried(batch: Batch, i: int, joint: int, count: int) -> np.ndarray:
    """(L,) bool: the links of an object that a joint carries, directly or not."""
    above, joints = _above(batch, i), batch.joints()
    found = np.zeros(count, dtype=bool)
    for link in range(count):
        at = link
        while at in above and above[at] != joint:
            at = int(joints.parent[above[at]])
        found[link] = at in above
    return found


def _placed(
    batch: Batch, scene: Scene, pose: tuple[np.ndarray, np.ndarray], first: int
) -> tuple[np.ndarray, np.ndarray]:
    """Axis and pivot of a joint where the link that carries it stands."""
    joints = batch.joints()
    axis, pivot, row = joints.axis[scene.joint], joints.origin[scene.joint], first + int(joints.parent[scene.joint])
    turn, shift = pose[0][row], pose[1][row]
    return (turn * axis).sum(axis=1), (turn * pivot).sum(axis=1) + shift


def _probes(batch: Batch, scene: Scene, points: np.ndarray) -> np.ndarray:
    """Places (m, 3): half of them anywhere in the box, half beside the surface."""
    key = random.key(batch.seed, "ditto", "probes")
    address = random.mix(np.asarray(int(batch.numbers[scene.i]), dtype=np.uint64), scene.tried)
    share = random.uniform(key, address, np.arange(3)[None], np.arange(PROBES)[:, None])
    low, high = points.min(axis=0), points.max(axis=0)
    diagonal, half = float(norms(high - low)), PROBES // 2
    anywhere = low - _ROOM * diagonal + share[:half] * (high - low + 2 * _ROOM * diagonal)
    chosen = np.arange(half) * len(points) // half
    return np.concatenate([anywhere, points[chosen] + (share[half:] - 0.5) * 2 * _NEAR * diagonal])


def _place(entry: Entry, number: int, scene: Scene) -> str:
    return f"{ROOT}/{entry.category}_{entry.split(number)}/scenes/{entry.token(number)}_{scene.index}.npz"


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """A file for each scene."""
    for scene, held in arrays(batch):
        yield _place(entry, int(batch.numbers[scene.i]), scene), npz_bytes(held, pack=True)


def index(entries: Sequence[Entry], folder: Path) -> dict[str, bytes]:
    """A folder for each split. Raises UserError where a category has no scene at all."""
    for entry in entries:
        if not any((folder / ROOT).glob(f"{entry.category}_*/scenes/*.npz")):
            raise UserError(
                f"no joint of {entry.category} is one that Ditto can learn",
                "it takes joints with limits that turn 15 degrees or slide 2 % of the diagonal, that no other follows, "
                "and that carry more than a sliver",
            )
    return {f"{ROOT}/{entry.category}_{split}/scenes/": b"" for entry in entries for split in SPLITS}


# ---------------------------------------------------------------- reading back


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as the loader does, and compare with the model."""
    for scene, model in arrays(batch):
        name = _place(entry, int(batch.numbers[scene.i]), scene)
        with np.load(folder / name, allow_pickle=False) as read:
            held = {key: read[key] for key in read.files}
        if not found.of(name, held.keys() == model.keys(), f"holds {', '.join(sorted(held))}"):
            continue
        for key, array in model.items():
            found.of(name, held[key].dtype == array.dtype, f"{key} is {held[key].dtype}, not {array.dtype}")
            found.near(name, key, held[key], array, 1e-6)
        _traps(name, held, found)


def _traps(name: str, held: dict[str, np.ndarray], found: Findings) -> None:
    """What the loader does not notice."""
    axis, moment, kind = held["screw_axis"], held["screw_moment"], int(held["joint_type"])
    found.of(name, abs(float(norms(axis)) - 1) < 1e-9, "the axis has not the length 1")
    found.of(name, abs(float((axis * moment).sum())) < 1e-6, "the moment is not across the axis")
    part = int(held["joint_index"]) + 1
    within = held["start_occ_list"]
    if not found.of(name, part < len(within), "its joint has no part"):
        return
    found.of(name, bool(within[part].any()), "no place within the part that moves")
    found.of(name, held["start_occ_density"].ndim == 2, "densities are no column, which the loader squeezes")
    pivot, step = cross(axis, moment), float(held["state_end"] - held["state_start"])
    for begun, gone, mask, way in (
        ("pc_start", "pc_start_end", "pc_seg_start", step),
        ("pc_end", "pc_end_start", "pc_seg_end", -step),
    ):
        points, moved = held[begun].astype(np.float64), held[mask].astype(bool)
        after = points + way * axis if kind else turn_about(points, pivot, axis, way)
        found.near(name, f"{gone} by its screw", held[gone], np.where(moved[:, None], after, points), 1e-5)
