"""How a section stands across its path: two unit vectors for each place of it, which agree where pieces meet.

With ``up`` the second of them is as near to it as it can be. Where ``up`` is left out and z will not do, or the path runs
along it somewhere, the section turns about its path no more than it must: along lines not at all, along an arc with the arc,
along a formula by reflecting it from one place to the next (Wang and others, "Computation of rotation minimizing frames").
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import Triple, triple
from ...graph.substitution import substitute_all
from ...records import dataclass
from ..values.vectors import cross, dot, minus, normalized, plus, times, unit
from .paths import Stretch, turned
from .probe import Probe
from .profiles import V

Vector = Callable[[float | Expr], Triple]
ALONG = 0.05  # the sine of the least angle between a path and what is `up`
ROOM = E.const(0.95)  # of a radius of curvature may be filled along a formula: it is taken at some places only
PLACES = 32  # steps at which a formula's speed and curvature are taken
BETWEEN = np.radians(20.0)  # how far a path turns from one reflection to the next


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """``side`` and ``up`` across a stretch at v; ``plain`` where ``up`` is one direction all along, square to the path."""

    side: Vector
    up: Vector
    plain: bool = False


def frames(probe: Probe, rails: list[Stretch], up: Triple | None) -> list[Frames]:
    """One per stretch."""
    for wanted in (up or unit(2), *(unit(k) for k in range(3))):
        if probe.zero(*(dot(wanted, rail.towards(k / 8)) for rail in rails for k in range(9))):
            return [Frames(at(cross(wanted, rail.direction)), at(wanted), plain=True) for rail in rails]
        if up is not None:
            break
    wanted = up or unit(2)
    if least(probe, rails, wanted) > ALONG and all(rail.center is None for rail in rails):
        sides = [normalized(cross(wanted, rail.direction)) for rail in rails]
        return [Frames(at(s), at(cross(rail.direction, s))) for s, rail in zip(sides, rails, strict=True)]
    start = rails[0].towards(0.0)
    if sine(probe, start, wanted).min() <= ALONG:
        wanted = max((unit(k) for k in range(3)), key=lambda axis: float(sine(probe, start, axis).min()))
    side = normalized(cross(wanted, start))
    found = []
    for rail in rails:
        found.append(carried(probe, rail, side))
        side = found[-1].side(1.0)
    return found


def at(vector: Triple) -> Vector:
    """A vector along a path as a function of v."""
    known: dict[Expr, Triple] = {}

    def there(v: float | Expr) -> Triple:
        place = E.wrap(v)
        if place not in known:
            known[place] = triple(substitute_all(vector, {V: place}))
        return known[place]

    return there


def sine(probe: Probe, direction: Triple, axis: Triple) -> np.ndarray:
    return np.nan_to_num(np.sqrt((probe(*cross(axis, direction)) ** 2).sum(axis=0)))


def least(probe: Probe, rails: list[Stretch], axis: Triple) -> float:
    """The sine of the least angle between a path and an axis."""
    across = (probe.along(cross(axis, rail.direction), [k / 64 for k in range(65)], V) for rail in rails)
    return float(min(np.nan_to_num(np.sqrt((seen**2).sum(axis=1))).min() for seen in across))


def carried(probe: Probe, rail: Stretch, side: Triple) -> Frames:
    """The frames along a stretch that begin with ``side`` and turn about the path nowhere."""
    start = rail.towards(0.0)
    if rail.center is not None and rail.out is not None:
        axis = cross(rail.out, start)
        flat, high = probe.tidy(dot(side, rail.out)), probe.tidy(dot(side, axis))
        out = cross(rail.direction, axis)
        across = plus(times(out, flat), times(axis, high))
        return Frames(at(across), at(cross(rail.direction, across)))
    if rail.length is not ZERO:
        return Frames(at(side), at(cross(start, side)))
    count = steps(probe, rail)
    held = [side]
    for k in range(count - 1):
        held.append(_reflected(rail, E.const(k / count), E.const((k + 1) / count), held[-1]))
    before = E.call("floor", E.mul(V, E.const(float(count))))
    before = E.minimum(E.maximum(before, ZERO), E.const(count - 1.0))
    last = held[-1]
    for k in range(count - 1, 0, -1):
        here = E.call("lt", before, E.const(float(k)))
        last = triple(E.where(here, a, b) for a, b in zip(held[k - 1], last, strict=True))
    across = _reflected(rail, E.mul(before, E.const(1.0 / count)), V, last)
    return Frames(at(across), at(cross(rail.direction, across)))


def steps(probe: Probe, rail: Stretch) -> int:
    """How many reflections a formula's path needs."""
    return int(np.clip(np.ceil(turned(probe, rail) / BETWEEN), 1, 256))


