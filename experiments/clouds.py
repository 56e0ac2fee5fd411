"""Clouds of objects with a truth value per point: whether it is on what moves. Of real objects, and of ours."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import artipg_dsl as apg
from artipg_dsl.errors import UserError

LEAST = 0.03  # of the surface: people who describe objects leave smaller parts to what they are on
_UP = {"x": 0, "y": 1, "z": 2}


@dataclass(frozen=True, slots=True, eq=False)
class Clouds:
    """K clouds of n points: ``points`` (K, n, 3) float32 with z up, the centre of their box 0 and the farthest point at 1; ``moves``
    (K, n) bool; ``category`` (K,) int64 indexes ``known``; ``names`` of the objects."""

    points: np.ndarray
    moves: np.ndarray
    category: np.ndarray
    known: tuple[str, ...]
    names: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.names)

    def take(self, rows: np.ndarray) -> Clouds:
        names = tuple(self.names[k] for k in rows)
        return Clouds(self.points[rows], self.moves[rows], self.category[rows], self.known, names)


def normalise(points: np.ndarray) -> np.ndarray:
    """Clouds (..., n, 3) about the centre of their box, as large as fits a ball of radius 1."""
    low, high = points.min(axis=-2, keepdims=True), points.max(axis=-2, keepdims=True)
    points = points - (low + high) / 2
    return (points / np.sqrt((points**2).sum(axis=-1)).max(axis=-1)[..., None, None]).astype(np.float32)


def read_real(folder: Path) -> Clouds:
    """Every ``CATEGORY/NAME/cloud.npz`` of the folder that has a ``joints.json`` beside it and a link that moves.

    ``points`` (n, 3), ``link_id`` (n,) into ``link_names``; the joints say which link each moves, and ``up`` which axis is. Objects of
    categories that are not shipped are left out. Raises UserError.
    """
    shipped = {name.lower(): name for name in apg.categories()}
    paths = [path for path in sorted(folder.rglob("cloud.npz")) if (path.parent / "joints.json").exists()]
    read = [(path, *_read(path)) for path in paths if path.parent.parent.name.lower() in shipped]
    found = [(path, points, moves) for path, points, moves in read if moves.any()]
    if not found:
        raise UserError(
            f"{folder} has no object with a joint, of a category that is shipped",
            "the form is CATEGORY/NAME/cloud.npz with joints.json beside it",
        )
    least = min(len(points) for _, points, _ in found)
    thinned = [np.random.default_rng(k).permutation(len(points))[:least] for k, (_, points, _) in enumerate(found)]
    kinds = [shipped[path.parent.parent.name.lower()] for path, *_ in found]
    known = tuple(sorted(set(kinds)))
    return Clouds(
        normalise(np.stack([points[at] for (_, points, _), at in zip(found, thinned, strict=True)])),
        np.stack([moves[at] for (_, _, moves), at in zip(found, thinned, strict=True)]),
        np.array([known.index(kind) for kind in kinds]),
        known,
        tuple(f"{kind} {path.parent.name}" for kind, (path, *_) in zip(kinds, found, strict=True)),
    )


def _read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    record = json.loads((path.parent / "joints.json").read_text(encoding="utf-8"))
    try:
        with np.load(path) as data:
            points, link, names = data["points"], data["link_id"], [str(name) for name in data["link_names"]]
        up, sign = _UP[record["up"].strip("+-")], -1.0 if record["up"].startswith("-") else 1.0
        children = {joint["child"]: joint for joint in record["joints"]}
        moves = np.array([_rides(name, children) for name in names], dtype=bool)[link]
    except (KeyError, IndexError, ValueError) as wrong:
        raise UserError(f"{path}: {wrong!r} is missing or wrong", "points, link_id, link_names; up, joints") from None
    turned = (
        np.roll(points, 2 - up, axis=1) * sign
    )  # rolling the axes keeps them right-handed; both signs turn them over
    if sign < 0:
        turned[:, 0] *= -1.0
    return turned, moves


def _rides(link: str, children: dict[str, dict[str, str]]) -> bool:
    """Whether a joint that moves is between a link and the root."""
    seen: set[str] = set()
    while link in children and link not in seen:
        if children[link]["type"] != "fixed":
            return True
        seen.add(link)
        link = children[link]["parent"]
    return False


def sample_ours(categories: Sequence[str], each: int, n: int, seed: int) -> Clouds:
    """Fresh objects of the categories, each at rest and in a random state."""
    points, moves, names = [], [], []
    for category in categories:
        objects = apg.sample(category, n=each, seed=seed)
        made = objects.points(n, objects.joint_values("rest,random:1"), surface="outside")
        for k, state in enumerate(("at rest", "open")):
            points.append(normalise(made.position[:, k]))
            moves.append(_moving(objects, made.link))
            names += [f"{category} {number} {state}" for number in objects.numbers]
    kinds = np.repeat(np.arange(len(categories)), 2 * each)
    return Clouds(np.concatenate(points), np.concatenate(moves), kinds, tuple(categories), tuple(names))


def _moving(objects: apg.Samples, link: np.ndarray) -> np.ndarray:
    """(B, n) bool for points on links: whether a joint moves them that carries enough of the surface to be counted."""
    links, joints, count = objects.links(), objects.joints(), len(objects)
    size = int(links.number.max()) + 1
    share = np.stack([np.bincount(row, minlength=size) for row in link]) / link.shape[1]
    parent, free = np.full((count, size), -1), np.zeros((count, size), dtype=bool)
    parent[joints.owner, joints.child] = joints.parent
    free[joints.owner, joints.child] = np.array([kind != "fixed" for kind in joints.kind])
    carried, above = share.copy(), parent.copy()
    owner = np.broadcast_to(np.arange(count)[:, None], above.shape)
    while (above >= 0).any():  # what a link carries, those on it too
        at = above >= 0
        np.add.at(carried, (owner[at], above[at]), share[at])
        above = np.where(at, parent[owner, above], -1)
    counted, moves, above = free & (carried >= LEAST), np.zeros_like(free), np.broadcast_to(np.arange(size), free.shape)
    for _ in range(size):
        moves |= (above >= 0) & counted[owner, above]
        above = np.where(above >= 0, parent[owner, above], -1)
    return moves[np.arange(count)[:, None], link]
