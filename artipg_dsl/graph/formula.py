"""Formulas over free variables turned into functions of arrays: patches, inside functions, label fields.

A formula takes arrays that broadcast with one another and returns one array per expression. Equal subexpressions are
computed once. It is run as a tape by the compiled backend where there is one, else by NumPy: step by step at first, since most
formulas are asked a few times and to generate code costs as much as a hundred calls, then as generated code. The bits are the
same.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from itertools import count
from typing import Any

import numpy as np

from ..native import backend
from ..native.tape import Tape
from .expr import Expr, show, variables

NUMPY = {
    "add": "({0} + {1})",
    "sub": "({0} - {1})",
    "mul": "({0} * {1})",
    "div": "np.divide({0}, {1})",
    "neg": "(-{0})",
    "pow": "np.power({0}, {1})",
    "abs": "np.abs({0})",
    "sqrt": "np.sqrt({0})",
    "sin": "np.sin({0})",
    "cos": "np.cos({0})",
    "tan": "np.tan({0})",
    "asin": "np.arcsin({0})",
    "acos": "np.arccos({0})",
    "atan": "np.arctan({0})",
    "atan2": "np.arctan2({0}, {1})",
    "hypot": "np.hypot({0}, {1})",
    "exp": "np.exp({0})",
    "log": "np.log({0})",
    "floor": "np.floor({0})",
    "ceil": "np.ceil({0})",
    "sign": "np.sign({0})",
    "min": "np.minimum({0}, {1})",
    "max": "np.maximum({0}, {1})",
    "mod": "np.mod({0}, {1})",
    "lt": "({0} < {1})",
    "le": "({0} <= {1})",
    "eq": "({0} == {1})",
    "and": "np.logical_and({0}, {1})",
    "or": "np.logical_or({0}, {1})",
    "not": "np.logical_not({0})",
    "where": "np.where({0}, {1}, {2})",
}


def literal(value: object) -> str:
    """A constant as Python source that reads back to the same bits."""
    if isinstance(value, bool):
        return repr(value)
    if not isinstance(value, int | float):
        raise ValueError(f"a constant is a number, not {value!r}")
    number = float(value)
    if number != number or number in (float("inf"), float("-inf")):
        return {"inf": "np.inf", "-inf": "-np.inf", "nan": "np.nan"}[repr(number)]
    return repr(number) if number >= 0 else f"({number!r})"


def source(exprs: Sequence[Expr], names: Sequence[str], name: str = "formula", given: Sequence[Expr] = ()) -> str:
    """Python source of a function, ``formula`` or of another name, that returns a tuple with one value per expression.

    The parameters are the values of the expressions ``given``, then the free variables ``names``. They are called ``v0``,
    ``v1``, ...: no text of a program is ever part of the code.
    """
    return _source(tape(exprs, names, given), name)


def _source(tape: Tape, name: str) -> str:
    """A tape as a Python function. A name is used again once its value is: what a formula of thousands of steps keeps in memory is
    what it still needs."""
    texts = [f"v{place}" for place in range(tape.variables)] + list(map(literal, tape.constants))
    first = len(texts)
    uses = Counter(tape.outputs)
    for _, arguments in tape.steps:
        uses.update(arguments)
    lines: list[str] = []
    free: list[str] = []
    made = 0
    for operation, arguments in tape.steps:
        text = NUMPY[operation].format(*[texts[k] for k in arguments])
        for k in arguments:
            uses[k] -= 1
            if not uses[k] and k >= first:
                free.append(texts[k])
        if not free:
            free.append(f"t{made}")
            made += 1
        texts.append(free.pop())
        lines.append(f"    {texts[-1]} = {text}")
    header = f"def {name}({', '.join(texts[: tape.variables])}):"
    return "\n".join([header, *lines, f"    return ({''.join(texts[k] + ', ' for k in tape.outputs)})"])


def _steps(exprs: Sequence[Expr], given: Iterable[Expr] = ()) -> list[Expr]:
    """All nodes, arguments before what is made of them; those ``given`` are left out."""
    order: list[Expr] = []
    seen = set(given)

    def visit(node: Expr) -> None:
        seen.add(node)
        for arg in node.args:
            if arg not in seen:
                visit(arg)
        order.append(node)

    for expr in exprs:
        if expr not in seen:
            visit(expr)
    return order


# Formulas are computed everywhere and taken where they hold (the branches of `a if c else b`, points outside a `where`):
# NumPy's warnings of values that are not taken say nothing. Those that are taken are asked for as numbers
# (``lower.elaborate.legal``, ``annotate.points``).
_quiet = np.errstate(divide="ignore", invalid="ignore", over="ignore")


SHORT = 16  # steps below which calling NumPy for each is faster than telling the machine of all
_OFTEN = 64  # calls from which on generated code is faster, the time to generate it included
# In numbers that NumPy computes: what the call of a step costs, what it costs to tell the machine of a tape, and of each of its steps.
_CALL, _TOLD, _STEP = 1000, 60_000, 280


class Formula:
    """A tape as a function of arrays or numbers that returns a tuple of values, one per output."""

    __slots__ = ("tape", "_code", "_calls", "_work", "_worth")

    def __init__(self, tape: Tape):
        self.tape = tape
        self._code: Callable[..., tuple[Any, ...]] | None = None
        self._calls = 0
        self._work = 0  # what NumPy would have had to do for each step
        self._worth = _STEP + _TOLD // max(1, len(tape.operations))  # of such work, to tell the machine of it

    def __call__(self, *values: Any) -> tuple[Any, ...]:
        machine = backend.machine() if len(self.tape.operations) >= SHORT else None
        if machine is not None and self._work < self._worth:
            self._work += _CALL + max(map(np.size, values), default=1)  # about: of rows and columns it is more
        if machine is not None and self._work >= self._worth:
            found = self.tape.run(machine, values)
            if found is not None:
                return found
        self._calls += 1
        return self.numpy(*values) if self._calls > _OFTEN else _stepwise(self.tape, values)

    @property
    def numpy(self) -> Callable[..., tuple[Any, ...]]:
        """The same by generated NumPy code."""
        if self._code is None:
            namespace: dict[str, Any] = {"np": np}
            text = _source(self.tape, "formula")
            exec(compile(text, "<formula>", "exec"), namespace)  # no text of a program reaches it
            self._code = _quiet(namespace["formula"])
        return self._code


_stepwise = _quiet(Tape.stepwise)


def tape(exprs: Sequence[Expr], names: Sequence[str], given: Sequence[Expr] = ()) -> Tape:
    """The expressions as operations on columns: the values of those ``given``, then ``names``, in this order."""
    known = {variable: place for place, variable in enumerate(names, len(given))}
    order = _steps(exprs, given)
    constants = [node for node in order if node.op == "const"]
    steps = [node for node in order if node.op not in ("const", "var")]
    for node in order:
        if node.op == "var" and node.value not in known:
            raise ValueError(f"a formula reads {node.value}, which is not among its variables {sorted(known)}")
    for node in steps:
        if node.op not in NUMPY:
            raise ValueError(f"{show(node)} is not a formula over variables")
    columns = len(given) + len(names)
    number = {node: place for place, node in enumerate(given)}
    number.update((node, known[node.value]) for node in order if node.op == "var")
    number.update(zip([*constants, *steps], count(columns), strict=False))
    arguments = [number[arg] for node in steps for arg in node.args]
    operations = [node.op for node in steps]
    return Tape(columns, [node.value for node in constants], operations, arguments, [number[e] for e in exprs])


def compile_formula(exprs: Sequence[Expr], names: Sequence[str], given: Sequence[Expr] = ()) -> Formula:
    """A function that returns a tuple of values, one per expression, of the values of the expressions ``given``, which it does not
    compute, and then of the variables ``names``: arrays or scalars."""
    return _compile(tuple(exprs), tuple(names), tuple(given))


@lru_cache(maxsize=4096)
def _compile(exprs: tuple[Expr, ...], names: tuple[str, ...], given: tuple[Expr, ...]) -> Formula:
    return Formula(tape(exprs, names, given))


def evaluate(exprs: Sequence[Expr], values: dict[str, np.ndarray | float]) -> list[np.ndarray]:
    """Values of the expressions for the given variables, broadcast to one common shape, float64 or bool."""
    names = tuple(sorted(variables(exprs)))
    results = compile_formula(exprs, names)(*(values[n] for n in names))
    shape = np.broadcast_shapes(*(np.shape(v) for v in values.values())) if values else ()
    return [np.broadcast_to(np.asarray(r), shape) for r in results]


def row_values(formulas: Iterable[Expr]) -> list[Expr]:
    """The largest subexpressions that read columns and no variable of a formula."""
    found: dict[Expr, None] = {}
    seen: set[Expr] = set()

    def visit(node: Expr) -> None:
        if node.op in ("const", "var") or node in seen:
            return
        seen.add(node)
        if node.scope is not None and not node.reads:
            found[node] = None
            return
        for arg in node.args:
            visit(arg)

    for formula in formulas:
        visit(formula)
    return list(found)
