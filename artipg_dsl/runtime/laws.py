"""The laws by which values are drawn: truncated to the room that is left, and how much of a law a room holds.

A law is a *level*: its distribution function, along which it is uniform. A room that consists of several intervals is the
hull of them without the gaps between; a gap is cut out of the levels, so that what is left is drawn by the law itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..records import dataclass

TOLERANCE = 1e-9  # bounds and requirements are decided to this
_LISTS = ("values", "weighted")  # the values, equally likely; the values, then as many weights


@dataclass(slots=True, eq=False)
class Room:
    """Where a value may lie in each row: from ``low`` to ``high`` (rows,) and in none of the open ``gaps``, of which the first array
    (gaps, rows) says where they begin, the second where they end."""

    low: np.ndarray
    high: np.ndarray
    gaps: tuple[np.ndarray, np.ndarray] | None = None

    def clip(self, value: np.ndarray) -> np.ndarray:
        """Values moved between the ends."""
        return np.minimum(np.maximum(value, self.low), self.high)

    def holds(self, value: np.ndarray) -> np.ndarray:
        """Which values lie between the ends and in no gap, but for rounding."""
        found = (value >= self.low - TOLERANCE) & (value <= self.high + TOLERANCE)
        return found if self.gaps is None else found & ~in_gap(value, self.gaps)

    def widened(self, by: float) -> Room:
        return Room(self.low - by, self.high + by, self.gaps)

    def but(self, stays: np.ndarray, tight: Room) -> Room:
        """The room ``tight`` within this one, but for rows that may stay where they are."""
        return Room(np.where(stays, self.low, tight.low), np.where(stays, self.high, tight.high), self.gaps)


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """``name`` is the word of the language: uniform (with two arguments only between these), normal, lognormal, values, weighted."""

    name: str
    arguments: tuple[Any, ...]

    @property
    def listed(self) -> bool:
        """Whether it is a list of values."""
        return is_listed(self.name)

    @property
    def values(self) -> tuple[Any, ...]:
        """The values of one that is a list."""
        return values_of(self.name, self.arguments)

    @property
    def confined(self) -> bool:
        """Whether it says where its values lie; others have some density everywhere."""
        return bool(self.arguments) and self.name not in ("normal", "lognormal")

    def support(self, room: Room) -> Room:
        """The part of a room in which it lies: ``uniform(a, b)`` between the two."""
        if self.name != "uniform" or not self.arguments:
            return room
        low, high = (np.minimum(np.maximum(end, room.low), room.high) for end in self.arguments)
        return Room(low, high, room.gaps)

    def is_empty(self, room: Room) -> np.ndarray:
        """Whether one that is confined has no values there (rows,)."""
        if self.listed:
            return np.logical_not(_among(room, self.values)[1].any(axis=0))
        return np.logical_not(
            np.maximum(self.arguments[0], room.low) <= np.minimum(self.arguments[1], room.high) + TOLERANCE
        )

    def spread(self, unit: np.ndarray, room: Room) -> np.ndarray:
        """Uniform numbers to values of the law within a room."""
        if self.listed:
            return self._pick(unit, room)
        room = self.support(room)
        if room.gaps is not None:
            return self._spread_between(unit, room, room.gaps)
        low, high = room.low, room.high
        if self.name == "normal":
            return _truncated(unit, low, high, self.arguments[0], self.arguments[1])
        if self.name == "lognormal":
            small, (middle, deviation) = np.maximum(low, 1e-12), self.arguments
            inner = _truncated(unit, np.log(small), np.log(np.maximum(high, small)), np.log(middle), deviation)
            return room.clip(np.exp(inner))
        return np.minimum(low + unit * (high - low), high)

    def _spread_between(self, unit: np.ndarray, room: Room, gaps: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
        first, last = self._level(room.low), self._level(room.high)
        begin, end = self._apart(room, gaps)
        at = first + unit * ((last - first) - _total(end - begin))
        for one, two in zip(begin, end, strict=True):
            at = np.where(at >= one, at + (two - one), at)
        return room.clip(self._value(np.minimum(at, last)))

    def _pick(self, unit: np.ndarray, room: Room) -> np.ndarray:
        """One of the values that the room holds, by their weights; the first when it holds none, which is refused."""
        table, within = _among(room, self.values)
        if self.name == "weighted":
            levels = np.cumsum(np.where(within, self._weights, 0.0), axis=0)
            last = len(table) - 1 - np.argmax(within[::-1], axis=0)
            at = np.minimum((levels <= unit * levels[-1]).sum(axis=0), last)
            found = np.take_along_axis(table, at[None], axis=0)[0]
            return np.where(within.any(axis=0), found, table[0])
        count = within.sum(axis=0)
        wanted = np.minimum((unit * np.maximum(count, 1)).astype(np.int64), np.maximum(count - 1, 0))
        seen = np.cumsum(within, axis=0) - 1
        chosen = np.where(within & (seen == wanted), table, -np.inf).max(axis=0)
        return np.where(count > 0, chosen, table[0])

    @property
    def _weights(self) -> np.ndarray:
        """The weights (values, 1) of a weighted law; all are above 0."""
        return np.array(self.arguments[len(self.values) :], dtype=np.float64)[:, None]

    def measure(self, room: Room) -> np.ndarray:
        """How much of the law a room holds, in a measure of the law's own (rows,)."""
        if self.listed:
            within = _among(room, self.values)[1]
            if self.name == "values":
                return within.sum(axis=0).astype(np.float64)
            return _total(np.where(within, self._weights, 0.0))
        room = self.support(room)
        total = np.maximum(self._level(room.high) - self._level(room.low), 0.0)
        if room.gaps is None:
            return total
        begin, end = self._apart(room, room.gaps)
        return np.maximum(total - _total(end - begin), 0.0)

    def density(self, value: np.ndarray) -> np.ndarray:
        """The density at a value, in the measure of ``measure``."""
        if self.name == "normal":
            return np.exp(-0.5 * ((value - self.arguments[0]) / self.arguments[1]) ** 2) / (_ROOT * self.arguments[1])
        if self.name == "lognormal":
            small = np.maximum(value, 1e-12)
            off = np.log(small / self.arguments[0]) / self.arguments[1]
            return np.exp(-0.5 * off**2) / (_ROOT * self.arguments[1] * small)
        if self.name == "weighted":
            return self.measure(Room(value, value))
        return np.ones(len(value))

    def _level(self, value: np.ndarray) -> np.ndarray:
        if self.name == "normal":
            return np.interp((value - self.arguments[0]) / self.arguments[1], _Z, _STEEP)
        if self.name == "lognormal":
            return np.interp(np.log(np.maximum(value, 1e-12) / self.arguments[0]) / self.arguments[1], _Z, _STEEP)
        return np.asarray(value, dtype=np.float64)

    def _value(self, level: np.ndarray) -> np.ndarray:
        if self.name == "normal":
            return self.arguments[0] + self.arguments[1] * np.interp(level, _STEEP, _Z)
        if self.name == "lognormal":
            return self.arguments[0] * np.exp(self.arguments[1] * np.interp(level, _STEEP, _Z))
        return level

    def _apart(self, room: Room, gaps: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """The gaps within a room in levels, ascending and no two of them overlapping."""
        begin = self._level(room.clip(gaps[0]))
        end = np.maximum(self._level(room.clip(gaps[1])), begin)
        order = np.argsort(begin, axis=0, kind="stable")
        begin, end = np.take_along_axis(begin, order, axis=0), np.take_along_axis(end, order, axis=0)
        end = np.maximum.accumulate(end, axis=0)
        begin[1:] = np.maximum(begin[1:], end[:-1])
        return begin, end


EVEN = Law("uniform", ())


def is_listed(distribution: str) -> bool:
    """Whether a law of this name is a list of values."""
    return distribution in _LISTS


def values_of(distribution: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """The values of a law that is a list."""
    return arguments[: len(arguments) // 2] if distribution == "weighted" else arguments


def step_along(
    unit: np.ndarray, old: np.ndarray, reach: np.ndarray, swap: np.ndarray, room: Room, values: tuple[Any, ...]
) -> np.ndarray:
    """From old values (rows,) to some of a list: one within ``reach``; with ``swap`` another one, a neighbour at least.

    Where there is none, the old one stays if it fits or none does, and else gives way to the nearest that does.
    """
    table, within = _among(room, values)
    away = np.abs(table - old)
    other = within & (away > TOLERANCE)
    above, below = (np.where(other & side, away, np.inf).min(axis=0) for side in (table > old, table < old))
    beside = other & (away <= np.where(table > old, above, below) + TOLERANCE)
    near = within & (away <= reach + TOLERANCE) & (reach > 0.0)
    able = np.where(swap & other.any(axis=0), other & (near | beside), near)
    count = able.sum(axis=0)
    wanted = np.minimum((unit * np.maximum(count, 1)).astype(np.int64), np.maximum(count - 1, 0))
    place = np.argmax(able & (np.cumsum(able, axis=0) - 1 == wanted), axis=0)
    place = np.where(count > 0, place, np.argmin(np.where(within, away, np.inf), axis=0))
    found = np.take_along_axis(table, place[None], axis=0)[0]
    return np.where((count == 0) & (room.holds(old) | ~within.any(axis=0)), old, found)


def _among(room: Room, values: tuple[Any, ...]) -> tuple[np.ndarray, np.ndarray]:
    """The values (values, rows), and which of them the room holds."""
    table = np.stack([np.broadcast_to(np.asarray(v, dtype=np.float64), room.low.shape) for v in values])
    return table, np.stack([room.holds(row) for row in table])


# ---------------------------------------------------------------- gaps


def gaps_of(low: np.ndarray, unions: tuple[Any, ...], whole: bool) -> tuple[np.ndarray, np.ndarray]:
    """Where the open gaps that unions of intervals leave begin and end: two arrays (gaps, rows); an empty one ends first.

    A union is (guard, ((low, high), ...)): where the guard holds, the value lies in one of the intervals. ``whole``: of
    whole numbers, in halves.
    """
    begins, ends = [], []
    for guard, intervals in unions:
        first = np.stack([_end(low, guard, one, -np.inf) for one, _ in intervals])
        last = np.stack([_end(low, guard, two, np.inf) for _, two in intervals])
        empty = first > last
        first, last = np.where(empty, np.inf, first), np.where(empty, -np.inf, last)
        order = np.argsort(first, axis=0, kind="stable")
        first = np.take_along_axis(first, order, axis=0)
        reach = np.maximum.accumulate(np.take_along_axis(last, order, axis=0), axis=0)
        edge = np.full((1, len(low)), np.inf)
        begins.append(np.concatenate([-edge, reach]))
        ends.append(np.concatenate([first, edge]))
    begin, end = np.concatenate(begins), np.concatenate(ends)
    if whole:
        begin, end = np.floor(begin + TOLERANCE) + 0.5, np.ceil(end - TOLERANCE) - 0.5
    return begin, end


def _end(low: np.ndarray, guard: np.ndarray | bool, value: np.ndarray | float, free: float) -> np.ndarray:
    """The end of an interval per row; none where the guard does not hold or nothing is known."""
    found = np.broadcast_to(np.asarray(value, dtype=np.float64), low.shape)
    return np.where(np.logical_and(guard, ~np.isnan(found)), found, free)


def in_gap(value: np.ndarray, gaps: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Which values lie in a gap, by more than rounding."""
    return np.logical_or.reduce((value > gaps[0] + TOLERANCE) & (value < gaps[1] - TOLERANCE), axis=0)


def move_out_of_gaps(value: np.ndarray, room: Room) -> np.ndarray:
    """Values in a gap moved to the nearest place between the ends that is in none; else left where they are."""
    if room.gaps is None:
        return value
    lost = np.flatnonzero(in_gap(value, room.gaps))
    if not len(lost):
        return value
    old, low, high = value[lost], room.low[lost], room.high[lost]
    gaps = room.gaps[0][:, lost], room.gaps[1][:, lost]
    near, best = old, np.full(len(lost), np.inf)
    for place in (*gaps[0], *gaps[1]):
        way = np.abs(place - old)
        better = (place >= low) & (place <= high) & (way < best) & ~in_gap(place, gaps)
        near, best = np.where(better, place, near), np.where(better, way, best)
    found = value.copy()
    found[lost] = near
    return found


# ---------------------------------------------------------------- the normal law

# on a grid fine enough that straight lines between its nodes do for sampling
_Z = np.linspace(-8.0, 8.0, 4097)


def _grid() -> np.ndarray:
    density = np.exp(-0.5 * _Z * _Z)
    steps = np.concatenate([[0.0], 0.5 * (density[1:] + density[:-1])])
    total = np.cumsum(steps)
    return total / total[-1]


_CDF = _grid()


def _truncated(
    unit: np.ndarray, low: np.ndarray, high: np.ndarray, mean: np.ndarray | float, deviation: np.ndarray | float
) -> np.ndarray:
    """Inverse distribution function of the normal law between two values."""
    a, b = (low - mean) / deviation, (high - mean) / deviation
    below, above = np.interp(a, _Z, _CDF), np.interp(b, _Z, _CDF)
    inner = mean + deviation * np.interp(below + unit * (above - below), _CDF, _Z)
    flat = above - below < 1e-9  # far out in a tail: uniform
    inner = np.where(flat, low + unit * (high - low), inner)
    return np.minimum(np.maximum(inner, low), high)


# the distribution function with the least slope, so that a range far out in a tail has a measure, too
_STEEP = _CDF + 1e-9 * _Z
_ROOT = float(np.sqrt(2.0 * np.pi))


def _total(lengths: np.ndarray) -> np.ndarray:
    """The sum over the first axis, added up in order."""
    total = lengths[0]
    for one in lengths[1:]:
        total = total + one
    return total
