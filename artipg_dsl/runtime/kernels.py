"""What the generated code calls: tables, segment operations, draws. NumPy alone; arrays of rows, never a loop over them.

Everything is computed per row in a fixed order, so a row's value does not depend on which other rows are there.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..graph.random import key, mix, uniform

TOLERANCE = 1e-9  # bounds and requirements are decided to this


@dataclass(slots=True, eq=False)
class Rows:
    """A table: ``parent`` row of each row, ``rank`` among its siblings, ``owner`` (the object), the random address.

    ``start`` and ``count`` give the rows of each parent row.
    """

    size: int
    parent: np.ndarray
    rank: np.ndarray
    owner: np.ndarray
    address: np.ndarray
    start: np.ndarray
    count: np.ndarray


@dataclass(slots=True, eq=False)
class Kept:
    """Values that rows had before, by their address mixed with their owner (ascending): a row found here keeps its value
    as far as it can.

    ``reach`` lets a number move by so much; ``swap`` asks for another option or count. What no longer fits is moved to
    the nearest value that does.
    """

    address: np.ndarray
    value: np.ndarray
    reach: np.ndarray
    swap: np.ndarray

    def find(self, rows: Rows) -> tuple[np.ndarray, np.ndarray]:
        """Which rows are known, and where."""
        if not len(self.address):
            return np.zeros(rows.size, dtype=bool), np.zeros(rows.size, dtype=np.int64)
        wanted = mix(rows.address, rows.owner)
        at = np.minimum(np.searchsorted(self.address, wanted), len(self.address) - 1)
        return self.address[at] == wanted, at


@dataclass(slots=True, eq=False)
class State:
    """One evaluation: the objects, the attempts, what is given or kept, and what failed.

    ``given`` maps the index of a draw to its value (a scalar, or one per row), ``kept`` to the values of an object that
    this one is made from; ``salt``, and ``lane`` per object, set the random numbers of one such making apart. ``missed`` counts the objects for
    which a draw found no room, per draw; ``broken`` those that break a requirement, per requirement. ``faults`` has the
    rows in question: of the table of the draw ("draw", number), or of that of the requirement ("requirement", number).
    """

    seed: int
    objects: np.ndarray
    attempt: np.ndarray
    given: dict[int, np.ndarray | float] = field(default_factory=dict)
    defaults: bool = False
    kept: dict[int, Kept] = field(default_factory=dict)
    salt: str = ""
    lane: np.ndarray | None = None
    failed: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=bool))
    missed: dict[int, int] = field(default_factory=dict)
    broken: dict[int, int] = field(default_factory=dict)
    faults: dict[tuple[str, int], list[np.ndarray]] = field(default_factory=dict)
    values: dict[int, np.ndarray] = field(default_factory=dict)

    def lanes(self) -> np.ndarray:
        return np.zeros(len(self.objects), dtype=np.int64) if self.lane is None else self.lane


def root_rows(state: State) -> Rows:
    n = len(state.objects)
    state.failed = np.zeros(n, dtype=bool)
    index = np.arange(n)
    ones = np.ones(n, dtype=np.int64)
    return Rows(n, index, np.zeros(n, dtype=np.int64), index, state.objects.astype(np.uint64), index, ones)


def child_rows(parent: Rows, count: np.ndarray | float | bool, *, guard: bool) -> Rows:
    """The table with ``count`` rows per row of ``parent`` (a guard: none or one, at the parent's address)."""
    counts = np.broadcast_to(np.asarray(count), (parent.size,)).astype(np.int64)
    counts = np.maximum(counts, 0)
    start = np.cumsum(counts) - counts
    index = np.repeat(np.arange(parent.size), counts)
    rank = np.arange(len(index)) - start[index]
    address = parent.address[index] if guard else mix(parent.address[index], rank)
    return Rows(len(index), index, rank, parent.owner[index], address, start, counts)


def full(rows: Rows, value: np.ndarray | float | bool) -> np.ndarray:
    """A value as one array entry per row."""
    array = np.asarray(value)
    return array if array.shape == (rows.size,) else np.full(rows.size, array)


def merge(parent: Rows, default: np.ndarray | float, branches: list[tuple[Rows, np.ndarray | float]]) -> np.ndarray:
    """Per parent row the value of whichever child row exists, else the default."""
    kind = np.result_type(np.asarray(default), *(np.asarray(v) for _, v in branches))
    out = np.empty(parent.size, dtype=kind)
    out[...] = default
    for rows, value in branches:
        out[rows.parent] = value
    return out


_REDUCTIONS = {
    "sum": (np.add, 0.0), "min": (np.minimum, np.inf), "max": (np.maximum, -np.inf), "any": (np.logical_or, False),
    "all": (np.logical_and, True),
}  # fmt: skip


def reduce_rows(kind: str, rows: Rows, value: np.ndarray | float) -> np.ndarray:
    """Reduction over the rows of each parent row, element by element from the first to the last."""
    function, empty = _REDUCTIONS[kind]
    values = full(rows, value)
    out = np.full(len(rows.count), empty, dtype=values.dtype if kind in ("any", "all") else np.float64)
    has = rows.count > 0
    if has.any():
        out[has] = function.reduceat(values, rows.start[has])
    return out


def pick_row(rows: Rows, value: np.ndarray | float, index: np.ndarray | float) -> np.ndarray:
    """Per parent row the value of the child with the given rank (0 where there is none)."""
    values = full(rows, value)
    rank = np.broadcast_to(np.asarray(index), rows.count.shape).astype(np.int64)
    inside = (rank >= 0) & (rank < rows.count)
    out = np.zeros(len(rows.count), dtype=values.dtype)
    out[inside] = values[rows.start[inside] + rank[inside]]
    return out


def row_before(rows: Rows, value: np.ndarray | float, first: np.ndarray | float) -> np.ndarray:
    """The value of the sibling before each row."""
    values = full(rows, value)
    out = full(rows, first).astype(values.dtype).copy()
    later = np.flatnonzero(rows.rank > 0)
    out[later] = values[later - 1]
    return out


def running_sum(rows: Rows, value: np.ndarray | float) -> np.ndarray:
    """The sum over the siblings before each row, added up rank by rank."""
    values = full(rows, value)
    out = np.zeros(rows.size)
    if rows.size == 0:
        return out
    order = np.argsort(rows.rank, kind="stable")
    edges = np.searchsorted(rows.rank[order], np.arange(1, int(rows.rank.max()) + 2))
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        at = order[low:high]
        out[at] = out[at - 1] + values[at - 1]
    return out


# ---------------------------------------------------------------- draws


def narrow(low: np.ndarray, high: np.ndarray, side: str, bound: np.ndarray | float, guard: np.ndarray | bool) -> None:
    """Narrow the open interval in place by a bound where its guard holds."""
    if side == "low":
        np.maximum(low, np.where(guard, bound, -np.inf), out=low)
    else:
        np.minimum(high, np.where(guard, bound, np.inf), out=high)


def _lot(state: State, rows: Rows, address: str) -> np.ndarray:
    names = (address, state.salt) if state.salt else (address,)
    lane = 0 if state.lane is None else state.lane[rows.owner]
    return uniform(key(state.seed, *names), rows.address, lane, state.attempt[rows.owner])


def _no_room(state: State, rows: Rows, number: int, bad: np.ndarray) -> None:
    if bad.any():
        owners = rows.owner[bad]
        state.failed[owners] = True
        state.missed[number] = state.missed.get(number, 0) + len(np.unique(owners))
        state.faults.setdefault(("draw", number), []).append(np.flatnonzero(bad))


def _given(state: State, rows: Rows, number: int, low: np.ndarray | float, high: np.ndarray | float) -> np.ndarray | None:
    """The value given for a draw, if any; an object that has no room for it fails (and goes on with a legal value)."""
    value = state.given.get(number)
    if value is None:
        return None
    found = full(rows, value).astype(np.float64)
    bad = ~((found >= low - TOLERANCE) & (found <= high + TOLERANCE))
    _no_room(state, rows, number, bad)
    return np.where(bad, low, found)


def draw_real(
    state: State, rows: Rows, number: int, address: str, low: np.ndarray, high: np.ndarray, distribution: str,
    arguments: tuple, default: np.ndarray | float | None,
) -> np.ndarray:  # fmt: skip
    """A value between ``low`` and ``high`` per row, distributed as asked within them."""
    found = _given(state, rows, number, low, high)
    if found is None:
        bad = low > high + TOLERANCE
        _no_room(state, rows, number, bad)
        top = np.maximum(low, high)
        if state.defaults and default is not None:
            found = np.minimum(np.maximum(full(rows, default).astype(np.float64), low), top)
        else:
            unit = _lot(state, rows, address)
            found = spread(unit, low, top, distribution, arguments)
            if number in state.kept:
                found = _near(state.kept[number], rows, unit, low, top, found)
    state.values[number] = found
    return found


def _near(kept: Kept, rows: Rows, unit: np.ndarray, low: np.ndarray, high: np.ndarray, fresh: np.ndarray) -> np.ndarray:
    """Within reach of the value kept, as far as the bounds allow; the fresh value for rows that are new."""
    known, at = kept.find(rows)
    if not known.any():
        return fresh
    old = kept.value[at]
    first = np.minimum(np.maximum(old - kept.reach[at], low), high)
    last = np.minimum(np.maximum(old + kept.reach[at], low), high)
    return np.where(known, np.minimum(first + unit * (last - first), last), fresh)


def spread(unit: np.ndarray, low: np.ndarray, high: np.ndarray, distribution: str, arguments: tuple) -> np.ndarray:
    """Uniform numbers to a distribution truncated to ``low .. high``."""
    if distribution == "normal":
        return _truncated(unit, low, high, arguments[0], arguments[1])
    if distribution == "lognormal":
        small = np.maximum(low, 1e-12)
        inner = _truncated(unit, np.log(small), np.log(np.maximum(high, small)), np.log(arguments[0]), arguments[1])
        return np.minimum(np.maximum(np.exp(inner), low), high)
    if distribution == "values":
        return _nearest(unit, low, high, arguments)
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


def _truncated(unit: np.ndarray, low: np.ndarray, high: np.ndarray, mean: np.ndarray | float, deviation: np.ndarray | float) -> np.ndarray:
    """Inverse distribution function of the normal law between two values."""
    a, b = (low - mean) / deviation, (high - mean) / deviation
    below, above = np.interp(a, _Z, _CDF), np.interp(b, _Z, _CDF)
    inner = mean + deviation * np.interp(below + unit * (above - below), _CDF, _Z)
    flat = above - below < 1e-9  # far out in a tail: uniform
    inner = np.where(flat, low + unit * (high - low), inner)
    return np.minimum(np.maximum(inner, low), high)


def _nearest(unit: np.ndarray, low: np.ndarray, high: np.ndarray, values: tuple) -> np.ndarray:
    """One of the values that lie within the bounds, equally likely; the nearest bound when none does."""
    table = np.stack([np.broadcast_to(np.asarray(v, dtype=np.float64), unit.shape) for v in values])
    inside = (table >= low - TOLERANCE) & (table <= high + TOLERANCE)
    count = inside.sum(axis=0)
    wanted = np.minimum((unit * np.maximum(count, 1)).astype(np.int64), np.maximum(count - 1, 0))
    seen = np.cumsum(inside, axis=0) - 1
    chosen = np.where(inside & (seen == wanted), table, 0.0).max(axis=0)
    return np.where(count > 0, chosen, np.minimum(np.maximum(table[0], low), high))


def draw_count(
    state: State, rows: Rows, number: int, address: str, low: np.ndarray, high: np.ndarray, distribution: str,
    arguments: tuple, default: np.ndarray | float | None,
) -> np.ndarray:  # fmt: skip
    """A whole number between ``low`` and ``high`` per row."""
    found = _given(state, rows, number, np.ceil(low - TOLERANCE), np.floor(high + TOLERANCE))
    if found is None:
        first, last = np.ceil(low - TOLERANCE), np.floor(high + TOLERANCE)
        _no_room(state, rows, number, first > last)
        last = np.maximum(first, last)
        if state.defaults and default is not None:
            found = np.minimum(np.maximum(full(rows, default).astype(np.float64), first), last)
        elif distribution == "uniform":
            unit = _lot(state, rows, address)
            if arguments:
                first, last = (np.minimum(np.maximum(end, first), last) for end in arguments)
                first, last = np.ceil(first - TOLERANCE), np.floor(last + TOLERANCE)
            found = np.minimum(first + np.floor(unit * (last - first + 1.0)), last)
        else:
            wide = spread(_lot(state, rows, address), first - 0.5, last + 0.5, distribution, arguments)
            found = np.minimum(np.maximum(np.floor(wide + 0.5), first), last)
        if number in state.kept:
            found = _other_count(state.kept[number], rows, _lot(state, rows, address), first, last, found)
    state.values[number] = found
    return found


def _other_count(kept: Kept, rows: Rows, unit: np.ndarray, first: np.ndarray, last: np.ndarray, fresh: np.ndarray) -> np.ndarray:
    """The count kept, moved into the range; another one where that is asked for and there is one."""
    known, at = kept.find(rows)
    if not known.any():
        return fresh
    old = np.minimum(np.maximum(kept.value[at], first), last)
    other = np.minimum(first + np.floor(unit * (last - first)), last)
    other = np.where(other >= old, np.minimum(other + 1.0, last), other)
    return np.where(known, np.where(kept.swap[at] & (last > first), other, old), fresh)


def draw_choice(state: State, rows: Rows, number: int, address: str, weights: tuple) -> np.ndarray:
    """The index of one of the options, by weight."""
    table = np.stack([np.broadcast_to(np.asarray(w, dtype=np.float64), (rows.size,)) for w in weights])
    found = _given(state, rows, number, 0.0, len(weights) - 1.0)
    if found is not None:
        _no_room(state, rows, number, table[found.astype(np.int64), np.arange(rows.size)] <= 0.0)
    else:
        if number in state.kept:
            table = _other_option(state.kept[number], rows, table)
        total = np.cumsum(np.maximum(table, 0.0), axis=0)
        _no_room(state, rows, number, total[-1] <= 0.0)
        if state.defaults:
            found = np.argmax(table > 0.0, axis=0).astype(np.float64)
        else:
            mark = _lot(state, rows, address) * total[-1]
            found = np.minimum((total <= mark).sum(axis=0), len(weights) - 1).astype(np.float64)
    state.values[number] = found
    return found


def _other_option(kept: Kept, rows: Rows, table: np.ndarray) -> np.ndarray:
    """Weights (options, rows) that leave only the option kept, or only others where a swap is asked for and possible."""
    known, at = kept.find(rows)
    if not known.any():
        return table
    option = np.arange(len(table))[:, None] == kept.value[at].astype(np.int64)
    alone, others = np.where(option, table, 0.0), np.where(option, 0.0, table)
    swap = kept.swap[at] & (others > 0.0).any(axis=0)
    keep = ~swap & (alone > 0.0).any(axis=0)
    return np.where(known & swap, others, np.where(known & keep, alone, table))


def demand(state: State, rows: Rows, number: int, holds: np.ndarray | bool) -> None:
    """Note the objects that break a requirement."""
    bad = np.flatnonzero(~full(rows, holds).astype(bool))
    if len(bad):
        owners = np.unique(rows.owner[bad])
        state.failed[owners] = True
        state.broken[number] = state.broken.get(number, 0) + len(owners)
        state.faults.setdefault(("requirement", number), []).append(bad)
