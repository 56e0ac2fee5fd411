"""The laws by which values are drawn: truncated to a range, without its gaps, and how much of a law a range holds.

A law is a *level*: its distribution function, along which it is uniform. A range that consists of several intervals is the
hull of them without the gaps between; a gap is cut out of the levels, so that what is left is drawn by the law itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np

TOLERANCE = 1e-9  # bounds and requirements are decided to this
_DISCRETE = ("values", "weighted")  # the values, equally likely; the values, then as many weights


def spread(
    unit: np.ndarray, low: np.ndarray, high: np.ndarray, distribution: str, arguments: tuple[Any, ...]
) -> np.ndarray:
    """Uniform numbers to a distribution truncated to ``low .. high``."""
    if distribution == "normal":
        return _truncated(unit, low, high, arguments[0], arguments[1])
    if distribution == "lognormal":
        small = np.maximum(low, 1e-12)
        inner = _truncated(unit, np.log(small), np.log(np.maximum(high, small)), np.log(arguments[0]), arguments[1])
        return np.minimum(np.maximum(np.exp(inner), low), high)
    if distribution in _DISCRETE:
        return _pick(unit, low, high, distribution, arguments)
    if arguments:  # uniform(a, b): within the part of the domain that lies between the two
        low, high = (np.minimum(np.maximum(end, low), high) for end in arguments)
    return np.minimum(low + unit * (high - low), high)


# the normal distribution on a grid fine enough that straight lines between its nodes do for sampling
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


def _among(
    low: np.ndarray, high: np.ndarray, values: tuple[Any, ...], gaps: tuple[np.ndarray, np.ndarray] | None
) -> tuple[np.ndarray, np.ndarray]:
    """The values (values, rows), and which of them lie within the bounds and in no gap."""
    table = np.stack([np.broadcast_to(np.asarray(v, dtype=np.float64), low.shape) for v in values])
    return table, np.stack([fits(row, low, high, gaps) for row in table])


def _pick(
    unit: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    distribution: str,
    arguments: tuple[Any, ...],
    gaps: tuple[np.ndarray, np.ndarray] | None = None,
) -> np.ndarray:
    """One of the values that lie within the bounds, by their weights; the first when none does, which is refused."""
    if distribution == "weighted":
        values, weights = _halves(arguments)
        table, within = _among(low, high, values, gaps)
        levels = np.cumsum(np.where(within, weights, 0.0), axis=0)
        last = len(values) - 1 - np.argmax(within[::-1], axis=0)
        at = np.minimum((levels <= unit * levels[-1]).sum(axis=0), last)
        found = np.take_along_axis(table, at[None], axis=0)[0]
        return np.where(within.any(axis=0), found, table[0])
    table, within = _among(low, high, arguments, gaps)
    count = within.sum(axis=0)
    wanted = np.minimum((unit * np.maximum(count, 1)).astype(np.int64), np.maximum(count - 1, 0))
    seen = np.cumsum(within, axis=0) - 1
    chosen = np.where(within & (seen == wanted), table, -np.inf).max(axis=0)
    return np.where(count > 0, chosen, table[0])


def _halves(arguments: tuple[Any, ...]) -> tuple[tuple[Any, ...], np.ndarray]:
    """The values and the weights (values, 1) of a weighted law; all weights are above 0."""
    half = len(arguments) // 2
    return arguments[:half], np.array(arguments[half:], dtype=np.float64)[:, None]


def is_listed(distribution: str) -> bool:
    """Whether a law is a list of values."""
    return distribution in _DISCRETE


def values_of(distribution: str, arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """The values of a law that is a list."""
    return arguments[: len(arguments) // 2] if distribution == "weighted" else arguments


def step_along(
    unit: np.ndarray,
    old: np.ndarray,
    reach: np.ndarray,
    swap: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    gaps: tuple[np.ndarray, np.ndarray] | None,
    values: tuple[Any, ...],
) -> np.ndarray:
    """From old values (rows,) to some of a list: one within ``reach``; with ``swap`` another one, a neighbour at least.

    Where there is none, the old one stays if it fits or none does, and else gives way to the nearest that does.
    """
    table, within = _among(low, high, values, gaps)
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
    return np.where((count == 0) & (fits(old, low, high, gaps) | ~within.any(axis=0)), old, found)


def fits(
    value: np.ndarray, low: np.ndarray, high: np.ndarray, gaps: tuple[np.ndarray, np.ndarray] | None
) -> np.ndarray:
    """Which values lie within the bounds and in no gap, but for rounding."""
    found = (value >= low - TOLERANCE) & (value <= high + TOLERANCE)
    return found if gaps is None else found & ~in_gap(value, gaps)


def is_empty(
    low: np.ndarray,
    high: np.ndarray,
    gaps: tuple[np.ndarray, np.ndarray] | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> np.ndarray:
    """Whether a law that states its values, or where they lie, has none there (rows,)."""
    if distribution not in _DISCRETE:
        return np.logical_not(np.maximum(arguments[0], low) <= np.minimum(arguments[1], high) + TOLERANCE)
    return np.logical_not(_among(low, high, values_of(distribution, arguments), gaps)[1].any(axis=0))


# ---------------------------------------------------------------- ranges with gaps


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


def move_out_of_gaps(
    value: np.ndarray, low: np.ndarray, high: np.ndarray, gaps: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Values in a gap moved to the nearest place between ``low`` and ``high`` that is in none; else left where they are."""
    lost = np.flatnonzero(in_gap(value, gaps))
    if not len(lost):
        return value
    old, low, high, gaps = value[lost], low[lost], high[lost], (gaps[0][:, lost], gaps[1][:, lost])
    near, best = old, np.full(len(lost), np.inf)
    for place in (*gaps[0], *gaps[1]):
        way = np.abs(place - old)
        better = (place >= low) & (place <= high) & (way < best) & ~in_gap(place, gaps)
        near, best = np.where(better, place, near), np.where(better, way, best)
    found = value.copy()
    found[lost] = near
    return found