def _reflected(rail: Stretch, low: Expr, high: Expr, side: Triple) -> Triple:
    """``side`` at the place ``low`` of a path brought to ``high``: by two reflections, which keep it square to the path."""
    (here, there), (start, end) = (tuple(at(vector)(v) for v in (low, high)) for vector in (rail.place, rail.direction))
    first = minus(there, here)
    mirrored = [mirror(first, vector) for vector in (side, start)]
    moved = mirror(minus(end, mirrored[1]), mirrored[0])
    same = E.call("lt", dot(first, first), E.const(1e-18))  # no direction is left of a nanometre
    return triple(E.where(same, a, b) for a, b in zip(side, moved, strict=True))


def mirror(normal: Triple, vector: Triple) -> Triple:
    square = E.maximum(dot(normal, normal), E.const(1e-30))
    return minus(vector, times(normal, E.div(E.mul(E.const(2.0), dot(normal, vector)), square)))


def turning(rail: Stretch, made: Frames) -> Expr:
    """The most that the section turns about the path in a metre of it, at several places."""
    if made.plain or rail.length is not ZERO:
        return ZERO
    found, small = [], 1e-4
    for k in range(33):
        v = min(max(k / 32, small), 1 - small)
        moved = minus(made.side(v + small), made.side(v - small))
        way = minus(at(rail.place)(v + small), at(rail.place)(v - small))
        found.append(E.call("abs", E.div(dot(moved, made.up(v)), E.call("sqrt", dot(way, way)))))
    return E.mul(E.const(1.05), E.maximum(*found))


def bend(rail: Stretch) -> Expr:
    """The greatest curvature of a formula's path, and a twentieth for what lies between the places it is taken at."""
    return E.mul(E.const(1.05), E.maximum(*_curvatures(rail)))


def _curvatures(rail: Stretch) -> list[Expr]:
    """The curvature of a formula's path at several places."""
    found = []
    for here, beside in _bending(rail):
        fast = E.call("sqrt", dot(here, here))
        found.append(E.div(E.call("sqrt", dot(beside, beside)), E.mul(fast, E.mul(fast, fast))))
    return found


def tightest(rail: Stretch) -> Expr:
    """The least radius of curvature of a formula's path, at the places where it is taken."""
    return E.div(ONE, E.maximum(E.const(1e-9), *_curvatures(rail)))


def inwards(rail: Stretch) -> list[Triple]:
    """The same as vectors towards the centre of curvature."""
    found = []
    for here, beside in _bending(rail):
        square = dot(here, here)
        found.append(times(cross(beside, here), E.div(ONE, E.mul(square, square))))
    return found


def _bending(rail: Stretch) -> list[tuple[Triple, Triple]]:
    """Speed, and speed x change of speed, at several places of a formula's path."""
    speed = triple(derive(c, "v") for c in rail.place)
    change = triple(derive(c, "v") for c in speed)
    steps = [k / PLACES for k in range(PLACES + 1)]
    return [(at(speed)(v), cross(at(speed)(v), at(change)(v))) for v in steps]


def slowest(rail: Stretch) -> Expr:
    """The least length of a formula's path for a step of its parameter, at several places."""
    speed = at(triple(derive(c, "v") for c in rail.place))
    return E.mul(
        E.const(0.95),
        E.minimum(*(E.call("sqrt", dot(speed(k / PLACES), speed(k / PLACES))) for k in range(PLACES + 1))),
    )
