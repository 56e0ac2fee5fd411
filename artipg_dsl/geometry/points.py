"""Exactly n points per object, uniform by area over its visible surface, each bound to (site, row, patch, u, v).

Candidates are allocated to the patches of an object by one random offset and fall on them by addressed random
numbers; the hidden ones are dropped and the rest thinned evenly. Nothing that is drawn for an object depends on the
others in the batch. Candidates stand in the order of the cells: what is kept of them is in order too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..graph import random
from .block import Block, block
from .cells import Cells, Coordinates
from .density import Placement, solve_linear
from .flat import PLANAR
from .hidden import Occlusion, runs, scales
from .sites import SiteTable

_ROWS, _OBJECTS = 16_000, 256  # at most in a block, about
_CANDIDATES = 40_000  # at a time: their arrays stay in the caches
_SPARE = 1.06  # candidates per point wanted, were all to be seen that are thought to be
_LEAST_GUESS = 1 / 4  # share of visible candidates that the first round reckons with at least
_ROUNDS = 40
_LEAST = 1 / 64  # share of visible candidates that later rounds reckon with at least
_OFFSET_LANE, _THIN_LANE = 0xFFFFFFFF, 0xFFFFFFFE


class PointsError(Exception):
    """Objects (their indices in the batch) that have no visible surface to put points on."""

    def __init__(self, objects: list[int]):
        super().__init__(f"no visible surface on objects {objects[:5]}")
        self.objects = objects


@dataclass(frozen=True, slots=True, eq=False)
class PointSet:
    """n points for each of B objects; metres, in the frames of the objects.

    The binding is (``site`` number, ``row`` of that site's table, ``patch`` number, fractions ``u``, ``v``).
    """

    site: np.ndarray  # (B, n) int32
    row: np.ndarray  # (B, n) int32
    patch: np.ndarray  # (B, n) int16
    u: np.ndarray  # (B, n)
    v: np.ndarray  # (B, n)
    position: np.ndarray  # (B, n, 3)
    normal: np.ndarray  # (B, n, 3)


def sample(sites: list[SiteTable], n_objects: int, n_points: int, key: random.Key, address: np.ndarray) -> PointSet:
    """Points of ``n_objects`` objects whose rows ``sites`` hold; ``address`` (n_objects,) uint64 names each to ``key``.

    Raises PointsError for objects without visible surface.
    """
    shape = (n_objects, n_points)
    out = PointSet(
        np.zeros(shape, np.int32), np.zeros(shape, np.int32), np.zeros(shape, np.int16), np.zeros(shape),
        np.zeros(shape), np.zeros((*shape, 3)), np.zeros((*shape, 3)),
    )  # fmt: skip
    if n_points:
        for first, stop in _blocks(sites, n_objects):
            _Sampler(block(sites, first, stop), key, address[first:stop], first, n_points).fill(out)
    return out


def _blocks(sites: list[SiteTable], n_objects: int) -> list[tuple[int, int]]:
    """Ranges of objects that are set up together."""
    step = max(1, min(_OBJECTS, _ROWS * n_objects // max(1, sum(len(s) for s in sites))))
    return [(first, min(first + step, n_objects)) for first in range(0, n_objects, step)]


def _even(number: np.ndarray) -> np.ndarray:
    """Counts of candidates: even, as two share one random function value."""
    half = np.ceil(number / 2).astype(np.int64)
    return 2 * half


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """One round: ``wanted`` (objects,) candidates, ``count`` (C,) of them on each cell, ``before`` (C,) lanes first."""

    attempt: int
    wanted: np.ndarray
    count: np.ndarray
    before: np.ndarray


class _Sampler:
    """The candidates of one block of objects."""

    def __init__(self, rows: Block, key: random.Key, address: np.ndarray, first: int, n: int):
        self.rows, self.key, self.first, self.n = rows, key, first, n
        self.address = np.asarray(address, dtype=np.uint64)
        self.cells = cells = Cells(rows)
        cells.measure_bent()
        together = max(1, _CANDIDATES // (n + 32))
        self.groups = [(k, min(k + together, rows.objects)) for k in range(0, rows.objects, together)]
        self.occlusion = Occlusion(cells, scales(rows), np.arange(rows.objects) // together)
        area = np.where(self.occlusion.buried, 0.0, cells.area)
        counts = np.diff(cells.start)
        slot = np.arange(len(area)) - cells.start[cells.owner]
        padded = np.zeros((rows.objects, max(1, int(counts.max(initial=1)))))
        padded[cells.owner, slot] = area
        running = np.cumsum(padded, axis=1)
        total = running[:, -1]
        if (total <= 0.0).any():
            raise PointsError((first + np.flatnonzero(total <= 0.0)).tolist())
        self.share = (running / total[:, None])[cells.owner, slot]
        seen = np.bincount(cells.owner, area * self.occlusion.visible(), minlength=rows.objects)
        self.guess = np.maximum(seen / total, _LEAST_GUESS)
        self.head = slot == 0

    def fill(self, out: PointSet) -> None:
        """Rounds of candidates until every object has its points."""
        n = self.n
        filled = np.zeros(self.rows.objects, dtype=np.int64)
        wanted = _even(_SPARE * n / self.guess + 32)
        tried, seen = np.zeros_like(wanted), np.zeros_like(wanted)
        for attempt in range(_ROUNDS):
            survivors = self._round(out, filled, wanted, attempt)
            tried += wanted
            seen += survivors
            filled = np.minimum(filled + survivors, n)
            missing = n - filled
            if not missing.any():
                return
            share = np.maximum(seen / tried, _LEAST)
            wanted = np.where(missing > 0, _even(_SPARE * missing / share + 32), 0)
        raise PointsError((self.first + np.flatnonzero(filled < n)).tolist())

    def _round(self, out: PointSet, filled: np.ndarray, wanted: np.ndarray, attempt: int) -> np.ndarray:
        """One round of ``wanted`` (objects,) candidates; the survivors counted, and written as far as there is room."""
        cells = self.cells
        offset, thin = (random.uniform(self.key, self.address, lane, attempt) for lane in (_OFFSET_LANE, _THIN_LANE))
        most = wanted[cells.owner]
        upto = np.clip(np.ceil(most * self.share - offset[cells.owner]), 0, most).astype(np.int64)
        before = np.concatenate([[0], upto[:-1]])
        before[self.head] = 0
        drawn = _Drawn(attempt, wanted, upto - before, before)
        bent = _BentPoints(self, drawn)
        survivors = np.zeros_like(wanted)
        for number, (low, high) in enumerate(self.groups):
            if wanted[low:high].any():
                survivors[low:high] = self._group(out, number, low, high, filled, thin, drawn, bent)
        return survivors

    def _group(
        self, out: PointSet, number: int, low: int, high: int, filled: np.ndarray, thin: np.ndarray, drawn: _Drawn,
        bent: _BentPoints,
    ) -> np.ndarray:  # fmt: skip
        """The candidates of the objects ``low .. high - 1``; how many of each can be seen."""
        cells, n, objects = self.cells, self.n, slice(low, high)
        begin, end = int(cells.start[low]), int(cells.start[high])
        count = drawn.count[begin:end]
        start = np.cumsum(count) - count
        wanted = drawn.wanted[objects]
        u, v = random.coarse_pairs(self.key, self.address[objects], wanted, drawn.attempt)
        self._slant(begin, start, count, u, v)
        mine = slice(*np.searchsorted(bent.cell, (begin, end)).tolist())
        at = start[bent.cell[mine] - begin] + bent.nth[mine]
        hidden = self.occlusion.flat_hidden(number, begin, start, count, u, v)
        u[at], v[at], hidden[at] = bent.u[mine], bent.v[mine], bent.hidden[mine]

        running = np.concatenate([[0], np.cumsum(~hidden)])
        upto = np.cumsum(wanted)
        survivors = running[upto] - running[upto - wanted]
        room = np.minimum(n - filled[objects], survivors)
        kept = np.flatnonzero(~hidden)
        if (room < survivors).any():  # thin evenly
            rank = np.arange(len(kept)) - np.repeat(np.cumsum(survivors) - survivors, survivors)
            total, take = np.repeat(survivors, survivors), np.repeat(room, survivors)
            shift = np.minimum((thin[objects] * survivors).astype(np.int64), np.maximum(survivors - 1, 0))
            place = rank * take + np.repeat(shift, survivors)
            kept = kept[place % total + take >= total]
        cell = np.repeat(np.arange(begin, end), count)[kept]
        u, v = u[kept], v[kept]
        position, normal = cells.flat_position(cell, u, v), [x[cell] for x in cells.normal]
        if len(at):
            among = np.searchsorted(kept, at)
            there = np.flatnonzero(np.append(kept, -1)[among] == at)
            for axis in range(3):
                position[axis][among[there]] = bent.position[axis][mine][there]
                normal[axis][among[there]] = bent.normal[axis][mine][there]
        row = cells.row[cell]
        target: slice | np.ndarray
        if (room == n).all():
            target = slice((self.first + low) * n, (self.first + high) * n)
        else:
            target = runs((self.first + np.arange(low, high)) * n + filled[objects], room)
        out.site.reshape(-1)[target] = self.rows.site[row]
        out.row.reshape(-1)[target] = self.rows.row[row]
        out.patch.reshape(-1)[target] = cells.patch[cell]
        out.u.reshape(-1)[target], out.v.reshape(-1)[target] = u, v
        for axis in range(3):
            out.position.reshape(-1, 3)[target, axis] = position[axis]
            out.normal.reshape(-1, 3)[target, axis] = normal[axis]
        return survivors

    def _slant(self, begin: int, start: np.ndarray, count: np.ndarray, u: np.ndarray, v: np.ndarray) -> None:
        """Fractions, uniform by area, on the cells from ``begin`` on whose element grows along u or v."""
        chosen = np.flatnonzero((self.cells.shape[begin : begin + len(count)] == PLANAR) & (count > 0))
        cell, at = np.repeat(begin + chosen, count[chosen]), runs(start[chosen], count[chosen])
        base, along_u, along_v = (e[cell] for e in self.cells.element)
        middle = base + along_v / 2
        u[at] = solve_linear(u[at], middle, middle + along_u)
        left = base + along_u * u[at]
        v[at] = solve_linear(v[at], left, left + along_v)


class _BentPoints:
    """The candidates of one round on the cells that are not flat, of all objects of a block, sorted by cell and lane.

    ``nth`` counts them within their cell; ``u``, ``v``, ``hidden`` (m,), ``position`` and ``normal`` three (m,) each.
    """

    def __init__(self, sampler: _Sampler, drawn: _Drawn):
        cells = sampler.cells
        every = np.concatenate([np.empty(0, np.int64), *(bent.cell for bent in cells.bent)])
        count = drawn.count[every]
        cell = np.repeat(every, count)
        nth = runs(np.zeros_like(count), count)
        owner = cells.owner[cell]
        u, v = random.coarse_pair(sampler.key, sampler.address[owner], drawn.before[cell] + nth, drawn.attempt)
        position, normal = np.empty((3, len(cell))), np.empty((3, len(cell)))
        begin = 0
        done = np.cumsum(np.concatenate([[0], count]))
        for bent in cells.bent:
            stop = begin + len(bent.cell)
            part = slice(int(done[begin]), int(done[stop]))
            begin = stop
            if part.start == part.stop:
                continue
            _, local, params = cells.rows_asked(bent, cell[part])
            u[part], v[part] = Placement(bent.shelf.primitive, bent.patch, params).place(local, u[part], v[part])
            at, outward = cells.bent_position(bent, cell[part], u[part], v[part])
            for axis in range(3):
                position[axis, part], normal[axis, part] = at[axis], outward[axis]
        order = np.lexsort((nth, cell))
        self.cell, self.nth, self.u, self.v = cell[order], nth[order], u[order], v[order]
        self.position: Coordinates = (position[0, order], position[1, order], position[2, order])
        self.normal: Coordinates = (normal[0, order], normal[1, order], normal[2, order])
        self.hidden = sampler.occlusion.bent_hidden(self.cell, self.position, self.normal)


def evaluate(sites: list[SiteTable], binding: PointSet) -> tuple[np.ndarray, np.ndarray]:
    """Positions and normals (B, n, 3) of bound points on the present rows of ``sites``.

    On the rows they were sampled from, the very bits of the sampled positions and normals.
    """
    position, normal = np.empty(binding.position.shape), np.empty(binding.normal.shape)
    count = binding.u.shape[1]
    for first, stop in _blocks(sites, len(binding.u)):
        part = slice(first, stop)
        rows = block(sites, first, stop)
        cells = Cells(rows)
        cell = cells.first[_rows(sites, rows, binding.site[part].ravel(), binding.row[part].ravel())]
        cell = cell + binding.patch[part].ravel()
        u, v = binding.u[part].ravel(), binding.v[part].ravel()
        place, direction = cells.flat_position(cell, u, v), [x[cell] for x in cells.normal]
        for bent in cells.bent:
            at = np.flatnonzero(np.isin(cell, bent.cell))
            if len(at):
                made = cells.bent_position(bent, cell[at], u[at], v[at])
                for axis in range(3):
                    place[axis][at], direction[axis][at] = made[0][axis], made[1][axis]
        position[part] = np.stack(place, axis=-1).reshape(-1, count, 3)
        normal[part] = np.stack(direction, axis=-1).reshape(-1, count, 3)
    return position, normal


def _rows(sites: list[SiteTable], rows: Block, number: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Rows of a block for pairs (site number, row of that site's table); ValueError when there is no such row."""
    longest = max((len(s) for s in sites), default=0) + 1
    have, asked = rows.site * longest + rows.row, number.astype(np.int64) * longest + row
    order = np.argsort(have)
    found = order[np.minimum(np.searchsorted(have[order], asked), len(order) - 1)]
    if (have[found] != asked).any():
        raise ValueError("points are bound to rows that their objects do not have")
    return found
