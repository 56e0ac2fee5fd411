"""Do the links of an object penetrate one another, at rest or while one joint runs through its range?

The truth is the convex pieces, the very ones that are exported. Every pair of links counts, parents and children too.
Each joint moves alone, all others at rest, with everything that hangs on its link. A prismatic joint is swept exactly
(the hull of a piece at both ends); a revolute one is looked at in states that lie dense near rest and near its ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..geometry import pieces
from ..geometry.collide import overlap
from .batch import Batch
from .motion import apply, rotation_about

MARGIN = 1e-6  # metres: what overlaps by less touches
BLOCK = 32  # objects at a time
SHARES = np.unique(np.concatenate([[0.002, 0.005, 0.01, 0.02, 0.035], np.linspace(0.0, 1.0, 25), [0.98, 0.995]]))


@dataclass(frozen=True, slots=True)
class Collisions:
    """One row per pair of links that penetrate: object index, link numbers, and the joint (-1: at rest) and its value."""

    owner: np.ndarray
    first: np.ndarray
    second: np.ndarray
    joint: np.ndarray
    value: np.ndarray

    def __len__(self) -> int:
        return len(self.owner)

    def objects(self) -> np.ndarray:
        """Indices of the objects that have any."""
        return np.unique(self.owner)


@dataclass(slots=True)
class _Body:
    """Pieces of some objects at rest: vertices (N, P, 3) (a short piece repeats its last corner), their boxes, owner, link."""

    vertices: np.ndarray
    low: np.ndarray
    high: np.ndarray
    owner: np.ndarray
    link: np.ndarray

    def part(self, rows: slice) -> _Body:
        return _Body(self.vertices[rows], self.low[rows], self.high[rows], self.owner[rows], self.link[rows])


@dataclass(slots=True)
class _Motion:
    """Pieces ``piece`` (k,) carried by joints: turned and shifted, or swept along ``sweep``; boxes that hold them."""

    piece: np.ndarray
    joint: np.ndarray
    value: np.ndarray
    low: np.ndarray
    high: np.ndarray
    turn: np.ndarray | None = None
    shift: np.ndarray | None = None
    sweep: tuple[np.ndarray, np.ndarray] | None = None

    def vertices(self, still: _Body, rows: np.ndarray) -> np.ndarray:
        points = still.vertices[self.piece[rows]]
        if self.sweep is not None:
            return np.concatenate([points + end[rows][:, None] for end in self.sweep], axis=1)
        if self.turn is None or self.shift is None:
            return points
        return _turned(self.turn[rows], points) + self.shift[rows][:, None]


def collisions(batch: Batch) -> Collisions:
    """All penetrations of a batch, each pair of links once per joint."""
    tree = _Tree(batch)
    body = _pieces(batch, tree)
    found = [_block(tree, body, start, min(start + BLOCK, len(batch))) for start in range(0, len(batch), BLOCK)]
    rows = np.concatenate(found) if found else np.zeros((0, 5))
    rows = rows[~tree.permitted(rows[:, 1].astype(np.int64), rows[:, 2].astype(np.int64))] if len(rows) else rows
    owner, first, second, joint = (rows[:, k].astype(np.int64) for k in range(4))
    number = batch.links().number
    joints = batch.joints().number
    return Collisions(
        owner, number[first] if len(rows) else first, number[second] if len(rows) else second,
        np.where(joint < 0, -1, joints[np.maximum(joint, 0)]) if len(rows) and len(joints) else joint, rows[:, 4],
    )  # fmt: skip


class _Tree:
    """Links above each link, and joint axes at rest."""

    def __init__(self, batch: Batch):
        self.batch, self.links, self.joints = batch, batch.links(), batch.joints()
        count = len(self.links.owner)
        first = np.searchsorted(self.links.owner, np.arange(len(batch)))
        self.first = first
        self.above = np.full(count, -1, dtype=np.int64)  # parent link of each link
        self.joint = np.full(count, -1, dtype=np.int64)
        child = first[self.joints.owner] + self.joints.child
        self.above[child] = first[self.joints.owner] + self.joints.parent
        self.joint[child] = np.arange(len(child))
        chain = [np.arange(count)]
        while (chain[-1] >= 0).any():
            chain.append(np.where(chain[-1] >= 0, self.above[np.maximum(chain[-1], 0)], -1))
        self.chain = np.stack(chain, axis=1)  # (L, depth): the link itself, its parent, ...
        self.turn, self.shift = batch.pose()
        holder = np.maximum(self.above[child], 0)
        self.axis = apply(self.turn[holder], self.joints.axis)
        self.origin = apply(self.turn[holder], self.joints.origin) + self.shift[holder]

    def permitted(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Pairs that the text allows to overlap or to block one another."""
        result = np.zeros(len(first), dtype=bool)
        kinds = self.links.definition
        for pair in self.batch.program.allowed:
            if pair.kind in ("overlap", "free"):
                one = np.isin(kinds[first], pair.first) & np.isin(kinds[second], pair.second)
                other = np.isin(kinds[first], pair.second) & np.isin(kinds[second], pair.first)
                result |= one | other
        return result


