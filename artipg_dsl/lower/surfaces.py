"""Frames on curved surfaces: ``body.wall.at(u, z = h)``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..graph import expr as E
from ..graph.derive import derive
from ..graph.expr import Expr
from ..graph.linear import Linear, isolate
from ..syntax import ast
from .builtins import named
from .values import (
    AXES,
    HERE,
    Frame,
    Value,
    compose,
    cross,
    frame_of,
    merged,
    moved,
    normalized,
    unit,
)

if TYPE_CHECKING:
    from .evaluate import Evaluator, Surface


def frame_on(ev: Evaluator, surface: Surface, node: ast.CallExpr) -> Frame:
    """The frame at (u, v) of a surface, or at u and a given coordinate: out = outward normal, up = z."""
    arguments = named(node, "u", "v")
    part, outer = surface.ref.branches[0].members[0]
    found: list[tuple] = []
    for instance in part.instances:
        if instance.solid is None:
            continue
        primitive = instance.solid.primitive
        patch = next((p for p in primitive.patches if p.name == surface.name), None)
        if patch is None:
            continue
        mapping = instance.solid.mapping(instance)
        values: dict[Expr, Expr] = dict(mapping)
        u = ev.scalar(arguments["u"])
        if "v" in arguments:
            v = ev.scalar(arguments["v"])
        else:
            v = solve_v(ev, node, arguments, patch, mapping, u)
        values[E.var("u")], values[E.var("v")] = u, v
        position = tuple(E.substitute(c, values) for c in patch.position)
        du, dv = (
            tuple(E.substitute(derive(c, name), values) for c in patch.position) for name in ("u", "v")
        )
        out = normalized(cross(du, dv))
        frame = Frame(position, frame_of(out, unit(2)), (part,))  # type: ignore[arg-type]
        found.append((instance.scope, frame))
    if not found:
        raise ev.env.context.error("unknown-member", node.span, f"`{part.name}` has no surface `{surface.name}`")
    value: Value = found[0][1] if len(found) == 1 and found[0][0] is part.env.scope else merged(part.env.scope, found)
    return moved(value, compose(outer, part.pose) if outer is not HERE else part.pose)  # type: ignore[return-value]


def solve_v(ev: Evaluator, node: ast.CallExpr, arguments: dict, patch, mapping: dict, u: Expr) -> Expr:  # noqa: ANN001
    """The v at which a coordinate of the surface takes the given value."""
    axis = next((a for a in AXES if a in arguments), None)
    if axis is None:
        raise ev.env.context.error("wrong-arguments", node.span, "`at` takes u and v, or u and one coordinate (z = ...)")
    coordinate = E.substitute(patch.position[AXES.index(axis)], {**mapping, E.var("u"): u})
    from ..graph.expr import Column, Scope

    marker = Column(coordinate.scope or Scope("surface"), "v")
    target = E.col(marker)
    linear = Linear(lambda c: c is marker, {})
    found = isolate(E.substitute(coordinate, {E.var("v"): target}), marker, ev.scalar(arguments[axis]), linear)
    if found is None:
        raise ev.env.context.error(
            "not-solvable", node.span, f"this surface cannot be solved for the place where {axis} has a value", hint="give u and v",
        )  # fmt: skip
    return found
