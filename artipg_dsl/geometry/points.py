"""Exactly n points per object, uniform by area over its visible surface, each bound to (site, row, patch, u, v).

Candidates are allocated to the patches of an object by one random offset and fall on them by addressed random
numbers; the hidden ones are dropped and the rest thinned evenly. Nothing that is drawn for an object depends on the
others in the batch. Candidates stand in the order of the cells: what is kept of them is in order too.

What gets n points is called a *pool*: the rows of an object, or those of one of its links, parts or primitives.
Whatever the pools, points are hidden by all rows of their object.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .. import random
from ..records import dataclass
from .block import Block, block_of
from .candidates import Candidates, Drawn, LoosePoints, Thinning, draw, slant
from .cells import Cells
from .cover import meeting_rows, scales
from .flat import PLANAR
from .hidden import Occlusion
from .outside import Outlook
from .pointset import PointSet, Pools
from .runs import runs
from .sites import SiteTable

_ROWS, _OBJECTS = 16_000, 256  # at most in a block, about
_LOOKED_AT = 32  # objects in a block whose triangles are needed
_RARELY = 0.5  # points that flat cells have at least, about, if they are prepared for being asked quickly
_POINTS = 2_000_000  # in a block, about
_CANDIDATES = 40_000  # at a time: their arrays stay in the caches
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
    order: Callable[[Pools], np.ndarray] | None = None,
) -> tuple[PointSet, Pools, np.ndarray]:
    """The same for the pools that ``labels`` tell: one array (k,) of whole numbers from 0 on per site table.

    The points (P, n) and the pools that have them, and about how much surface each shows (P,), in square metres. Pools
    without surface are left out: those of which none of the first 50,000 candidates can be seen (``outside``: 5,000),
    or less than one in 2,500 of more. Points are sorted by their surfaces; ``order`` tells in which order (P, n) they are wanted.
    """
    pools = Pools.of(sites, labels, n_objects)
    counts = np.full(len(pools.owner), n_points)
    place = None
    if order is not None and len(counts):
        place = np.empty(counts.sum(), dtype=np.int64)
        place[(np.cumsum(counts) - counts)[:, None] + order(pools)] = np.arange(len(place)).reshape(-1, n_points)
    points, full, area = sample_counts(sites, pools, counts, key, address, outside=outside, place=place)
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
    place: np.ndarray | None = None,
) -> tuple[PointSet, np.ndarray, np.ndarray]:
    """The same with a number of points of its own for each pool, ``counts`` (P,): they come first in rows (P, n) of the
    largest number. Which pools have all of theirs (P,) bool, and their surface (P,). ``place`` (P * n,): where points go instead."""
    named = random.mix(np.asarray(address, dtype=np.uint64)[pools.owner], pools.label)
    found = _sample(sites, pools, counts, key, named, outside, place)
    return found.points, found.full, found.area


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """Points (P, n), which pools are ``full``, and about how much visible surface they have. ``place`` (P * n,): where points go instead."""

    points: PointSet
    full: np.ndarray
    area: np.ndarray
    place: np.ndarray | None


def _sample(
    sites: list[SiteTable],
    pools: Pools,
    counts: np.ndarray,
    key: random.Key,
    address: np.ndarray,
    outside: bool,
    place: np.ndarray | None = None,
) -> _Found:
    count, n_points = len(pools.owner), int(counts.max(initial=0))
    found = _Found(PointSet.empty(count, n_points), np.ones(count, dtype=bool), np.zeros(count), place)
    if not count or not n_points:
        return found
    offsets = np.cumsum([0, *(len(site) for site in sites)])
    pool_of = np.concatenate([np.empty(0, np.int64), *pools.rows])
    begin = {site.number: int(offset) for site, offset in zip(sites, offsets[:-1], strict=True)}
    starts = np.zeros(max(begin, default=0) + 1, dtype=np.int64)
    starts[list(begin)] = list(begin.values())
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
        self.key, self.first, self.n = key, first, n
        self.address = address
        off = scales(rows)
        asked = n[pool] > 0
        near, other = meeting_rows(rows, off, asked)
        if not (outside or asked.all()):  # what is seen from without depends on all rows
            asked[other] = True
            rows, pool, place = rows.only(asked), pool[asked], np.cumsum(asked) - 1
            near, other = place[near], place[other]
        self.cells = cells = Cells(rows, pool, len(address))
        cells.measure_bent(None if outside else n > 0)  # what is seen from without depends on all surfaces
        together = max(1, _CANDIDATES // (int(n.max(initial=0)) + 32))
        self.groups = [(k, min(k + together, len(address))) for k in range(0, len(address), together)]
        group, least = np.arange(len(address)) // together, _RARELY / np.maximum(n, 1)
        self.occlusion = Occlusion(cells, off, group, least, (near, other))
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
            survivors = self._round(found, filled, wanted, attempt)
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

    def _round(self, out: _Found, filled: np.ndarray, wanted: np.ndarray, attempt: int) -> np.ndarray:
        """One round of ``wanted`` (pools,) candidates; the survivors counted, and written as far as there is room."""
        cells = self.cells
        offset, thin = (random.uniform(self.key, self.address, lane, attempt) for lane in (_OFFSET_LANE, _THIN_LANE))
        most = wanted[cells.pool]
        upto = np.clip(np.ceil(most * self.share - offset[cells.pool]), 0, most).astype(np.int64)
        before = np.concatenate([[0], upto[:-1]])
        before[self.head] = 0
        drawn = Drawn(random.streams(self.key, self.address, attempt), wanted, upto - before, before)
        loose = LoosePoints(cells, self.occlusion, drawn)
        survivors = np.zeros_like(wanted)
        for number, (low, high) in enumerate(self.groups):
            if wanted[low:high].any():
                survivors[low:high] = self._group(out, number, low, high, filled, thin, drawn, loose)
        return survivors

    def _group(
        self,
        out: _Found,
        number: int,
        low: int,
        high: int,
        filled: np.ndarray,
        thin: np.ndarray,
        drawn: Drawn,
        loose: LoosePoints,
    ) -> np.ndarray:
        """The candidates of the pools ``low .. high - 1``; how many of each can be seen."""
        cells, pools = self.cells, slice(low, high)
        begin, end = int(cells.start[low]), int(cells.start[high])
        count = drawn.count[begin:end]
        start = np.cumsum(count) - count
        wanted = drawn.wanted[pools]
        u, v = draw(drawn.stream[pools], np.zeros_like(wanted), wanted)
        slanting = np.flatnonzero((cells.shape[begin:end] == PLANAR) & (count > 0))
        cell = np.repeat(begin + slanting, count[slanting])
        slant(cells, cell, runs(start[slanting], count[slanting]), u, v)
        hidden = self.occlusion.flat_hidden(number, begin, start, count, u, v)
        every = Candidates(cells, begin, count, u, v, hidden, loose.part(begin, end, start))
        kept = np.flatnonzero(~hidden)
        if self.outlook is not None:
            unseen = ~self.outlook.sees(every.cell[kept], *every.places(kept))
            hidden[kept[unseen]], kept = True, kept[~unseen]
        survivors = np.diff(np.searchsorted(kept, np.concatenate([[0], np.cumsum(wanted)])))
        room = np.minimum(self.n[pools] - filled[pools], survivors)
        shift = np.minimum((thin[pools] * survivors).astype(np.int64), np.maximum(survivors - 1, 0))
        target = (self.first + np.arange(low, high)) * out.points.u.shape[1] + filled[pools]
        every.keep(out.points, out.place, Thinning(wanted, survivors, room, shift, target), kept)
        return survivors


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
        for bent, at in cells.by_bent(cell):
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
