"""The functions that the language brings along."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.primitive import triple
from ...source import Span
from ...syntax import ast
from ..values.carry import mapped, scalars
from ..values.faces import FACES, extent, frame_of, squared
from ..values.kinds import Box, Frame, Line, Ports, Surface, Value
from ..values.vectors import dot, minus, normalized, times, unit
from .arithmetic import applied
from .env import Element
from .members import describe

if TYPE_CHECKING:
    from .env import Env
    from .evaluate import Evaluator

SCALAR = frozenset("sin cos tan asin acos atan atan2 sqrt abs floor ceil exp log sign mod".split())
"""Functions of numbers that the graph has too, under the same names."""


def pick(ports: Ports, index: Expr, env: Env, span: Span) -> Value:
    """The port with an index, which may differ from row to row."""
    values = ports.settled()
    if index.constant is not None:
        if int(index.constant) not in values:
            raise env.context.error(
                "unknown-port",
                span,
                f"`{ports.name}` has no index {int(index.constant)}; it has 0 .. {len(values) - 1}",
            )
        return values[int(index.constant)]
    keys = sorted(values)
    value = values[keys[-1]]
    for key in reversed(keys[:-1]):
        here = E.call("eq", index, E.const(float(key)))
        others = iter(scalars(values[key]))
        value = mapped(value, partial(chosen, here, others))
    return value


def chosen(here: Expr, others: Iterator[Expr], otherwise: Expr) -> Expr:
    """The next of the others where ``here`` holds."""
    return E.where(here, next(others), otherwise)


def function(ev: Evaluator, node: ast.CallExpr, name: str) -> Value:
    """A call of a function of the language."""
    context = ev.env.context
    if name in SCALAR:
        arguments = [ev.scalar(a.value) for a in node.arguments]
        return applied(ev, node, name, arguments)
    if name == "round":
        return E.call("floor", E.add(ev.scalar(node.arguments[0].value), E.const(0.5)))
    if name == "hypot":
        arguments = [ev.scalar(a.value) for a in node.arguments]
        total = arguments[0]
        for other in arguments[1:]:
            total = E.call("hypot", total, other)
        return total
    if name in ("sum", "min", "max", "number") and len(node.arguments) == 1:
        return reduction(ev, name, node.arguments[0].value)
    if name in ("min", "max"):
        arguments = [ev.scalar(a.value) for a in node.arguments]
        return (E.minimum if name == "min" else E.maximum)(*arguments)
    if name == "offset":
        return context.makers.offset(ev, node)
    if name == "frame":
        return make_frame(ev, node)
    if name == "line":
        return make_line(ev, node)
    if name == "box":
        return make_box(ev, node)
    if name == "lowest":
        box = ev.box(node.arguments[0].value)
        return dot(times(ev.direction(node.arguments[1].value), E.const(1.0)), farthest(box, ev, node))
    raise context.error("unknown-name", node.function.span, f"there is no function `{name}`")


def farthest(box: Box, ev: Evaluator, node: ast.CallExpr) -> tuple[Expr, Expr, Expr]:
    """The point of a box that lies farthest along a direction."""
    direction = ev.direction(node.arguments[1].value)
    outer = extent(box)
    point = []
    for k in range(3):
        sign = direction[k].constant
        point.append(outer.low[k] if sign is not None and sign < 0 else outer.high[k])
    return triple(point)


def named(node: ast.CallExpr, *order: str) -> dict[str, ast.Expr]:
    """Arguments by name; positional ones take the names of ``order``."""
    found: dict[str, ast.Expr] = {}
    for k, argument in enumerate(node.arguments):
        found[argument.name or (order[k] if k < len(order) else str(k))] = argument.value
    return found


def need(ev: Evaluator, node: ast.CallExpr, arguments: dict[str, ast.Expr], name: str) -> ast.Expr:
    if name not in arguments:
        raise ev.env.context.error("wrong-arguments", node.span, f"the argument `{name}` is missing")
    return arguments[name]


def carriers(value: Value) -> tuple[Any, ...]:
    return getattr(value, "on", ())


def make_frame(ev: Evaluator, node: ast.CallExpr) -> Frame:
    arguments = named(node, "at", "out", "up")
    at = need(ev, node, arguments, "at")
    place_value = ev.value(at)
    origin = ev.vector(at)
    out = ev.direction(need(ev, node, arguments, "out"))
    up = ev.direction(arguments["up"]) if "up" in arguments else unit(0 if abs(out[2].constant or 0) == 1 else 2)
    return Frame(origin, frame_of(out, up), carriers(place_value))


def make_line(ev: Evaluator, node: ast.CallExpr) -> Line:
    arguments = named(node, "at")
    at = need(ev, node, arguments, "at")
    value, point = ev.value(at), ev.vector(at)
    if "to" in arguments:
        to = ev.vector(arguments["to"])
        return Line(point, normalized(minus(to, point)), to, carriers(value))
    return Line(point, normalized(ev.direction(need(ev, node, arguments, "along"))), None, carriers(value))


def make_box(ev: Evaluator, node: ast.CallExpr) -> Box:
    """``box(front = a, ...)``: faces that are left out are the template's own."""
    own = ev.own_box()
    own = squared(own) if own is not None else None
    low: list[Expr | None] = list(own.low) if own is not None else [None] * 3
    high: list[Expr | None] = list(own.high) if own is not None else [None] * 3
    on: tuple[Any, ...] = ()
    for argument in node.arguments:
        if argument.name not in FACES:
            raise ev.env.context.error(
                "wrong-arguments", argument.span, "box takes front, back, left, right, top, bottom"
            )
        axis, sign = FACES[argument.name]
        value = ev.value(argument.value)
        on += carriers(value)
        coordinate = ev.number(value, argument.value.span)
        (high if sign > 0 else low)[axis] = coordinate
    missing = [n for n, (a, s) in FACES.items() if (high if s > 0 else low)[a] is None]
    if missing:
        raise ev.env.context.error(
            "wrong-arguments",
            node.span,
            f"the faces {', '.join(missing)} are open: this template has no box of its own to take them from",
        )
    return Box(triple(c for c in low if c is not None), triple(c for c in high if c is not None), on=on)


