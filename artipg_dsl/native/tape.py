"""Tapes: straight-line programs of operations on columns, and how the machine runs one over arrays.

Values are numbered: the variables, then the constants, then what each step makes. The arrays that come out are those that NumPy would
make of the same operations, bit for bit: each value is made by the loop that NumPy would call, of rows that lie as they would there.
Where that cannot be promised (types other than float64 and bool, three patterns of broadcasting, a power whose exponents are
broadcast otherwise than along rows), ``run`` leaves the work to NumPy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from itertools import accumulate, pairwise
from math import prod
from typing import TYPE_CHECKING, Any

import numpy as np

from ..records import dataclass
from .calls import integers
from .loops import FUNCTIONS
from .plan import COLUMN, EVERY, ROW, Encoded, NotPlanned, Plan, make_plan

if TYPE_CHECKING:
    from .backend import Machine

_LITTLE = 1 << 20  # numbers that may be kept for nothing: which ones are is not free to find
_NARROWEST = 32  # columns of a row that are worth a round of their own
_CALLS: dict[str, Callable[..., Any]] = {**FUNCTIONS, "where": np.where}  # what NumPy calls the operations

_TAKEN = {**{operation: function.nin for operation, function in FUNCTIONS.items()}, "where": 3}  # arguments of a step

_FLOAT, _BOOL = np.dtype(np.float64), np.dtype(np.bool_)
_SIZES = {_FLOAT: 8, _BOOL: 1}


@dataclass(slots=True, eq=False)
class Tape:
    """``operations`` of the steps, ``arguments`` of one after the other and ``outputs``: numbers of values."""

    variables: int
    constants: Sequence[float | bool]
    operations: Sequence[str]
    arguments: Sequence[int]
    outputs: Sequence[int]
    plans: dict[tuple[tuple[int, ...], tuple[int, ...]], Plan | None] = field(init=False, default_factory=dict)
    last: list[list[int]] | None = field(init=False, default=None)  # per step, what no later one reads
    code: Encoded | None = field(init=False, default=None)
    _steps: list[tuple[str, tuple[int, ...]]] | None = field(init=False, default=None)

    @property
    def steps(self) -> list[tuple[str, tuple[int, ...]]]:
        """Operations with the numbers of their arguments."""
        if self._steps is None:
            ends = accumulate(map(_TAKEN.__getitem__, self.operations), initial=0)
            taken = [tuple(self.arguments[start:stop]) for start, stop in pairwise(ends)]
            self._steps = list(zip(self.operations, taken, strict=True))
        return self._steps

    def to_data(self) -> dict[str, Any]:
        """As JSON has it; ``read_tape`` reads it."""
        return {
            "variables": self.variables,
            "constants": list(self.constants),
            "operations": " ".join(self.operations),
            "arguments": list(self.arguments),
            "outputs": list(self.outputs),
        }

    @property
    def encoded(self) -> Encoded:
        """The same as arrays, for the machine."""
        if self.code is None:
            self.code = Encoded(self)
        return self.code

    def stepwise(self, values: Sequence[Any]) -> tuple[Any, ...]:
        """The outputs for arrays or numbers ``values``, by NumPy, a call for each step; a value is dropped behind its last use if all
        of them could take much memory."""
        found: list[Any] = [*values, *(c if isinstance(c, bool) else float(c) for c in self.constants)]
        if len(self.operations) * prod({v.size for v in values if isinstance(v, np.ndarray)}) < _LITTLE:
            for operation, arguments in self.steps:
                found.append(_CALLS[operation](*[found[k] for k in arguments]))
            return tuple([found[k] for k in self.outputs])
        if self.last is None:
            self.last = self._last_uses(len(found))
        for (operation, arguments), done in zip(self.steps, self.last, strict=True):
            found.append(_CALLS[operation](*[found[k] for k in arguments]))
            for k in done:
                found[k] = None
        return tuple([found[k] for k in self.outputs])

    def _last_uses(self, first: int) -> list[list[int]]:
        kept, last = set(self.outputs), []
        for _, arguments in reversed(self.steps):
            done = [k for k in dict.fromkeys(arguments) if k >= first and k not in kept]
            kept.update(done)
            last.append(done)
        return last[::-1]

    def run(self, machine: Machine, values: Sequence[Any]) -> tuple[Any, ...] | None:
        """The outputs for arrays or numbers ``values``; None where NumPy has to do it."""
        arrays: list[np.ndarray] = []
        sizes, shapes = [], []
        for value in values:
            array = value if type(value) is np.ndarray else np.asarray(value)
            size = _SIZES.get(array.dtype)
            if size is None:
                return None
            arrays.append(array)
            sizes.append(size)
            shapes.append(array.shape)
        found = _layout(shapes)
        if found is None:
            return None
        along, outer, inner, shape, split = found
        key = tuple(sizes), along
        try:
            plan = self.plans[key]
        except KeyError:
            try:
                plan = make_plan(machine, self, sizes, along)
            except NotPlanned:
                plan = None
            self.plans[key] = plan
        if plan is None or plan.wary and inner == 1 and not _alike(arrays):
            return None
        some = outer > 0 and inner > 0
        if not some and any(o.along != EVERY for o in plan.made):
            return None
        kinds = (1,) * len(shape), shape[:split] + (1,) * (len(shape) - split), (1,) * split + shape[split:], shape
        made = [np.empty(kinds[o.along], _BOOL if o.size == 1 else _FLOAT) for o in plan.made]
        if plan.steps and some:
            every = (*arrays, *made)
            objects = integers(len(every))(*map(id, every))
            if machine.run(plan, objects, outer, inner):
                return None
        return tuple(
            made[place] if kind == "made" else arrays[place] if kind == "given" else place
            for kind, place in plan.results
        )


def read_tape(held: Any) -> Tape:
    """A tape that was kept. Raises ValueError, TypeError or KeyError where data is none: each step takes what is there before it."""
    variables, constants = held["variables"], held["constants"]
    operations, arguments, outputs = held["operations"].split(), held["arguments"], held["outputs"]
    numbers = [variables, *arguments, *outputs]
    if set(map(type, numbers)) != {int} or not set(map(type, constants)) <= {int, float, bool}:
        raise ValueError("no tape")
    taken = np.array([_TAKEN[operation] for operation in operations], dtype=np.int64)
    first = variables + len(constants)
    limit = np.repeat(np.arange(first, first + len(operations)), taken)
    if len(limit) != len(arguments) or min(numbers) < 0 or (np.array(arguments, dtype=np.int64) >= limit).any():
        raise ValueError("a step takes what is not there")
    if max(outputs, default=-1) >= first + len(operations):
        raise ValueError("an output is not there")
    return Tape(variables, constants, operations, arguments, outputs)


def _alike(arrays: Sequence[np.ndarray]) -> bool:
    """Whether arrays of one number lie as those of many would: NumPy takes exponents that are broadcast another way."""
    return len({a.ndim for a in arrays if a.ndim}) <= 1 and not any([0 in a.strides for a in arrays])


Layout = tuple[tuple[int, ...], int, int, tuple[int, ...], int]


def _layout(shapes: Sequence[tuple[int, ...]]) -> Layout | None:
    """Along what each of some shapes varies, the rows and columns there are, the common shape, and how many of its axes the rows are.
    None where rows and columns do not say it. Raises ValueError for shapes that do not go together."""
    shape: tuple[int, ...] = ()
    for other in shapes:
        if other and other != shape:
            if shape:
                return _mixed(shapes)
            shape = other
    return tuple([EVERY if s else 0 for s in shapes]), 1, prod(shape), shape, 0


def _mixed(shapes: Sequence[tuple[int, ...]]) -> Layout | None:
    longest = max(map(len, shapes))
    padded = [(1,) * (longest - len(s)) + tuple(s) for s in shapes]
    sizes = [set(axis) - {1} for axis in zip(*padded, strict=True)]
    if any([len(size) > 1 for size in sizes]):
        np.broadcast_shapes(*shapes)  # raises
    shape = tuple([size.pop() if size else 1 for size in sizes])
    groups: list[tuple[tuple[bool, ...], int]] = []  # what varies along it, and the axis it begins with
    for axis, size in enumerate(shape):
        pattern = tuple([s[axis] != 1 for s in padded])
        if size != 1 and (not groups or groups[-1][0] != pattern):
            groups.append((pattern, axis))
    if len(groups) <= 1:
        varies = groups[0][0] if groups else (False,) * len(shapes)
        return tuple([EVERY if v else 0 for v in varies]), 1, prod(shape), shape, 0
    if len(groups) > 2:
        return None
    split = groups[1][1]
    outer, inner = prod(shape[:split]), prod(shape[split:])
    if inner < _NARROWEST:
        return None
    along = tuple([ROW * a | COLUMN * b for a, b in zip(groups[0][0], groups[1][0], strict=True)])
    return along, outer, inner, shape, split
