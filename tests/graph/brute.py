"""Expressions worked out point by point, apart from the code of the graph: what its laws are checked against."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from hypothesis import strategies as st

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import Column, Expr, Scope
from artipg_dsl.graph.program import Draw
from artipg_dsl.graph.substitution import rebuild

ROOT = Scope("root")
X, Y = Column(ROOT, "x"), Column(ROOT, "y")
LEAST, MOST = {X: -2.0, Y: 0.5}, {X: 3.0, Y: 4.0}
DRAWS = [Draw(c, c.name, "real", E.const(LEAST[c]), E.const(MOST[c])) for c in (X, Y)]
x, y = E.col(X), E.col(Y)

FUNCTIONS = {
    "add": np.add,
    "sub": np.subtract,
    "mul": np.multiply,
    "div": np.divide,
    "neg": np.negative,
    "abs": np.abs,
    "sqrt": np.sqrt,
    "hypot": np.hypot,
    "min": np.minimum,
    "max": np.maximum,
    "le": np.less_equal,
    "lt": np.less,
    "eq": np.equal,
    "and": np.logical_and,
    "or": np.logical_or,
    "not": np.logical_not,
    "where": np.where,
}
REDUCTIONS = {"sum": np.sum, "min": np.min, "max": np.max}


def evaluate(node: Expr, values: Mapping[Column, object], rows: int = 1) -> np.ndarray:
    """The value of an expression; of a table below the root, an array of its ``rows``."""
    with np.errstate(all="ignore"):
        return _evaluate(node, values, rows)


def _evaluate(node: Expr, values: Mapping[Column, object], rows: int) -> np.ndarray:
    if node.op == "const":
        return np.asarray(node.value)
    if node.op == "col":
        return np.asarray(values[node.value])
    args = [_evaluate(a, values, rows) for a in node.args]
    if node.op == "reduce":
        return REDUCTIONS[node.value[0]](np.broadcast_to(args[0], rows))
    return FUNCTIONS[node.op](*args)


def within(column: Column) -> st.SearchStrategy[float]:
    """Values of a column in its domain, in steps, so that ends and middles are met."""
    steps = int((MOST[column] - LEAST[column]) * 16)
    return st.integers(0, steps).map(lambda k: LEAST[column] + k / 16)


numbers = st.integers(-8, 8).map(lambda k: k / 2)
above_zero = st.integers(1, 6).map(lambda k: k / 2)


def formulas(
    leaves: st.SearchStrategy[Expr], divisor: Expr, most: int = 6, *, rounded: bool = True
) -> st.SearchStrategy[Expr]:
    """Sums, products, extremes, ... of some leaves, and quotients with one divisor; with roots where they may be rounded."""

    def grown(inner: st.SearchStrategy[Expr]) -> st.SearchStrategy[Expr]:
        words = ["add", "sub", "mul", "min", "max", *(["hypot"] if rounded else [])]
        two = st.tuples(st.sampled_from(words), inner, inner)
        one = st.tuples(st.sampled_from(["neg", "abs"]), inner)
        quotients = inner.map(lambda a: E.div(a, divisor))
        roots = inner.map(lambda a: E.call("sqrt", E.call("abs", a)))
        squares = inner.map(lambda a: E.mul(a, a))
        plain = two.map(lambda t: _built(*t)) | one.map(lambda t: _built(*t)) | quotients | squares
        return plain | roots if rounded else plain

    return st.recursive(leaves, grown, max_leaves=most)


def _built(op: str, *args: Expr) -> Expr:
    return rebuild(E.raw(op, args), args)


anything = formulas(st.sampled_from([x, y, E.const(0.5), E.const(-1.5)]), y)
