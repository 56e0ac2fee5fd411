"""A tape laid out for the machine: which registers hold what, and which steps run once, once per row, per column, or per block.

A value varies along rows, along columns, along both or neither; each is computed as often as NumPy would compute it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..records import dataclass
from . import loops

if TYPE_CHECKING:
    from .tape import Tape

ONE, ROW, COLUMN, EVERY = range(4)  # as in machine.c; what two vary along together is ``a | b``
CONSTANT, INPUT, OUTPUT, SPARE = range(4)
_PHASES = (ONE, ROW, COLUMN, EVERY)
_CACHE = 24 << 10  # bytes of the first cache that blocks may take
LEAST, MOST = 128, 1024  # rows in a block

_TRUTHS = frozenset({"lt", "le", "eq", "ne", "and", "or", "not"})
Locate = Callable[
    [str, str], tuple[int, int]
]  # addresses of the loop of an operation on types, and of what it is given


class NotPlanned(Exception):
    """A tape that NumPy would not run on these types, or not in this way."""


@dataclass(frozen=True, slots=True)
class Made:
    """An array that comes out: along what it varies, bytes of a number in it."""

    along: int
    size: int


@dataclass(slots=True, eq=False)
class Plan:
    """``results``: for each output ("made", number), ("given", variable) or ("constant", value). ``wary``: there is a power of
    columns, which NumPy computes in another way where they are broadcast."""

    head: np.ndarray
    ops: np.ndarray
    regs: np.ndarray
    pool: np.ndarray
    steps: int
    block: int
    made: tuple[Made, ...]
    results: tuple[tuple[str, Any], ...]
    wary: bool
    places: tuple[int, int, int, int]  # addresses of the arrays above


@dataclass(slots=True, eq=False)
class _Value:
    kind: str  # d or ?
    along: int
    constant: float | bool | None = None
    register: int = -1
    uses: int = 0
    kept: bool = False  # used in a later phase, or given out


class _Planner:
    def __init__(self, tape: Tape, letters: str, along: tuple[int, ...]):
        self.tape = tape
        self.values = [_Value(k, a) for k, a in zip(letters, along, strict=True)]
        for constant in tape.constants:
            self.values.append(_Value("?" if isinstance(constant, bool) else "d", ONE, constant))
        self.steps: list[tuple[str, str, list[int], int]] = []  # operation, types, arguments, value
        self.numbers: dict[int, int] = {}  # truth value -> the same as a number
        self.place: list[int] = list(range(len(self.values)))  # numbers on the tape -> values here
        self.wary = False

    def add(self, op: str, kinds: str, arguments: list[int]) -> int:
        made = _Value(kinds[-1], ONE)
        given = [self.values[a] for a in arguments]
        for one in given:
            made.along |= one.along
        if all(one.constant is not None for one in given):
            with np.errstate(all="ignore"):
                result = _constant(op, [one.constant for one in given])
            made.constant = bool(result) if kinds[-1] == "?" else float(result)
        else:
            self.steps.append((op, kinds, arguments, len(self.values)))
        self.values.append(made)
        return len(self.values) - 1

    def number(self, value: int) -> int:
        """A value as a number, if it is a truth value."""
        if self.values[value].kind == "d":
            return value
        if value not in self.numbers:
            self.numbers[value] = self.add("number", "?->d", [value])
        return self.numbers[value]

    def step(self, op: str, asked: Sequence[int]) -> int:
        arguments = list(asked)
        kinds = [self.values[a].kind for a in arguments]
        if op == "where":
            if kinds[0] == "d":
                self.values.append(_Value("d", ONE, 0.0))
                arguments = [self.add("ne", "dd->?", [arguments[0], len(self.values) - 1]), *arguments[1:]]
            if kinds[1:] == ["?", "?"]:
                return self.add(op, "???->?", arguments)
            return self.add(op, "?dd->d", [arguments[0], *map(self.number, arguments[1:])])
        if op in _TRUTHS and "d" not in kinds:
            return self.add(op, "?" * len(kinds) + "->?", arguments)
        if "d" not in kinds:
            raise NotPlanned(op)  # NumPy's sums of truth values are truth values
        if op == "pow" and self.values[arguments[1]].constant is None:
            self.wary = True
            if self.values[arguments[1]].along != EVERY:
                raise NotPlanned(op)
        arguments = [self.number(a) for a in arguments]
        return self.add(op, "d" * len(kinds) + ("->?" if op in _TRUTHS else "->d"), arguments)


def _constant(op: str, values: list[Any]) -> Any:
    if op == "where":
        return np.where(*values)
    return float(values[0]) if op == "number" else loops.FUNCTIONS[op](*values)


def make_plan(tape: Tape, letters: str, along: tuple[int, ...], locate: Locate) -> Plan:
    """The plan for variables of the types ``letters`` that vary as ``along`` says. Raises NotPlanned."""
    planner = _Planner(tape, letters, along)
    for op, asked in tape.steps:
        planner.place.append(planner.step(op, [planner.place[a] for a in asked]))
    values, steps = planner.values, planner.steps
    outputs = [planner.place[o] for o in tape.outputs]
    needed = set(outputs)
    for _, _, arguments, value in reversed(steps):
        if value in needed:
            needed.update(arguments)
    steps = [s for s in steps if s[3] in needed]
    for _, _, arguments, value in steps:
        for argument in arguments:
            values[argument].uses += 1
            values[argument].kept |= values[argument].along != values[value].along
    for output in outputs:
        values[output].kept = True
    return _laid_out(tape, planner, steps, outputs, locate)


def _laid_out(
    tape: Tape, planner: _Planner, steps: list[tuple[str, str, list[int], int]], outputs: list[int], locate: Locate
) -> Plan:
    values = planner.values
    regs: list[tuple[int, int, int, int]] = []
    pool: list[bytes] = []
    made: list[Made] = []
    results: list[tuple[str, Any]] = []
    placed: dict[int, int] = {}
    arrays = tape.variables
    for output in outputs:
        value = values[output]
        if value.constant is not None:
            results.append(("constant", value.constant))
        elif output < arrays:
            results.append(("given", output))
        else:
            if output not in placed:
                placed[output] = len(made)
                made.append(Made(value.along, 8 if value.kind == "d" else 1))
                value.register = len(regs)
                regs.append((OUTPUT, value.along, made[-1].size, arrays + placed[output]))
            results.append(("made", placed[output]))

    free: dict[int, list[int]] = {phase: [] for phase in _PHASES}
    spare = [0] * 4
    ops: list[tuple[int, ...]] = []
    counts = [0] * 4

    def register(number: int) -> int:
        value = values[number]
        if value.register < 0:
            value.register = len(regs)
            if value.constant is not None:
                regs.append((CONSTANT, ONE, 8, 8 * len(pool)))
                kind: type = np.float64 if value.kind == "d" else np.bool_
                pool.append(kind(value.constant).tobytes().ljust(8, b"\0"))
            else:
                assert number < arrays
                regs.append((INPUT, value.along, 1 if value.kind == "?" else 8, number))
        return value.register

    for phase in _PHASES:
        for op, kinds, arguments, number in steps:
            value = values[number]
            if value.along != phase:
                continue
            given = [register(a) for a in arguments]
            if value.register < 0:
                size = 8 if value.kind == "d" else 1
                for at, old in enumerate(free[phase]):  # of the same size: registers are of numbers or of truth values
                    if regs[old][2] == size:
                        value.register = free[phase].pop(at)
                        break
                else:
                    value.register = len(regs)
                    regs.append((SPARE, phase, size, spare[phase]))
                    spare[phase] += 1
            for argument in arguments:
                used = values[argument]
                used.uses -= 1
                if not used.uses and not used.kept and used.constant is None and regs[used.register][0] == SPARE:
                    free[phase].append(used.register)
            address, data = locate(op, kinds)
            ops.append((address, data, len(given), *given, *[0] * (3 - len(given)), value.register, phase))
            counts[phase] += 1
    block = max(LEAST, min(MOST, _CACHE // (8 * max(1, spare[EVERY] + len(made))) // 64 * 64))
    held = (
        np.array([len(ops), len(regs), *spare, *counts], dtype=np.int64),
        np.array(ops, dtype=np.int64).reshape(-1, 8),
        np.array(regs, dtype=np.int64).reshape(-1, 4),
        np.frombuffer(b"".join(pool) or bytes(8), dtype=np.uint8).copy(),
    )
    head, lines, rows, numbers = (a.ctypes.data for a in held)
    return Plan(*held, len(ops), block, tuple(made), tuple(results), planner.wary, (head, lines, rows, numbers))
