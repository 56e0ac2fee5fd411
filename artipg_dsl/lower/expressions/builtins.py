"""The functions that the language brings along."""

from __future__ import annotations

import functools
import math
from functools import partial
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.primitive import triple
from ...language import Form
from ...semantics.meanings import Declared, Inner
from ...source import Span
from ...syntax import ast
from ...syntax.walk import walk
from ..values.carry import whichever
from ..values.faces import FACES, frame_of, squared
from ..values.kinds import Box, Frame, Line, Ports, Value, carriers_of
from ..values.vectors import HERE, compose, cross, dot, minus, normalized, place, times, transpose
from .arithmetic import applied
from .env import Element, pose_between

if TYPE_CHECKING:
    from ..values.kinds import Carrier
    from .context import Makes
    from .env import Env
    from .evaluate import Evaluator


def pick(ports: Ports, index: Expr, env: Env, span: Span) -> Value:
    """The port with an index, which may differ from row to row."""
    values = ports.settled()
    if index.constant is not None:
        if int(index.constant) not in values:
            raise env.context.error(
                "unknown-port",
                span,
                f"`{ports.name}` has no index {int(index.constant)}; it has 0 .. {len(values) - 1}",
                hint=f"write `[last]` for the last, or declare more: `port {ports.name}[{int(index.constant) + 1}]`",
            )
        return values[int(index.constant)]
    return whichever([(E.call("eq", index, E.const(float(key))), values[key]) for key in sorted(values)])


