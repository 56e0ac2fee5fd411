"""Requirements to conditional ranges that consist of several intervals."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.program import Draw, Union
from ...graph.union import LEAST, MOST_OF_ALL, Region, region_of
from .readers import Readers


def unite(
    readers: Readers, draw: Draw, scope: Scope, condition: Expr, number: int, also: tuple[int, ...] = ()
) -> tuple[Expr, Expr] | None:
    """Turn a condition into a union of intervals of the variable that is drawn last, where it can be solved for it.

    Returns the inequality (low, high) that says of what is drawn before that one of the intervals has room.
    """
    column = draw.column
    if not column.scope.within(scope) or draw.low is None or draw.high is None:
        return None  # its rows have more rows each: what holds in all of them is no union of so few
    discrete = draw.kind == "count" or draw.distribution == "values"
    region = region_of(condition, readers.ends(column), discrete=discrete)
    if region is None or not _useful(region):
        return None
    ends = [end for pair in region for end in pair]
    if not all(column.scope.within(end.scope) for end in ends):
        return None
    if readers.late(column, ends):
        return None
    draw.unions.append(Union(region, E.TRUE, number, also))
    rooms = [room(pair, draw.low, draw.high) for pair in region]
    return E.minimum(*rooms), E.ZERO


def _useful(region: Region) -> bool:
    """Whether no interval is the whole line."""
    return bool(region) and not any(low is LEAST and high is MOST_OF_ALL for low, high in region)


def room(pair: tuple[Expr, Expr], low: Expr, high: Expr) -> Expr:
    """How much an interval lacks to have room within a domain: at most 0 where it has some."""
    first, last = pair
    lacks = []
    if first is not LEAST:
        lacks.append(E.sub(first, high))
    if last is not MOST_OF_ALL:
        lacks.append(E.sub(low, last))
    if len(lacks) == 2:
        lacks.append(E.sub(first, last))
    return E.maximum(*lacks)
