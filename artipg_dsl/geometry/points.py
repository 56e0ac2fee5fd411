"""Exactly n points per object, uniform by area over its visible surface, each bound to (site, row, patch, u, v).

Candidates are allocated to the patches of an object by one random offset and fall on them by addressed random
numbers; the hidden ones are dropped and the rest thinned evenly. Nothing that is drawn for an object depends on the
others in the batch. Candidates stand in the order of the cells: what is kept of them is in order too.

What gets n points is called a *pool*: the rows of an object, or those of one of its links, parts or primitives.
Whatever the pools, points are hidden by all rows of their object.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import random
from ..records import dataclass
from .block import Block, Coordinates, block_of, to_object
from .cells import Cells
from .density import AreaPlacement, solve_linear
from .flat import BENT, PLANAR
from .hidden import Occlusion, runs, scales
from .outside import Outlook
from .pointset import PointSet, Pools
from .sites import SiteTable
from .surface import PatchEvaluator

_ROWS, _OBJECTS = 16_000, 256  # at most in a block, about
_LOOKED_AT = 32  # objects in a block whose triangles are needed
_RARELY = 0.5  # points that flat cells have at least, about, if they are prepared for being asked quickly
_POINTS = 2_000_000  # in a block, about
_CANDIDATES = 40_000  # at a time: their arrays stay in the caches
_CHUNK = 16_000  # points on one bent patch at a time, likewise
_SPARE = 1.06  # candidates per point wanted, were all to be seen that are thought to be
_LEAST_GUESS = 1 / 4  # share of visible candidates that the first round reckons with at least
_ROUNDS = 40
_LEAST = 1 / 64  # share of visible candidates that later rounds reckon with at least
_HOPELESS, _HOPELESS_OUTSIDE = 50_000, 5_000  # candidates none of which is seen: nothing is
_OFFSET_LANE, _THIN_LANE = 0xFFFFFFFF, 0xFFFFFFFE


class PointsError(Exception):
    """Objects (their indices in the batch) that have no visible surface to put points on."""

    def __init__(self, objects: list[int]):
        super().__init__(f"no visible surface on objects {objects[:5]}")
        self.objects = objects


def sample(
    sites: list[SiteTable],
    n_objects: int,
    n_points: int,
    key: random.Key,
    address: np.ndarray,
    *,
    outside: bool = False,
) -> PointSet:
    """Points of ``n_objects`` objects whose rows ``sites`` hold; ``address`` (n_objects,) uint64 names each to ``key``.

    The surface is the boundary of the union of the primitives; with ``outside`` what of it can be seen from without
    (see ``outside.Outlook``). Raises PointsError for objects without such surface.
    """
    labels = [np.zeros(len(site), dtype=np.int64) for site in sites]
    address = np.asarray(address, dtype=np.uint64)
    pools = Pools.of(sites, labels, n_objects)
    found = _sample(sites, pools, np.full(len(pools.owner), n_points), key, address, outside)
    if not found.full.all():
        raise PointsError(np.flatnonzero(~found.full).tolist())
    return found.points


def sample_pools(
    sites: list[SiteTable],
    labels: list[np.ndarray],
    n_objects: int,
    n_points: int,
    key: random.Key,
    address: np.ndarray,
    *,
    outside: bool = False,
) -> tuple[PointSet, Pools, np.ndarray]:
    """The same for the pools that ``labels`` tell: one array (k,) of whole numbers from 0 on per site table.

    The points (P, n) and the pools that have them, and about how much surface each shows (P,), in square metres. Pools
    without surface are left out: those of which none of the first 50,000 candidates can be seen (``outside``: 5,000),
    or less than one in 2,500 of more.
    """
    pools = Pools.of(sites, labels, n_objects)
    counts = np.full(len(pools.owner), n_points)
    points, full, area = sample_counts(sites, pools, counts, key, address, outside=outside)
    if full.all():
        return points, pools, area
    kept = np.flatnonzero(full)
    return points.take(kept), Pools(pools.owner[kept], pools.label[kept], []), area[kept]


def sample_counts(
    sites: list[SiteTable],
    pools: Pools,
    counts: np.ndarray,
    key: random.Key,
    address: np.ndarray,
    *,
    outside: bool = False,
) -> tuple[PointSet, np.ndarray, np.ndarray]:
    """The same with a number of points of its own for each pool, ``counts`` (P,): they come first in rows (P, n) of the
    largest number. Which pools have all of theirs (P,) bool, and their surface (P,)."""
    named = random.mix(np.asarray(address, dtype=np.uint64)[pools.owner], pools.label)
    found = _sample(sites, pools, counts, key, named, outside)
    return found.points, found.full, found.area


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """Points (P, n), which pools are ``full``, and about how much visible surface they have."""

    points: PointSet
    full: np.ndarray
    area: np.ndarray


def _sample(
    sites: list[SiteTable], pools: Pools, counts: np.ndarray, key: random.Key, address: np.ndarray, outside: bool
) -> _Found:
    count, n_points = len(pools.owner), int(counts.max(initial=0))
    found = _Found(PointSet.empty(count, n_points), np.ones(count, dtype=bool), np.zeros(count))
    if not count or not n_points:
        return found
    offsets = np.cumsum([0, *(len(site) for site in sites)])
    pool_of = np.concatenate([np.empty(0, np.int64), *pools.rows])
    place = {site.number: int(offset) for site, offset in zip(sites, offsets[:-1], strict=True)}
    starts = np.zeros(max(place, default=0) + 1, dtype=np.int64)
    starts[list(place)] = list(place.values())
    objects = int(pools.owner[-1]) + 1
    most = min(_LOOKED_AT if outside else _OBJECTS, max(1, _POINTS * objects // (count * n_points)))
    for first, stop in _blocks(sites, objects, most):
        rows = block_of(sites, first, stop)
        low, high = np.searchsorted(pools.owner, (first, stop)).tolist()
        pool = pool_of[starts[rows.site] + rows.row] - low
        _Sampler(rows, pool, key, address[low:high], low, counts[low:high], outside).fill(found)
    return found


def _blocks(sites: list[SiteTable], n_objects: int, most: int = _OBJECTS) -> list[tuple[int, int]]:
    """Ranges of objects that are set up together."""
    step = max(1, min(most, _ROWS * n_objects // max(1, sum(len(s) for s in sites))))
    return [(first, min(first + step, n_objects)) for first in range(0, n_objects, step)]


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """One round: ``stream`` (pools,) of random numbers, ``wanted`` (pools,) candidates, ``count`` (C,) of them on each
    cell, ``before`` (C,) lanes first."""

    stream: np.ndarray
    wanted: np.ndarray
    count: np.ndarray
    before: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class _Candidates:
    """Candidates of a group in the order of their cells: ``loose`` are those which are ``mine`` among the
    ``_LoosePoints``."""

    cell: np.ndarray
    u: np.ndarray
    v: np.ndarray
    loose: np.ndarray
    mine: slice


class _Sampler:
    """The candidates of one block of objects: of the pools from ``first`` on, ``address`` (pools,) each and ``n`` (pools,)
    points wanted."""

    def __init__(
        self,
        rows: Block,
        pool: np.ndarray,
        key: random.Key,
        address: np.ndarray,
        first: int,
        n: np.ndarray,
        outside: bool,
    ):
        self.rows, self.key, self.first, self.n = rows, key, first, n
        self.address = address
        self.cells = cells = Cells(rows, pool, len(address))
        cells.measure_bent(None if outside else n > 0)  # what is seen from without depends on all surfaces
        together = max(1, _CANDIDATES // (int(n.max(initial=0)) + 32))
        self.groups = [(k, min(k + together, len(address))) for k in range(0, len(address), together)]
        self.occlusion = Occlusion(cells, scales(rows), np.arange(len(address)) // together, _RARELY / np.maximum(n, 1))
        self.outlook = Outlook(cells, self.occlusion.off, self.occlusion.buried) if outside else None
        area = np.where(self.occlusion.buried, 0.0, cells.area)
        counts = np.diff(cells.start)
        slot = np.arange(len(area)) - cells.start[cells.pool]
        padded = np.zeros((len(address), max(1, int(counts.max(initial=1)))))
        padded[cells.pool, slot] = area
        running = np.cumsum(padded, axis=1)
        self.total = running[:, -1]
        total = np.where(self.total > 0.0, self.total, 1.0)
        self.share = (running / total[:, None])[cells.pool, slot]
        seen = np.bincount(cells.pool, area * self.occlusion.visible(), minlength=len(address))
        self.guess = np.maximum(seen / total, _LEAST_GUESS)
        self.head = slot == 0

    def fill(self, found: _Found) -> None:
        """Rounds of candidates until every pool has its points, or is found to have no surface for them."""
        n = self.n
        filled = np.zeros(len(self.address), dtype=np.int64)
        room = (self.total > 0.0) & (n > 0)
        wanted = np.where(room, np.ceil(_SPARE * n / self.guess + 32), 0).astype(np.int64)
        tried, seen = np.zeros_like(wanted), np.zeros_like(wanted)
        hopeless = _HOPELESS if self.outlook is None else _HOPELESS_OUTSIDE
        for attempt in range(_ROUNDS):
            survivors = self._round(found.points, filled, wanted, attempt)
            tried += wanted
            seen += survivors
            filled = np.minimum(filled + survivors, n)
            missing = np.where((self.total > 0.0) & ((seen > 0) | (tried < hopeless)), n - filled, 0)
            if not missing.any():
                break
            share = np.maximum(seen / np.maximum(tried, 1), _LEAST)
            wanted = np.where(missing > 0, np.ceil(_SPARE * missing / share + 32), 0).astype(np.int64)
            wanted = np.where(seen > 0, wanted, np.minimum(wanted, hopeless))
        mine = slice(self.first, self.first + len(filled))
        found.full[mine] = filled == n
        found.area[mine] = self.total * seen / np.maximum(tried, 1)

    def _round(self, out: PointSet, filled: np.ndarray, wanted: np.ndarray, attempt: int) -> np.ndarray:
        """One round of ``wanted`` (pools,) candidates; the survivors counted, and written as far as there is room."""
        cells = self.cells
        offset, thin = (random.uniform(self.key, self.address, lane, attempt) for lane in (_OFFSET_LANE, _THIN_LANE))
        most = wanted[cells.pool]
        upto = np.clip(np.ceil(most * self.share - offset[cells.pool]), 0, most).astype(np.int64)
        before = np.concatenate([[0], upto[:-1]])
        before[self.head] = 0
        drawn = _Drawn(random.streams(self.key, self.address, attempt), wanted, upto - before, before)
        loose = _LoosePoints(self, drawn)
        survivors = np.zeros_like(wanted)
        for number, (low, high) in enumerate(self.groups):
            if wanted[low:high].any():
                survivors[low:high] = self._group(out, number, low, high, filled, thin, drawn, loose)
        return survivors

    def _group(
        self,
        out: PointSet,
        number: int,
        low: int,
        high: int,
        filled: np.ndarray,
        thin: np.ndarray,
        drawn: _Drawn,
        loose: _LoosePoints,
    ) -> np.ndarray:
        """The candidates of the pools ``low .. high - 1``; how many of each can be seen."""
        cells, stride, pools = self.cells, out.u.shape[1], slice(low, high)
        n = self.n[pools]
        begin, end = int(cells.start[low]), int(cells.start[high])
        count = drawn.count[begin:end]
        start = np.cumsum(count) - count
        wanted = drawn.wanted[pools]
        u, v = random.coarse(np.repeat(drawn.stream[pools], wanted), runs(np.zeros_like(wanted), wanted))
        slanting = np.flatnonzero((cells.shape[begin:end] == PLANAR) & (count > 0))
        cell = np.repeat(begin + slanting, count[slanting])
        _slant(cells, cell, runs(start[slanting], count[slanting]), u, v)
        mine = slice(*np.searchsorted(loose.cell, (begin, end)).tolist())
        at = start[loose.cell[mine] - begin] + loose.nth[mine]
        hidden = self.occlusion.flat_hidden(number, begin, start, count, u, v)
        u[at], v[at], hidden[at] = loose.u[mine], loose.v[mine], loose.hidden[mine]
        every = _Candidates(np.repeat(np.arange(begin, end), count), u, v, at, mine)
        kept = np.flatnonzero(~hidden)
        if self.outlook is not None:
            kept = kept[self.outlook.sees(every.cell[kept], *self._places(every, kept, loose))]
        borders = np.searchsorted(kept, np.concatenate([[0], np.cumsum(wanted)]))
        survivors = np.diff(borders)
        room = np.minimum(n - filled[pools], survivors)
        if (room < survivors).any():  # thin evenly
            rank = np.arange(len(kept)) - np.repeat(borders[:-1], survivors)
            total, take = np.repeat(survivors, survivors), np.repeat(room, survivors)
            shift = np.minimum((thin[pools] * survivors).astype(np.int64), np.maximum(survivors - 1, 0))
            place = rank * take + np.repeat(shift, survivors)
            kept = kept[place % total + take >= total]
        cell = every.cell[kept]
        position, normal = self._places(every, kept, loose)
        row = cells.row[cell]
        target: slice | np.ndarray
        if (room == stride).all():
            target = slice((self.first + low) * stride, (self.first + high) * stride)
        else:
            target = runs((self.first + np.arange(low, high)) * stride + filled[pools], room)
        out.site.reshape(-1)[target] = self.rows.site[row]
        out.row.reshape(-1)[target] = self.rows.row[row]
        out.patch.reshape(-1)[target] = cells.patch[cell]
        out.u.reshape(-1)[target], out.v.reshape(-1)[target] = u[kept], v[kept]
        for axis in range(3):
            out.position.reshape(-1, 3)[target, axis] = position[axis]
            out.normal.reshape(-1, 3)[target, axis] = normal[axis]
        return survivors

    def _places(self, every: _Candidates, kept: np.ndarray, loose: _LoosePoints) -> tuple[list[Any], list[Any]]:
        """Positions and normals of the candidates ``kept`` (ascending), three arrays each."""
        cells = self.cells
        if not len(every.loose):
            cell = every.cell[kept]
            return list(cells.flat_position(cell, every.u[kept], every.v[kept])), [x[cell] for x in cells.normal]
        which = np.full(len(every.cell), -1)  # of the loose points, if it is one
        which[every.loose] = np.arange(every.mine.start, every.mine.stop)
        which = which[kept]
        flat, other = np.flatnonzero(which < 0), np.flatnonzero(which >= 0)
        which, some = which[other], kept[flat]
        cell = every.cell[some]
        placed = cells.flat_position(cell, every.u[some], every.v[some])
        position, normal = [np.empty(len(kept)) for _ in range(3)], [np.empty(len(kept)) for _ in range(3)]
        for axis in range(3):
            position[axis][flat], normal[axis][flat] = placed[axis], cells.normal[axis][cell]
            position[axis][other], normal[axis][other] = loose.position[axis][which], loose.normal[axis][which]
        return position, normal


def _slant(cells: Cells, cell: np.ndarray, at: np.ndarray, u: np.ndarray, v: np.ndarray) -> None:
    """Make the fractions ``u[at]``, ``v[at]`` uniform by area on flat cells whose element grows along u or v."""
    base, along_u, along_v = (e[cell] for e in cells.element)
    middle = base + along_v / 2
    u[at] = solve_linear(u[at], middle, middle + along_u)
    left = base + along_u * u[at]
    v[at] = solve_linear(v[at], left, left + along_v)


class _LoosePoints:
    """The candidates of one round, of all pools of a block, on the cells that are not prepared: the bent ones, and flat
    ones so small that hardly a point falls on them. Sorted by cell and lane.

    ``nth`` counts them within their cell; ``u``, ``v``, ``hidden`` (m,), ``position`` and ``normal`` three (m,) each.
    """

    def __init__(self, sampler: _Sampler, drawn: _Drawn):
        cells = sampler.cells
        small = np.flatnonzero((cells.shape != BENT) & ~sampler.occlusion.prepared & (drawn.count > 0))
        every = np.concatenate([*(bent.cell for bent in cells.bent), small])
        count = drawn.count[every]
        cell = np.repeat(every, count)
        nth = runs(np.zeros_like(count), count)
        u, v = random.coarse(drawn.stream[cells.pool[cell]], drawn.before[cell] + nth)
        position, normal = np.empty((3, len(cell))), np.empty((3, len(cell)))
        begin = 0
        done = np.cumsum(np.concatenate([[0], count]))
        for bent in cells.bent:
            stop = begin + len(bent.cell)
            part = slice(int(done[begin]), int(done[stop]))
            begin = stop
            if part.start == part.stop:
                continue
            row, local, params = cells.rows_asked(bent, cell[part])
            placement = AreaPlacement(bent.shelf.primitive, bent.patch, params)
            surface = PatchEvaluator(bent.shelf.primitive, bent.patch, params)
            for low in range(0, part.stop - part.start, _CHUNK):
                some, mine = (
                    slice(part.start + low, min(part.start + low + _CHUNK, part.stop)),
                    slice(low, low + _CHUNK),
                )
                u[some], v[some] = placement.place(local[mine], u[some], v[some])
                at, outward = surface.at(local[mine], u[some], v[some])
                at, outward = to_object(cells.poses, row[mine], at, outward)
                for axis in range(3):
                    position[axis, some], normal[axis, some] = at[axis], outward[axis]
        part = slice(int(done[begin]), len(cell))
        slanting = np.flatnonzero(cells.shape[cell[part]] == PLANAR)
        _slant(cells, cell[part][slanting], slanting, u[part], v[part])
        at = cells.flat_position(cell[part], u[part], v[part])
        for axis in range(3):
            position[axis, part], normal[axis, part] = at[axis], cells.normal[axis][cell[part]]
        order = np.argsort(cell, kind="stable")
        self.cell, self.nth, self.u, self.v = cell[order], nth[order], u[order], v[order]
        self.position: Coordinates = (position[0, order], position[1, order], position[2, order])
        self.normal: Coordinates = (normal[0, order], normal[1, order], normal[2, order])
        self.hidden = sampler.occlusion.loose_hidden(self.cell, self.position, self.normal)


def evaluate(sites: list[SiteTable], binding: PointSet) -> tuple[np.ndarray, np.ndarray]:
    """Positions and normals (B, n, 3) of bound points on the present rows of ``sites``.

    On the rows they were sampled from, the very bits of the sampled positions and normals. Raises ValueError for points
    that are bound to rows which their objects do not have.
    """
    shape = binding.u.shape
    owner = np.repeat(np.arange(shape[0]), shape[1])
    names = ("site", "row", "patch", "u", "v")
    position, normal, _ = evaluate_flat(sites, owner, *(getattr(binding, name).ravel() for name in names))
    return position.reshape(*shape, 3), normal.reshape(*shape, 3)


def evaluate_flat(
    sites: list[SiteTable],
    owner: np.ndarray,
    site: np.ndarray,
    row: np.ndarray,
    patch: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same for m points of objects ``owner`` (m,), ascending: positions and normals (m, 3), and whether the patch
    exists (m,)."""
    position, normal = np.empty((len(owner), 3)), np.empty((len(owner), 3))
    exists = np.empty(len(owner), dtype=bool)
    for first, stop in _blocks(sites, int(owner[-1]) + 1 if len(owner) else 0):
        part = slice(*np.searchsorted(owner, (first, stop)).tolist())
        if part.start == part.stop:
            continue
        rows = block_of(sites, first, stop)
        cells = Cells(rows)
        own = _rows(sites, rows, site[part], row[part])
        if (rows.owner[own] != owner[part] - first).any():
            raise ValueError(_NOT_THEIRS)
        cell = cells.first[own] + patch[part]
        at_u, at_v = u[part], v[part]
        place, direction = cells.flat_position(cell, at_u, at_v), [x[cell] for x in cells.normal]
        for bent in cells.bent:
            at = np.flatnonzero(np.isin(cell, bent.cell))
            if len(at):
                made = cells.bent_position(bent, cell[at], at_u[at], at_v[at])
                for axis in range(3):
                    place[axis][at], direction[axis][at] = made[0][axis], made[1][axis]
        position[part], normal[part] = np.stack(place, axis=-1), np.stack(direction, axis=-1)
        exists[part] = cells.exists[cell]
    return position, normal, exists


_NOT_THEIRS = "points are bound to rows that their objects do not have"


def _rows(sites: list[SiteTable], rows: Block, number: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Rows of a block for pairs (site number, row of that site's table); ValueError when there is no such row."""
    longest = max((len(s) for s in sites), default=0) + 1
    have, asked = rows.site * longest + rows.row, number.astype(np.int64) * longest + row
    order = np.argsort(have)
    found = order[np.minimum(np.searchsorted(have[order], asked), len(order) - 1)]
    if (have[found] != asked).any():
        raise ValueError(_NOT_THEIRS)
    return found
