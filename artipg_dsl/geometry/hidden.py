"""Which surface points are hidden in, or pressed against, another primitive of the same object.

A point is asked a small way off its surface. Boxes narrow the question first: rows against rows, then patches against
rows, then points against rows; what is left goes through the inside functions, one call per primitive.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ..graph.primitive import Primitive
from .block import Block, Shelf, placed_bounds, to_local
from .box import bounds
from .patches import Params, Split, position_split, surfaces
from .topology import turns

OFF = 1e-6  # how far off its surface a point is asked, relative to the largest primitive of its object
_ABOUT = 1.5  # a coincident surface lies within this many times that distance of the point asked
_MARGIN = 0.15  # a smooth quarter turn stays this close to the box of a few of its points
_PAIRS = 2_000_000  # pairs of rows, or of a point and a row, looked at together


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """Patches of rows, which points are allocated to, sorted by (object, rank of the row, patch)."""

    row: np.ndarray  # (C,) row of the block
    patch: np.ndarray  # (C,)
    owner: np.ndarray  # (C,) object of the block


@dataclass(frozen=True, slots=True, eq=False)
class Occluders:
    """Rows of one shelf that may hide points of cells: those of cell c are ``rows[start[c] : start[c + 1]]``."""

    shelf: Shelf
    inside: Split
    values: np.ndarray
    start: np.ndarray
    rows: np.ndarray


@lru_cache(maxsize=512)
def inside_split(primitive: Primitive) -> Split:
    """The inside function over p.x, p.y, p.z."""
    return Split(primitive, (primitive.inside,), ("p.x", "p.y", "p.z"))


@lru_cache(maxsize=512)
def _probes(primitive: Primitive, patch: int) -> tuple[np.ndarray, np.ndarray, float] | None:
    """Fractions (u, v) of points that span a patch, and the margin around them; None: use the box of the whole."""
    angle = max(turns(primitive, patch))
    if angle > 6.5:
        return None
    along = np.linspace(0.0, 1.0, 2 if angle < 1e-9 else 3 if angle < 1.6 else 9)
    u, v = np.meshgrid(along, along, indexing="ij")
    return u.ravel(), v.ravel(), 0.0 if angle < 1e-9 else _MARGIN


def patch_bounds(
    primitive: Primitive, params: Params, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (k, patches, 3) of the patches of k instances, within their whole boxes ``low``, ``high`` (k, 3)."""
    count = len(surfaces(primitive))
    lows, highs = (np.repeat(side[:, None], count, axis=1) for side in (low, high))
    for patch in range(count):
        probes = _probes(primitive, patch)
        if probes is None:
            continue
        u, v, margin = probes
        split = position_split(primitive, patch)
        values = split.points([r[None] for r in split.rows(params)], u[:, None], v[:, None])
        for axis, value in enumerate(np.atleast_2d(v) for v in values):
            least, most = np.minimum.reduce(value, axis=0), np.maximum.reduce(value, axis=0)
            slack = margin * (most - least)
            lows[:, patch, axis], highs[:, patch, axis] = least - slack, most + slack
    return lows, highs


def scales(rows: Block) -> np.ndarray:
    """(objects,) how far off the surface the points of each object are asked, in metres."""
    out = np.zeros(rows.objects)
    np.maximum.at(out, rows.owner, rows.diagonal)
    return OFF * out


def occluders(rows: Block, cells: Cells, off: np.ndarray) -> list[Occluders]:
    """For each primitive the rows that come near each cell."""
    near, other = _row_pairs(rows, off)
    ranks = rows.rank[cells.row]  # ascending
    first = np.searchsorted(ranks, rows.rank[near])
    counts = np.searchsorted(ranks, rows.rank[near], side="right") - first
    pair = np.repeat(np.arange(len(near)), counts)
    cell = first[pair] + np.arange(len(pair)) - np.repeat(np.cumsum(counts) - counts, counts)
    other = other[pair]
    low, high = _cell_bounds(rows, cells)
    slack = off[cells.owner[cell]]
    kept = np.ones(len(cell), dtype=bool)
    for axis in range(3):
        kept &= low[cell, axis] - slack <= rows.high[other, axis]
        kept &= high[cell, axis] + slack >= rows.low[other, axis]
    cell, other = cell[kept], other[kept]
    out = []
    for shelf in rows.shelves:
        own = (other >= shelf.start) & (other < shelf.stop)
        if not own.any():
            continue
        order = np.argsort(cell[own], kind="stable")
        start = np.zeros(len(cells.row) + 1, dtype=np.int64)
        np.cumsum(np.bincount(cell[own], minlength=len(cells.row)), out=start[1:])
        split = inside_split(shelf.primitive)
        out.append(Occluders(shelf, split, split.rows(shelf.params), start, other[own][order]))
    return out


