"""The type of what lies in a range, `low .. high`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..syntax import ast
from .types import LENGTH, PLANE, ScalarType, Type

if TYPE_CHECKING:
    from .checker import Checker, Context


def range_type(ck: Checker, ctx: Context, interval: ast.RangeExpr) -> Type:
    """The type of a value between the two ends of a range."""
    low, high = ck.infer(ctx, interval.low), ck.infer(ctx, interval.high)
    kind = high if isinstance(low, ScalarType) and low.zero else low
    if kind == PLANE:
        return LENGTH
    return ScalarType(kind.dimension) if isinstance(kind, ScalarType) else kind
