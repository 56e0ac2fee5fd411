"""How much of a primitive lies in others of its body that come before it, so that no volume counts twice.

Two primitives that overlap share a region, which belongs to the one that comes first. Boxes narrow the question: first
those in the object's frame, then the box of either in the frame of the other. What is left is decided by the inside
functions at points of a fixed sequence in the smaller of these boxes. Where all points lie in both, as with boxes that
stand alike, the region is the box itself and the result exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import cached_property, lru_cache

import numpy as np

from ..graph.primitive import Primitive
from ..native import backend
from ..native import overlaps as native
from ..records import dataclass
from .block import Block, placed_points, to_local
from .insides import Insides

FEW, MANY = 512, 4096  # points of a pair: to see whether there is an overlap, and to measure it
_CROWDED = 2048  # pairs of a body: with more of them its rows are measured whole
_SMALL = 0.05  # of the mass of a link: the box of a pair that is measured with few points
_THIN = 1e-6  # metres: boxes that overlap by less touch
_CHUNK = 1 << 18  # points at a time
_AT_ONCE = 1 << 13  # of them through one inside function: what it keeps on the way stays in the cache
# the additive sequence of the root of x^4 = x + 1 (M. Roberts, 2018), which fills a box evenly from the first point on
_ROOT = 1.2207440846057596
_Points = tuple[np.ndarray, np.ndarray, np.ndarray]


def sequence(count: int) -> np.ndarray:
    """Points (3, count) that fill the unit cube evenly."""
    steps = np.arange(1, count + 1, dtype=np.float64)
    return np.stack([(0.5 + steps * _ROOT**-k) % 1.0 for k in (1, 2, 3)])


@dataclass(frozen=True, slots=True, eq=False)
class Overlaps:
    """Regions (n,) of rows ``row`` of a block that belong to another row: volume m3, centre (n, 3) m in the object's frame,
    inertia about it per unit density (n, 3, 3) m5. A row has several; they do not overlap."""

    row: np.ndarray
    volume: np.ndarray
    center: np.ndarray
    inertia: np.ndarray

    @classmethod
    def joined(cls, some: Sequence[Overlaps]) -> Overlaps:
        return cls(*(np.concatenate([getattr(one, f.name) for one in some]) for f in fields(cls)))


@dataclass(frozen=True, slots=True, eq=False)
class Regions:
    """Boxes (n,) that hold what rows ``row`` share with rows ``first``: volume m3, centre (n, 3) m in the object's frame, and how
    far a corner is from it: metres, and along each axis (n, 3)."""

    row: np.ndarray
    first: np.ndarray
    volume: np.ndarray
    center: np.ndarray
    radius: np.ndarray
    half: np.ndarray


class Touching:
    """What each row shares with rows of the same ``body`` (R,) that come before it by ``order`` (R,), all different.

    ``worth`` (R,), per m3: boxes that weigh little by it are measured with fewer points. Sorted by body and row, and
    the same whatever the block holds besides.
    """

    def __init__(self, rows: Block, body: np.ndarray, order: np.ndarray, worth: np.ndarray):
        self.rows = _Rows(rows)
        self.pairs = self.rows.touching(body, order, worth)
        self.body, of = body, body[self.pairs.row]
        self.crowded = np.bincount(of, minlength=1)[of] > _CROWDED

    def measured(self, asked: np.ndarray | None = None, inertia: bool = True) -> Overlaps:
        """The overlaps of the rows ``asked`` (R,) bool, by default of all; inertia is noughts unless it is wanted."""
        wanted = np.ones(len(self.pairs), dtype=bool) if asked is None else asked[self.pairs.row]
        crowd, pairs = (
            self.pairs.at(np.flatnonzero(wanted & self.crowded)),
            self.pairs.at(np.flatnonzero(wanted & ~self.crowded)),
        )
        found = [
            self.rows.measured(pairs.at(self.rows.near(pairs)), inertia),
            self.rows.lost(crowd, self.body, inertia),
        ]
        return found[0] if not len(crowd) else Overlaps.joined(found)

    def regions(self) -> Regions:
        """Where all of that lies, by boxes alone."""
        pairs = self.pairs
        size = pairs.high - pairs.low
        center = np.stack(placed_points(self.rows.poses, pairs.frame, (pairs.low + pairs.high) / 2), axis=-1)
        radius = np.sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]) / 2
        turn = np.abs(self.rows.rows.rotation[:, pairs.frame])
        reach = [turn[3 * k] * size[0] + turn[3 * k + 1] * size[1] + turn[3 * k + 2] * size[2] for k in range(3)]
        half = np.stack(reach, axis=-1) / 2
        return Regions(pairs.row, pairs.first, size[0] * size[1] * size[2], center, radius, half)


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """``row`` and one that comes before it, and the box ``low`` to ``high`` (3, n) in the frame of the row ``frame``."""

    row: np.ndarray
    first: np.ndarray
    frame: np.ndarray
    low: np.ndarray
    high: np.ndarray
    great: np.ndarray  # whether many points are worth it

    def __len__(self) -> int:
        return len(self.row)

    def at(self, which: np.ndarray) -> Pairs:
        """Some of the pairs."""
        low, high = self.low[:, which], self.high[:, which]
        return Pairs(self.row[which], self.first[which], self.frame[which], low, high, self.great[which])


class _Rows(Insides):
    """Rows, and where they overlap."""

    @cached_property
    def effort(self) -> np.ndarray:
        return np.array([_effort(s.primitive) for s in self.rows.shelves], dtype=np.int64)

    def touching(self, body: np.ndarray, order: np.ndarray, worth: np.ndarray) -> Pairs:
        """Pairs of one body with the boxes that hold what they share, sorted by body and row."""
        row, first = self.pairs(body, order)
        sort = np.lexsort((order[first], order[row], body[row]))
        row, first = row[sort], first[sort]
        frame, low, high = self.region(row, first)
        keep = np.flatnonzero((high - low > _THIN).all(axis=0))
        row, first, frame, low, high = row[keep], first[keep], frame[keep], low[:, keep], high[:, keep]
        size = high - low
        return Pairs(row, first, frame, low, high, size[0] * size[1] * size[2] * worth[row] > _SMALL)

    def pairs(self, body: np.ndarray, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(row, one that comes before it) of one body whose boxes in the object's frame overlap."""
        sort = np.lexsort((order, body))
        start = np.searchsorted(body[sort], body[sort])  # where the body of each begins
        before = np.arange(len(sort)) - start
        later = np.repeat(np.arange(len(sort)), before)
        index = np.arange(len(later)) - np.repeat(np.cumsum(before) - before, before)
        row, first = sort[later], sort[start[later] + index]
        for axis in range(3):
            least = np.maximum(self.rows.low[row, axis], self.rows.low[first, axis])
            most = np.minimum(self.rows.high[row, axis], self.rows.high[first, axis])
            meet = most - least > _THIN
            row, first = row[meet], first[meet]
        return row, first

    def region(self, row: np.ndarray, first: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The smaller of the two boxes that hold what a pair shares: whose frame it is in, low and high (3, n)."""
        ends = [self._within(a, b) for a, b in ((row, first), (first, row))]
        size = [np.maximum(high - low, 0.0) for low, high in ends]
        own = size[0][0] * size[0][1] * size[0][2] <= size[1][0] * size[1][1] * size[1][2]
        return np.where(own, row, first), np.where(own, ends[0][0], ends[1][0]), np.where(own, ends[0][1], ends[1][1])

    def _within(self, frame: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The part (3, n), (3, n) of the box of ``frame``, in its own frame, that the box of ``other`` reaches."""
        middle, half = (self.low[:, other] + self.high[:, other]) / 2, (self.high[:, other] - self.low[:, other]) / 2
        center = to_local(self.poses, frame, placed_points(self.poses, other, middle))
        low, high = np.empty_like(middle), np.empty_like(middle)
        turn, other_turn = self.rows.rotation[:, frame], self.rows.rotation[:, other]
        for i in range(3):
            reach = np.zeros(len(frame))
            for j in range(3):
                cell = sum(turn[3 * k + i] * other_turn[3 * k + j] for k in range(3))
                reach += np.abs(cell) * half[j]
            low[i] = np.maximum(self.low[i, frame], center[i] - reach)
            high[i] = np.minimum(self.high[i, frame], center[i] + reach)
        return low, high

    def points(self, pairs: Pairs, count: int, shift: np.ndarray | None = None) -> _Points:
        """Three arrays (n, count): points of the object, evenly in the boxes of pairs; ``shift`` (3, n) moves them on within."""
        share, size = sequence(count), pairs.high - pairs.low
        machine = backend.machine() if shift is None else None
        if machine is not None:
            return native.place_shares(machine, self.poses, pairs.frame, pairs.low, size, share)
        part = share[:, None] if shift is None else (share[:, None] + shift[:, :, None]) % 1.0
        local = [pairs.low[k][:, None] + size[k][:, None] * part[k] for k in range(3)]
        x, y, z = placed_points(self.poses, pairs.frame[:, None], local)
        return x, y, z

    def within(self, row: np.ndarray, points: _Points, asked: np.ndarray, near: np.ndarray | float = 0.0) -> np.ndarray:
        """Which of the points (n, count) that are ``asked`` lie in their rows, or by the inside function as ``near``."""
        held = np.zeros(asked.shape, dtype=bool)
        counts = asked.sum(axis=1)
        limit = np.broadcast_to(near, len(row))
        for number, shelf in enumerate(self.rows.shelves):
            chosen = np.flatnonzero((self.shelf[row] == number) & (counts > 0))
            width = max(1, int(counts[chosen].max(initial=1)))
            for part in _parts(len(chosen), max(1, _AT_ONCE // width)):
                at = chosen[part]
                local, place = self._asked(row[at], points, asked, at, int(counts[at].max()))
                values = list(self.values[number].take(row[at] - shelf.start, axis=1)[..., None])
                held[place] = self.inside[number].points(values, *local)[0] <= limit[at, None]
        return held & asked

    def _asked(
        self, row: np.ndarray, points: _Points, asked: np.ndarray, at: np.ndarray, width: int
    ) -> tuple[_Points, tuple[np.ndarray, ...]]:
        """The points of the pairs ``at`` (k,) that are asked in the frames of rows (k,), with others, so that there are ``width`` of each, as
        of the pair with the most; and where these stand."""
        machine = backend.machine()
        if machine is not None:
            local, pick = native.local_points(machine, self.poses, points, asked, at, row, width)
            return local, (at,) if width == asked.shape[1] else (at[:, None], pick)
        if width == asked.shape[1]:
            return to_local(self.poses, row[:, None], [axis[at] for axis in points]), (at,)
        first = at[:, None], np.argsort(~asked[at], axis=1, kind="stable")[:, :width]
        return to_local(self.poses, row[:, None], [axis[first] for axis in points]), first

    def both(self, pairs: Pairs, points: _Points, near: np.ndarray | float = 0.0) -> np.ndarray:
        """Which points (n, count) lie in both rows of pairs; the one that is told sooner is asked first."""
        row, first = pairs.row, pairs.first
        easy = self.effort[self.shelf[row]] <= self.effort[self.shelf[first]]
        one, two = np.where(easy, row, first), np.where(easy, first, row)
        held = self.within(one, points, np.ones(points[0].shape, dtype=bool), near)
        return self.within(two, points, held, near)

    def near(self, pairs: Pairs) -> np.ndarray:
        """Which pairs to measure: the small ones, and those of which a point comes as near to both as points are apart."""
        found = [np.flatnonzero(~pairs.great)]
        great = np.flatnonzero(pairs.great)
        for part in _parts(len(great), _CHUNK // FEW):
            some = pairs.at(great[part])
            size = some.high - some.low
            apart = np.cbrt(size[0] * size[1] * size[2] / FEW) + size.max(axis=0) / 16
            held = self.both(some, self.points(some, FEW), apart)
            found.append(great[part][held.any(axis=1)])
        return np.sort(np.concatenate(found))

    def measured(self, pairs: Pairs, inertia: bool) -> Overlaps:
        """Pairs sorted by row: what a pair shares, without what a pair of the same row before it has."""
        new = np.diff(pairs.row, prepend=-1) != 0
        begin = np.flatnonzero(new)[np.cumsum(new) - 1] if len(pairs) else pairs.row  # where the pairs of a row begin
        volume, center, about = np.zeros(len(pairs)), np.zeros((len(pairs), 3)), np.zeros((len(pairs), 3, 3))
        for count in (FEW, MANY):
            chosen = np.flatnonzero(pairs.great == (count == MANY))
            for part in _parts(len(chosen), _CHUNK // count):
                at = chosen[part]
                some = pairs.at(at)
                points = self.points(some, count)
                held = self.both(some, points)
                for back in range(
                    1, int((at - begin[at]).max()) + 1
                ):  # the pairs before it of the same row, one by one
                    more = np.flatnonzero((at - begin[at] >= back) & held.any(axis=1))
                    if len(more):
                        asked = held[more]
                        x, y, z = (axis[more] for axis in points)
                        held[more] &= ~self.within(pairs.first[at[more] - back], (x, y, z), asked)
                volume[at], center[at], about[at] = self._moments(some, points, held, inertia)
        kept = np.flatnonzero(volume > 0.0)
        return Overlaps(pairs.row[kept], volume[kept], center[kept], about[kept])

    def lost(self, pairs: Pairs, body: np.ndarray, inertia: bool) -> Overlaps:
        """What rows share with any that come before them, where pairs are too many to be measured one by one: at points of
        the whole row, each asked until one holds it. Rows that are alike get other points, whose errors do not add up."""
        begin = np.flatnonzero(np.diff(pairs.row, prepend=-1) != 0)
        row, earlier = pairs.row[begin], np.diff(begin, append=len(pairs))
        rank = np.arange(len(row)) - np.searchsorted(body[row], body[row])
        shift = np.stack([rank * _ROOT**-k % 1.0 for k in (2, 3, 1)])
        great = np.logical_or.reduceat(pairs.great, begin) if len(begin) else pairs.great
        volume, center, about = np.zeros(len(row)), np.zeros((len(row), 3)), np.zeros((len(row), 3, 3))
        for count in (FEW, MANY):
            chosen = np.flatnonzero(great == (count == MANY))
            for part in _parts(len(chosen), _CHUNK // count):
                at = chosen[part]
                own = row[at]
                whole = Pairs(own, own, own, self.low[:, own], self.high[:, own], great[at])
                points = self.points(whole, count, shift[:, at])
                held = self.within(own, points, np.ones(points[0].shape, dtype=bool))
                left = held.copy()
                for k in range(int(earlier[at].max())):
                    more = np.flatnonzero((earlier[at] > k) & left.any(axis=1))
                    x, y, z = (axis[more] for axis in points)
                    left[more] &= ~self.within(pairs.first[begin[at[more]] + k], (x, y, z), left[more])
                volume[at], center[at], about[at] = self._moments(whole, points, held & ~left, inertia)
        kept = np.flatnonzero(volume > 0.0)
        return Overlaps(row[kept], volume[kept], center[kept], about[kept])

    def _moments(
        self, pairs: Pairs, points: _Points, held: np.ndarray, inertia: bool
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Volume (n,), centre (n, 3), inertia (n, 3, 3) of what is held of the boxes; exact where that is all."""
        many, means, spread = _held_moments(held, points, inertia)
        whole = many == held.shape[1]
        size = pairs.high - pairs.low
        volume = size[0] * size[1] * size[2] * (many / held.shape[1])
        middle = placed_points(self.poses, pairs.frame, (pairs.low + pairs.high) / 2)
        center = np.where(whole[:, None], np.stack(middle, axis=-1), means)
        about = np.zeros((len(pairs), 3, 3))
        if not inertia:
            return volume, center, about
        turn = self.rows.rotation[:, pairs.frame]
        for i in range(3):
            for j in range(3):
                exact = sum(turn[3 * i + k] * turn[3 * j + k] * size[k] ** 2 for k in range(3)) / 12.0
                second = volume * np.where(whole, exact, spread[:, i, j])
                about[:, i, j] -= second
                if i == j:
                    for k in range(3):
                        about[:, k, k] += second
        return volume, center, about


def _held_moments(held: np.ndarray, points: _Points, inertia: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of points (n, count) that are held: how many there are (n,), their mean (n, 3) and, for ``inertia``, the means of the products of any
    two coordinates from there (n, 3, 3); noughts where there are none, the products also where all are held."""
    if (machine := backend.machine()) is not None:
        return native.held_moments(machine, held, points, inertia)
    many = held.sum(axis=1)
    mean, spread = np.zeros((len(held), 3)), np.zeros((len(held), 3, 3))
    some = np.flatnonzero(many)
    mean[some] = np.stack([_mean(held[some], axis[some]) for axis in points], axis=-1)
    some = np.flatnonzero((many > 0) & (many < held.shape[1]))
    local = [axis[some] - mean[some, k, None] for k, axis in enumerate(points)]
    for i in range(3 if inertia else 0):
        for j in range(i, 3):
            spread[some, i, j] = spread[some, j, i] = _mean(held[some], local[i] * local[j])
    return many, mean, spread


def _mean(held: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The means (n,) of values (n, count) over what is held, at least one of each."""
    found: np.ndarray = np.where(held, values, 0.0).sum(axis=1) / held.sum(axis=1)
    return found


@lru_cache(maxsize=512)
def _effort(primitive: Primitive) -> int:
    """How many operations the inside function takes."""
    seen: set[int] = set()
    waiting = [primitive.inside]
    while waiting:
        node = waiting.pop()
        if id(node) not in seen:
            seen.add(id(node))
            waiting.extend(node.args)
    return len(seen)


def _parts(count: int, size: int) -> list[slice]:
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]
