"""Frames on curved surfaces: ``body.wall.at(u, z = h)``."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import Expr, Scope
from ...graph.primitive import Patch, pair, triple
from ...graph.roots import lowest_root
from ...graph.substitution import substitute
from ...language import Form
from ...records import dataclass
from ...semantics.types import ANGLE, LENGTH
from ...syntax import ast
from ..expressions.builtins import bound
from ..expressions.context import Abort, where
from ..expressions.rows import has_row
from ..solve.guarded import lifted
from ..values.carry import mapped_pose, moved, whichever
from ..values.faces import frame_of
from ..values.kinds import Frame, Surface
from ..values.vectors import AXES, cross, normalized, unit
from .ranges import NEAR, ON, THERE, Legal, OnSurface, Quantity

if TYPE_CHECKING:
    from ..expressions.evaluate import Evaluator

_LOOKS = 8  # where a message looks for how far a curve that turns back goes: between its ends, at eighths
_BEYOND = "the place lies beyond the surface"
_WITHIN = "give u and v within the ranges that the primitive states for this surface"
_FROM_ORIGIN = (
    "`{}` is measured along the axis of the part itself, from its origin, which is the middle of most primitives"
)
_ELSEWHERE = "the primitive has it only where a condition holds: change its arguments, or name another surface"


def frame_on(ev: Evaluator, node: ast.CallExpr, form: Form) -> Frame:
    """The frame at (u, v) of a surface, or at u and a given coordinate: out = outward normal, up = z (x where the surface
    is square to z).

    Of several alternatives each is evaluated in the table of the statement, and the one that exists is taken; of several surfaces
    that a slot binds, the first on which the place lies.
    """
    assert isinstance(node.function, ast.MemberExpr)
    surface, arguments = ev.value(node.function.obj), bound(node, form)
    if not isinstance(surface, Surface):
        raise ev.env.context.error(
            "wrong-kind",
            node.function.name_span,
            f"`{node.function.obj.span.words}` binds no surface: `at` is a function of curved surfaces",
            hint="bind a surface to it, as in `slot face = body.wall`",
        )
    scope = ev.env.scope
    u = ev.scalar(arguments["u"])
    found: dict[Expr, list[_Place]] = {}  # by where they exist: alternatives of one another, or surfaces of one slot
    for _, part, outer, name in surface.branches:
        for instance in part.instances:
            patches = () if instance.solid is None else instance.solid.primitive.patches
            own = [p for p in patches if p.name == name]
            if not own or instance.solid is None:
                continue
            exists, patch = has_row(instance.scope, scope), own[0]
            _refuse_other_elements(ev, node, instance.scope)
            if len(own) > 1 or patch.count is not None or exists in found and "v" in arguments:
                raise _several(ev, node)
            mapping = {k: lifted(e, scope) for k, e in instance.solid.mapping(instance).items()}
            v = ev.scalar(arguments["v"]) if "v" in arguments else _solve_v(ev, node, arguments, patch, mapping, u)
            values: dict[Expr, Expr] = {**mapping, E.var("u"): u, E.var("v"): v}
            position = triple(substitute(c, values) for c in patch.position)
            du, dv = (triple(substitute(derive(c, name), values) for c in patch.position) for name in ("u", "v"))
            out = cross(du, dv)
            level = out[0] is E.ZERO and out[1] is E.ZERO
            frame = Frame(position, frame_of(normalized(out), unit(0 if level else 2)), (part,))
            pose = mapped_pose(outer, lambda e: lifted(e, scope))
            found.setdefault(exists, []).append(_Place(moved(frame, pose), patch, values))
    if not found:
        raise ev.env.context.internal(node.span, "none of the alternatives has this surface")
    for exists, places in found.items():
        _ask_whether_on(ev, node, arguments, places, exists)
    cases = [
        (exists if len(places) == 1 else E.both(exists, place.holds), place.frame)
        for exists, places in found.items()
        for place in places
    ]
    carriers = tuple(dict.fromkeys(p for _, f in cases for p in f.on))
    return moved(replace(whichever(cases), on=carriers), ev.pose)


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """A frame on a patch, whose formulas read ``values`` there."""

    frame: Frame
    patch: Patch
    values: dict[Expr, Expr]

    def inside_of(self, name: str) -> Expr:
        """How far u or v lies within its range; of one that comes back to where it was, whatever the number of turns."""
        value, (low, high) = self.values[E.var(name)], self.range_of(name)
        period = _period(self.patch.position, name)
        if period is None:
            return E.minimum(E.sub(value, low), E.sub(high, value))
        wide, past = E.sub(high, low), E.call("mod", E.add(E.sub(value, low), E.const(NEAR)), E.const(period))
        return E.maximum(E.sub(wide, E.const(period)), E.sub(wide, past))

    def range_of(self, name: str) -> tuple[Expr, Expr]:
        return pair(substitute(end, self.values) for end in (self.patch.u_range if name == "u" else self.patch.v_range))

    @property
    def holds(self) -> Expr:
        """Whether the place lies on the patch; one without a value does not."""
        return E.call("le", E.const(-NEAR), E.minimum(self.inside_of("u"), self.inside_of("v")))


def _refuse_other_elements(ev: Evaluator, node: ast.CallExpr, home: Scope) -> None:
    """The formulas of a surface are those of its own row: another element's are out of reach."""
    if any(s.kind == "repeat" and not ev.env.scope.within(s) for s in home.ancestors()):
        raise ev.env.context.error(
            "many-elements",
            node.span,
            "`at` reads surfaces in the same element of a repeat alone",
            hint="name the place in the repeat, `let spot = peg.side.at(...)`, and then `row[last].spot`",
        )


