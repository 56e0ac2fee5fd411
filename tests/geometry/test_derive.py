"""Derivatives against central differences, over every operation that has one."""

import numpy as np
import pytest

from artipg_dsl.graph.derive import RULES, derive
from artipg_dsl.graph.expr import ONE, ZERO, Column, Scope, call, col, const, reduce, var
from artipg_dsl.graph.formula import evaluate
from artipg_dsl.graph.functions import FUNCTIONS, PREDICATES

X, Y = var("x"), var("y")


def _argument(op, index):
    """A smooth argument that stays in the domain of every operation: between 0.1 and 0.9."""
    return const(0.5) + const(0.35) * call("sin", X * (1.0 + index) + Y + 0.3 * index)


@pytest.mark.parametrize("op", sorted(set(FUNCTIONS) - PREDICATES - {"floor", "ceil", "sign"}))
def test_derivative_agrees_with_differences(op):
    arguments = [_argument(op, i) for i in range(FUNCTIONS[op][0])]
    if op == "where":
        arguments[0] = call("lt", X, Y)
    if op == "mod":
        arguments[0] = arguments[0] * 7.0
    root = call(op, *arguments)
    x, y = np.random.default_rng(3).uniform(-2, 2, (2, 400))
    step = 1e-6
    low, high = (evaluate([root], {"x": x + s, "y": y})[0] for s in (-step, step))
    slope = (high - low) / (2 * step)
    exact = evaluate([derive(root, "x")], {"x": x, "y": y})[0]
    smooth = np.abs(high - low) < 1e-3  # no jump of mod or where between the two
    assert smooth.mean() > 0.95
    assert np.allclose(exact[smooth], slope[smooth], rtol=1e-5, atol=1e-6)


def test_steps_and_predicates_are_flat_and_other_variables_constant():
    assert set(RULES) == set(FUNCTIONS) - PREDICATES
    for op in ("floor", "ceil", "sign"):
        assert derive(call(op, X), "x") is ZERO
    assert derive(call("lt", X, Y), "x") is ZERO
    assert derive(Y * 3.0, "x") is ZERO
    assert derive(X * 3.0 + Y, X) is const(3.0)


def test_a_column_is_a_variable_too_but_not_through_another_table():
    root = Scope("a")
    child = Scope("b", root, "repeat", const(2.0))
    width = col(Column(root, "width"))
    assert derive(width + 2.0, width) is ONE
    row = col(Column(child, "row"))
    with pytest.raises(ValueError, match="through another table"):
        derive(reduce("sum", child, row), row)
