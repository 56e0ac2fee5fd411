"""Frames on curved surfaces: ``body.wall.at(u, z = h)``."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import Column, Expr, Scope
from ...graph.linear import Linear, isolate
from ...graph.primitive import Patch, triple
from ...graph.substitution import substitute
from ...language import Form
from ...syntax import ast
from ..expressions.builtins import bound
from ..solve.solve import lifted
from ..values.carry import mapped_pose, moved, whichever
from ..values.faces import frame_of
from ..values.kinds import Frame, Surface
from ..values.vectors import AXES, cross, normalized, unit
from .guards import has_row

if TYPE_CHECKING:
    from ..expressions.evaluate import Evaluator


def frame_on(ev: Evaluator, node: ast.CallExpr, form: Form) -> Frame:
    """The frame at (u, v) of a surface, or at u and a given coordinate: out = outward normal, up = z (x where the surface
    is square to z).

    Of several alternatives each is evaluated in the table of the statement, and the one that exists is taken.
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
    found: list[tuple[Expr, Frame]] = []
    for _, part, outer, name in surface.branches:
        for instance in part.instances:
            patches = () if instance.solid is None else instance.solid.primitive.patches
            patch = next((p for p in patches if p.name == name), None)
            if patch is None or instance.solid is None:
                continue
            _refuse_other_elements(ev, node, instance.scope)
            mapping = {k: lifted(e, scope) for k, e in instance.solid.mapping(instance).items()}
            v = ev.scalar(arguments["v"]) if "v" in arguments else _solve_v(ev, node, arguments, patch, mapping, u)
            values: dict[Expr, Expr] = {**mapping, E.var("u"): u, E.var("v"): v}
            position = triple(substitute(c, values) for c in patch.position)
            du, dv = (triple(substitute(derive(c, name), values) for c in patch.position) for name in ("u", "v"))
            out = cross(du, dv)
            level = out[0] is E.ZERO and out[1] is E.ZERO
            frame = Frame(position, frame_of(normalized(out), unit(0 if level else 2)), (part,))
            pose = mapped_pose(outer, lambda e: lifted(e, scope))
            found.append((has_row(instance.scope, scope), moved(frame, pose)))
    if not found:
        raise ev.env.context.internal(node.span, "none of the alternatives has this surface")
    carriers = tuple(dict.fromkeys(p for _, f in found for p in f.on))
    return moved(replace(whichever(found), on=carriers), ev.pose)


def _refuse_other_elements(ev: Evaluator, node: ast.CallExpr, home: Scope) -> None:
    """The formulas of a surface are those of its own row: another element's are out of reach."""
    if any(s.kind == "repeat" and not ev.env.scope.within(s) for s in home.ancestors()):
        raise ev.env.context.error(
            "many-elements",
            node.span,
            "`at` reads surfaces in the same element of a repeat alone",
            hint="name the place in the repeat, `let spot = peg.side.at(...)`, and then `row[last].spot`",
        )


def _solve_v(
    ev: Evaluator, node: ast.CallExpr, arguments: dict[str, ast.Expr], patch: Patch, mapping: dict[Expr, Expr], u: Expr
) -> Expr:
    """The v at which a coordinate of the surface takes the given value."""
    axis = next((a for a in AXES if a in arguments), None)
    if axis is None:
        raise ev.env.context.internal(node.span, "neither v nor a coordinate is given")
    coordinate = substitute(patch.position[AXES.index(axis)], {**mapping, E.var("u"): u})
    marker = Column(coordinate.scope or Scope("surface"), "v")
    target = E.col(marker)
    linear = Linear(lambda c: c is marker, {})
    found = isolate(substitute(coordinate, {E.var("v"): target}), marker, ev.scalar(arguments[axis]), linear)
    if found is None:
        raise ev.env.context.error(
            "not-solvable", node.span, f"u and v cannot be found from {axis} on this surface", hint="give u and v"
        )
    return found