def reduction(ev: Evaluator, name: str, node: ast.Expr) -> Expr:
    """``sum(cell.size.z)``: over the elements of the repeat that the path goes through."""
    base = node
    while isinstance(base, ast.MemberExpr | ast.IndexExpr | ast.CallExpr | ast.BinaryExpr | ast.UnaryExpr):
        base = (
            base.obj
            if isinstance(base, ast.MemberExpr | ast.IndexExpr)
            else base.left
            if isinstance(base, ast.BinaryExpr)
            else base.operand
            if isinstance(base, ast.UnaryExpr)
            else base.arguments[0].value
        )
    element = ev.value(base) if isinstance(base, ast.NameExpr) else None
    if not isinstance(element, Element) or ev.inside(element):
        raise ev.env.context.error(
            "wrong-kind", node.span, f"`{name}` of one value needs a path through a repeat, such as {name}(cell.size.z)"
        )
    if name == "number":
        return element.count
    value = type(ev)(element.env).scalar(node)
    while value.scope is not None and not ev.env.scope.within(value.scope):
        value = E.reduce(name, value.scope, value)
    return value


def method(ev: Evaluator, node: ast.CallExpr) -> Value:
    """``body.wall.at(u, z = h)``: a frame on a curved surface."""
    function = node.function
    assert isinstance(function, ast.MemberExpr)
    owner = ev.value(function.obj)
    if function.name == "at" and isinstance(owner, Surface):
        return ev.env.context.makers.frame_on(ev, owner, node)
    raise ev.env.context.error("unknown-member", function.name_span, f"{describe(owner)} has no `{function.name}(...)`")
