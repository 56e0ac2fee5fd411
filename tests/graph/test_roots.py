"""Of the places on a curve where a formula takes a value, the first is found, and none where there is none."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import Expr
from artipg_dsl.graph.formula import evaluate
from artipg_dsl.graph.roots import lowest_root

V, S = E.var("v"), E.var("s")
TURN = 2 * math.pi
LEVELS = np.linspace(-1.15, 1.15, 47)


def sine(argument: Expr) -> Expr:
    return E.call("sin", argument)


def cosine(argument: Expr) -> Expr:
    return E.call("cos", argument)


@pytest.mark.parametrize("grows", [False, True], ids=["constant", "depends on a value"])
@pytest.mark.parametrize(
    ("formula", "low", "high"),
    [
        (sine, -TURN / 4, TURN / 4),
        (sine, TURN / 4, TURN * 3 / 4),
        (sine, 0.0, TURN / 2),
        (sine, TURN * 0.4, TURN * 1.6),
        (sine, -3.3, 2.2),
        (lambda v: sine(0.4 - 1.7 * v), 0.0, 4.0),
        (lambda v: 0.5 * sine(v) + 0.5, 0.3, 5.0),
        (cosine, 0.0, TURN / 2),
        (cosine, -TURN / 4, TURN / 4),
        (cosine, -2.0, 9.0),
        (lambda v: E.div(E.call("tan", v), E.const(20.0)), 2.0, 4.0),
        (lambda v: E.mul(v, v), -1.0, 1.0),
        (lambda v: E.mul(v - 0.3, v - 0.3), 0.0, 1.0),
        (lambda v: E.power(v, E.const(4.0)), -1.1, 0.9),
        (lambda v: E.call("abs", v), -1.0, 0.5),
        (lambda v: E.call("hypot", v, E.const(0.2)), -1.0, 0.5),
        (lambda v: E.call("abs", sine(v)), 0.1, 3.5),
        (lambda v: sine(v) + 0.1 * S, 1.0, 4.0),
    ],
)
def test_the_lowest_root(formula: Callable[[Expr], Expr], low: float, high: float, grows: bool) -> None:
    ends = (E.const(low), E.const(high))
    if grows:  # from 1.0
        ends = (E.mul(S, ends[0]), E.mul(S, ends[1]))
    node = formula(V)
    root = lowest_root(node, "v", ends, E.var("level"))
    assert root is not None
    (found,) = evaluate([root], {"level": LEVELS, "s": np.ones(len(LEVELS))})
    fine = np.linspace(low, high, 20_001)
    (values,) = evaluate([node], {"v": fine, "s": np.ones(len(fine))})
    (there,) = evaluate([node], {"v": found, "s": np.ones(len(found))})
    for level, v, value in zip(LEVELS, found.tolist(), there.tolist(), strict=True):
        over = values - level
        met = np.flatnonzero((over[1:] * over[:-1] <= 0) & (np.abs(over[1:] - over[:-1]) < 0.1))  # no pole
        if len(met):
            assert fine[met[0]] - 1e-6 <= v <= fine[met[0] + 1] + 1e-6, (level, v)
        else:
            assert not low <= v <= high or abs(value - level) < 1e-9, (level, v)  # where it turns back


def test_a_quarter_turn_needs_no_choice() -> None:
    quarter = lowest_root(sine(V), "v", (E.ZERO, E.const(TURN / 4)), S)
    assert quarter is E.call("asin", S)
    assert lowest_root(sine(V) + V, "v", (E.ZERO, E.ONE), S) is None
