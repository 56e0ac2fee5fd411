"""What an inequality says of one value: bounds that no valid value breaks, and that say all where the value stands once."""

import math

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import TRUE, Column, Expr, Scope
from artipg_dsl.graph.inequality import Ends, Half, bounds_of, least_of
from artipg_dsl.graph.interval import Intervals
from artipg_dsl.graph.program import Draw
from artipg_dsl.graph.substitution import rebuild, substitute

from .brute import DRAWS, LEAST, MOST, ROOT, X, Y, above_zero, anything, evaluate, numbers, within, x, y

EXAMPLES = 150
HAIR = 1e-7
EVERY = np.linspace(LEAST[X], MOST[X], 1001)
INTERVALS = Intervals(DRAWS, {})


def of(low: Expr, high: Expr, guard: Expr = TRUE) -> list[Half]:
    read = X in E.leaves(E.sub(low, high))
    return bounds_of(low, high, guard, ROOT, Ends(X, INTERVALS, {})) if read else []


def clearly(low: Expr, high: Expr) -> Expr:
    """That an inequality holds, however its sides are rounded: where they are one number, rounding may tell either way."""
    return E.call("le", E.add(low, E.mul(E.const(1e-12), E.add(E.ONE, E.call("abs", low)))), high)


def kept(halves: list[Half], a: float, b: float, slack: float) -> bool:
    """Whether a value keeps the bounds of which the guard holds."""
    known = {Y: b}
    bounds = [(half.side, float(evaluate(half.value, known))) for half in halves if evaluate(half.guard, known)]
    room = [slack * (1.0 + abs(bound)) for _, bound in bounds]
    return all(
        a >= bound - more if side == "low" else a <= bound + more
        for (side, bound), more in zip(bounds, room, strict=True)
    )


@settings(max_examples=EXAMPLES, deadline=None)
@given(anything, anything, within(X), within(Y))
def test_no_value_with_which_an_inequality_holds_is_excluded(low: Expr, high: Expr, a: float, b: float) -> None:
    assume(evaluate(clearly(low, high), {X: a, Y: b}))
    assert kept(of(low, high), a, b, HAIR)


@settings(max_examples=EXAMPLES, deadline=None)
@given(anything, anything, anything, within(X), within(Y))
def test_nor_where_a_guard_holds(low: Expr, high: Expr, given: Expr, a: float, b: float) -> None:
    guard = E.call("le", substitute(given, {x: E.const(1.0)}), y)
    holds = evaluate(guard, {Y: b})
    assume(not holds or evaluate(clearly(low, high), {X: a, Y: b}))
    assert kept(of(low, high, guard), a, b, HAIR)


def over(inner: Expr, step: str) -> Expr:
    """One operation more over what stands below; it grows with it, as far as that is above 0."""
    if step == "abs":
        return E.call("abs", inner)
    if step == "square":
        return E.mul(inner, inner)
    if step == "root":
        return E.call("sqrt", E.maximum(inner, E.ZERO))
    return rebuild(E.raw(step, (inner, y)), (inner, y))


factors = st.tuples(above_zero, st.sampled_from([1.0, -1.0])).map(lambda t: E.const(t[0] * t[1]))
mixed = numbers.map(lambda k: E.sub(y, E.const(k + 1 / 32)))  # of either sign, never 0
linear = st.tuples(factors | mixed, numbers).map(lambda t: E.add(E.mul(t[0], x), E.const(t[1])))
steps = st.lists(st.sampled_from(["abs", "square", "hypot", "max", "mul", "div", "add"]), max_size=3)
positive = st.tuples(above_zero, above_zero).map(lambda t: E.add(E.mul(E.const(t[0]), y), E.const(t[1] / 4)))


@settings(max_examples=EXAMPLES, deadline=None)
@given(linear, steps, positive, within(X), within(Y))
def test_of_a_value_that_stands_once_the_bounds_say_all(inner, steps, high, a, b) -> None:
    low = inner
    for step in steps:
        low = over(low, step)
    holds = [evaluate(E.call("le", low, high), {X: a + d, Y: b}) for d in (-1e-6, 0.0, 1e-6)]
    assume(all(holds) or not any(holds))
    assume(evaluate(E.call("le", low, high), {X: EVERY, Y: b}).any())  # else it is for another value to give way
    assert kept(of(low, high), a, b, 0.0) == all(holds)


@settings(max_examples=EXAMPLES, deadline=None)
@given(anything, within(X), within(Y))
def test_the_least_is_never_above_a_value(node: Expr, a: float, b: float) -> None:
    least = least_of(node, Ends(X, INTERVALS, {}))
    value = float(evaluate(node, {X: a, Y: b}))
    assert least is None or evaluate(least, {Y: b}) <= value + HAIR * (1.0 + abs(value))


@given(linear, within(Y))
def test_the_least_of_a_linear_form_is_that_at_an_end(node: Expr, b: float) -> None:
    least = least_of(node, Ends(X, INTERVALS, {}))
    at_ends = [evaluate(node, {X: end, Y: b}) for end in (LEAST[X], MOST[X])]
    assert least is not None and math.isclose(evaluate(least, {Y: b}), min(at_ends), abs_tol=1e-12)


def test_a_guard_that_reads_the_value_leaves_it_alone() -> None:
    assert of(x, y, E.call("lt", x, E.const(1.0))) == []


def test_a_definition_is_read_through() -> None:
    double = Column(ROOT, "double")
    (half,) = bounds_of(E.col(double), y, TRUE, ROOT, Ends(X, INTERVALS, {double: E.mul(x, E.const(2.0))}))
    assert half.side == "high" and evaluate(half.value, {Y: 3.0}) == 1.5


# ---------------------------------------------------------------- tables

CHILD = Scope("row", ROOT, "repeat", E.const(3.0))
Z = Column(CHILD, "z")
z = E.col(Z)
TABLES = Intervals([*DRAWS, Draw(Z, "z", "real", E.const(-1.0), E.const(2.0))], {})
rows = st.lists(st.integers(-16, 32).map(lambda k: k / 16), min_size=3, max_size=3).map(np.array)


@given(rows, within(Y))
def test_the_greatest_of_some_rows_binds_each(values: np.ndarray, b: float) -> None:
    (half,) = bounds_of(E.reduce("max", CHILD, z), y, TRUE, ROOT, Ends(Z, TABLES, {}))
    bound = evaluate(half.value, {Y: b})
    assert half.scope is CHILD and (values <= bound).all() == (values.max() <= b)


@given(rows, within(Y))
def test_a_sum_binds_each_row_beside_the_least_of_the_others(values: np.ndarray, b: float) -> None:
    (half,) = bounds_of(E.reduce("sum", CHILD, z), y, TRUE, ROOT, Ends(Z, TABLES, {}))
    bound = evaluate(half.value, {Y: b}, rows=3)
    assert half.scope is CHILD and bound == b + 2.0
    if values.sum() <= b:
        assert (values <= bound).all()


@given(within(X), within(Y))
def test_a_sum_binds_what_its_rows_share(a: float, b: float) -> None:
    halves = bounds_of(E.reduce("sum", CHILD, E.add(x, E.const(0.5))), y, TRUE, ROOT, Ends(X, TABLES, {}))
    (half,) = [half for half in halves if evaluate(half.guard, {Y: b}, rows=3)]
    assert half.scope is ROOT and half.side == "high"
    assert (a <= evaluate(half.value, {Y: b}, rows=3)) == (a <= (b - 1.5) / 3.0)
