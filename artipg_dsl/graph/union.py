"""What a condition says of one column as a union of intervals: ``x <= p or x >= q``, ``abs(x - a) >= c``, ``i != j``.

Each end is an expression of the other columns; an interval that a condition rules out ends first. Where a condition cannot
be solved for the column, nothing is said.
"""

from __future__ import annotations

import math

from ..records import dataclass
from . import expr as E
from .expr import Column, Expr
from .inequality import Ends
from .interval import Intervals
from .linear import Linear

Region = tuple[tuple[Expr, Expr], ...]

MOST = 8  # intervals of a union
_DEEPEST = 24
BESIDE = 1e-6  # a whole number, or a listed value, is left out with so much to both sides
LEAST, MOST_OF_ALL = E.const(-math.inf), E.const(math.inf)
EVERYTHING: Region = ((LEAST, MOST_OF_ALL),)


def region_of(condition: Expr, ends: Ends, *, discrete: bool) -> Region | None:
    """The intervals of the column of ``ends`` in which a condition can hold; None where that cannot be told. ``discrete``: of
    single values."""
    return _Regions(ends.column, ends.linear, ends.intervals, discrete).of(condition, True, 0)


def _lower(a: Expr, b: Expr) -> Expr:
    return b if a is MOST_OF_ALL else a if b is MOST_OF_ALL else E.minimum(a, b)


def _higher(a: Expr, b: Expr) -> Expr:
    return b if a is LEAST else a if b is LEAST else E.maximum(a, b)


def intersect_regions(first: Region, second: Region) -> Region:
    return tuple((_higher(a[0], b[0]), _lower(a[1], b[1])) for a in first for b in second)


@dataclass(slots=True)
class _Regions:
    column: Column
    linear: Linear
    intervals: Intervals
    discrete: bool

    def of(self, node: Expr, wanted: bool, depth: int) -> Region | None:
        """Where the condition is as ``wanted``."""
        if depth > _DEEPEST:
            return None
        if not self.linear.reads(node):
            holds = node if wanted else E.negate(node)
            return ((E.where(holds, LEAST, MOST_OF_ALL), E.where(holds, MOST_OF_ALL, LEAST)),)
        if node.op == "not":
            return self.of(node.args[0], not wanted, depth + 1)
        if node.op in ("and", "or"):
            first, second = (self.of(a, wanted, depth + 1) for a in node.args)
            return self.together(first, second, (node.op == "and") == wanted)
        if node.op in ("le", "lt"):
            a, b = node.args
            return self.solve(E.sub(a, b) if wanted else E.sub(b, a), "high", E.ZERO, depth + 1)
        if node.op == "eq":
            return self.equal(E.sub(*node.args), wanted)
        if node.op == "col":
            return self.of(self.linear.definitions[node.value], wanted, depth + 1)
        return None

    def together(self, first: Region | None, second: Region | None, both: bool) -> Region | None:
        """Where both hold (what cannot be told says nothing), or one of them."""
        if both and (first is None or second is None):
            return first if second is None else second
        if first is None or second is None:
            return None
        found = intersect_regions(first, second) if both else (*first, *second)
        return found if len(found) <= MOST else None

    def equal(self, difference: Expr, wanted: bool) -> Region | None:
        """Where a linear form is 0, or is not: the latter is worth saying of single values alone."""
        form = self.linear.form(difference)
        if form is None or self.column not in form[0] or len(form[0]) > 1:
            return None
        factor = form[0][self.column]
        if self.sign(factor) == 0:
            return None
        root = E.div(E.neg(form[1]), factor)
        if wanted:
            return ((root, root),)
        if not self.discrete:
            return None
        beside = E.const(BESIDE)
        return (LEAST, E.sub(root, beside)), (E.add(root, beside), MOST_OF_ALL)

    def sign(self, factor: Expr) -> int:
        low, high = self.intervals.of(factor)
        return 1 if low > 0 else -1 if high < 0 else 0

    def solve(self, node: Expr, side: str, value: Expr, depth: int) -> Region | None:
        """Where ``node <= value`` (side "high") or ``node >= value``."""
        if depth > _DEEPEST:
            return None
        if not self.linear.reads(node):
            return self.of(E.call("le", node, value) if side == "high" else E.call("le", value, node), True, depth)
        terms, rest = self.linear.parts(node)
        if len(terms) != 1:
            return None
        ((key, factor),) = terms.items()
        sign = self.sign(factor)
        if sign == 0:
            return None
        end = E.div(E.sub(value, rest), factor)
        side = side if sign > 0 else "low" if side == "high" else "high"
        if key is self.column:
            return ((LEAST, end),) if side == "high" else ((end, MOST_OF_ALL),)
        return None if isinstance(key, Column) else self.through(key, side, end, depth + 1)

    def through(self, node: Expr, side: str, value: Expr, depth: int) -> Region | None:
        """Backwards through an operation that stands alone on its side."""
        op, args = node.op, node.args
        if op in ("min", "max"):
            first, second = (self.solve(a, side, value, depth) for a in args)
            return self.together(first, second, (op == "max") == (side == "high"))
        if op == "abs":
            return self.magnitude(args[0], side, value, depth)
        if op == "mul" and args[0] is args[1]:
            return self.magnitude(args[0], side, self.root(value), depth)
        if op == "hypot" and self.linear.reads(args[0]) != self.linear.reads(args[1]):
            leg, other = args if self.linear.reads(args[0]) else args[::-1]
            left = E.sub(E.mul(value, value), E.mul(other, other))
            left = E.where(E.call("lt", value, E.ZERO), E.const(-1.0), left)
            return self.magnitude(leg, side, self.root(left), depth)
        return None

    def root(self, square: Expr) -> Expr:
        """The root of a square, -1 where that is negative."""
        return E.where(E.call("lt", square, E.ZERO), E.const(-1.0), E.call("sqrt", E.maximum(square, E.ZERO)))

    def magnitude(self, node: Expr, side: str, value: Expr, depth: int) -> Region | None:
        """``abs(node)`` at most a value: an interval; at least: the two beside it, which overlap where the value is negative."""
        above = self.solve(node, side, value, depth)
        below = self.solve(node, "low" if side == "high" else "high", E.neg(value), depth)
        return self.together(above, below, side == "high")


__all__ = ["EVERYTHING", "LEAST", "MOST_OF_ALL", "Region", "region_of"]