def _of_graph(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    """A function of numbers that the graph has too, under the same name."""
    return applied(ev, node, form.name, numbers(ev, node))


def _rounded(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    return E.call("floor", E.add(ev.scalar(node.arguments[0].value), E.const(0.5)))


def _hypotenuse(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    return functools.reduce(partial(E.call, "hypot"), numbers(ev, node))


def least(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    return E.minimum(*numbers(ev, node))


def greatest(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    return E.maximum(*numbers(ev, node))


def lowest(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    """How far a box reaches along a direction."""
    given = bound(node, form)
    box, direction = squared(ev.box(given["part"])), normalized(ev.direction(given["direction"]))
    along = triple(E.call("abs", dot(direction, axis)) for axis in transpose(box.pose.rotation))
    return E.add(dot(direction, place(box.pose, box.center)), dot(along, times(box.size, E.const(0.5))))


def numbers(ev: Evaluator, node: ast.CallExpr) -> list[Expr]:
    return [ev.scalar(a.value) for a in node.arguments]


def bound(node: ast.CallExpr, form: Form) -> dict[str, ast.Expr]:
    """Arguments by the names of their parameters, of a form that takes each once."""
    parameters = form.bind([a.name for a in node.arguments])
    return {p.name: a.value for a, p in zip(node.arguments, parameters, strict=True) if p is not None}


def frame(ev: Evaluator, node: ast.CallExpr, form: Form) -> Frame:
    given = bound(node, form)
    out, up = ev.direction(given["out"]), ev.direction(given["up"])
    if all(c is E.ZERO for c in cross(normalized(out), normalized(up))):
        raise ev.env.context.error(
            "illegal-value",
            given["up"].span,
            "`up` of a frame must not run along its `out`",
            hint="name a direction across it, such as x for the `out` z",
        )
    return Frame(ev.vector(given["at"]), frame_of(out, up), carriers_of(ev.value(given["at"])))


def line(ev: Evaluator, node: ast.CallExpr, form: Form) -> Line:
    given = bound(node, form)
    point, on = ev.vector(given["at"]), carriers_of(ev.value(given["at"]))
    if "to" in given:
        to = ev.vector(given["to"])
        return Line(point, normalized(minus(to, point)), to, on)
    return Line(point, normalized(ev.direction(given["along"])), None, on)


def box(ev: Evaluator, node: ast.CallExpr, form: Form) -> Box:
    """``box(front = a, ...)``: faces that are left out are the template's own."""
    own = ev.own_box()
    own = squared(own) if own is not None else None
    if own is not None and own.pose is not HERE:  # in a ring its faces have no coordinates
        own = None
    low: list[Expr | None] = list(own.low) if own is not None else [None] * 3
    high: list[Expr | None] = list(own.high) if own is not None else [None] * 3
    on: tuple[Carrier, ...] = ()
    for name, argument in bound(node, form).items():
        axis, sign = FACES[name]
        value = ev.value(argument)
        on += carriers_of(value)
        coordinate = ev.number(value, argument.span)
        (high if sign > 0 else low)[axis] = coordinate
    missing = [n for n, (a, s) in FACES.items() if (high if s > 0 else low)[a] is None]
    if missing:
        raise ev.env.context.error(
            "wrong-arguments",
            node.span,
            f"the faces {', '.join(missing)} are open: this template has no box of its own to supply them",
            hint="give them too, or give the template `param size : length[3]`",
        )
    return Box(triple(c for c in low if c is not None), triple(c for c in high if c is not None), on=on)


def count(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    """How many elements a repeat has; of a repeat in a repeat, how many in all elements of that."""
    element = _repeat_of(ev, node.arguments[0].value)
    return over(ev, "sum", element.scope.parent, element.count)


def reduction(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    """``sum(cell.size.z)``: over the elements of the repeat that the path goes through."""
    argument = node.arguments[0].value
    element = _repeat_of(ev, argument)
    pose = compose(ev.pose, pose_between(element.env, ev.env))
    value = type(ev)(element.env, pose=pose, frame=ev.frame).scalar(argument)
    deeper = value.scope is not None and value.scope.within(element.scope)
    return over(ev, form.name, value.scope if deeper else element.scope, value)


def over(ev: Evaluator, kind: str, scope: Scope | None, value: Expr) -> Expr:
    """A value of each row of ``scope``, reduced table by table to what stands here. Of what is the same in all rows the sum counts it for
    each of them, and the least and the greatest are it where there is one."""
    while scope is not None and not ev.env.scope.within(scope):
        if value.scope is not None and value.scope.within(scope):
            value = E.reduce(kind, scope, value)
        elif scope.count is not None:
            there = scope.count if scope.kind == "repeat" else E.where(scope.count, E.ONE, E.ZERO)
            if kind == "sum":
                value = E.mul(value, there)
            else:
                none = E.const(math.inf if kind == "min" else -math.inf)
                value = E.where(E.call("lt", E.ZERO, there), value, none)
        scope = scope.parent
    return value


def _repeat_of(ev: Evaluator, argument: ast.Expr) -> Element:
    """The innermost repeat that a path in an argument runs through."""
    found = (_element_of(ev, node) for node in walk(argument))
    element = next((e for e in found if e is not None and not ev.inside(e)), None)
    if element is None:
        raise ev.env.context.internal(argument.span, "no path here runs through a repeat")
    return element


def _element_of(ev: Evaluator, node: ast.Node) -> Element | None:
    """The repeat that a path of names stands for."""
    value: Value | None = None
    match node, ev.env.context.meaning(node):
        case ast.NameExpr(), Declared() as meaning:
            value = ev.meant(meaning)
        case ast.MemberExpr(obj=obj), Inner(name):
            owner = _element_of(ev, obj)
            value = None if owner is None else owner.env.declared(name)
    return value if isinstance(value, Element) else None


FUNCTIONS: dict[str, Makes] = {
    "graph": _of_graph,
    "round": _rounded,
    "hypot": _hypotenuse,
    "least": least,
    "greatest": greatest,
    "reduce": reduction,
    "count": count,
    "lowest": lowest,
    "frame": frame,
    "line": line,
    "box": box,
}
"""What calls mean, by the ``meaning`` that the table of functions gives a form; rooms above add theirs (``Makers``)."""