def _row_pairs(rows: Block, off: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of different rows of one object whose boxes meet."""
    order = np.argsort(rows.rank)
    counts = np.bincount(rows.owner, minlength=rows.objects)
    starts = np.cumsum(counts) - counts
    found: list[tuple[np.ndarray, np.ndarray]] = []
    widest = max(1, int(counts.max(initial=1)))
    at_once = max(1, _PAIRS // (widest * widest))
    for begin in range(0, rows.objects, at_once):
        part = slice(begin, begin + at_once)
        slots = starts[part, None] + np.arange(widest)
        there = np.arange(widest) < counts[part, None]
        member = order[np.where(there, slots, 0)]
        low = np.where(there[..., None], rows.low[member] - off[part, None, None], np.inf)
        high = np.where(there[..., None], rows.high[member] + off[part, None, None], -np.inf)
        meet = ~np.eye(widest, dtype=bool)[None] & there[:, :, None]
        for axis in range(3):
            meet = meet & (low[:, :, None, axis] <= high[:, None, :, axis])
            meet &= low[:, None, :, axis] <= high[:, :, None, axis]
        which, one, two = np.nonzero(meet)
        found.append((member[which, one], member[which, two]))
    return np.concatenate([a for a, _ in found]), np.concatenate([b for _, b in found])


def _cell_bounds(rows: Block, cells: Cells) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (C, 3) of cells in the frames of their objects."""
    low, high = np.empty((len(cells.row), 3)), np.empty((len(cells.row), 3))
    for shelf in rows.shelves:
        at = np.flatnonzero((cells.row >= shelf.start) & (cells.row < shelf.stop))
        whole = bounds(shelf.primitive, shelf.params)
        lows, highs = patch_bounds(shelf.primitive, shelf.params, *whole)
        row, patch = cells.row[at] - shelf.start, cells.patch[at]
        poses = (rows.rotation, rows.translation, rows.mirror)
        low[at], high[at] = placed_bounds(poses, cells.row[at], lows[row, patch], highs[row, patch])
    return low, high


def hidden(
    rows: Block, near: list[Occluders], cell: np.ndarray, own: np.ndarray, position, normal, off: np.ndarray
) -> np.ndarray:
    """(m,) bool: which points are hidden.

    ``cell`` (m,) and ``own`` (m,) give the cell and the row of each point, ``position`` and ``normal`` three arrays
    (m,) each in the object's frame, ``off`` (m,) the distance at which to ask.
    """
    out = np.zeros(len(cell), dtype=bool)
    outer = [p + off * n for p, n in zip(position, normal, strict=True)]
    for group in near:
        counts = group.start[cell + 1] - group.start[cell]
        asked = np.flatnonzero(counts)
        ends = np.cumsum(counts[asked])
        cuts = np.searchsorted(ends, np.arange(_PAIRS, int(ends[-1]) if len(ends) else 0, _PAIRS))
        for part in np.split(asked, cuts):
            out[_hiding(rows, group, cell, own, part, counts[part], position, normal, outer, off)] = True
    return out


def _hiding(
    rows: Block, group: Occluders, cell: np.ndarray, own: np.ndarray, asked: np.ndarray, counts: np.ndarray,
    position, normal, outer, off: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Which of the points ``asked`` (indices), with ``counts`` occluders each, are hidden by one of this group."""
    poses = (rows.rotation, rows.translation, rows.mirror)
    point = np.repeat(asked, counts)
    slot = np.arange(len(point)) - np.repeat(np.cumsum(counts) - counts, counts)
    other = group.rows[group.start[cell[point]] + slot]
    for axis in range(3):
        value, slack = outer[axis][point], off[point]
        kept = (value >= rows.low[other, axis] - slack) & (value <= rows.high[other, axis] + slack)
        point, other = point[kept], other[kept]
    if len(point) == 0:
        return point
    depth = _inside(group, poses, other, [c[point] for c in outer])
    within = point[depth < 0.0]
    close = (depth >= 0.0) & (depth <= _ABOUT * off[point]) & (rows.rank[other] < rows.rank[own[point]])
    point, other = point[close], other[close]
    inner = [p[point] - off[point] * n[point] for p, n in zip(position, normal, strict=True)]
    return np.concatenate([within, point[_inside(group, poses, other, inner) < 0.0]])


def _inside(group: Occluders, poses, other: np.ndarray, point) -> np.ndarray:
    """(m,) the inside functions of rows ``other`` at points of their objects."""
    row = other - group.shelf.start
    local = to_local(poses, other, point)
    value = group.inside.points([r[row] for r in group.values], *local)[0]
    return np.broadcast_to(value, row.shape)
