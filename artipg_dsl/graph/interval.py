"""Intervals of expressions from the domains of drawn variables: what always holds, what never can."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from .expr import Column, Expr
from .functions import FUNCTIONS
from .order import bottom_up

if TYPE_CHECKING:
    from .program import Draw

Interval = tuple[float, float]
EVERYTHING: Interval = (-math.inf, math.inf)


def _mul(a: Interval, b: Interval) -> Interval:
    products = [0.0 if x == 0.0 or y == 0.0 else x * y for x in a for y in b]
    return min(products), max(products)


class Intervals:
    """Bounds of expressions; ``definitions`` are read through, draws are taken at their whole domain."""

    def __init__(self, draws: Iterable[Draw], definitions: Mapping[Column, Expr]):
        self.draws = {d.column: d for d in draws}
        self.definitions = definitions
        self.memo: dict[Expr, Interval] = {}

    def of(self, node: Expr) -> Interval:
        memo = self.memo
        found = memo.get(node)
        if found is None:
            known = all(
                [below in memo for below in self.inner(node)]
            )  # as most of the time: who asks goes from the bottom up
            for at in (node,) if known else bottom_up(node, self.inner, memo):
                memo[at] = EVERYTHING  # in a circle of definitions
                low, high = self._of(at)
                found = memo[at] = (-math.inf if low != low else low, math.inf if high != high else high)
            assert found is not None
        return found

    def inner(self, node: Expr) -> Iterable[Expr]:
        """What the interval of a node follows from."""
        if node.op != "col":
            return node.args
        if node.value in self.definitions:
            return (self.definitions[node.value],)
        draw = self.draws.get(node.value)
        return () if draw is None or draw.kind == "choice" else draw.ends

    def _of(self, node: Expr) -> Interval:
        op = node.op
        if op in FUNCTIONS:
            return self.function(op, node)
        if op == "const":
            return float(node.value), float(node.value)
        if op == "col":
            return self.column(node.value)
        if op == "rank":
            return 0.0, math.inf
        if op == "phi":
            ends = [self.of(a) for a in node.args[:-1]]
            return min(e[0] for e in ends), max(e[1] for e in ends)
        if op == "reduce":
            kind, child = node.value
            low, high = self.of(node.args[0])
            if kind in ("min", "max"):
                if child.count is None or self.of(child.count)[0] >= 1.0:
                    return low, high
                return (low, math.inf) if kind == "min" else (-math.inf, high)  # over no rows
            return (0.0 if low >= 0 else -math.inf), (0.0 if high <= 0 else math.inf)
        if op in ("element", "previous"):
            low, high = self.of(node.args[0])
            return (min(low, 0.0), max(high, 0.0)) if op == "previous" else (low, high)
        if op == "scan":
            low, high = self.of(node.args[0])
            return (0.0 if low >= 0 else -math.inf), (0.0 if high <= 0 else math.inf)
        return EVERYTHING

    def column(self, column: Column) -> Interval:
        if column in self.definitions:
            return self.of(self.definitions[column])
        draw = self.draws.get(column)
        if draw is None:
            return EVERYTHING
        if draw.kind == "choice":
            return 0.0, float(len(draw.options) - 1)
        low, high = draw.ends
        return self.of(low)[0], self.of(high)[1]

    def function(self, op: str, node: Expr) -> Interval:
        args = [self.of(a) for a in node.args]
        if op == "add":
            return args[0][0] + args[1][0], args[0][1] + args[1][1]
        if op == "sub":
            return args[0][0] - args[1][1], args[0][1] - args[1][0]
        if op == "neg":
            return -args[0][1], -args[0][0]
        if op == "mul":
            if node.args[0] is node.args[1]:
                low, high = args[0]
                best = max(abs(low), abs(high))
                return (0.0 if low <= 0 <= high else min(abs(low), abs(high)) ** 2), best * best
            return _mul(args[0], args[1])
        if op == "div":
            low, high = args[1]
            return EVERYTHING if low <= 0 <= high else _mul(args[0], (1 / high, 1 / low))
        if op == "abs":
            low, high = args[0]
            return (0.0 if low <= 0 <= high else min(abs(low), abs(high))), max(abs(low), abs(high))
        if op == "min":
            return min(args[0][0], args[1][0]), min(args[0][1], args[1][1])
        if op == "max":
            return max(args[0][0], args[1][0]), max(args[0][1], args[1][1])
        if op == "where":
            return min(args[1][0], args[2][0]), max(args[1][1], args[2][1])
        if op == "sqrt":
            return math.sqrt(max(args[0][0], 0.0)), math.sqrt(max(args[0][1], 0.0))
        if op == "hypot":
            ends = [(0.0 if a <= 0 <= b else min(abs(a), abs(b)), max(abs(a), abs(b))) for a, b in args]
            return math.hypot(ends[0][0], ends[1][0]), math.hypot(ends[0][1], ends[1][1])
        if op in ("sin", "cos"):
            return -1.0, 1.0
        if op in ("floor", "ceil"):
            return args[0][0] - 1.0, args[0][1] + 1.0
        if op == "le":
            return float(args[0][1] <= args[1][0]), float(args[0][0] <= args[1][1])
        if op == "lt":
            return float(args[0][1] < args[1][0]), float(args[0][0] < args[1][1])
        if op in ("and", "or", "not", "eq", "sign"):
            return self.logic(op, args)
        return EVERYTHING

    def logic(self, op: str, args: list[Interval]) -> Interval:
        if op == "and":
            return min(args[0][0], args[1][0]), min(args[0][1], args[1][1])
        if op == "or":
            return max(args[0][0], args[1][0]), max(args[0][1], args[1][1])
        if op == "not":
            return 1.0 - args[0][1], 1.0 - args[0][0]
        if op == "sign":
            return -1.0, 1.0
        apart = args[0][1] < args[1][0] or args[1][1] < args[0][0]
        return (0.0, 0.0) if apart else (0.0, 1.0)


def holds_always(condition: Expr, draws: Iterable[Draw]) -> bool:
    """Whether a predicate holds for all values of the draws."""
    return Intervals(draws, {}).of(condition)[0] >= 1.0
