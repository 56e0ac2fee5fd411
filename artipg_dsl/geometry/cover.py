"""Which places on the surfaces of rows are hidden in, or pressed against, another row of the same object.

A place is asked a small way off its surface. Boxes narrow the question first: rows against rows, then places against rows. What is left
goes through the inside functions, one call per primitive.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..native import backend, points
from .block import Block, to_local
from .insides import Insides
from .runs import runs

ABOUT = 1.5  # a coincident surface lies within this many times that distance of the point asked
REACH = 1.6  # boxes are wider by this many times that distance
PAIRS = 100_000  # pairs of rows, or of a point and a row, looked at together
_OFF = 1e-6  # how far off its surface a point is asked, relative to the largest primitive of its object
Places = Sequence[np.ndarray] | np.ndarray  # three arrays (m,)


def scales(rows: Block) -> np.ndarray:
    """(objects,) how far off the surface the points of each object are asked, in metres."""
    out = np.zeros(rows.objects)
    np.maximum.at(out, rows.owner, rows.diagonal)
    return _OFF * out


class Cover(Insides):
    """The rows of a block as what hides places of others: ``off`` (objects,) as of ``scales``; ``meeting``: the rows on which places are
    asked, and those that may hide them, as of ``meeting_rows``.

    ``ends`` (two arrays (3, R)) bound each row in the object's frame, somewhat wider.
    """

    def __init__(self, rows: Block, off: np.ndarray, meeting: tuple[np.ndarray, np.ndarray]):
        super().__init__(rows)
        self.off = off
        reach = (REACH * off)[rows.owner]
        low, high = (np.ascontiguousarray(x.T) for x in (rows.low, rows.high))
        self.ends = low - reach, high + reach
        near, other = meeting
        order = np.argsort(near, kind="stable")
        self._other = other[order]  # rows whose boxes meet that of row r: from _start[r] to _start[r + 1]
        self._start = np.concatenate([[0], np.cumsum(np.bincount(near, minlength=len(rows.owner)))])

    def depths(self, other: np.ndarray, local: Places) -> np.ndarray:
        """(m,) depths of points in rows of any shelves, in the frames of those rows."""
        out = np.empty(len(other))
        shelf = self.shelf[other]
        order = np.argsort(shelf, kind="stable")
        edges = np.searchsorted(shelf[order], np.arange(len(self.rows.shelves) + 1))
        for number in range(len(self.rows.shelves)):
            mine = order[edges[number] : edges[number + 1]]
            if len(mine):
                out[mine] = self.depth(number, other[mine], [x[mine] for x in local])
        return out

    def depth(self, shelf: int, other: np.ndarray, local: Places) -> np.ndarray:
        """(m,) the inside function of rows ``other`` of one shelf at points in their own frames."""
        row = other - self.rows.shelves[shelf].start
        value = self.inside[shelf].points([r[row] for r in self.values[shelf]], *local)[0]
        return np.broadcast_to(value, row.shape)

    def hidden(self, row: np.ndarray, position: Places, normal: Places) -> np.ndarray:
        """(m,) bool: which places on the surfaces of rows ``row`` are hidden; positions and normals in the frames of their objects."""
        out = np.zeros(len(row), dtype=bool)
        first, count = self._start[row], self._start[row + 1] - self._start[row]
        ends = np.cumsum(count)
        cuts = np.searchsorted(ends, np.arange(PAIRS, int(ends[-1]) if len(ends) else 0, PAIRS))
        off = self.off[self.rows.owner[row]]
        outer = np.stack([p + off * n for p, n in zip(position, normal, strict=True)])
        for part in np.split(np.arange(len(row)), cuts):
            point, other, local = self._within_boxes(part, first[part], count[part], outer)
            depth = self.depths(other, local)
            out[point.compress(depth < 0.0)] = True
            close = np.flatnonzero((depth >= 0.0) & (depth <= ABOUT * off[point]))
            point, other = point[close], other[close]
            lower = np.flatnonzero(self.rows.rank[other] < self.rows.rank[row[point]])
            point, other = point[lower], other[lower]
            inner = [p[point] - off[point] * n[point] for p, n in zip(position, normal, strict=True)]
            depth = self.depths(other, to_local(self.poses, other, inner))
            out[point.compress(depth < 0.0)] = True
        return out

    def _within_boxes(
        self, asked: np.ndarray, first: np.ndarray, count: np.ndarray, place: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, Places]:
        """Points of ``asked`` (n,) and rows (k,), each point with a run of them, in whose boxes they lie, and where in their frames
        (3, k); ``place`` (3, m) of all points."""
        machine = backend.machine()
        if machine is not None:
            other, point, local = points.near_loose(
                machine, asked, first, count, self._other, place, self.poses, self.ends
            )
            return point, other, local
        point, other = np.repeat(asked, count), self._other[runs(first, count)]
        for axis in range(3):
            value = place[axis][point]
            kept = np.flatnonzero((value >= self.ends[0][axis][other]) & (value <= self.ends[1][axis][other]))
            point, other = point[kept], other[kept]
        return point, other, to_local(self.poses, other, place.take(point, axis=1))


def meeting_rows(rows: Block, off: np.ndarray, asked: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of different rows of one object whose boxes meet; the first of each is one of those that are ``asked`` (R,) bool."""
    if not len(rows.rank):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    order = np.argsort(rows.rank)
    counts = np.bincount(rows.owner, minlength=rows.objects)
    starts = np.cumsum(counts) - counts
    machine = backend.machine()
    if machine is not None:
        slack = off[rows.owner, None]
        every = np.ones(len(order), dtype=bool) if asked is None else asked
        return points.near_rows(machine, starts, counts, order, rows.low - slack, rows.high + slack, every)
    found: list[tuple[np.ndarray, np.ndarray]] = []
    widest = max(1, int(counts.max(initial=1)))
    at_once = max(1, PAIRS // (widest * widest))
    for begin in range(0, rows.objects, at_once):
        part = slice(begin, begin + at_once)
        slots = starts[part, None] + np.arange(widest)
        there = np.arange(widest) < counts[part, None]
        member = order[np.where(there, slots, 0)]
        low = np.where(there[..., None], rows.low[member] - off[part, None, None], np.inf)
        high = np.where(there[..., None], rows.high[member] + off[part, None, None], -np.inf)
        meet = ~np.eye(widest, dtype=bool)[None] & there[:, :, None]
        if asked is not None:
            meet &= asked[member][:, :, None]
        for axis in range(3):
            meet = meet & (low[:, :, None, axis] <= high[:, None, :, axis])
            meet &= low[:, None, :, axis] <= high[:, :, None, axis]
        which, one, two = np.nonzero(meet)
        found.append((member[which, one], member[which, two]))
    return np.concatenate([a for a, _ in found]), np.concatenate([b for _, b in found])
