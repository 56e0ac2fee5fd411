"""What the generated code calls: tables, segment operations, requirements. NumPy alone; arrays of rows, never a loop over them.

Everything is computed per row in a fixed order, so a row's value does not depend on which other rows are there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field

import numpy as np

from ..random import key, mix, uniform
from ..records import dataclass

MOST_ROWS = 20_000  # of one table in one object, as ``lower.elaborate.ranges`` has it: more would fill the memory


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

    ``given`` maps the index of a draw to its value (a scalar, or one per row), ``asked`` to one per object, nan for those
    that draw it, and ``kept`` to the values of an object that this one is made from; ``salt``, and ``lane`` per object,
    set the random numbers of one such making apart. ``missed`` counts the objects for which a draw found no room, per
    draw; ``broken`` those that break a requirement, per requirement. ``faults`` has the rows in question: of the table of
    the draw ("draw", number), or of that of the requirement ("requirement", number).
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
    asked: dict[int, np.ndarray] = field(default_factory=dict)

    def asked_of(self, objects: np.ndarray) -> dict[int, np.ndarray]:
        """What the objects at these places are asked for."""
        return {number: values[objects] for number, values in self.asked.items()}

    def lanes(self) -> np.ndarray:
        return np.zeros(len(self.objects), dtype=np.int64) if self.lane is None else self.lane


def root_rows(state: State) -> Rows:
    n = len(state.objects)
    state.failed, state.crowd = np.zeros(n, dtype=bool), np.zeros(n)
    state.log_weight, state.leaning = np.zeros(n), np.zeros(n)
    index = np.arange(n)
    ones = np.ones(n, dtype=np.int64)
    return Rows(n, index, np.zeros(n, dtype=np.int64), index, state.objects.astype(np.uint64), index, ones)


def child_rows(state: State, parent: Rows, count: np.ndarray | float | bool, guard: bool) -> Rows:
    """The table with ``count`` rows per row of ``parent`` (a guard: none or one, at the parent's address).

    An object whose counts are no numbers, or more than ``MOST_ROWS`` in all, has no rows here: a requirement says that it is not valid,
    and ``crowded`` sees to it that one does.
    """
    if not parent.size:
        none = np.zeros(0, dtype=np.int64)
        return Rows(0, none, none, none, np.zeros(0, dtype=np.uint64), none, none)
    asked = full(parent, count)
    if not guard:
        held = np.bincount(parent.owner, weights=np.maximum(asked, 0.0), minlength=len(state.objects))
        over = ~(held <= MOST_ROWS)
        if over.any():
            state.crowd = np.maximum(state.crowd, np.where(over, held, 0.0))
            asked = np.where(over[parent.owner], 0.0, asked)
        asked = np.maximum(asked, 0.0)
    counts = asked.astype(np.int64)
    start = counts.cumsum() - counts
    if guard:
        index = counts.nonzero()[0]
        rank, address = np.zeros(len(index), dtype=np.int64), parent.address[index]
    else:
        index = np.arange(parent.size).repeat(counts)
        rank = np.arange(len(index)) - start[index]
        address = mix(parent.address[index], rank)
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


def merge(parent: Rows, default: np.ndarray | float, branches: Sequence[tuple[Rows, np.ndarray | float]]) -> np.ndarray:
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
    out = np.empty(len(rows.count), dtype=values.dtype if kind in ("any", "all") else np.float64)
    out[...] = empty
    has = rows.count.nonzero()[0]
    if len(has):
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


def demand(state: State, rows: Rows, number: int, holds: np.ndarray | bool) -> None:
    """Note the objects that break a requirement."""
    if not rows.size:
        return
    bad = _unmet(rows, holds)
    if len(bad):
        owners = np.flatnonzero(np.bincount(rows.owner[bad]))
        state.failed[owners] = True
        state.broken[number] = state.broken.get(number, 0) + len(owners)
        state.faults.setdefault(("requirement", number), []).append(bad)


def _unmet(rows: Rows, holds: np.ndarray | bool) -> np.ndarray:
    """The rows for which something does not hold."""
    found = np.asarray(holds, dtype=bool)
    if found.ndim == 0:
        return np.arange(0 if found else rows.size)
    return np.logical_not(found).nonzero()[0]


def lean(state: State, rows: Rows, number: int, holds: np.ndarray | bool, weight: np.ndarray | float) -> None:
    """Note the objects that do not keep a preference, and what it weighs, once for each of their rows."""
    bad = _unmet(rows, holds)
    if len(bad):
        owners = rows.owner[bad]
        heavy = np.maximum(full(rows, weight).astype(np.float64)[bad], 0.0)
        state.leaning += np.bincount(owners, weights=heavy, minlength=len(state.objects))
        state.unkept[number] = state.unkept.get(number, 0) + int(np.count_nonzero(np.bincount(owners)))


def preferred(state: State) -> np.ndarray:
    """Which objects their preferences let pass: with probability exp(-weight) for each row that does not keep one."""
    if not state.leaning.any():
        return np.ones(len(state.objects), dtype=bool)
    lot = uniform(key(state.seed, "prefer"), state.objects.astype(np.uint64), 0, state.attempt)
    return lot <= np.exp(-state.leaning)