def spread_between(
    unit: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    gaps: tuple[np.ndarray, np.ndarray],
    distribution: str,
    arguments: tuple[Any, ...],
) -> np.ndarray:
    """Uniform numbers to a distribution truncated to ``low .. high`` without the gaps."""
    if distribution in _DISCRETE:
        return _pick(unit, low, high, distribution, arguments, gaps)
    low, high = support_of(low, high, distribution, arguments)
    first, last = _find_level(low, distribution, arguments), _find_level(high, distribution, arguments)
    begin, end = _apart(low, high, gaps, distribution, arguments)
    at = first + unit * ((last - first) - _total(end - begin))
    for one, two in zip(begin, end, strict=True):
        at = np.where(at >= one, at + (two - one), at)
    return np.minimum(np.maximum(_value(np.minimum(at, last), distribution, arguments), low), high)


def measure(
    low: np.ndarray,
    high: np.ndarray,
    gaps: tuple[np.ndarray, np.ndarray] | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> np.ndarray:
    """How much of a law lies between ``low`` and ``high`` outside the gaps, in a measure of the law's own (rows,)."""
    if distribution == "values":
        return _among(low, high, arguments, gaps)[1].sum(axis=0).astype(np.float64)
    if distribution == "weighted":
        values, weights = _halves(arguments)
        return _total(np.where(_among(low, high, values, gaps)[1], weights, 0.0))
    low, high = support_of(low, high, distribution, arguments)
    total = np.maximum(_find_level(high, distribution, arguments) - _find_level(low, distribution, arguments), 0.0)
    if gaps is None:
        return total
    begin, end = _apart(low, high, gaps, distribution, arguments)
    return np.maximum(total - _total(end - begin), 0.0)


def density(value: np.ndarray, distribution: str, arguments: tuple[Any, ...]) -> np.ndarray:
    """The density of a law at a value, in the measure of ``measure``."""
    if distribution == "normal":
        return np.exp(-0.5 * ((value - arguments[0]) / arguments[1]) ** 2) / (_ROOT * arguments[1])
    if distribution == "lognormal":
        small = np.maximum(value, 1e-12)
        return np.exp(-0.5 * (np.log(small / arguments[0]) / arguments[1]) ** 2) / (_ROOT * arguments[1] * small)
    if distribution == "weighted":
        return measure(value, value, None, distribution, arguments)
    return np.ones(len(value))


def support_of(
    low: np.ndarray, high: np.ndarray, distribution: str, arguments: tuple[Any, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """The part of a range in which the law lies: ``uniform(a, b)`` between the two."""
    if distribution == "uniform" and arguments:
        low, high = (np.minimum(np.maximum(end, low), high) for end in arguments)
    return low, high


# the distribution function with the least slope, so that a range far out in a tail has a measure, too
_STEEP = _CDF + 1e-9 * _Z
_ROOT = float(np.sqrt(2.0 * np.pi))


def _find_level(value: np.ndarray, distribution: str, arguments: tuple[Any, ...]) -> np.ndarray:
    if distribution == "normal":
        return np.interp((value - arguments[0]) / arguments[1], _Z, _STEEP)
    if distribution == "lognormal":
        return np.interp(np.log(np.maximum(value, 1e-12) / arguments[0]) / arguments[1], _Z, _STEEP)
    return np.asarray(value, dtype=np.float64)


def _value(level: np.ndarray, distribution: str, arguments: tuple[Any, ...]) -> np.ndarray:
    if distribution == "normal":
        return arguments[0] + arguments[1] * np.interp(level, _STEEP, _Z)
    if distribution == "lognormal":
        return arguments[0] * np.exp(arguments[1] * np.interp(level, _STEEP, _Z))
    return level


def _apart(
    low: np.ndarray,
    high: np.ndarray,
    gaps: tuple[np.ndarray, np.ndarray],
    distribution: str,
    arguments: tuple[Any, ...],
) -> tuple[np.ndarray, np.ndarray]:
    """The gaps within a range in levels, ascending and no two of them overlapping."""
    begin = _find_level(np.minimum(np.maximum(gaps[0], low), high), distribution, arguments)
    end = np.maximum(_find_level(np.minimum(np.maximum(gaps[1], low), high), distribution, arguments), begin)
    order = np.argsort(begin, axis=0, kind="stable")
    begin, end = np.take_along_axis(begin, order, axis=0), np.take_along_axis(end, order, axis=0)
    end = np.maximum.accumulate(end, axis=0)
    begin[1:] = np.maximum(begin[1:], end[:-1])
    return begin, end


def _total(lengths: np.ndarray) -> np.ndarray:
    """The sum over the first axis, added up in order."""
    total = lengths[0]
    for one in lengths[1:]:
        total = total + one
    return total
