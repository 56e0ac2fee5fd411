"""Whether a value is a number whatever is drawn: no step of it divides by zero, takes the root of what may be negative, ...

Static and conservative, as intervals are: what is found certain is; the rest is asked of every object.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from .expr import Expr, Scope
from .interval import EVERYTHING, Interval, Intervals

_LARGEST = 700.0  # exp of more is beyond what a number can hold
_PASSING = frozenset(
    {
        "min",
        "max",
        "where",
        "phi",
        "neg",
        "abs",
        "le",
        "lt",
        "eq",
        "and",
        "or",
        "not",
        "sign",
        "element",
        "previous",
        "col",
        "rank",
    }
)  # of infinite numbers these make no nan
_BENT = frozenset({"sin", "cos", "asin", "acos", "atan"})


PARTIAL = {
    "div": "it divides by zero",
    "mod": "it divides by zero",
    "sqrt": "negative numbers have no square root",
    "log": "only numbers above 0 have a logarithm",
    "asin": "it takes numbers from -1 to 1",
    "acos": "it takes numbers from -1 to 1",
    "exp": "it is too large for a number",
    "pow": "a negative number has only whole powers, 0 no negative ones, and some are too large for a number",
}
"""Operations that not all numbers have a value of, and why not."""


class Sharp(Intervals):
    """Narrower intervals: of ranks and sums by how many rows there are, of angles by where they lie."""

    def rows(self, scope: Scope) -> Interval:
        """How many rows of a table a row of its parent has."""
        low, high = (1.0, 1.0) if scope.count is None else self.of(scope.count)
        return max(low, 0.0), max(high, 0.0)

    def _of(self, node: Expr) -> Interval:
        if node.op == "rank":
            return 0.0, max(self.rows(node.value)[1] - 1.0, 0.0)
        if node.op == "reduce" and node.value[0] == "sum":
            return self.summed(node.args[0], *self.rows(node.value[1]))
        if node.op == "scan":
            return self.summed(node.args[0], 0.0, max(self.rows(node.value)[1] - 1.0, 0.0))
        return super()._of(node)

    def summed(self, value: Expr, least: float, most: float) -> Interval:
        """A sum of ``least`` to ``most`` values."""
        low, high = self.of(value)
        ends = [0.0 if count == 0.0 else count * end for end in (low, high) for count in (least, most)]
        return min(ends), max(ends)

    def function(self, op: str, node: Expr) -> Interval:
        if op == "atan2":
            return -math.pi, math.pi
        if op == "where" and (decided := self.of(node.args[0])) in ((0.0, 0.0), (1.0, 1.0)):
            return self.of(node.args[1 if decided[0] else 2])
        if op == "pow":
            return _power(self.of(node.args[0]), node.args[1].constant)
        if op == "exp":
            return _rising(lambda a: _finite(lambda: math.exp(a)), self.of(node.args[0]), math.inf)
        if op not in _BENT:
            return super().function(op, node)
        ends = self.of(node.args[0])
        if op in ("asin", "acos", "atan") and ends != EVERYTHING:
            limit = math.inf if op == "atan" else 1.0
            rising = (lambda a: -math.acos(a)) if op == "acos" else getattr(math, op)
            return _rising(rising, ends, limit, op == "acos")
        if op == "cos" and math.isfinite(ends[0]) and math.isfinite(ends[1]):
            return _cosine(*ends)
        if op == "sin" and math.isfinite(ends[0]) and math.isfinite(ends[1]):
            return _cosine(ends[0] - math.pi / 2, ends[1] - math.pi / 2)
        return super().function(op, node)


def _power(base: Interval, power: float | None) -> Interval:
    """The powers of an interval, of what has one; whole powers of negative numbers are not looked into."""
    low, high = max(base[0], 0.0), base[1]
    if power is None or not math.isfinite(high) or high < 0.0 or base[0] < 0.0 and float(power).is_integer():
        return EVERYTHING
    ends = _finite(lambda: low**power), _finite(lambda: high**power)
    return min(ends), max(ends)


def _finite(value: Callable[[], float]) -> float:
    """A value that is infinite where it is too large for a number, or divides by 0."""
    try:
        return value()
    except (OverflowError, ZeroDivisionError):
        return math.inf


def _rising(function: Callable[[float], float], ends: Interval, limit: float, falls: bool = False) -> Interval:
    """The ends of a rising function of -``limit`` .. ``limit`` (of the negative of it, which ``falls``)."""
    low, high = (function(min(max(end, -limit), limit)) for end in ends)
    return (-high, -low) if falls else (low, high)


def _cosine(low: float, high: float) -> Interval:
    """The cosines of an interval of angles, a little widened."""
    turn = 2 * math.pi
    values = (math.cos(low), math.cos(high))
    top = math.ceil(low / turn) * turn <= high
    bottom = math.ceil((low - math.pi) / turn) * turn + math.pi <= high
    return (-1.0 if bottom else min(values) - 1e-12), (1.0 if top else max(values) + 1e-12)


class Defined:
    """Answers for expressions over the columns that ``intervals`` knows."""

    def __init__(self, intervals: Intervals):
        self.intervals = intervals
        self.memo: dict[Expr, bool] = {}
        self.running: set[Expr] = set()

    def certain(self, root: Expr) -> bool:
        """Whether an expression is a number, be it infinite, in every row of every object."""
        stack = [root]
        while stack:
            node = stack.pop()
            if node in self.running:  # all that it is made of has been looked at
                self.running.discard(node)
                self.memo[node] = all(self.memo.get(a, False) for a in self.reads(node)) and self.safe(node)
            elif node not in self.memo:
                self.running.add(node)
                stack.append(node)  # a value that needs itself is not certain: the plan reports it
                stack.extend(a for a in self.reads(node) if a not in self.memo and a not in self.running)
        return self.memo[root]

    def culprit(self, root: Expr, direct: bool = False) -> Expr | None:
        """The only operation that may leave ``root`` without a value, if it is one of the ``PARTIAL`` ones; None where there is none, or
        more than one. ``direct``: others that have no value because it is infinite do not count."""
        stack, seen, found = [root], set[Expr](), list[Expr]()
        while stack and len(found) < 2:
            node = stack.pop()
            if node in seen or self.certain(node):
                continue
            seen.add(node)
            parts = [a for a in self.reads(node) if not self.certain(a)]
            if not parts or not self.safe(node) and not (direct and self.follows(node, parts)):
                found.append(node)
            stack += parts
        return found[0] if len(found) == 1 and found[0].op in PARTIAL else None

    def follows(self, node: Expr, parts: list[Expr]) -> bool:
        """Whether an operation has no value only where what it is made of, the uncertain ``parts``, is infinite."""
        endless = [a for a in node.args if not all(map(math.isfinite, self.intervals.of(a)))]
        held = [self.intervals.of(a) for a in node.args]
        return (
            bool(endless)
            and all(a in parts for a in endless)
            and (node.op not in PARTIAL or _within(node.op, node, held))
        )

    def reads(self, node: Expr) -> tuple[Expr, ...]:
        """What a value is made of; definitions are read through, a draw lies between its ends."""
        if node.op != "col":
            return node.args
        definition = self.intervals.definitions.get(node.value)
        if definition is not None:
            return (definition,)
        draw = self.intervals.draws.get(node.value)
        return () if draw is None or draw.low is None or draw.high is None else (draw.low, draw.high)

    def safe(self, node: Expr) -> bool:
        """Whether an operation on numbers gives one."""
        op = node.op
        if op == "const":
            return not math.isnan(node.value)
        if op in _PASSING or op == "reduce" and node.value[0] not in ("sum",):
            return True
        if op in ("solve", "root", "var"):
            return False
        ends = [self.intervals.of(a) for a in node.args]
        finite = [math.isfinite(low) and math.isfinite(high) for low, high in ends]
        if op in ("add", "sub"):
            return any(finite)
        return all(finite) and _within(op, node, ends)


def _within(op: str, node: Expr, ends: list[Interval]) -> bool:
    """Whether finite arguments lie where an operation has a value."""
    low, high = ends[0]
    if op in ("div", "mod"):
        return ends[1][0] > 0.0 or ends[1][1] < 0.0
    if op == "sqrt":
        return low >= 0.0
    if op == "log":
        return low > 0.0
    if op in ("asin", "acos"):
        return low >= -1.0 and high <= 1.0
    if op == "exp":
        return high < _LARGEST
    if op == "pow":
        power = node.args[1].constant
        whole = power is not None and power >= 0 and float(power).is_integer()
        if power is not None and math.isinf(_finite(lambda: max(-low, high) ** power)):
            return False
        return whole or low > 0.0 or low >= 0.0 and ends[1][0] > 0.0
    return True
