"""What a condition says of one value as a union of intervals: never less than can hold, and no more where it can be solved."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import Expr
from artipg_dsl.graph.inequality import Ends
from artipg_dsl.graph.interval import Intervals
from artipg_dsl.graph.substitution import rebuild
from artipg_dsl.graph.union import BESIDE, EVERYTHING, LEAST, MOST, MOST_OF_ALL, Region, intersect_regions, region_of

from .brute import DRAWS, X, Y, above_zero, anything, evaluate, numbers, within, x, y

HAIR = 1e-9
AROUND = (-1e-6, 0.0, 1e-6)
EXAMPLES = 150
ends = st.lists(st.sampled_from([LEAST, MOST_OF_ALL]) | numbers.map(E.const), min_size=2, max_size=2).map(tuple)
regions = st.lists(ends, max_size=4).map(tuple)


def of(condition: Expr, discrete: bool = False) -> Region | None:
    return region_of(condition, Ends(X, Intervals(DRAWS, {}), {}), discrete=discrete)


def contains(region: Region, at: float, other: float, slack: float = 0.0) -> bool:
    """Whether a value lies in one of the intervals, whose ends are formulas of another value."""
    low_high = [[float(evaluate(end, {Y: other})) for end in pair] for pair in region]
    return any(low - slack <= at <= high + slack for low, high in low_high)


@given(regions, regions, numbers)
def test_two_unions_contain_together_what_each_contains(first: Region, second: Region, at: float) -> None:
    assert contains(intersect_regions(first, second), at, 1.0) == (
        contains(first, at, 1.0) and contains(second, at, 1.0)
    )
    assert contains((*first, *second), at, 1.0) == (contains(first, at, 1.0) or contains(second, at, 1.0))


@given(regions, numbers)
def test_everything_leaves_a_union_as_it_is(region: Region, at: float) -> None:
    assert intersect_regions(region, EVERYTHING) == region == intersect_regions(EVERYTHING, region)
    assert contains(EVERYTHING, at, 1.0)


def together(atoms: st.SearchStrategy[Expr], most: int = 3) -> st.SearchStrategy[Expr]:
    """Conditions joined by `and`, `or` and `not`."""

    def grown(inner: st.SearchStrategy[Expr]) -> st.SearchStrategy[Expr]:
        return (
            st.tuples(inner, inner).map(lambda t: E.both(*t))
            | st.tuples(inner, inner).map(lambda t: E.either(*t))
            | inner.map(E.negate)
        )

    return st.recursive(atoms, grown, max_leaves=most)


comparisons = st.tuples(st.sampled_from(["le", "lt"]), anything, anything).map(lambda t: E.call(*t))


@settings(max_examples=EXAMPLES, deadline=None)
@given(together(comparisons), within(X), within(Y))
def test_no_value_with_which_a_condition_holds_is_left_out(condition: Expr, a: float, b: float) -> None:
    region = of(condition)
    if region is not None and evaluate(condition, {X: a, Y: b}):
        assert contains(region, a, b, HAIR)


OTHER = E.add(y, E.const(0.25))  # never the same as what stands on the right: ends belong to both sides


def nested(inner: Expr, steps: list[str]) -> Expr:
    """Operations over one another, in which the value stands once."""
    for step in steps:
        if step == "square":
            inner = E.mul(inner, inner)
        elif step in ("abs", "neg"):
            inner = rebuild(E.raw(step, (inner,)), (inner,))
        else:
            other = OTHER if step in ("min", "max") else y
            inner = rebuild(E.raw(step, (inner, other)), (inner, other))
    return inner


linear = st.tuples(above_zero, st.booleans(), numbers).map(
    lambda t: E.add(E.mul(E.const(-t[0] if t[1] else t[0]), x), E.const(t[2]))
)
plain = st.lists(st.sampled_from(["neg", "sub", "mul", "div"]), max_size=2)
folds = st.lists(st.sampled_from(["abs", "square", "hypot"]), max_size=1)  # each doubles the intervals
extremes = st.lists(st.sampled_from(["min", "max"]), max_size=1)
steps = st.tuples(plain, folds, extremes, plain).map(lambda t: sum(t, [])).flatmap(st.permutations)
right = st.tuples(numbers, numbers).map(lambda t: E.add(E.mul(E.const(t[0]), y), E.const(t[1])))
once = st.tuples(linear, steps, right, st.booleans()).map(
    lambda t: E.call("le", nested(t[0], t[1]), t[2]) if t[3] else E.call("le", t[2], nested(t[0], t[1]))
)


@pytest.mark.slow
@settings(max_examples=EXAMPLES, deadline=None)
@given(together(once, 2), within(X), within(Y))
def test_of_a_value_that_stands_once_exactly_what_holds_is_said(condition: Expr, a: float, b: float) -> None:
    region = of(condition)
    assume(region is not None)
    holds = [evaluate(condition, {X: a + d, Y: b + e}) for d in AROUND for e in AROUND]
    assume(all(holds) or not any(holds))  # ends belong to both sides
    assert all(contains(region, a + d, b) for d in AROUND) == all(holds)


@given(once)
def test_one_comparison_of_a_value_that_stands_once_is_solved(condition: Expr) -> None:
    assert of(condition) is not None


@given(numbers, st.sampled_from([1.0, 2.0]))
def test_what_does_not_read_the_value_says_all_or_nothing(at: float, other: float) -> None:
    region = of(E.call("lt", y, E.const(1.5)))
    assert region is not None and contains(region, at, other) == (other < 1.5)


@given(numbers, above_zero)
def test_a_single_value_and_all_but_one(at: float, other: float) -> None:
    equal = E.call("eq", E.mul(E.const(2.0), x), y)
    assert contains(of(equal), at, other) == (2.0 * at == other)
    beside = of(E.negate(equal), discrete=True)
    assert contains(beside, at, other) == (2.0 * at != other)
    assert not contains(beside, other / 2 + BESIDE / 2, other)


@pytest.mark.parametrize(
    "condition",
    [
        E.call("le", E.mul(x, E.sub(y, E.const(1.0))), E.const(1.0)),  # of either sign
        E.call("le", E.add(x, E.call("abs", x)), y),  # stands twice
        E.negate(E.call("eq", x, y)),  # a gap of no width
        E.either(E.call("le", x, y), E.call("le", E.call("sin", x), y)),  # one of two is not solved
    ],
    ids=["sign", "twice", "continuous", "or"],
)
def test_nothing_is_said_of_what_cannot_be_solved(condition: Expr) -> None:
    assert of(condition) is None


def test_of_two_conditions_the_one_that_is_solved_counts() -> None:
    solved = E.call("le", x, y)
    assert of(E.both(solved, E.call("le", E.call("sin", x), y))) == of(solved)


def test_too_many_intervals_say_nothing() -> None:
    apart = [E.call("le", E.const(1.0), E.call("abs", E.sub(x, E.const(float(k))))) for k in range(4)]
    some, many = E.both(apart[0], E.both(apart[1], apart[2])), E.both(*(E.both(*p) for p in (apart[:2], apart[2:])))
    assert len(of(some)) == MOST and of(many) is None
    assert np.isfinite(MOST)
