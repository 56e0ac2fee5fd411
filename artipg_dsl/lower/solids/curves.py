"""Curves: what the name of a curve means, and the curves that the language brings along.

A curve of a primitive is a formula over its parameter or one of ``circle``, ``rectangle``, ``polygon``; ``offset``
moves a curve sideways. A path in space is a chain of lines and arcs (see ``paths``) or a formula.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import pair
from ...graph.substitution import substitute
from ...language import Form
from ...semantics.types import CURVE
from ...syntax import ast
from ..expressions.builtins import bound
from ..expressions.env import Env, Function, Thunk
from ..expressions.evaluate import Evaluator
from ..values.handed import Handed
from ..values.kinds import Value, Vec
from .profiles import Point, Span, V, between, right_of

if TYPE_CHECKING:
    from ...source import Span as Place

TURN = 6.283185307179586


class Curve(Function):
    """``curve skin (v in 0 .. 1) = [radius, height]``, or a chain; where it has a parameter it can be called."""

    __slots__ = ("statement", "handed")

    def __init__(self, statement: ast.CurveDecl | ast.LetDecl, env: Env):
        parameters = (statement.parameter,) if isinstance(statement, ast.CurveDecl) else ()
        super().__init__(statement.name, parameters, statement.value, env)
        self.statement = statement
        self.handed: dict[str, Handed] = {}  # by the parameter that it is the value of

    def ends(self) -> tuple[Expr, Expr]:
        """The ends of the parameter's range; 0 and 1 for a chain, which has none."""
        if not isinstance(self.statement, ast.CurveDecl):
            return ZERO, ONE
        ev, interval = Evaluator(self.env), self.statement.parameter_range
        return ev.scalar(interval.low), ev.scalar(interval.high)

    def point(self, ev: Evaluator | None = None) -> tuple[Expr, ...]:
        """The place at the parameter ``v``, of two or three coordinates."""
        ev = Evaluator(self.env, {p: V for p in self.parameters})
        value = ev.value(self.value)
        if isinstance(value, Vec):
            return value.items
        raise ev.impossible(self.value.span, "a point", value)


def let(env: Env, statement: ast.LetDecl | ast.CurveDecl) -> Function | Thunk:
    """What a ``let`` or a ``curve`` declares: a function, a curve, or a value that is found when it is first read."""
    value = statement.value
    if isinstance(statement, ast.LetDecl) and statement.parameters:
        return Function(statement.name, statement.parameters, value, env)
    made = env.context.form(value) is not None and env.context.typed.type_of(value) == CURVE
    if made or isinstance(statement, ast.CurveDecl) or isinstance(value, ast.ChainExpr):
        return Curve(statement, env)
    return Thunk(partial(Evaluator(env).value, value), statement.name_span, by_reader=True)


def offset(ev: Evaluator, node: ast.CallExpr, form: Form) -> Vec:
    """``offset(skin(v), d)``: the place at distance d to the right of the curve (outwards where it runs upwards)."""
    given = bound(node, form)
    call, distance = given["curve"], ev.scalar(given["distance"])
    curve, at = None, V
    if isinstance(call, ast.CallExpr) and isinstance(call.function, ast.NameExpr) and len(call.arguments) == 1:
        curve, at = named_curve(ev, call.function), ev.scalar(call.arguments[0].value)
    elif isinstance(call, ast.NameExpr):
        curve = named_curve(ev, call)
    if not isinstance(curve, Curve) or len(curve.parameters) != 1:
        raise ev.env.context.error(
            "wrong-kind",
            call.span,
            "`offset` needs a curve at a value of its parameter",
            hint="for example `offset(skin(v), -2mm)`",
        )
    point = plane(ev, curve.point(), call.span)
    normal = right_of((derive(point[0], "v"), derive(point[1], "v")), ONE)
    moved = (E.add(p, E.mul(distance, n)) for p, n in zip(point, normal, strict=True))
    return Vec(tuple(substitute(c, {V: at}) for c in moved))


def named_curve(ev: Evaluator, node: ast.Expr | None) -> Value | None:
    """The curve, or path that a use hands in, that a name stands for; None for what is neither."""
    found = None if node is None else ev.meant(ev.env.context.meaning(node))
    return found if isinstance(found, Curve | Handed) else None


def spans_of(ev: Evaluator, node: ast.Expr) -> list[Span]:
    """The curves in a plane that an argument of an operator names: one, a list of them, or a constructor's."""
    if isinstance(node, ast.VectorExpr):
        return [span for item in node.items for span in spans_of(ev, item)]
    if isinstance(node, ast.NameExpr):
        curve = named_curve(ev, node)
        if isinstance(curve, Curve):
            if curve.parameters:
                return [Span(curve.name, plane(ev, curve.point(), node.span), *curve.ends())]
            return [Span(curve.name, s.position, s.low, s.high) for s in spans_of(Evaluator(curve.env), curve.value)]
    form = ev.env.context.form(node)
    if form is not None and form.kind == "curve" and isinstance(node, ast.CallExpr):
        return OUTLINES[form.meaning](ev, node, form)
    raise ev.env.context.error(
        "wrong-kind",
        node.span,
        "a curve is needed here",
        hint="name a curve of this primitive, a list of them, or write circle(...), rectangle(...), polygon(...)",
    )


def plane(ev: Evaluator, point: tuple[Expr, ...], place: Place) -> Point:
    if len(point) != 2:
        raise ev.env.context.error(
            "wrong-kind",
            place,
            "a curve in a plane is needed here, but this one lies in space",
            hint="let the curve have two components: `curve f (v in 0 .. 1) = [a, b]`",
        )
    return point


def offset_spans(ev: Evaluator, node: ast.CallExpr, form: Form) -> list[Span]:
    value = offset(Evaluator(ev.env, ev.local), node, form)
    first = node.arguments[0].value
    curve = named_curve(ev, first.function if isinstance(first, ast.CallExpr) else first)
    assert isinstance(curve, Curve)
    return [Span(f"{curve.name}_offset", pair(value.items), *curve.ends())]


def circle(ev: Evaluator, node: ast.CallExpr, form: Form) -> list[Span]:
    radius = ev.scalar(bound(node, form)["radius"])
    return [Span("skin", (E.mul(radius, E.call("cos", V)), E.mul(radius, E.call("sin", V))), ZERO, E.const(TURN))]


def rectangle(ev: Evaluator, node: ast.CallExpr, form: Form) -> list[Span]:
    given = bound(node, form)
    a, b = (E.mul(ev.scalar(given[k]), E.const(0.5)) for k in ("width", "height"))
    corners = [(E.neg(a), E.neg(b)), (a, E.neg(b)), (a, b), (E.neg(a), b)]
    return closed("skin", corners)


def polygon(ev: Evaluator, node: ast.CallExpr, form: Form) -> list[Span]:
    corners: list[Point] = []
    for argument in node.arguments:
        value = ev.value(argument.value)
        if not isinstance(value, Vec) or len(value.items) != 2:
            raise ev.impossible(argument.span, "a corner [a, b]", value)
        corners.append(value.items)
    return closed("skin", corners)


def closed(name: str, corners: list[Point]) -> list[Span]:
    ends = zip(corners, [*corners[1:], corners[0]], strict=True)
    return [Span(name, between(name, a, b).position) for a, b in ends]


OUTLINES = {"circle": circle, "rectangle": rectangle, "polygon": polygon, "offset": offset_spans}
"""Closed and moved curves, by the ``meaning`` of their forms."""
