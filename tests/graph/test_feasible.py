"""Ranges that can never be met: what is reported is so by trying everything, and what values alone decide is found."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import TRUE, Column, Expr, Scope
from artipg_dsl.graph.feasible import find_conflicts, find_idle, find_ranges, is_certain
from artipg_dsl.graph.inequality import Ends, bounds_of
from artipg_dsl.graph.interval import Intervals
from artipg_dsl.graph.program import Bound, Draw, Program, Requirement, Union

from .brute import evaluate, formulas, numbers

EXAMPLES = 100
ROOT = Scope("root")
COLUMNS = [Column(ROOT, name, "count") for name in "abc"]
a, b, c = map(E.col, COLUMNS)
Inequality = tuple[Expr, Expr, Expr]  # low, high, where it is required
Domains = Sequence[tuple[int, int]]

domains = st.lists(
    st.tuples(st.integers(-2, 2), st.integers(0, 3)).map(lambda t: (t[0], t[0] + t[1])), min_size=3, max_size=3
)
terms = formulas(st.sampled_from([a, b, c, E.const(1.0), E.const(-2.0)]), E.const(2.0), 4, rounded=False)
guards = st.just(TRUE) | st.tuples(terms, terms).map(lambda t: E.call("le", *t))
inequalities = st.lists(st.tuples(terms, terms, guards), min_size=1, max_size=4)


def program(spans: Domains, stated: Sequence[Inequality]) -> Program:
    """Whole numbers with some requirements, each of which bounds what it reads, as conditional ranges do."""
    made = Program("Thing", scopes=[ROOT])
    made.draws = [
        Draw(column, column.name, "count", E.const(float(low)), E.const(float(high)))
        for column, (low, high) in zip(COLUMNS, spans, strict=True)
    ]
    intervals = Intervals(made.draws, {})
    for number, (low, high, guard) in enumerate(stated):
        made.requirements.append(Requirement(ROOT, E.call("le", low, high), guard, "", None, slack=(low, high)))
        read = E.leaves(E.sub(low, high))
        for draw in (draw for draw in made.draws if draw.column in read):
            for half in bounds_of(low, high, guard, ROOT, Ends(draw.column, intervals, {})):
                draw.bounds.append(Bound(half.side, half.value, half.guard, number))
    return made


def valid(spans: Domains, stated: Sequence[Inequality]) -> Iterator[tuple[int, ...]]:
    """All values that keep the requirements, by trying each."""
    for values in itertools.product(*(range(low, high + 1) for low, high in spans)):
        known = dict(zip(COLUMNS, map(float, values), strict=True))
        required = [(low, high) for low, high, guard in stated if evaluate(guard, known)]
        if all(evaluate(low, known) <= evaluate(high, known) + 1e-9 for low, high in required):
            yield values


@pytest.mark.slow
@settings(max_examples=EXAMPLES, deadline=None)
@given(domains, inequalities)
def test_a_conflict_is_one_by_trying_everything(spans: Domains, stated: list[Inequality]) -> None:
    for conflict in find_conflicts(program(spans, stated)):
        assert conflict.certain
        told = [stated[k] for k in conflict.reasons]
        assert told and not list(valid(spans, told)), "what is named is enough to rule everything out"


@settings(max_examples=EXAMPLES, deadline=None)
@given(domains, inequalities)
def test_ranges_hold_every_valid_value(spans: Domains, stated: list[Inequality]) -> None:
    made = program(spans, stated)
    if not find_conflicts(made):
        narrowed = find_ranges(made)
        for values in valid(spans, stated):
            for k, (low, high) in narrowed.items():
                assert low - 1e-9 <= values[k] <= high + 1e-9


@settings(max_examples=EXAMPLES, deadline=None)
@given(domains, inequalities, st.integers(0, 2), st.integers(-3, 6))
def test_values_that_are_given(spans: Domains, stated: list[Inequality], which: int, value: int) -> None:
    low, high = spans[which]
    value = min(max(value, low), high)
    if find_conflicts(program(spans, stated), {which: float(value)}):
        assert not any(values[which] == value for values in valid(spans, stated))


@settings(max_examples=EXAMPLES, deadline=None)
@given(domains, inequalities)
def test_what_is_idle_always_holds(spans: Domains, stated: list[Inequality]) -> None:
    everything = len(list(valid(spans, [])))
    for number in find_idle(program(spans, stated)):
        assert len(list(valid(spans, [stated[number]]))) == everything


def test_a_requirement_between_constants_is_not_idle() -> None:
    made = program([(0, 1)] * 3, [(E.ONE, E.const(2.0), TRUE), (a, E.const(5.0), TRUE), (a, E.ZERO, TRUE)])
    assert find_idle(made) == [1]


# ---------------------------------------------------------------- one value

pairs = st.tuples(st.sampled_from(["low", "high"]), numbers)


def alone(
    low: float, high: float, bounds: Sequence[tuple[str, float]], regions: Sequence[Sequence[tuple[float, float]]] = ()
) -> Program:
    """One value with bounds and unions that are numbers."""
    made = Program("Thing", scopes=[ROOT])
    column = Column(ROOT, "v")
    draw = Draw(column, "v", "real", E.const(low), E.const(high))
    made.draws = [draw]
    for number, (side, value) in enumerate(bounds):
        ends = (E.col(column), E.const(value))[:: 1 if side == "high" else -1]
        made.requirements.append(Requirement(ROOT, E.call("le", *ends), TRUE, "", None, slack=ends))
        draw.bounds.append(Bound(side, E.const(value), TRUE, number))
    for region in regions:
        within = [
            E.both(E.call("le", E.const(p), E.col(column)), E.call("le", E.col(column), E.const(q))) for p, q in region
        ]
        condition = E.FALSE
        for one in within:
            condition = E.either(condition, one)
        draw.unions.append(Union(tuple((E.const(p), E.const(q)) for p, q in region), TRUE, len(made.requirements)))
        made.requirements.append(Requirement(ROOT, condition, TRUE, "", None))
    return made


@given(st.lists(pairs, max_size=5))
def test_bounds_of_one_value_conflict_where_they_leave_nothing(bounds: list[tuple[str, float]]) -> None:
    low = max([-3.0, *(value for side, value in bounds if side == "low")])
    high = min([3.0, *(value for side, value in bounds if side == "high")])
    made = alone(-3.0, 3.0, bounds)
    found = find_conflicts(made)
    assert bool(found) == (low > high)
    if found:
        assert (found[0].draw, found[0].low, found[0].high) == (0, low, high)
    else:
        assert find_ranges(made).get(0, (-3.0, 3.0)) == (low, high)


spans = st.tuples(numbers, numbers).map(lambda t: (min(t), max(t)))


@given(st.lists(pairs, max_size=2), st.lists(spans, min_size=1, max_size=3))
def test_a_union_narrows_to_the_hull_of_what_it_leaves(
    bounds: list[tuple[str, float]], region: list[tuple[float, float]]
) -> None:
    low = max([-3.0, *(value for side, value in bounds if side == "low")])
    high = min([3.0, *(value for side, value in bounds if side == "high")])
    left = [(max(p, low), min(q, high)) for p, q in region if max(p, low) <= min(q, high)]
    made = alone(-3.0, 3.0, bounds, [region])
    found = find_conflicts(made)
    assert bool(found) == (not left)
    for conflict in found:
        named = [bounds[k] for k in conflict.reasons if k < len(bounds)]
        again = find_conflicts(alone(-3.0, 3.0, named, [region] if len(bounds) in conflict.reasons else []))
        assert again, "what is named is enough to rule everything out"
    if left:
        hull = min(p for p, _ in left), max(q for _, q in left)
        assert find_ranges(made).get(0, (-3.0, 3.0)) == hull


# ---------------------------------------------------------------- tables


def row(count: Expr, kind: str) -> Scope:
    return Scope("row", ROOT, kind, count)


@pytest.mark.parametrize(
    "scope, known",
    [
        (ROOT, True),
        (row(E.const(3.0), "repeat"), True),
        (row(a, "repeat"), True),
        (row(b, "repeat"), False),
        (row(E.call("lt", E.ZERO, a), "guard"), True),
        (row(E.call("lt", E.ZERO, b), "guard"), False),
    ],
    ids=["root", "constant", "from-1", "from-0", "holds", "may-hold"],
)
def test_what_every_object_has(scope: Scope, known: bool) -> None:
    made = program([(1, 2), (0, 2), (0, 0)], [])
    assert is_certain(scope, Intervals(made.draws, {})) == known


@pytest.mark.parametrize("least, sure", [(0, False), (1, True)])
def test_a_conflict_in_a_table_is_certain_where_the_table_has_rows(least: int, sure: bool) -> None:
    made = program([(least, 2), (0, 2), (0, 0)], [])
    child = row(a, "repeat")
    column = Column(child, "v")
    made.scopes.append(child)
    made.draws.append(Draw(column, "v", "real", E.const(1.0), E.const(2.0), bounds=[Bound("high", E.ZERO, TRUE, 0)]))
    made.requirements.append(Requirement(child, E.call("le", E.col(column), E.ZERO), TRUE, "", None))
    (conflict,) = find_conflicts(made)
    assert (conflict.draw, conflict.scope, conflict.certain) == (3, child, sure)


def test_a_bound_under_a_guard_that_may_not_hold_rules_nothing_out() -> None:
    made = program([(0, 1), (1, 2), (0, 0)], [])
    made.draws[1].bounds.append(Bound("high", E.ZERO, E.call("le", E.ONE, a), 0))
    made.requirements.append(Requirement(ROOT, E.call("le", b, E.ZERO), E.call("le", E.ONE, a), "", None))
    assert find_conflicts(made) == [] and find_ranges(made) == {}
    (found,) = find_conflicts(made, {0: 1.0})
    assert found.draw == 1 and (found.low, found.high) == (1.0, 0.0)