def _several(ev: Evaluator, node: ast.CallExpr) -> Abort:
    """Of several surfaces with one name, none is meant more than the others."""
    assert isinstance(node.function, ast.MemberExpr)
    return ev.env.context.error(
        "wrong-kind",
        node.span,
        f"`{node.function.obj.span.words}` is several surfaces, and `at` takes one",
        hint="name one of them, or a port or a face of the box; curves that make a surface may have names of their own",
    )


def _ask_whether_on(
    ev: Evaluator, node: ast.CallExpr, given: dict[str, ast.Expr], places: list[_Place], exists: Expr
) -> None:
    """Ask of every object that has the surface whether the place lies on it: beyond, the formulas give places off the solid."""
    context, scope = ev.env.context, ev.env.scope
    guard = E.all_of((exists, context.known, context.subject))

    def ask(value: Expr, legal: Legal, on: OnSurface) -> None:
        if not value.reads:  # in the formula of a label it is of every point
            context.ask(Quantity(on.told, scope, value, legal, where(node.span), guard, on))

    for place in places:
        if place.patch.guard is not None:
            there = E.where(substitute(place.patch.guard, place.values), E.ONE, E.ZERO)
            ask(there, THERE, OnSurface(node.span, "the surface is not there", _ELSEWHERE))
    axis = next((axis for axis in AXES if axis in given), None)
    if len(places) > 1:
        found = E.where(E.any_of(place.holds for place in places), E.ONE, E.ZERO)
        ask(found, THERE, OnSurface(node.span, _BEYOND, _FROM_ORIGIN.format(axis)))
        return
    (place,) = places
    for name in ("u", "v"):
        ends: tuple[Expr, ...] = place.range_of(name)
        value, word, remedy = place.values[E.var(name)], name, _WITHIN
        if axis is not None and name == "v":
            coordinate = place.patch.position[AXES.index(axis)]
            low, high = ends
            along = (E.add(low, E.mul(E.const(k / _LOOKS), E.sub(high, low))) for k in range(_LOOKS + 1))
            ends = tuple(substitute(coordinate, {**place.values, E.var("v"): v}) for v in along)
            value, word, remedy = ev.scalar(given[axis]), axis, _FROM_ORIGIN.format(axis)
        on = OnSurface(node.span, _BEYOND, remedy, word, value, ends, _unit(ev, given[word]))
        ask(place.inside_of(name), ON, on)


def _period(formulas: Iterable[Expr], name: str) -> float | None:
    """After how much of a parameter all formulas have the values that they had: they read it in sines and cosines alone, of angles
    that are whole multiples of it, or of it as a share of a turn."""
    factors: set[float] = set()
    stack, seen, reads = list(formulas), set[Expr](), E.var(name).reads
    while stack:
        node = stack.pop()
        if node in seen or not node.reads & reads:
            continue
        seen.add(node)
        factor = derive(node.args[0], name).constant if node.op in ("sin", "cos") else None
        if factor is not None:
            factors.add(float(factor))
        elif not node.args:
            return None
        else:
            stack += node.args
    return next((p for p in (2 * math.pi, 1.0) if all((f * p / (2 * math.pi)).is_integer() for f in factors)), None)


def _unit(ev: Evaluator, node: ast.Expr) -> str:
    """The unit in which a message shows a number."""
    kind = ev.env.context.typed.type_of(node)
    return "m" if kind == LENGTH else "rad" if kind == ANGLE else ""


def _solve_v(
    ev: Evaluator, node: ast.CallExpr, arguments: dict[str, ast.Expr], patch: Patch, mapping: dict[Expr, Expr], u: Expr
) -> Expr:
    """The lowest v of the surface at which a coordinate takes the given value; where it never does, any."""
    axis = next((a for a in AXES if a in arguments), None)
    if axis is None:
        raise ev.env.context.internal(node.span, "neither v nor a coordinate is given")
    values = {**mapping, E.var("u"): u}
    coordinate = substitute(patch.position[AXES.index(axis)], values)
    ends = pair(substitute(end, values) for end in patch.v_range)
    found = lowest_root(coordinate, "v", ends, ev.scalar(arguments[axis]))
    if found is None:
        raise ev.env.context.error(
            "not-solvable", node.span, f"u and v cannot be found from {axis} on this surface", hint="give u and v"
        )
    return found
