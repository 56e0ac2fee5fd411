"""Intervals hold the values they are to hold."""

from hypothesis import given, settings
from hypothesis import strategies as st

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import Column, Scope
from artipg_dsl.graph.interval import Intervals
from artipg_dsl.graph.program import Draw
from artipg_dsl.graph.substitution import substitute

ROOT = Scope("root")
COLUMNS = [Column(ROOT, n) for n in "ab"]
DRAWS = [
    Draw(c, c.name, "real", E.const(low), E.const(high))
    for c, (low, high) in zip(COLUMNS, [(-2.0, 3.0), (0.5, 4.0)], strict=True)
]
A, B = (E.col(c) for c in COLUMNS)

LEAVES = st.sampled_from([A, B, E.const(0.5), E.const(-1.5)])


def grow(inner):
    binary = st.tuples(st.sampled_from(["add", "sub", "mul", "min", "max", "hypot"]), inner, inner).map(
        lambda t: E.call(*t)
    )
    unary = st.tuples(st.sampled_from(["neg", "abs", "sin", "cos"]), inner).map(lambda t: E.call(*t))
    return binary | unary


@settings(max_examples=200, deadline=None)
@given(st.recursive(LEAVES, grow, max_leaves=8), st.floats(0, 1), st.floats(0, 1))
def test_an_interval_contains_every_value(node, s, t):
    low, high = Intervals(DRAWS, {}).of(node)
    a, b = -2.0 + 5.0 * s, 0.5 + 3.5 * t
    value = substitute(node, {A: E.const(a), B: E.const(b)}).constant
    slack = 1e-9 * (1 + abs(value))
    assert low - slack <= value <= high + slack


def test_predicates():
    intervals = Intervals(DRAWS, {})
    assert intervals.of(E.call("le", E.const(-5.0), A)) == (1.0, 1.0)
    assert intervals.of(E.call("lt", B, E.const(0.2))) == (0.0, 0.0)
    assert intervals.of(E.call("le", A, B)) == (0.0, 1.0)
