"""A tape laid out for the machine: which registers hold what, and which steps run once, once per row, per column, or per block.

A value varies along rows, along columns, along both or neither; each is computed as often as NumPy would compute it. ``layout.c`` does
it, in a few hundred nanoseconds a step: a plan pays from the first call on.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..records import dataclass
from . import loops
from .calls import address, call

if TYPE_CHECKING:
    from .backend import Machine
    from .tape import Tape

ROW, COLUMN, EVERY = 1, 2, 3  # as in tape.h, where 0 is neither; what two vary along together is ``a | b``
_CACHE = 24 << 10  # bytes of the first cache that blocks may take
LEAST, MOST = 128, 1024  # rows in a block

_TRUTHS = ("lt", "le", "eq", "ne", "and", "or", "not")
_PLAIN, _TRUTH, _POWER, _WHERE = range(4)  # as in layout.c
_MADE, _GIVEN, _FIXED = range(3)
_OPS = (*loops.FUNCTIONS, "where", "number", "same")
_CODES = {op: code for code, op in enumerate(_OPS)}
_INPUTS = np.array([*(f.nin for f in loops.FUNCTIONS.values()), 3, 1, 1], dtype=np.uint8)
_KINDS = np.full(len(_OPS), _PLAIN, dtype=np.uint8)
_KINDS[[_CODES[op] for op in _TRUTHS]] = _TRUTH
_KINDS[_CODES["pow"]], _KINDS[_CODES["where"]] = _POWER, _WHERE


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


class Encoded:
    """A tape as arrays: operations, arguments of one after the other, constants and their bytes, and what comes out."""

    __slots__ = ("codes", "arguments", "constants", "sizes", "outputs")

    def __init__(self, tape: Tape):
        self.codes = np.array([_CODES[op] for op in tape.operations], dtype=np.int32)
        self.arguments = np.array(tape.arguments, dtype=np.int32)
        self.constants = np.array(tape.constants, dtype=np.float64)
        self.sizes = np.array([1 if isinstance(c, bool) else 8 for c in tape.constants], dtype=np.uint8)
        self.outputs = np.array(tape.outputs, dtype=np.int32)


class _Request(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_int64) for name in ("variables", "constants", "steps", "outputs")),
        *(
            (name, ctypes.c_void_p)
            for name in ("size", "along", "constant", "constant_size", "code", "asked", "wanted")
        ),
        *((name, ctypes.c_void_p) for name in ("inputs", "kind", "table")),
        *((name, ctypes.c_int64) for name in ("ne", "number", "same")),
        *((name, ctypes.c_void_p) for name in ("head", "ops", "regs", "pool", "result", "fixed", "made", "count")),
    ]


def make_table(moves: dict[str, int]) -> np.ndarray:
    """(operations, 2, 2) int64: loops for numbers and for truth values, and what each is given, 0 where there is none. ``moves``: those
    that are none of NumPy's. Raises Unreadable."""
    table = np.zeros((len(_OPS), 2, 2), dtype=np.int64)
    for op, function in loops.FUNCTIONS.items():
        truth = op in _TRUTHS
        table[_CODES[op], 0] = loops.loop(function, "d" * function.nin + ("->?" if truth else "->d"))
        if truth:
            table[_CODES[op], 1] = loops.loop(function, "?" * function.nin + "->?")
    table[_CODES["where"], :, 0] = moves["choose8"], moves["choose1"]
    table[_CODES["number"], 0, 0], table[_CODES["same"], 0, 0] = moves["number"], moves["same8"]
    return table


def make_plan(machine: Machine, tape: Tape, sizes: Sequence[int], along: Sequence[int]) -> Plan:
    """The plan for variables whose numbers have ``sizes`` bytes, 8 or 1, and vary as ``along`` says. Raises NotPlanned."""
    code = tape.encoded
    steps, outputs = len(code.codes), len(code.outputs)
    first = tape.variables + len(code.constants)
    # a step may need a comparison with nought, truth values as numbers, and to repeat an exponent
    most = first + 6 * steps
    head, count = np.zeros(10, dtype=np.int64), np.zeros(3, dtype=np.int64)
    ops, regs, pool = np.empty((5 * steps, 8), np.int64), np.empty((most, 4), np.int64), np.empty(most)
    result, fixed = np.empty((outputs, 2), dtype=np.int64), np.empty(outputs)
    made = np.empty((outputs, 2), dtype=np.int64)
    given = np.array(sizes, dtype=np.uint8), np.array(along, dtype=np.uint8)
    arrays = (
        *given,
        code.constants,
        code.sizes,
        code.codes,
        code.arguments,
        code.outputs,
        _INPUTS,
        _KINDS,
        machine.table,
    )
    found = (head, ops, regs, pool, result, fixed, made, count)
    request = _Request(
        tape.variables,
        len(code.constants),
        steps,
        outputs,
        *(address(a) for a in arrays),
        _CODES["ne"],
        _CODES["number"],
        _CODES["same"],
        *(address(a) for a in found),
    )
    wrong = call(machine.library.lay_out, request)
    if wrong == 1:
        raise NotPlanned
    if wrong:
        raise MemoryError
    held = (head, ops[: head[0]].copy(), regs[: head[1]].copy(), pool[: max(1, count[1])].copy())
    results = [_result(*told) for told in zip(*result.T.tolist(), fixed.tolist(), strict=True)]
    arrays_made = tuple([Made(*one) for one in made[: count[0]].tolist()])
    spare = int(head[2 + EVERY])
    block = max(LEAST, min(MOST, _CACHE // (8 * max(1, spare + len(arrays_made))) // 64 * 64))
    first_op, first_reg, first_number = (address(a) for a in held[1:])
    places = address(head), first_op, first_reg, first_number
    return Plan(*held, int(head[0]), block, arrays_made, tuple(results), bool(count[2]), places)


def _result(kind: int, number: int, value: float) -> tuple[str, Any]:
    if kind == _FIXED:
        return "constant", bool(value) if number == 1 else value
    return "made" if kind == _MADE else "given", number
