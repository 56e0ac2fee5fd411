"""Formulas of a primitive as functions of columns, split into what is computed per instance and what per point.

To differentiate, substitute and number them takes longer than to compute a few objects: they are kept between runs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..graph.expr import Expr, var
from ..graph.formula import Formula, compile_formula
from ..graph.primitive import Primitive
from ..native.tape import read_tape
from . import facts

Params = dict[str, np.ndarray]


def rows_of(params: Params) -> int:
    """The number of instances; a primitive without parameters is one instance unless ``""`` gives a column."""
    return len(next(iter(params.values()))) if params else 1


class Split:
    """Formulas over parameters and the coordinates of a point: ``per_row`` of the former alone, ``per_point`` of what that gives and the
    latter. ``exponents``: which values per row are exponents of powers."""

    def __init__(self, names: Sequence[str], per_row: Formula, per_point: Formula, exponents: Sequence[int]):
        self._names, self._rows, self._points = names, per_row, per_point
        self._exponents = exponents

    @staticmethod
    def of(primitive: Primitive, exprs: Sequence[Expr], point: Sequence[str] = ("u", "v")) -> Split:
        along = 0
        for name in point:
            along |= var(name).reads
        hoisted: dict[Expr, None] = {}
        seen: set[Expr] = set()

        def collect(node: Expr) -> None:
            if node in seen:
                return
            seen.add(node)
            if node.reads & along:
                for arg in node.args:
                    collect(arg)
            elif node.op != "const":
                hoisted[node] = None

        for expr in exprs:
            collect(expr)
        powers = {node.args[1] for node in seen if node.op == "pow"}
        exponents = [k for k, node in enumerate(hoisted) if node in powers]
        per_row = compile_formula(tuple(hoisted), primitive.parameters)
        return Split(primitive.parameters, per_row, compile_formula(exprs, point, tuple(hoisted)), exponents)

    @staticmethod
    def kept(
        primitive: Primitive,
        name: str,
        values: int,
        exprs: Callable[[], Sequence[Expr]],
        point: Sequence[str] = ("u", "v"),
    ) -> Split:
        """The same for so many ``values``, which ``exprs`` gives where no earlier run has; ``name`` tells them from others of the
        primitive."""

        def read(held: Any) -> Split:
            per_row, per_point, exponents = read_tape(held["rows"]), read_tape(held["points"]), held["exponents"]
            columns = len(per_row.outputs)
            if (
                per_row.variables != len(primitive.parameters)
                or per_point.variables != columns + len(point)
                or len(per_point.outputs) != values
                or not set(exponents) <= set(range(columns))
            ):
                raise ValueError("other formulas")
            return Split(primitive.parameters, Formula(per_row), Formula(per_point), exponents)

        return facts.recall_fact(primitive, name, lambda: Split.of(primitive, exprs(), point), Split._to_data, read)

    def _to_data(self) -> dict[str, Any]:
        return {
            "rows": self._rows.tape.to_data(),
            "points": self._points.tape.to_data(),
            "exponents": list(self._exponents),
        }

    def rows(self, params: Params) -> np.ndarray:
        """(h, k): the values per instance that the formulas need."""
        count = rows_of(params)
        values = self._rows(*(params[n] for n in self._names))
        out = np.empty((len(values), count))
        for row, value in zip(out, values, strict=True):
            row[...] = value
        return out

    def points(self, rows: Sequence[np.ndarray] | np.ndarray, *point: np.ndarray) -> tuple[Any, ...]:
        """The values at points: ``rows`` gathered to arrays that broadcast with the point variables (fractions).

        Exponents are told for every point: NumPy computes the power of one that is broadcast in another way, by the number of rows.
        """
        given = list(rows)
        if self._exponents:
            shape = np.broadcast_shapes(*(array.shape for array in (*rows, *point)))
            for k in self._exponents:
                if given[k].shape != shape or 0 in given[k].strides:
                    given[k] = np.broadcast_to(given[k], shape).copy(order="C")
        return self._points(*given, *point)


def keep_formula(
    primitive: Primitive, name: str, values: int, exprs: Callable[[], Sequence[Expr]], more: Sequence[str] = ()
) -> Formula:
    """A function of the parameters' columns, and ``more``, that gives so many ``values``; kept as a split is."""
    names = (*primitive.parameters, *more)

    def read(held: Any) -> Formula:
        tape = read_tape(held)
        if tape.variables != len(names) or len(tape.outputs) != values:
            raise ValueError("another formula")
        return Formula(tape)

    return facts.recall_fact(
        primitive, name, lambda: compile_formula(exprs(), names), lambda made: made.tape.to_data(), read
    )
