"""Nodes in the order in which they are made, however many follow one from another."""

from __future__ import annotations

from collections.abc import Iterable

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.expr import Expr
from artipg_dsl.graph.interval import Intervals
from artipg_dsl.graph.order import bottom_up


def below(node: Expr) -> Iterable[Expr]:
    return node.args


def test_what_a_node_is_made_of_comes_before_it_and_once() -> None:
    a, b = E.var("a"), E.var("b")
    both = E.add(a, b)
    root = E.mul(both, E.sub(both, a))
    order = list(bottom_up(root, below, ()))
    assert len(order) == len(set(order)) == 5 and order[-1] is root
    assert all(order.index(arg) < order.index(node) for node in order for arg in node.args)


def test_what_is_known_is_left_out_with_what_is_below_it() -> None:
    a, b = E.var("a"), E.var("b")
    inner = E.add(a, b)
    root = E.neg(inner)
    assert list(bottom_up(root, below, {inner})) == [root]


def test_a_circle_is_broken() -> None:
    a, b = E.var("a"), E.var("b")
    assert list(bottom_up(a, lambda node: (b if node is a else a,), ())) == [b, a]


def test_an_interval_of_ten_thousand_terms() -> None:
    total = E.call("sin", E.var("a"))
    for k in range(10_000):
        total = E.call("sin", E.add(total, E.const(float(k))))
    assert Intervals((), {}).of(total) == (-1.0, 1.0)
