"""What the generated code calls: tables, segment operations, draws. NumPy alone; arrays of rows, never a loop over them.

Everything is computed per row in a fixed order, so a row's value does not depend on which other rows are there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..random import key, mix, uniform
from .laws import TOLERANCE, clear, density, gaps_of, held, inside, spread, spread_between, support

Gaps = tuple[np.ndarray, np.ndarray]  # where gaps begin and end: (gaps, rows) each
MOST_ROWS = 20_000  # of one table in one object, as ``lower.elaborate.ranges`` has it: more would fill the memory
LEAST = 1e-300  # a range that holds less of its law than this counts as holding so much


class TooMany(Exception):
    """A table with more rows in an object than any object has."""


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

    Where ``weigh`` is set, ``log_weight`` (objects,) is the logarithm of how much of the declared laws the ranges held in
    which the values were drawn. ``leaning`` (objects,) are the weights of the preferences that an object does not keep,
    added up, and ``unkept`` the objects per preference.

    ``given`` maps the index of a draw to its value (a scalar, or one per row), ``kept`` to the values of an object that
    this one is made from; ``salt``, and ``lane`` per object, set the random numbers of one such making apart. ``missed`` counts the objects for
    which a draw found no room, per draw; ``broken`` those that break a requirement, per requirement. ``faults`` has the
    rows in question: of the table of the draw ("draw", number), or of that of the requirement ("requirement", number).
    ``crowd`` (objects,) is the size of a table that is too large to be made, 0 where none is.
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
    weigh: bool = False
    log_weight: np.ndarray = field(default_factory=lambda: np.zeros(0))
    leaning: np.ndarray = field(default_factory=lambda: np.zeros(0))
    unkept: dict[int, int] = field(default_factory=dict)
    crowd: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def lanes(self) -> np.ndarray:
        return np.zeros(len(self.objects), dtype=np.int64) if self.lane is None else self.lane


def root_rows(state: State) -> Rows:
    n = len(state.objects)
    state.failed, state.crowd = np.zeros(n, dtype=bool), np.zeros(n)
    state.log_weight, state.leaning = np.zeros(n), np.zeros(n)
    index = np.arange(n)
    ones = np.ones(n, dtype=np.int64)
    return Rows(n, index, np.zeros(n, dtype=np.int64), index, state.objects.astype(np.uint64), index, ones)


def child_rows(state: State, parent: Rows, count: np.ndarray | float | bool, *, guard: bool) -> Rows:
    """The table with ``count`` rows per row of ``parent`` (a guard: none or one, at the parent's address).

    An object whose counts are no numbers, or more than ``MOST_ROWS`` in all, has no rows here: a requirement says that it is not valid,
    and ``crowded`` sees to it that one does.
    """
    asked = np.broadcast_to(np.asarray(count), (parent.size,))
    if not guard:
        held = np.bincount(parent.owner, weights=np.maximum(asked, 0.0), minlength=len(state.objects))
        over = ~(held <= MOST_ROWS)
        if over.any():
            state.crowd = np.maximum(state.crowd, np.where(over, held, 0.0))
            asked = np.where(over[parent.owner], 0.0, asked)
        asked = np.maximum(asked, 0.0)
    counts = asked.astype(np.int64)
    start = np.cumsum(counts) - counts
    index = np.repeat(np.arange(parent.size), counts)
    rank = np.arange(len(index)) - start[index]
    address = parent.address[index] if guard else mix(parent.address[index], rank)
    return Rows(len(index), index, rank, parent.owner[index], address, start, counts)


def crowded(state: State) -> None:
    """Raise TooMany where an object has had more elements than fit, and nothing says that it is not valid."""
    held = np.where(state.failed, 0.0, state.crowd)
    if held.any():
        raise TooMany(
            f"object {np.argmax(held)} of these has {held.max():.0f} elements of one repeat, more than {MOST_ROWS}"
        )


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
    "sum": (np.add, 0.0),
    "min": (np.minimum, np.inf),
    "max": (np.maximum, -np.inf),
    "any": (np.logical_or, False),
    "all": (np.logical_and, True),
}


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


def _given(
    state: State, rows: Rows, number: int, low: np.ndarray | float, high: np.ndarray | float, gaps: Gaps | None = None
) -> np.ndarray | None:
    """The value given for a draw, if any; an object that has no room for it fails (and goes on with a legal value)."""
    value = state.given.get(number)
    if value is None:
        return None
    found = full(rows, value).astype(np.float64)
    bad = ~((found >= low - TOLERANCE) & (found <= high + TOLERANCE))
    _no_room(state, rows, number, bad if gaps is None else bad | inside(found, gaps))
    return np.where(bad, low, found)


def draw_real(
    state: State,
    rows: Rows,
    number: int,
    address: str,
    low: np.ndarray,
    high: np.ndarray,
    distribution: str,
    arguments: tuple[Any, ...],
    default: np.ndarray | float | None,
    domain: tuple[Any, ...] | None = None,
    unions: tuple[Any, ...] = (),
) -> np.ndarray:
    """A value between ``low`` and ``high`` per row, distributed as asked within them.

    ``domain``: the ends of the declared range, where it is another one. ``unions`` as ``laws.gaps_of`` has them.
    """
    gaps = gaps_of(low, unions, False) if unions else None
    found = _given(state, rows, number, low, high, gaps)
    if found is None:
        bad = ~(low <= high + TOLERANCE)  # nor is there room between ends that are no numbers
        _no_room(state, rows, number, bad)
        top = np.maximum(low, high)
        if state.defaults and default is not None:
            found = np.minimum(np.maximum(full(rows, default).astype(np.float64), low), top)
            found = found if gaps is None else clear(found, low, top, gaps)
        else:
            unit = _lot(state, rows, address)
            found = _spread(unit, low, top, gaps, distribution, arguments)
            if number in state.kept:
                found = _near(state.kept[number], rows, unit, low, top, found, gaps)
        if gaps is not None:
            _no_room(state, rows, number, inside(found, gaps) & ~bad)
    if state.weigh and domain is not None:
        _weigh(state, rows, number, found, (low, high), domain, gaps, distribution, arguments)
    state.values[number] = found
    return found


def _spread(
    unit: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    gaps: Gaps | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> np.ndarray:
    if gaps is None:
        return spread(unit, low, high, distribution, arguments)
    return spread_between(unit, low, high, gaps, distribution, arguments)


def _weigh(
    state: State,
    rows: Rows,
    number: int,
    value: np.ndarray,
    ends: tuple[Any, ...],
    domain: tuple[Any, ...],
    gaps: Gaps | None,
    distribution: str,
    arguments: tuple[Any, ...],
) -> None:
    """Note how much of the declared law lies in the range that was left of it, or how likely a value given is by it."""
    whole = held(
        full(rows, domain[0]).astype(np.float64),
        full(rows, domain[1]).astype(np.float64),
        None,
        distribution,
        arguments,
    )
    part = (
        density(value, distribution, arguments)
        if number in state.given
        else held(ends[0], ends[1], gaps, distribution, arguments)
    )
    _note(state, rows, part, whole, number in state.given)


def _note(state: State, rows: Rows, part: np.ndarray, whole: np.ndarray, dense: bool = False) -> None:
    share = np.where(whole > 0.0, part / np.where(whole > 0.0, whole, 1.0), 1.0)
    share = np.maximum(share if dense else np.minimum(share, 1.0), LEAST)
    state.log_weight += np.bincount(rows.owner, weights=np.log(share), minlength=len(state.objects))


def _near(
    kept: Kept, rows: Rows, unit: np.ndarray, low: np.ndarray, high: np.ndarray, fresh: np.ndarray, gaps: Gaps | None
) -> np.ndarray:
    """Within reach of the value kept, as far as the bounds allow; the fresh value for rows that are new."""
    known, at = kept.find(rows)
    if not known.any():
        return fresh
    old = kept.value[at]
    first = np.minimum(np.maximum(old - kept.reach[at], low), high)
    last = np.minimum(np.maximum(old + kept.reach[at], low), high)
    if gaps is not None:
        near = clear(spread_between(unit, first, last, gaps, "uniform", ()), low, high, gaps)
        return np.where(known, np.where(first < last, near, clear(first, low, high, gaps)), fresh)
    return np.where(known, np.minimum(first + unit * (last - first), last), fresh)


def draw_count(
    state: State,
    rows: Rows,
    number: int,
    address: str,
    low: np.ndarray,
    high: np.ndarray,
    distribution: str,
    arguments: tuple[Any, ...],
    default: np.ndarray | float | None,
    domain: tuple[Any, ...] | None = None,
    unions: tuple[Any, ...] = (),
) -> np.ndarray:
    """A whole number between ``low`` and ``high`` per row; ``domain`` and ``unions`` as of ``draw_real``."""
    gaps = gaps_of(low, unions, True) if unions else None
    first, last = np.ceil(low - TOLERANCE), np.floor(high + TOLERANCE)
    found = _given(state, rows, number, first, last, gaps)
    if found is None:
        bad = ~(first <= last)
        _no_room(state, rows, number, bad)
        last = np.maximum(first, last)
        if state.defaults and default is not None:
            found = np.minimum(np.maximum(full(rows, default).astype(np.float64), first), last)
        elif distribution == "uniform" and gaps is None:
            unit = _lot(state, rows, address)
            one, two = _whole(first, last, distribution, arguments)
            found = np.minimum(one + np.floor(unit * (two - one + 1.0)), two)
        else:
            one, two = _whole(first, last, distribution, arguments)
            law = () if distribution == "uniform" else arguments
            wide = _spread(_lot(state, rows, address), one - 0.5, two + 0.5, gaps, distribution, law)
            found = np.minimum(np.maximum(np.floor(wide + 0.5), one), two)
        if number in state.kept:
            found = _other_count(state.kept[number], rows, _lot(state, rows, address), first, last, found)
        if gaps is not None:
            found = (
                np.floor(clear(found, first - 0.5, last + 0.5, gaps) + 0.5) if state.defaults or state.kept else found
            )
            _no_room(state, rows, number, inside(found, gaps) & ~bad)
    if state.weigh and domain is not None:
        one, two = _whole(first, last, distribution, arguments)
        least, most = (full(rows, end).astype(np.float64) for end in domain)
        least, most = _whole(np.ceil(least - TOLERANCE), np.floor(most + TOLERANCE), distribution, arguments)
        law = () if distribution == "uniform" else arguments
        ends = (found, found) if number in state.given else (one, two)
        part = held(ends[0] - 0.5, ends[1] + 0.5, gaps, distribution, law)
        _note(state, rows, part, held(least - 0.5, most + 0.5, None, distribution, law))
    state.values[number] = found
    return found


def _whole(
    first: np.ndarray, last: np.ndarray, distribution: str, arguments: tuple[Any, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """The whole numbers of a range in which a law lies."""
    first, last = support(first, last, distribution, arguments)
    return np.ceil(first - TOLERANCE), np.floor(last + TOLERANCE)


def _other_count(
    kept: Kept, rows: Rows, unit: np.ndarray, first: np.ndarray, last: np.ndarray, fresh: np.ndarray
) -> np.ndarray:
    """The count kept, moved into the range; another one where that is asked for and there is one."""
    known, at = kept.find(rows)
    if not known.any():
        return fresh
    old = np.minimum(np.maximum(kept.value[at], first), last)
    other = np.minimum(first + np.floor(unit * (last - first)), last)
    other = np.where(other >= old, np.minimum(other + 1.0, last), other)
    return np.where(known, np.where(kept.swap[at] & (last > first), other, old), fresh)


def draw_choice(
    state: State,
    rows: Rows,
    number: int,
    address: str,
    weights: tuple[Any, ...],
    declared: tuple[Any, ...] | None = None,
    default: np.ndarray | float | None = None,
) -> np.ndarray:
    """The index of one of the options, by weight; ``declared`` are the weights before requirements removed some."""
    table = np.stack([np.broadcast_to(np.asarray(w, dtype=np.float64), (rows.size,)) for w in weights])
    table = np.where(table < np.inf, table, 0.0)  # a weight that is no number is for a requirement to refuse
    found = _given(state, rows, number, 0.0, len(weights) - 1.0)
    if found is not None:
        _no_room(state, rows, number, table[found.astype(np.int64), np.arange(rows.size)] <= 0.0)
    else:
        left = _other_option(state.kept[number], rows, table) if number in state.kept else table
        total = np.cumsum(np.maximum(left, 0.0), axis=0)
        _no_room(state, rows, number, total[-1] <= 0.0)
        if state.defaults:
            found = np.argmax(left > 0.0, axis=0).astype(np.float64)
            if default is not None:
                usual = full(rows, default).astype(np.int64)
                found = np.where(left[usual, np.arange(rows.size)] > 0.0, usual, found).astype(np.float64)
        else:
            mark = _lot(state, rows, address) * total[-1]
            found = np.minimum((total <= mark).sum(axis=0), len(weights) - 1).astype(np.float64)
    if state.weigh and (declared is not None or number in state.given):
        prior = table if declared is None else np.stack([full(rows, w).astype(np.float64) for w in declared])
        part = (
            prior[found.astype(np.int64), np.arange(rows.size)]
            if number in state.given
            else np.cumsum(np.maximum(table, 0.0), axis=0)[-1]
        )
        _note(state, rows, part, np.cumsum(np.maximum(prior, 0.0), axis=0)[-1])
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


def lean(state: State, rows: Rows, number: int, holds: np.ndarray | bool, weight: np.ndarray | float) -> None:
    """Note the objects that do not keep a preference, and what it weighs, once for each of their rows."""
    bad = np.flatnonzero(~full(rows, holds).astype(bool))
    if len(bad):
        owners = rows.owner[bad]
        heavy = np.maximum(full(rows, weight).astype(np.float64)[bad], 0.0)
        state.leaning += np.bincount(owners, weights=heavy, minlength=len(state.objects))
        state.unkept[number] = state.unkept.get(number, 0) + len(np.unique(owners))


def preferred(state: State) -> np.ndarray:
    """Which objects their preferences let pass: with probability exp(-weight) for each row that does not keep one."""
    if not state.leaning.any():
        return np.ones(len(state.objects), dtype=bool)
    lot = uniform(key(state.seed, "prefer"), state.objects.astype(np.uint64), 0, state.attempt)
    return lot <= np.exp(-state.leaning)
