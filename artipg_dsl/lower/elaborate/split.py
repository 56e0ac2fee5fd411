"""``split A along axis weight w gap g each lo .. hi``: elements that share a box, in closed form."""

from __future__ import annotations

from collections.abc import Callable

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.linear import tidy
from ...syntax import ast
from ..expressions.context import where
from ..expressions.env import Element, Env
from ..expressions.evaluate import Evaluator
from ..values.kinds import Box
from ..values.vectors import signed_axis
from .ranges import ROOM, SIZE, WEIGHT, WEIGHTS, Quantity

_ROUNDS = 6


def split(
    inner: Env, element: Element, statement: ast.RepeatStmt, box: Box, register: Callable[[Env, ast.Stmt], None]
) -> None:
    """Set the element's box and the gap before it. The weight may name what the body declares."""
    assert inner.outer is not None
    outer = Evaluator(inner.outer)
    axis, scope = axis_of(outer, statement), element.scope
    gap = scalar(outer, statement.gap)
    for declaration in statement.body:
        if isinstance(declaration, ast.ParamDecl | ast.CountDecl | ast.LetDecl):
            register(inner, declaration)
    weight = E.ONE if statement.weight is None else Evaluator(inner).scalar(statement.weight.value)
    room = E.sub(box.size[axis], E.mul(E.sub(element.count, E.ONE), gap))
    asked = inner.outer.context.asked
    if statement.weight is not None:
        name, place = f"the weight of an element of `{element.name}`", where(statement.weight.span)
        asked.append(Quantity(name, scope, weight, WEIGHT, place))
        name, some = f"the sum of the weights of `{element.name}`", E.call("lt", E.ZERO, element.count)
        asked.append(Quantity(name, inner.outer.scope, total(scope, weight, element.count), WEIGHTS, place, some))
    if statement.gap is not None:
        name, place = f"the gap between elements of `{element.name}`", where(statement.gap.span)
        asked.append(Quantity(name, inner.outer.scope, gap, ROOM, place))
    if statement.gap is not None and statement.each is None:
        name, place = f"what the gaps leave to the elements of `{element.name}`", where(statement.gap.span)
        asked.append(Quantity(name, inner.outer.scope, tidy(room), ROOM, place))
    if statement.each is None:
        size = E.div(E.mul(room, weight), total(scope, weight, element.count))
    else:
        low, high = outer.scalar(statement.each.value.low), outer.scalar(statement.each.value.high)
        name, place = f"the least size of an element of `{element.name}`", where(statement.each.span)
        asked.append(Quantity(name, inner.outer.scope, low, SIZE, place))
        size = _limit_shares(scope, room, weight, element.count, low, high)
        _bound_count(inner, element, statement, room, low, high)
    if size.scope is scope:
        before = E.scan(scope, size)
    else:
        before = E.mul(E.rank(scope), size)
    start = E.add(E.add(box.low[axis], before), E.mul(E.rank(scope), gap))
    element.box = box.between(axis, start, E.add(start, size))
    element.gap = box.between(axis, E.sub(start, gap), start, E.negate(E.call("eq", E.rank(scope), E.ZERO)))


def _bound_count(inner: Env, element: Element, statement: ast.RepeatStmt, room: Expr, low: Expr, high: Expr) -> None:
    """So many elements that each has room for its least size and all together fill the box."""
    outer = inner.outer
    assert outer is not None
    for sides, message in (
        ((E.mul(element.count, low), room), f"too many elements of `{element.name}` for the space available"),
        ((room, E.mul(element.count, high)), f"too few elements of `{element.name}` to fill the space available"),
    ):
        holds = E.call("le", *sides)
        if holds is not E.TRUE:
            text = f"each of {element.name}"
            outer.context.require(outer.scope, holds, statement.span, message, sides=sides, text=text)


def total(scope: Scope, value: Expr, count: Expr) -> Expr:
    """The sum over the elements of one parent row; a value equal for all is multiplied."""
    return E.reduce("sum", scope, value) if value.scope is scope else E.mul(count, value)


def _limit_shares(scope: Scope, room: Expr, weight: Expr, count: Expr, low: Expr, high: Expr) -> Expr:
    """Every element gets ``low``, the rest is shared by weight, and what exceeds ``high`` is shared again.

    What many elements of very unequal weights still leave after the last round goes to all in proportion to their room.
    """
    rest = E.sub(room, E.mul(count, low))
    span = E.sub(high, low)
    if weight.scope is not scope:
        return E.add(low, E.minimum(E.div(rest, count), span))
    share: Expr = E.ZERO
    for _ in range(_ROUNDS):
        free = E.where(E.call("lt", share, span), weight, E.ZERO)
        left = E.sub(rest, E.reduce("sum", scope, share))
        step = E.div(E.mul(left, free), E.maximum(E.reduce("sum", scope, free), E.const(1e-12)))
        share = E.minimum(E.add(share, step), span)
    left, space = E.sub(rest, E.reduce("sum", scope, share)), E.sub(span, share)
    step = E.div(E.mul(left, space), E.maximum(E.reduce("sum", scope, space), E.const(1e-12)))
    return E.add(low, E.add(share, step))


def axis_of(ev: Evaluator, statement: ast.RepeatStmt) -> int:
    """The axis of ``along``; for ``pitch`` too."""
    found = statement.along
    assert found is not None
    axis = signed_axis(ev.direction(found.value))
    if axis is None:
        raise ev.env.context.error(
            "bad-axis", found.span, "a repeat must run along x, y or z", hint="write `along x`, `along y` or `along z`"
        )
    if axis[1] < 0:
        said = "elements are counted in the positive direction of an axis"
        hint = f"write `along {'xyz'[axis[0]]}`: the element at the other end is `{statement.name}[last]`"
        raise ev.env.context.error("bad-axis", found.span, said, hint=hint)
    return axis[0]


def scalar(ev: Evaluator, clause: ast.Clause[ast.Expr] | None) -> Expr:
    return E.ZERO if clause is None else ev.scalar(clause.value)