def _pieces(batch: Batch, tree: _Tree) -> _Body:
    parts, owners, links = [], [], []
    for table in batch.sites():
        if not len(table):
            continue
        for group in pieces.build(table.primitive, table.params):
            rows = group.rows
            local = group.vertices * np.stack([np.ones(len(rows)), table.mirror[rows], np.ones(len(rows))], axis=-1)[:, None]
            placed = _turned(table.rotation[rows], local) + table.translation[rows][:, None]
            link = tree.first[table.owner[rows]] + table.link[rows]
            parts.append(_turned(tree.turn[link], placed) + tree.shift[link][:, None])
            owners.append(table.owner[rows])
            links.append(link)
    most = max((p.shape[1] for p in parts), default=1)
    low, high = (np.concatenate([f(p, axis=1) for p in parts]) for f in (np.min, np.max))
    vertices = np.concatenate([np.concatenate([p, np.repeat(p[:, -1:], most - p.shape[1], axis=1)], axis=1) for p in parts])
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return _Body(vertices[order], low[order], high[order], owner[order], np.concatenate(links)[order])


def _turned(rotation: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Matrices (k, 3, 3) times points (k, P, 3), written out."""
    r = rotation[:, None]
    columns = [r[..., i, 0] * points[..., 0] + r[..., i, 1] * points[..., 1] + r[..., i, 2] * points[..., 2] for i in range(3)]
    return np.stack(columns, axis=-1)


def _block(tree: _Tree, body: _Body, start: int, stop: int) -> np.ndarray:
    """Rows (object, link, link, joint, value) of the objects ``start .. stop``."""
    low, high = np.searchsorted(body.owner, [start, stop])
    still = body.part(slice(low, high))
    count = len(still.owner)
    rest = _Motion(np.arange(count), np.full(count, -1), np.zeros(count), still.low, still.high)
    return np.concatenate([_meet(tree, motion, still) for motion in (rest, *_motions(tree, still))])


def _motions(tree: _Tree, still: _Body) -> Iterator[_Motion]:
    """Pieces carried by each joint above them: prismatic ones swept, revolute ones in many states."""
    kinds = np.array(tree.joints.kind, dtype=object)
    center, half = (still.low + still.high) / 2, (still.high - still.low) / 2
    for level in range(tree.chain.shape[1] - 1):
        link = tree.chain[still.link, level]
        piece = np.flatnonzero((link >= 0) & (tree.joint[np.maximum(link, 0)] >= 0))
        joint = tree.joint[link[piece]]
        low = np.nan_to_num(tree.joints.low[joint], nan=-np.pi)
        high = np.nan_to_num(tree.joints.high[joint], nan=np.pi)
        rest = tree.joints.rest[joint]
        at = np.flatnonzero(kinds[joint] == "prismatic")
        if len(at):
            ends = tuple(tree.axis[joint[at]] * (end - rest)[at][:, None] for end in (low, high))
            reach = [(still.low[piece[at]] + e, still.high[piece[at]] + e) for e in ends]
            bounds = np.minimum(reach[0][0], reach[1][0]), np.maximum(reach[0][1], reach[1][1])
            yield _Motion(piece[at], joint[at], high[at], *bounds, sweep=ends)
        at = np.flatnonzero((kinds[joint] == "revolute") | (kinds[joint] == "continuous"))
        for share in SHARES if len(at) else ():
            value = (low + share * (high - low))[at]
            axis, origin = tree.axis[joint[at]], tree.origin[joint[at]]
            turn = rotation_about(axis, value - rest[at])
            shift = origin - apply(turn, origin)
            middle, reach = apply(turn, center[piece[at]]) + shift, apply(np.abs(turn), half[piece[at]])
            yield _Motion(piece[at], joint[at], value, middle - reach, middle + reach, turn, shift)


def _meet(tree: _Tree, motion: _Motion, still: _Body) -> np.ndarray:
    """Penetrations between moved pieces and those that stay: boxes first, then the pieces themselves."""
    i, j = _boxes(motion, still)
    link = still.link[motion.piece]
    if (motion.joint >= 0).all():  # what hangs on the joint's link moves along
        child = tree.first[tree.joints.owner[motion.joint]] + tree.joints.child[motion.joint]
        apart = ~(tree.chain[still.link[j]] == child[i][:, None]).any(axis=1)
    else:
        apart = link[i] < still.link[j]
    i, j = i[apart], j[apart]
    if not len(i):
        return np.zeros((0, 5))
    hit = overlap(motion.vertices(still, i), still.vertices[j], MARGIN)
    i, j = i[hit], j[hit]
    rows = np.stack([still.owner[j], link[i], still.link[j], motion.joint[i], motion.value[i]], axis=1).astype(np.float64)
    _, keep = np.unique(rows[:, :4], axis=0, return_index=True)
    return rows[np.sort(keep)]


def _boxes(motion: _Motion, still: _Body) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of one object, of different links, whose boxes overlap by more than the margin."""
    owner = still.owner[motion.piece]
    first = np.searchsorted(still.owner, owner, side="left")
    count = np.searchsorted(still.owner, owner, side="right") - first
    i = np.repeat(np.arange(len(owner)), count)
    j = np.arange(len(i)) - np.repeat(np.cumsum(count) - count, count) + np.repeat(first, count)
    for k in range(3):
        near = (motion.low[i, k] < still.high[j, k] - MARGIN) & (still.low[j, k] < motion.high[i, k] - MARGIN)
        i, j = i[near], j[near]
    apart = still.link[motion.piece[i]] != still.link[j]
    return i[apart], j[apart]
