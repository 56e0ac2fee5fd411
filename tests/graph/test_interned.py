"""Equal expressions are one object, and those that nobody holds are let go."""

import signal
import time

import pytest

from artipg_dsl.graph import expr
from artipg_dsl.graph.expr import call, const, var
from artipg_dsl.graph.interned import Interned


class _Node:
    def __init__(self, *args):
        self.args = args


@pytest.mark.slow
def test_an_interrupt_while_expressions_are_let_go_is_heard():
    """What is raised in a callback of a weak reference is lost."""
    made = [var("x") + const(float(k)) for k in range(60_000)]
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            signal.setitimer(signal.ITIMER_REAL, 0.002)
            made.clear()
            time.sleep(1.0)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_what_nobody_holds_takes_no_room():
    """A chain is let go as a whole: the key of each node holds the one before it."""
    table = Interned()
    kept = [_Node() for _ in range(100)]
    for k, node in enumerate(kept):
        table.keep(k, node)
    for number in range(10):
        last = None
        for k in range(5_000):
            last = _Node(last)
            table.keep((number, k, last.args), last)
    assert len(table._held) <= 15_100
    assert all(table.find(k) is node for k, node in enumerate(kept))


def test_equal_expressions_are_one_also_after_others_went():
    held = var("x") * var("y")
    for k in range(30_000):
        call("sin", var("x") + const(float(k)))
    assert var("x") * var("y") is held
    again = call("cos", held)
    assert call("cos", held) is again
    assert len(expr._interned._held) <= expr._interned._most
