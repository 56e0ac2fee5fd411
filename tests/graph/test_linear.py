"""Linear forms, isolation, small systems."""

import pytest

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import Column, Scope
from artipg_dsl.graph.formula import evaluate
from artipg_dsl.graph.linear import Linear, isolate, solve_block, tidy
from artipg_dsl.graph.substitution import substitute

ROOT = Scope("root")
COLUMNS = {name: Column(ROOT, name) for name in "xyzab"}
X, Y, Z, A, B = (E.col(COLUMNS[n]) for n in "xyzab")


def linear(*names, definitions=None):
    wanted = {COLUMNS[n] for n in names}
    return Linear(lambda c: c in wanted, definitions or {})


def value(expr, **values):
    mapping = {E.col(COLUMNS[k]): E.const(v) for k, v in values.items()}
    return substitute(expr, mapping).constant


def test_coefficients_of_a_linear_form():
    coefficients, rest = linear("x", "y").form(3 * X - Y * A + B - X)
    assert value(coefficients[COLUMNS["x"]]) == 2
    assert value(coefficients[COLUMNS["y"]], a=5.0) == -5
    assert value(rest, b=7.0) == 7


def test_what_cancels_is_gone_even_inside_what_is_not_linear():
    odd = E.call("max", X, Y)
    assert linear("x", "y").form(odd + X - odd) == ({COLUMNS["x"]: E.ONE}, E.ZERO)
    assert linear("x", "y").form(odd) is None


def test_definitions_are_read_through():
    form = linear("x", definitions={COLUMNS["y"]: 2 * X + A}).form(Y + X)
    assert value(form[0][COLUMNS["x"]]) == 3


@pytest.mark.parametrize(
    "node, target, x",
    [
        (E.call("sqrt", X + 1), 3.0, 8.0),
        (2 / (X + 1), 0.5, 3.0),
        (E.call("sin", X), 0.5, 0.5235987755982989),
        (E.call("hypot", X, E.const(3)), 5.0, 4.0),
        (X * X, 9.0, 3.0),
        (5 - X, 2.0, 3.0),
        (E.power(X, E.const(3)), 8.0, 2.0),
    ],
)
def test_isolation(node, target, x):
    found = isolate(node, COLUMNS["x"], E.const(target), linear("x"))
    assert found.constant == pytest.approx(x)


def test_isolation_gives_up_on_two_occurrences():
    assert isolate(E.call("sin", X) + X, COLUMNS["x"], E.ONE, linear("x")) is None


def test_a_coupled_system():
    forms = [linear("x", "y").form(X + Y - A), linear("x", "y").form(X - Y - B)]
    solution = solve_block(forms, [COLUMNS["x"], COLUMNS["y"]])
    assert value(solution[COLUMNS["x"]], a=10.0, b=4.0) == pytest.approx(7)
    assert value(solution[COLUMNS["y"]], a=10.0, b=4.0) == pytest.approx(3)


def test_a_singular_system_has_no_solution():
    forms = [linear("x", "y").form(X + Y - A), linear("x", "y").form(2 * X + 2 * Y - B)]
    assert solve_block(forms, [COLUMNS["x"], COLUMNS["y"]]) is None


def test_tidy_keeps_the_value():
    u, v = E.var("u"), E.var("v")
    expr = (u + v) * 0.5 + (v - u) * 0.5 - E.call("max", u, v) + E.call("max", u, v)
    got = evaluate([tidy(expr)], {"u": 3.0, "v": 8.0})[0]
    assert float(got) == 8.0
