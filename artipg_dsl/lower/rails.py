"""Places beside a path in a plane: the foot of a point on it, and how far what goes along it reaches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..graph import expr as E
from ..graph.derive import derive
from ..graph.expr import ONE, ZERO, Expr
from ..graph.primitive import Triple
from ..syntax import ast
from .curves import TURN, Curve
from .env import Env
from .made import clause
from .paths import Handed, Stretch
from .probe import Probe
from .profiles import FINE, STEPS, V, clamp, halved, onwards, summit
from .vectors import cross, dot, minus, plus, times

P: Triple = tuple(E.var(f"p.{a}") for a in "xyz")  # type: ignore[assignment]
Across = Callable[[float | Expr], Triple]  # the vector beside the path at v


def path_of(env: Env, solid: ast.SolidDecl) -> Curve | Handed:
    """The path that follows ``along``; raises Abort after a diagnostic where there is none."""
    node = clause(solid, "along")
    path = env.find(node.name) if isinstance(node, ast.NameExpr) else None
    if node is not None and isinstance(path, Curve | Handed):
        return path
    raise env.context.error(
        "wrong-kind", solid.span if node is None else node.span, f"`{solid.operator}` needs a path",
        hint="sweep(circle(r)) along path up y",
    )  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Foot:
    """Where p lies by a stretch: beside its foot ``v`` by ``x`` and ``y``; how far ``before`` its start or ``after`` its
    end; ``start`` and ``end``, the distances beyond the planes there; ``away``, from the axis of an arc.
    """

    v: Expr
    x: Expr
    y: Expr
    before: Expr
    after: Expr
    start: Expr
    end: Expr
    away: Expr = ZERO


def foot(probe: Probe, rail: Stretch, side: Across, up: Triple) -> Foot:
    """The nearest place of a stretch that lies in a plane across ``up``."""
    if rail.center is not None and rail.out is not None:
        return foot_on_arc(rail, up)
    if rail.length is not ZERO:
        from_start = minus(P, rail.at(0.0))
        along = dot(from_start, rail.direction)
        before, after = E.neg(along), E.sub(along, rail.length)
        v = clamp(E.div(along, rail.length), 0.0, 1.0)
        return Foot(v, dot(from_start, side(0.0)), dot(from_start, up), before, after, before, after)
    _, v = nearest(probe, rail)
    away = minus(P, tuple(E.substitute(c, {V: v}) for c in rail.place))  # type: ignore[arg-type]
    before = dot(minus(rail.at(0.0), P), rail.towards(0.0))
    after = dot(minus(P, rail.at(1.0)), rail.towards(1.0))
    return Foot(v, dot(away, side(v)), dot(away, up), before, after, before, after)


def about_arc(rail: Stretch) -> tuple[Expr, Expr, Expr]:
    """The angle of p about an arc's axis from the middle of the arc, its distance from that axis, half the arc."""
    assert rail.center is not None and rail.out is not None
    along, half = rail.towards(0.0), E.mul(rail.angle, E.const(0.5))
    c, s = E.call("cos", half), E.call("sin", half)
    away = minus(P, rail.center)
    a = dot(away, plus(times(rail.out, c), times(along, s)))
    b = dot(away, minus(times(along, c), times(rail.out, s)))
    return E.call("atan2", b, a), E.call("hypot", a, b), half


def cap(turned: Expr, away: Expr) -> Expr:
    """The distance beyond a half plane through an axis, for an angle counted away from what lies behind it."""
    return E.mul(away, E.call("sin", clamp(turned, -TURN / 4, TURN / 4)))


def foot_on_arc(rail: Stretch, up: Triple) -> Foot:
    """The angle of p is cut to the arc; the distances beyond its ends are measured about its axis."""
    assert rail.center is not None and rail.out is not None
    angle, away, half = about_arc(rail)
    turned = E.minimum(E.maximum(angle, E.neg(half)), half)
    beyond = E.sub(angle, turned)
    outward = E.sub(E.mul(away, E.call("cos", beyond)), rail.radius)
    inward = dot(cross(up, rail.towards(0.0)), rail.out)  # 1 where the side points away from the axis, else -1
    gap = E.mul(away, E.call("sin", clamp(beyond, -TURN / 4, TURN / 4)))
    start, end = cap(E.neg(E.add(angle, half)), away), cap(E.sub(angle, half), away)
    back = E.mul(beyond, E.div(E.const(0.5), E.sub(E.const(TURN / 2), half)))  # so that it is one behind the axis
    v = E.sub(E.div(E.add(turned, half), rail.angle), back)
    x, y = E.mul(inward, outward), dot(minus(P, rail.center), up)
    return Foot(v, x, y, E.neg(gap), gap, start, end, away)


def nearest(probe: Probe, rail: Stretch) -> tuple[Expr, Expr]:
    """Squared distance of p to the path of a formula, and its parameter there, by Newton's method in brackets."""
    speed: Triple = tuple(derive(c, "v") for c in rail.place)  # type: ignore[assignment]
    bend: Triple = tuple(derive(c, "v") for c in speed)  # type: ignore[assignment]
    best: tuple[Expr, Expr] | None = None
    for low, high in brackets(probe, rail):
        t: Expr = E.const((low + high) / 2)
        for turn in range(STEPS + 1):
            here, tangent, curved = (
                tuple(E.substitute(c, {V: t}) for c in vector) for vector in (rail.place, speed, bend)
            )
            away = minus(P, here)  # type: ignore[arg-type]
            move = onwards(dot(away, tangent), dot(tangent, tangent), dot(away, curved), turn)
            moved = clamp(E.add(t, move), low, high)
            if turn == STEPS:
                away = minus(away, times(tangent, E.sub(moved, t)))  # type: ignore[arg-type]
            t = moved
        square = dot(away, away)
        if best is None:
            best = square, t
        else:
            best = E.minimum(best[0], square), E.where(E.call("lt", square, best[0]), t, best[1])
    assert best is not None
    return best


def brackets(probe: Probe, rail: Stretch) -> list[tuple[float, float]]:
    """A formula's path cut so that it turns by little in each bracket."""
    places = [rail.towards(k / FINE) for k in range(FINE + 1)]
    seen = np.nan_to_num(probe(*(c for d in places for c in d)).reshape(FINE + 1, 3, -1))
    cosine = (seen[1:] * seen[:-1]).sum(axis=1)
    return halved(np.arccos(np.clip(cosine, -1.0, 1.0)).T, np.radians(25.0))


def reach(
    probe: Probe, rails: list[tuple[Stretch, Across]], wide: Sequence[Sequence[Expr]], axis: int, sign: int
) -> Expr:
    """The greatest (``sign`` 1) or least (-1) coordinate of lines beside stretches, at distances that change from
    ``wide[k][0]`` to ``wide[k][1]``.
    """
    factor = E.const(float(sign))
    found: list[Expr] = []
    for (rail, side), (low, high) in zip(rails, wide, strict=True):
        beside = E.add(low, E.mul(V, E.sub(high, low)))
        height = E.mul(factor, E.add(rail.place[axis], E.mul(side(V)[axis], beside)))
        found += [E.substitute(height, {V: end}) for end in (ZERO, ONE)]
        if rail.center is None and rail.length is not ZERO:
            continue
        values = probe(*(E.substitute(height, {V: E.const(k / 32)}) for k in range(33)))
        if (values.max(axis=0) > np.maximum(values[0], values[-1]) + 1e-12).any():
            found.append(E.substitute(height, {V: summit(height)}))
    greatest = probe.greatest(found)
    return greatest if sign > 0 else E.neg(greatest)
