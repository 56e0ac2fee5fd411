"""Places beside a path in a plane: the foot of a point on it, and how far what goes along it reaches."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import ZERO, Expr
from ...graph.primitive import Triple, triple
from ...graph.substitution import substitute
from ...records import dataclass
from ...syntax import ast
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.faces import frame_of
from ..values.handed import Handed
from ..values.kinds import Frame, Value
from ..values.vectors import cross, dot, minus, plus, times
from .curves import TURN, Curve, named_curve
from .cuts import FINE, Cut, clamp, halved, starts, within
from .paths import MOST_STEPS, Stretch, angles, windows
from .probe import Probe
from .profiles import SLOW, V, onwards, steps, summits

_BEND = np.radians(25.0)  # how far a path turns within a cut
_STEPS = 4  # of Newton's method, after a slow one
NEAR = E.const(0.1)  # of the width of a section: further off, the distance to the path tells how far it is

P: Triple = triple(E.var(f"p.{a}") for a in "xyz")
Across = Callable[[float | Expr], Triple]  # the vector beside the path at v
_MOST_TURNS = 64  # of a path: each is searched for how far it reaches


def path_of(env: Env, solid: ast.SolidDecl) -> Curve | Handed:
    """The path that follows ``along``; raises Abort after a diagnostic where there is none."""
    assert solid.along is not None
    path = named_curve(Evaluator(env), solid.along.value)
    if isinstance(path, Curve | Handed):
        return path
    hint = "sweep(circle(r)) along path up y"
    raise env.context.error("wrong-kind", solid.along.value.span, f"`{solid.operator}` needs a path", hint=hint)


@dataclass(frozen=True, slots=True, eq=False)
class Foot:
    """Where p lies by a stretch: beside its foot ``v`` by ``x`` and ``y``; how far ``before`` its start or ``after`` its
    end; ``start`` and ``end``, the distances beyond the planes there; ``away``, from the axis of an arc; ``gap``, from the
    path of a formula.
    """

    v: Expr
    x: Expr
    y: Expr
    before: Expr
    after: Expr
    start: Expr
    end: Expr
    away: Expr = ZERO
    gap: Expr = ZERO


def foot(probe: Probe, rail: Stretch, side: Across, up: Across, wide: Expr) -> Foot:
    """The nearest place of a stretch, across which a section stands along ``side`` and ``up`` and reaches ``wide``."""
    if rail.center is not None and rail.out is not None:
        return _foot_on_arc(rail, side, up)
    if rail.length is not ZERO:
        from_start = minus(P, rail.at(0.0))
        along = dot(from_start, rail.direction)
        before, after = E.neg(along), E.sub(along, rail.length)
        v = clamp(E.div(along, rail.length), 0.0, 1.0)
        return Foot(v, dot(from_start, side(0.0)), dot(from_start, up(0.0)), before, after, before, after)
    square, v = nearest(probe, rail)
    away = minus(P, triple(substitute(c, {V: v}) for c in rail.place))
    before, after = (disc(rail, v, end, wide) for end in (0.0, 1.0))
    gap = E.call("sqrt", square)
    return Foot(v, dot(away, side(v)), dot(away, up(v)), before, after, before, after, gap=gap)


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


def _foot_on_arc(rail: Stretch, side: Across, up: Across) -> Foot:
    """The angle of p is cut to the arc; the distances beyond its ends are measured about its axis."""
    assert rail.center is not None and rail.out is not None
    angle, away, half = about_arc(rail)
    turned = E.minimum(E.maximum(angle, E.neg(half)), half)
    beyond = E.sub(angle, turned)
    outward = E.sub(E.mul(away, E.call("cos", beyond)), rail.radius)
    axis = cross(rail.out, rail.towards(0.0))
    high = dot(minus(P, rail.center), axis)
    gap = E.mul(away, E.call("sin", clamp(beyond, -TURN / 4, TURN / 4)))
    start, end = cap(E.neg(E.add(angle, half)), away), cap(E.sub(angle, half), away)
    back = E.mul(beyond, E.div(E.const(0.5), E.sub(E.const(TURN / 2), half)))  # so that it is one behind the axis
    v = E.sub(E.div(E.add(turned, half), rail.angle), back)
    x, y = (
        E.add(E.mul(dot(across(0.0), rail.out), outward), E.mul(dot(across(0.0), axis), high)) for across in (side, up)
    )
    return Foot(v, x, y, E.neg(gap), gap, start, end, away)


def disc(rail: Stretch, v: Expr, end: float, radius: Expr) -> Expr:
    """How far p, nearest to the path of a formula at v, lies beyond the disc that closes it; negative before it.

    A path may wind back to the plane of its end, so the disc alone tells, not the plane.
    """
    away = minus(P, rail.at(end))
    along = dot(away, rail.towards(end))
    beyond = along if end else E.neg(along)
    aside = E.call("sqrt", E.maximum(E.sub(dot(away, away), E.mul(along, along)), ZERO))
    before = E.neg(E.call("hypot", along, E.maximum(E.sub(aside, radius), ZERO)))
    here = E.both(E.call("le", E.const(1.0), v) if end else E.call("le", v, ZERO), E.call("lt", ZERO, beyond))
    return E.where(here, beyond, before)


_BROKEN = "a path must be continuous everywhere: narrow the ranges of its formula"
_STEEP = (
    "it stands still there, or is infinitely steep, as `sqrt(t)` at 0: begin beside that place, or use another formula"
)
_WHERE = {0: "at its beginning", 4: "in its middle", 8: "at its end"}  # by eighths of the parameter


def check_directions(env: Env, probe: Probe, solid: ast.SolidDecl, rails: list[Stretch]) -> None:
    """Raises Abort after a diagnostic where a path stands still, has no value or winds without end at some test values."""
    seen = probe(*(c for rail in rails for k in range(9) for v in (rail.at(k / 8), rail.towards(k / 8)) for c in v))
    lost = np.flatnonzero(~np.isfinite(seen).reshape(len(seen), -1).all(axis=1))
    if len(lost):
        k, which = divmod(int(lost[0]) % 54, 6)
        raise env.context.error(
            "bad-curve",
            solid.span,
            f"the path has no {'place' if which < 3 else 'direction'} {_WHERE.get(k, f'at {k}/8 of its parameter')}, "
            "at some of the test values",
            hint=_BROKEN if which < 3 else _STEEP,
        )
    turns = max(windows(probe, rail) for rail in rails)
    if turns > _MOST_TURNS:
        raise env.context.error(
            "bad-curve",
            solid.span,
            f"the path makes {turns} turns at some of the test values; a solid can follow at most {_MOST_TURNS}",
            hint="use fewer turns, and repeat the part: `repeat coil[k] ...`",
        )


def ports_of(rails: list[Stretch], first: Across, last: Across) -> dict[str, Value]:
    """The frames at the ends of what goes along a path, ``out`` away from it."""
    start, end = times(rails[0].towards(0.0), E.const(-1.0)), rails[-1].towards(1.0)
    return {
        "start": Frame(rails[0].at(0.0), frame_of(start, first(0.0))),
        "end": Frame(rails[-1].at(1.0), frame_of(end, last(1.0))),
    }


def nearest(probe: Probe, rail: Stretch) -> tuple[Expr, Expr]:
    """Squared distance of p to the path of a formula, and its parameter there, by Newton's method from the nearest cuts; or at an
    end, which may be nearer than a foot in its own cut.
    """
    speed: Triple = triple(derive(c, "v") for c in rail.place)
    bend: Triple = triple(derive(c, "v") for c in speed)

    def moved(t: Expr, turn: int) -> tuple[Triple, Triple, Expr]:
        here, tangent, curved = (triple(substitute(c, {V: t}) for c in vector) for vector in (rail.place, speed, bend))
        away = minus(P, here)
        move = onwards(dot(away, tangent), dot(tangent, tangent), dot(away, curved), turn)
        return away, tangent, move

    found = []
    for begin in starts(P, rail.place, _cuts(probe, rail), 2):
        t = begin.v
        for turn in range(SLOW - 1, SLOW + _STEPS):
            away, tangent, move = moved(t, turn)
            after = within(E.add(t, move), begin.low, begin.high)
            if turn == SLOW + _STEPS - 1:
                away = minus(away, times(tangent, E.sub(after, t)))
            t = after
        found.append((dot(away, away), t))
    for end in (0.0, 1.0):
        away = minus(P, rail.at(end))
        found.append((dot(away, away), E.const(end)))
    square, v = found[0]
    for other, there in found[1:]:
        v = E.where(E.call("lt", other, square), there, v)
        square = E.minimum(square, other)
    return square, v


def _cuts(probe: Probe, rail: Stretch) -> list[Cut]:
    """A formula's path cut so that it turns by little in each cut."""
    fine = FINE
    while True:
        turns = angles(probe, rail, fine).T
        if fine >= MOST_STEPS or turns.max() <= _BEND / 2 and 4 * windows(probe, rail) <= fine:
            return halved(turns, _BEND)
        fine *= 2


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
        place = E.mul(factor, rail.place[axis])
        height = E.add(place, E.mul(E.mul(factor, side(V)[axis]), beside))
        if rail.center is None and rail.length is not ZERO:
            spots = steps(1)
        else:  # a line at one distance from the path is highest where the path is: both run in the same direction there
            turns = windows(probe, rail)
            spots = [*steps(turns), *summits(probe, place if low is high else height, turns)]
        found += [substitute(height, {V: v}) for v in spots]
    greatest = probe.greatest(found)
    return greatest if sign > 0 else E.neg(greatest)
