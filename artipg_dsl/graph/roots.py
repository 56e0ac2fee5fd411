"""The first place on a curve where a formula takes a value."""

from __future__ import annotations

import math
from collections.abc import Sequence

from . import expr as E
from .expr import Column, Expr, Scope
from .linear import Linear, roots
from .substitution import substitute

_SLACK = 1e-6  # so much may be lost in rounding before an end
_HALF = math.pi / 2  # each kind of argument of these lies so far on both sides of a middle
_PERIODS = {"sin": 2 * math.pi, "cos": 2 * math.pi, "tan": math.pi}


def lowest_root(formula: Expr, name: str, ends: tuple[Expr, Expr], value: Expr) -> Expr | None:
    """The lowest number between ``ends`` for which a formula of the variable ``name``, which stands in it once, is ``value``.

    Where there is none, one that is not between them, or nan; None for a formula that cannot be solved.
    """
    marker = Column(formula.scope or Scope("root"), name)

    def others(op: str, argument: Expr, value: Expr, root: Expr) -> list[Expr]:
        start, end = (substitute(argument, {E.col(marker): end}) for end in ends)
        if op in _PERIODS:
            return _turning(op, root, start, end)
        return _signed(E.where(E.call("lt", value, E.ZERO), E.call("sqrt", value), root), start, end)

    found = roots(
        substitute(formula, {E.var(name): E.col(marker)}), marker, value, Linear(lambda c: c is marker, {}), others
    )
    return None if found is None else _lowest(found, ends)


def _lowest(found: Sequence[Expr], ends: tuple[Expr, Expr]) -> Expr:
    low, high = E.sub(ends[0], E.const(_SLACK)), E.add(ends[1], E.const(_SLACK))

    def between(root: Expr) -> Expr:
        return E.both(E.call("le", low, root), E.call("le", root, high))

    best = found[0]
    for root in found[1:]:
        lower = E.either(E.negate(between(best)), E.call("lt", root, best))
        best = E.where(E.both(between(root), lower), root, best)
    return best


def _signed(root: Expr, start: Expr, end: Expr) -> list[Expr]:
    """Of a square or an absolute value: the positive argument and the negative one, where they can lie between the ends."""
    low, high = _constants(start, end)
    return [root] * (high > 0) + [E.neg(root)] * (low < 0) or [root]


def _turning(op: str, root: Expr, start: Expr, end: Expr) -> list[Expr]:
    """Of a sine, cosine or tangent: the first argument of each kind on the way from ``start`` to ``end``. Those of one kind are a
    whole number of periods apart."""
    period = _PERIODS[op]
    kinds = {
        "sin": [(root, 0.0), (E.sub(E.const(math.pi), root), math.pi)],
        "cos": [(root, _HALF), (E.neg(root), -_HALF)],
        "tan": [(root, 0.0)],
    }[op]
    low, high = _constants(start, end)
    if math.isfinite(low) and math.isfinite(high):
        met = [
            (kind, k)
            for kind, middle in kinds
            for k in range(math.floor((low - middle) / period), math.ceil((high - middle) / period) + 1)
            if max(low, middle + k * period - _HALF) + _SLACK < min(high, middle + k * period + _HALF)
        ]
        if len(met) == 1:
            kind, k = met[0]
            return [E.add(kind, E.const(k * period))]
    onwards = E.call("le", start, end)
    return [_first(kind, start, onwards, period) for kind, _ in kinds]


def _first(kind: Expr, start: Expr, onwards: Expr, period: float) -> Expr:
    """The first of the numbers that are a whole number of periods from ``kind``, from ``start`` upwards, or downwards."""
    turns = E.where(
        onwards,
        E.call("ceil", E.div(E.sub(E.sub(start, E.const(_SLACK)), kind), E.const(period))),
        E.call("floor", E.div(E.sub(E.add(start, E.const(_SLACK)), kind), E.const(period))),
    )
    return E.add(kind, E.mul(E.const(period), turns))


def _constants(start: Expr, end: Expr) -> tuple[float, float]:
    """The lower and the upper end of a way, infinite where they depend on values."""
    if start.constant is None or end.constant is None:
        return -math.inf, math.inf
    return min(start.constant, end.constant), max(start.constant, end.constant)
