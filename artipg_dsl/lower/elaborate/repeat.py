"""Repeats: the table of elements, the box or frame of each, in closed form."""

from __future__ import annotations

from collections.abc import Callable

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.linear import tidy
from ...graph.primitive import triple
from ...graph.program import Pose
from ...syntax import ast
from ..expressions.context import where
from ..expressions.env import Element, Env
from ..expressions.evaluate import Evaluator
from ..values.faces import squared
from ..values.kinds import Box, Frame, Line
from ..values.vectors import HERE, IDENTITY, ORIGIN, dot, matrix, minus, norm, rotation_about, signed_axis, times
from .ranges import EVERY, ROOM, Quantity
from .split import axis_of, scalar, split

_HALF = E.const(0.5)


def build_repeat(
    env: Env,
    statement: ast.RepeatStmt,
    declare: Callable[[Env, tuple[ast.Stmt, ...]], None],
    register: Callable[[Env, ast.Stmt], None],
) -> Element:
    """Open the table of a repeat, place its elements, lower its body: ``declare`` its statements, ``register`` names ahead."""
    context = env.context
    ev = Evaluator(env)
    box = whole = None
    if (within := statement.split or statement.spread or statement.fill) is not None:
        whole = ev.box(within.value)
        box = squared(whole)
    if statement.form == "mirror":
        count: Expr = E.const(2.0)
    elif statement.form == "fill" and statement.count is None:
        assert box is not None
        count = _count_filling(ev, statement, box)
        if (every := statement.every) is not None:
            name, place = f"`every` of `{statement.name}`", where(every.span)
            context.asked.append(Quantity(name, env.scope, ev.scalar(every.value), EVERY, place))
    else:
        assert statement.count is not None
        count = ev.scalar(statement.count)
    scope = context.scope(f"{env.path}{statement.name}", env.scope, "repeat", count)
    context.counted[scope] = statement.name_span
    inner = env.nested(scope, f"{env.path}{statement.name}.", deeper=1)
    element = Element(statement.name, inner, scope, count, None)
    inner.element = element
    if statement.index is not None:
        inner.names[statement.index] = E.rank(scope)
    match statement.form:
        case "split":
            assert box is not None
            split(inner, element, statement, box, register)
        case "spread" | "fill" | "pitch":
            element.box = _space_elements(ev, statement, box, count, scope)
        case "ring":
            inner.frame = ring(ev, statement, count, scope)
        case "mirror":
            inner.frame = _mirror_pose(ev, statement, scope)
        case _:
            pass
    if element.box is None and env.root.box is not None and inner.frame is HERE:
        element.box = ev.own_box()
    declare(inner, statement.body)
    return element


def _count_filling(ev: Evaluator, statement: ast.RepeatStmt, box: Box) -> Expr:
    """How many elements fit: ``fill A every d``."""
    axis = axis_of(ev, statement)
    length = E.sub(box.size[axis], E.mul(E.const(2.0), scalar(ev, statement.margin)))
    step = scalar(ev, statement.every)
    return E.maximum(E.ONE, E.add(E.call("floor", E.add(E.div(length, step), E.const(1e-9))), E.ONE))


def _space_elements(ev: Evaluator, statement: ast.RepeatStmt, box: Box | None, count: Expr, scope: Scope) -> Box:
    """Elements without extent along the axis: evenly spread, at a pitch, or as many as fit."""
    axis = axis_of(ev, statement)
    if box is None:
        own = ev.own_box()
        box = squared(own) if own is not None else Box(ORIGIN, ORIGIN)
    margin, rank = scalar(ev, statement.margin), E.rank(scope)
    length = box.size[axis]
    if statement.form == "pitch":
        assert statement.pitch is not None
        name, place = f"`pitch` of `{statement.name}`", where(statement.pitch.span)
        beside = E.call("lt", E.ONE, count)
        ev.env.context.asked.append(Quantity(name, ev.env.scope, scalar(ev, statement.pitch), EVERY, place, beside))
        center = E.add(E.add(box.low[axis], margin), E.mul(rank, scalar(ev, statement.pitch)))
    elif statement.form == "fill":
        step = scalar(ev, statement.every)
        used = E.mul(E.sub(count, E.ONE), step)
        start = E.mul(E.sub(length, used), _HALF)
        center = E.add(E.add(box.low[axis], start), E.mul(rank, step))
    else:
        room = E.sub(length, E.mul(E.const(2.0), margin))
        if statement.margin is not None:  # one alone lies in the middle, whatever the margin
            name, place = f"the room between the margins of `{statement.name}`", where(statement.margin.span)
            beside = E.call("lt", E.ONE, count)
            ev.env.context.asked.append(Quantity(name, ev.env.scope, tidy(room), ROOM, place, beside))
        step = E.div(room, E.maximum(E.ONE, E.sub(count, E.ONE)))
        several = E.add(E.add(box.low[axis], margin), E.mul(rank, step))
        center = E.where(E.call("le", count, E.ONE), E.mul(E.add(box.low[axis], box.high[axis]), _HALF), several)
    return box.between(axis, center, center)


def ring(ev: Evaluator, statement: ast.RepeatStmt, count: Expr, scope: Scope) -> Pose:
    """``ring n about axis``: the scope's frame turned by k / n about the axis, its origin on it."""
    found = statement.about
    assert found is not None
    value = ev.value(found.value)
    match value:
        case Line(point=point) | Frame(origin=point):
            pass
        case _:
            point = ORIGIN
    direction = ev.direction(found.value)
    if norm(direction) is not E.ONE:
        raise ev.env.context.error(
            "bad-axis",
            found.span,
            "a ring needs an axis of unit length",
            hint="write `x`, `y` or `z`, a line or a face; of a vector, divide it by its length",
        )
    angle = E.mul(E.div(E.rank(scope), count), E.const(6.283185307179586))
    # the origin: the point of the axis nearest the scope's origin keeps it independent of where the line starts
    axis = signed_axis(direction)
    if axis is not None:
        point = triple(E.ZERO if k == axis[0] else c for k, c in enumerate(point))
    else:
        point = minus(point, times(direction, dot(point, direction)))
    return Pose(rotation_about(direction, angle), point, E.ONE)


def _mirror_pose(ev: Evaluator, statement: ast.RepeatStmt, scope: Scope) -> Pose:
    """``mirror across y``: element 0 as written, element 1 its mirror image in the plane through the scope's centre."""
    found = statement.across
    assert found is not None
    axis = signed_axis(ev.direction(found.value))
    if axis is None:
        raise ev.env.context.error(
            "bad-axis",
            found.span,
            "a mirror must be across x, y or z",
            hint="write `across x`, `across y` or `across z`",
        )
    sign = E.where(E.call("eq", E.rank(scope), E.ZERO), E.ONE, E.const(-1.0))
    if axis[0] == 1:
        return Pose(IDENTITY, ORIGIN, sign)
    # a reflection in another axis is the one in y followed by a half turn
    other = 2 if axis[0] == 0 else 0
    diagonal = [sign, sign, sign]
    diagonal[other] = E.ONE
    rows = matrix(tuple(diagonal[i] if i == j else E.ZERO for j in range(3)) for i in range(3))
    return Pose(rows, ORIGIN, sign)
