"""Warns of labels and fields whose condition holds at no point of their targets, whatever is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from ...graph.defined import Sharp
from ...graph.expr import TRUE, Expr, variables
from ...graph.interval import EVERYTHING, Interval, Intervals
from ...graph.primitive import Triple
from ...records import dataclass
from ...syntax import ast
from ...syntax.walk import walk
from ..expressions.context import Draft

_STEP = 1.1  # a size is looked at in pieces, of which the ends differ by this factor at most
_PIECES = 24  # of a size at most; one that varies more is not looked at
_REACH = 0.55  # of its size, how far from its centre a target has points at most: a box may be off by a twentieth
_NORMAL = dict.fromkeys(("n.x", "n.y", "n.z"), (-1.001, 1.001))


@dataclass(frozen=True, slots=True, eq=False)
class Holding:
    """What stands behind ``where`` in a ``statement`` for one target, which is ``size`` large, and that its degree is ``above`` 0."""

    statement: ast.LabelStmt | ast.FieldStmt
    where: Expr
    above: Expr
    size: Triple


def note(context: Draft, holding: Holding) -> None:
    """Note where a statement holds on one of its targets."""
    context.holding.setdefault(id(holding.statement), []).append(holding)


def warn(context: Draft, own: object) -> None:
    """Report the statements in the file ``own`` that hold on none of their targets."""
    around = Sharp(context.draws, context.program.definitions)
    for several in context.holding.values():
        statement = several[0].statement
        if statement.span.source is not own:
            continue
        if statement.where is not None and all(_is_never(one.where, one.size, around) for one in several):
            wrong, said = statement.where, "is never true"
        elif statement.value is not None and all(_is_never(one.above, one.size, around) for one in several):
            wrong, said = statement.value, "is never above 0"
        else:
            continue
        idle = (span for span, carries in context.driven.items() if not carries)  # which is refused
        if any(span.source is own and wrong.span.start <= span.start and span.end <= wrong.span.end for span in idle):
            continue
        name = statement.label if isinstance(statement, ast.LabelStmt) else statement.name
        context.report.warning(
            "holds-nowhere", wrong.span, f"`{name}` holds nowhere: `{wrong.span.words}` {said}", hint=_hint(wrong)
        )


def _hint(wrong: ast.Expr) -> str:
    named = {
        node.obj.name for node in walk(wrong) if isinstance(node, ast.MemberExpr) and isinstance(node.obj, ast.NameExpr)
    }
    if "p" in named:
        return "p is measured from the centre of the target: p.z goes from -size.z / 2 to size.z / 2"
    if "n" in named:
        return "n has length 1: each of its components lies in -1 .. 1"
    return "correct it, or leave the statement out"


class _Points(Intervals):
    """Intervals of formulas on points, whose variables have the ``ranges``; all else is as ``around`` knows it."""

    def __init__(self, around: Intervals, ranges: dict[str, Interval]):
        super().__init__((), {})
        self.around, self.ranges = around, ranges

    def inner(self, node: Expr) -> Iterable[Expr]:
        return node.args if node.reads else ()

    def _of(self, node: Expr) -> Interval:
        if not node.reads:
            return self.around.of(node)
        return self.ranges.get(node.value, EVERYTHING) if node.op == "var" else super()._of(node)


def _is_never(holds: Expr, size: Triple, around: Intervals) -> bool:
    """Whether one of the conditions that have to hold together never does at points of a target that is ``size`` large."""
    if holds is TRUE:
        return False
    sizes = [around.of(length) for length in size]
    ranges = dict(_NORMAL)
    for axis, length in zip("xyz", sizes, strict=True):
        ranges |= _along(axis, length)
    everywhere = _Points(around, ranges)
    return any(
        everywhere.of(condition)[1] < 1.0 or _is_beyond(condition, sizes, around, ranges)
        for condition in _together(holds)
    )


def _along(axis: str, size: Interval) -> dict[str, Interval]:
    """What points have along an axis of a target that is ``size`` long."""
    return {f"size.{axis}": size, f"p.{axis}": (-_REACH * size[1], _REACH * size[1])}


def _together(condition: Expr) -> Iterator[Expr]:
    if condition.op == "and":
        for part in condition.args:
            yield from _together(part)
    else:
        yield condition


def _is_beyond(condition: Expr, sizes: list[Interval], around: Intervals, ranges: dict[str, Interval]) -> bool:
    """Whether a condition on where points lie along one axis holds only beyond the ends of the target, however large that is."""
    named = variables([condition])
    axes = [k for k, axis in enumerate("xyz") if {f"p.{axis}", f"size.{axis}"} <= named]
    if len(axes) != 1:
        return False
    axis, (low, high) = "xyz"[axes[0]], sizes[axes[0]]
    if not 0.0 < low < high < min(math.inf, low * _STEP**_PIECES):
        return False
    while low < high:
        piece = ranges | _along(axis, (low, min(low * _STEP, high)))
        if _Points(around, piece).of(condition)[1] >= 1.0:
            return False
        low *= _STEP
    return True
