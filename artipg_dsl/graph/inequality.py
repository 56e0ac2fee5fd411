"""What an inequality says of one column: bounds by going backwards through the operations that stand over it.

Where the column stands once the bounds are exact. Where it stands several times, all but one are taken at the end of
their interval over its domain that leaves most room (interval propagation, HC4-revise of Benhamou et al. 1999): such a bound is
never too narrow, and what it does not exclude is left to the check of requirements.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..records import dataclass
from . import expr as E
from .expr import ONE, ZERO, Column, Expr, Scope
from .interval import Intervals
from .linear import Linear
from .primitive import pair

_MOST = 16  # bounds of one inequality
_DEEPEST = 40


@dataclass(frozen=True, slots=True)
class Half:
    """The column is at least ("low") or at most ("high") ``value`` where ``guard`` holds, in each row of ``scope``."""

    side: str
    value: Expr
    guard: Expr
    scope: Scope


def bounds_of(low: Expr, high: Expr, guard: Expr, scope: Scope, ends: Ends) -> list[Half]:
    """What ``low <= high`` (where ``guard`` holds, in the rows of ``scope``) says of the column of ``ends``."""
    if ends.linear.reads(guard):
        return []
    solver = _Solver(ends)
    solver.solve(E.sub(low, high), "high", ZERO, guard, scope, 0)
    return solver.found[:_MOST]


def least_of(node: Expr, ends: Ends) -> Expr | None:
    """The least that an expression can be over the domain of a column, in terms of the others; None without a bound."""
    low, _ = ends.of(node)
    return None if low.constant is not None and not math.isfinite(low.constant) else low


def _other(side: str) -> str:
    return "low" if side == "high" else "high"


class Ends:
    """Symbolic intervals: what an expression can be while one column runs through its domain and the others stand still.

    What was asked before is kept, in ``linear`` (forms in the column alone) and in ``intervals`` (shared by all columns) too.
    """

    def __init__(self, column: Column, intervals: Intervals, definitions: Mapping[Column, Expr]):
        self.column, self.intervals = column, intervals
        self.linear = Linear(lambda c: c is column, definitions, through=True)
        self.memo: dict[Expr, tuple[Expr, Expr]] = {}

    def of(self, node: Expr) -> tuple[Expr, Expr]:
        found = self.memo.get(node)
        if found is None:
            found = self.memo[node] = self._of(node)
        return found

    def _of(self, node: Expr) -> tuple[Expr, Expr]:
        if not self.linear.reads(node):
            return node, node
        if node.op == "col":
            if node.value is not self.column:
                return self.of(self.linear.definitions[node.value])
            draw = self.intervals.draws[self.column]
            return (draw.low, draw.high) if draw.low is not None and draw.high is not None else self.static(node)
        if node.op in ("where", "phi", "element", "previous", "scan", "solve", "root"):
            return self.static(node)
        if node.op == "reduce":
            kind, child = node.value
            if kind not in ("sum", "min", "max"):
                return self.static(node)
            low, high = self.of(node.args[0])
            return E.reduce(kind, child, low), E.reduce(kind, child, high)
        parts = [self.of(a) for a in node.args]
        if any(e.constant is not None and not math.isfinite(e.constant) for pair in parts for e in pair):
            return self.static(node)
        return self.function(node, parts)

    def static(self, node: Expr) -> tuple[Expr, Expr]:
        low, high = self.intervals.of(node)
        return E.const(low), E.const(high)

    def function(self, node: Expr, parts: list[tuple[Expr, Expr]]) -> tuple[Expr, Expr]:
        op = node.op
        if op in ("add", "min", "max"):
            return E.call(op, parts[0][0], parts[1][0]), E.call(op, parts[0][1], parts[1][1])
        if op == "sub":
            return E.sub(parts[0][0], parts[1][1]), E.sub(parts[0][1], parts[1][0])
        if op == "neg":
            return E.neg(parts[0][1]), E.neg(parts[0][0])
        if op == "sqrt":
            return pair(E.call("sqrt", E.maximum(e, ZERO)) for e in parts[0])
        if op in ("abs", "hypot") or (op == "mul" and node.args[0] is node.args[1]):
            sizes = [self.magnitude(*p) for p in parts]
            if op == "abs":
                return sizes[0]
            return E.call(op, *(s[0] for s in sizes)), E.call(op, *(s[1] for s in sizes))
        if op == "mul":
            square = _completed(node.args[0], node.args[1], self.column, self.linear)
            if square is not None:
                return self.of(square)
            products = [E.mul(a, b) for a in dict.fromkeys(parts[0]) for b in dict.fromkeys(parts[1])]
            return E.minimum(*products), E.maximum(*products)
        if op == "div":
            low, high = self.intervals.of(node.args[1])
            if not low <= 0 <= high:
                ratios = [E.div(a, b) for a in dict.fromkeys(parts[0]) for b in dict.fromkeys(parts[1])]
                return E.minimum(*ratios), E.maximum(*ratios)
        return self.static(node)

    def magnitude(self, low: Expr, high: Expr) -> tuple[Expr, Expr]:
        return E.maximum(ZERO, low, E.neg(high)), E.maximum(high, E.neg(low))


def _completed(a: Expr, b: Expr, column: Column, linear: Linear) -> Expr | None:
    """The product of two linear forms as factor * (column + shift)^2 + rest; None where one is not linear."""
    first, second = linear.form(a), linear.form(b)
    if first is None or second is None or column not in first[0] or column not in second[0]:
        return None
    factor = E.mul(first[0][column], second[0][column])
    p, q = E.div(first[1], first[0][column]), E.div(second[1], second[0][column])  # a b = factor (x + p) (x + q)
    half = E.mul(E.sub(p, q), E.const(0.5))
    root = E.add(E.col(column), E.mul(E.add(p, q), E.const(0.5)))
    return E.mul(factor, E.sub(E.mul(root, root), E.mul(half, half)))


class _Solver:
    def __init__(self, ends: Ends):
        self.column, self.linear, self.intervals, self.ends = ends.column, ends.linear, ends.intervals, ends
        self.found: list[Half] = []

    def solve(self, node: Expr, side: str, value: Expr, guard: Expr, scope: Scope, depth: int) -> None:
        """Note what ``node <= value`` (side "high") or ``node >= value`` says of the column."""
        if guard is E.FALSE or depth > _DEEPEST or len(self.found) >= _MOST:
            return
        if not (scope.within(value.scope) and scope.within(guard.scope)):
            return  # it stands in rows of its own
        if node.op == "col":
            if node.value is self.column:
                self.found.append(Half(side, value, guard, scope))
            else:
                self.solve(self.linear.definitions[node.value], side, value, guard, scope, depth + 1)
            return
        terms, rest = self.linear.parts(node)
        if list(terms) == [node]:
            self.through(node, side, value, guard, scope, depth + 1)
            return
        for key, factor in terms.items():
            others = self.least([(k, f) for k, f in terms.items() if k is not key], side)
            if others is None:
                continue
            target = E.col(key) if isinstance(key, Column) else key
            self.divide(target, factor, side, E.sub(value, E.add(rest, others)), guard, scope, depth + 1)

    def least(self, terms: list[tuple[Column | Expr, Expr]], side: str) -> Expr | None:
        """The end of its other terms that leaves most room in a sum; None where they have none."""
        total = ZERO
        for key, factor in terms:
            ends = self.ends.of(E.mul(factor, E.col(key) if isinstance(key, Column) else key))
            end = ends[0] if side == "high" else ends[1]
            if end.constant is not None and not math.isfinite(end.constant):
                return None
            total = E.add(total, end)
        return total

    def divide(self, node: Expr, factor: Expr, side: str, value: Expr, guard: Expr, scope: Scope, depth: int) -> None:
        """``factor * node`` against a value; the sign of the factor is asked per row where it is not known."""
        low, high = self.intervals.of(factor)
        quotient = E.div(value, factor)
        if low > 0 or high < 0:
            self.solve(node, side if low > 0 else _other(side), quotient, guard, scope, depth)
            return
        if factor is ZERO:
            return
        self.solve(node, side, quotient, E.both(guard, E.call("lt", ZERO, factor)), scope, depth)
        self.solve(node, _other(side), quotient, E.both(guard, E.call("lt", factor, ZERO)), scope, depth)

    # ------------------------------------------------------------ backwards through one operation

    def through(self, node: Expr, side: str, value: Expr, guard: Expr, scope: Scope, depth: int) -> None:
        op, args = node.op, node.args
        if op in ("min", "max"):
            self.extreme(node, side, value, guard, scope, depth)
        elif op == "mul":
            self.product(args[0], args[1], side, value, guard, scope, depth)
        elif op == "div":
            self.quotient(args[0], args[1], side, value, guard, scope, depth)
        elif op == "abs":
            self.magnitude(args[0], side, value, guard, scope, depth)
        elif op == "hypot":
            for leg, rest in (args, args[::-1]):
                if self.linear.reads(leg):
                    self.leg(leg, rest, side, value, guard, scope, depth)
        elif op == "sqrt":
            square = E.mul(value, value)
            if side == "high":
                square = E.where(E.call("le", ZERO, value), square, E.const(-1.0))
                self.solve(args[0], side, square, guard, scope, depth)
            else:
                self.solve(args[0], side, square, E.both(guard, E.call("lt", ZERO, value)), scope, depth)
        elif op == "exp":
            logarithm = E.call("log", E.maximum(value, E.const(1e-300)))
            self.solve(args[0], side, logarithm, guard, scope, depth)
        elif op == "log":
            self.solve(args[0], side, E.call("exp", value), guard, scope, depth)
        elif op in ("floor", "ceil"):  # floor(a) <= v: a < v + 1
            slack = {("floor", "high"): 1.0, ("ceil", "low"): -1.0}.get((op, side), 0.0)
            self.solve(args[0], side, E.add(value, E.const(slack)), guard, scope, depth)
        elif op == "where" and not self.linear.reads(args[0]):
            self.solve(args[1], side, value, E.both(guard, args[0]), scope, depth)
            self.solve(args[2], side, value, E.both(guard, E.negate(args[0])), scope, depth)
        elif op == "reduce":
            self.reduction(node, side, value, guard, depth)

    def extreme(self, node: Expr, side: str, value: Expr, guard: Expr, scope: Scope, depth: int) -> None:
        """``max(a, b) <= v`` binds both; ``max(a, b) >= v`` binds a where b does not reach v."""
        for a, b in (node.args, node.args[::-1]):
            if not self.linear.reads(a):
                continue
            if (node.op == "max") == (side == "high"):
                self.solve(a, side, value, guard, scope, depth)
            elif not self.linear.reads(b):
                short = E.call("lt", b, value) if side == "low" else E.call("lt", value, b)
                self.solve(a, side, value, E.both(guard, short), scope, depth)
            else:
                low, high = self.ends.of(b)
                end = high if side == "low" else low
                short = E.call("lt", end, value) if side == "low" else E.call("lt", value, end)
                self.solve(a, side, value, E.both(guard, short), scope, depth)

    def product(self, a: Expr, b: Expr, side: str, value: Expr, guard: Expr, scope: Scope, depth: int) -> None:
        """Both factors depend on the column (Linear takes products apart where only one does)."""
        if a is b:
            root = E.call("sqrt", E.maximum(value, ZERO))
            self.magnitude(a, side, root, guard, scope, depth)
            return
        square = _completed(a, b, self.column, self.linear)
        if square is not None:
            self.solve(square, side, value, guard, scope, depth)
            return
        for node, factor in ((a, b), (b, a)):
            span = self.intervals.of(factor)
            if span[0] <= 0 or not math.isfinite(span[1]):
                continue
            low, high = self.ends.of(factor)
            near, far = (low, high) if side == "high" else (high, low)
            most = E.where(E.call("le", ZERO, value), E.div(value, near), E.div(value, far))
            self.solve(node, side, most, guard, scope, depth)

    def quotient(self, top: Expr, bottom: Expr, side: str, value: Expr, guard: Expr, scope: Scope, depth: int) -> None:
        """``top / bottom`` against a value, for a bottom that is never 0."""
        low, high = self.intervals.of(bottom)
        if low <= 0 <= high:
            return
        turned = side if low > 0 else _other(side)
        difference = E.sub(top, E.mul(value, bottom))  # top - value * bottom <= 0 where bottom > 0
        terms, _ = self.linear.parts(difference)
        if list(terms) != [difference]:
            self.solve(difference, turned, ZERO, guard, scope, depth)

    def magnitude(self, node: Expr, side: str, value: Expr, guard: Expr, scope: Scope, depth: int) -> None:
        """``abs(node)`` against a value."""
        low, high = self.intervals.of(node)
        if side == "high":
            if high > 0:
                self.solve(node, "high", value, guard, scope, depth)
            if low < 0:
                self.solve(node, "low", E.neg(value), guard, scope, depth)
        elif low >= 0:
            self.solve(node, "low", value, guard, scope, depth)
        elif high <= 0:
            self.solve(node, "high", E.neg(value), guard, scope, depth)

    def leg(self, leg: Expr, rest: Expr, side: str, value: Expr, guard: Expr, scope: Scope, depth: int) -> None:
        """``hypot(leg, rest)`` against a value: Pythagoras, the other leg at its best where it depends on the column too."""
        if self.linear.reads(rest):
            low, high = self.ends.magnitude(*self.ends.of(rest))
            rest = low if side == "high" else high
        left = E.sub(E.mul(value, value), E.mul(rest, rest))
        if side == "low":
            guard = E.both(guard, E.call("lt", ZERO, value))
        self.magnitude(leg, side, E.call("sqrt", E.maximum(left, ZERO)), guard, scope, depth)

    def reduction(self, node: Expr, side: str, value: Expr, guard: Expr, depth: int) -> None:
        """The least or greatest of some rows binds each; a sum binds what its rows share, or each beside the others' least."""
        kind, child = node.value
        inner = node.args[0]
        if (kind, side) in (("max", "high"), ("min", "low")):
            self.solve(inner, side, value, guard, child, depth)
            return
        if kind != "sum":
            return
        form = self.linear.form(inner)
        if form is not None and child.parent is not None and child.parent.within(self.column.scope):
            total = E.reduce("sum", child, form[1])
            factor = E.reduce("sum", child, form[0][self.column])
            self.divide(E.col(self.column), factor, side, E.sub(value, total), guard, child.parent, depth)
            return
        low, high = self.intervals.of(inner)
        end = low if side == "high" else high
        if math.isfinite(end) and self.column.scope.within(child):
            count = E.sub(E.reduce("sum", child, ONE), ONE)
            self.solve(inner, side, E.sub(value, E.mul(count, E.const(end))), guard, child, depth)


__all__ = ["Ends", "Half", "bounds_of", "least_of"]
