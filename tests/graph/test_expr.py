"""Expressions: interning, folding, scopes."""

import math

import pytest

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import Column, Scope
from artipg_dsl.graph.program import Program
from artipg_dsl.graph.substitution import substitute
from artipg_dsl.graph.writing import to_text

ROOT = Scope("root")
CHILD = Scope("child", ROOT, "repeat", E.const(3))
OTHER = Scope("other", ROOT, "repeat", E.const(2))
A, B = E.col(Column(ROOT, "a")), E.col(Column(ROOT, "b"))
C, D = E.col(Column(CHILD, "c")), E.col(Column(OTHER, "d"))


def test_equal_expressions_are_one_object():
    assert A + B is A + B
    assert E.call("sin", A * 2) is E.call("sin", A * 2)


@pytest.mark.parametrize(
    "built, expected",
    [
        (A + 0, A),
        (A - 0, A),
        (0 + A, A),
        (A * 1, A),
        (A * 0, E.ZERO),
        (A - A, E.ZERO),
        (-(-A), A),  # noqa: B002
        (A + (-B), A - B),
        (E.const(2) + E.const(3), E.const(5)),
        (E.both(E.TRUE, A), A),
        (E.either(E.TRUE, A), E.TRUE),
        (E.where(E.TRUE, A, B), A),
        (E.where(E.call("lt", A, B), A, A), A),
        (E.negate(E.negate(A)), A),
        (E.call("max", E.const(1), E.const(4)), E.const(4)),
    ],
)
def test_folding(built, expected):
    assert built is expected


def test_the_scope_of_an_operation_is_the_deepest():
    assert (A + C).scope is CHILD
    assert (A + B).scope is ROOT
    assert E.reduce("sum", CHILD, C).scope is ROOT
    assert E.element(CHILD, C, A).scope is ROOT


def test_values_of_unrelated_tables_do_not_mix():
    with pytest.raises(E.ScopeError):
        _ = C + D


def test_leaves_and_substitution():
    value = E.call("sin", A) * B + A
    assert {c.name for c in E.leaves(value)} == {"a", "b"}
    assert substitute(value, {A: E.ZERO}) is E.ZERO
    assert substitute(value, {B: E.ONE}) is E.call("sin", A) + A


def test_what_is_shared_a_thousandfold_is_shown_and_written_at_once():
    value = x = E.var("x")
    for _ in range(80):
        value = E.mul(value, E.add(value, x))
    assert E.show(value).count("...") and len(E.show(value, 100)) < 1000
    program = Program("many")
    program.scopes.append(E.Scope("many"))
    column = E.Column(program.scopes[0], "far")
    program.definitions[column] = value
    assert len(to_text(program)) < 10_000


@pytest.mark.parametrize(
    ("operation", "values"),
    [
        ("div", (1, 0)),
        ("mod", (1, 0)),
        ("pow", (-2, 0.5)),
        ("pow", (0, -1)),
        ("log", (-1,)),
        ("log", (0,)),
        ("sqrt", (-1,)),
        ("asin", (2,)),
        ("floor", (math.nan,)),
        ("sin", (math.inf,)),
    ],
)
def test_what_has_no_value_is_nan(operation, values):
    folded = E.call(operation, *map(E.const, values))
    assert folded.op == "const" and math.isnan(folded.value)
    assert folded is E.const(math.nan)  # one node, as for any constant


def test_what_is_too_large_is_infinite():
    assert E.call("exp", E.const(1e4)).value == math.inf == E.call("pow", E.const(10), E.const(400)).value
    assert E.call("floor", E.const(-math.inf)).value == -math.inf


def test_least_and_largest_of_nan_are_nan():
    for name in ("min", "max"):
        assert all(math.isnan(E.call(name, *map(E.const, pair)).value) for pair in ((1, math.nan), (math.nan, 1)))
