"""Plane regions bounded by curves: how far a point is from the boundary, on which side, and how far the region reaches.

A boundary is made of spans. The distance of a point to a straight span or a circular arc is exact; on others the foot of the
perpendicular is found by Newton's method, written out, from the nearest of cuts that bend little (see ``cuts``).
On the boundary itself the distance is 0 to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import pair
from ...graph.substitution import substitute, substitute_all
from ...records import dataclass
from .cuts import FINE, TINY, WHOLE, Cut, Fold, clamp, fold, halved, rivals, starts, within
from .cuts import V as V
from .probe import SMALL, Probe

Point = tuple[Expr, Expr]
SLOPE = E.const(0.95)  # takes what Newton's method leaves open far from a curve out of the slope
STEPS = 4
SLOW = 3
LEAST = 0.5  # of the squared speed: the least denominator of a step, near the centre of curvature
_BEND = np.radians(40.0)  # the most that a curve turns within a cut
TURN = 6.283185307179586
_STEPS, _COARSE = 48, 12  # at which a function is looked at for its summit; and written out
FLAT = 1e-7  # metres for the whole of a curve: a slope that leads nowhere


@dataclass(frozen=True, slots=True, eq=False)
class Span:
    """A curve ``position`` over the variable v from ``low`` to ``high``; ``closing`` where an operator made it."""

    name: str
    position: Point
    low: Expr = ZERO
    high: Expr = ONE
    closing: bool = False

    def at(self, value: Expr) -> Point:
        return substituted(self.position, value)

    @property
    def start(self) -> Point:
        return self.at(self.low)

    @property
    def end(self) -> Point:
        return self.at(self.high)

    @property
    def by_fraction(self) -> Point:
        """The position over v = 0 .. 1."""
        return self.at(E.add(self.low, E.mul(V, E.sub(self.high, self.low))))

    def fraction(self, value: float | Expr) -> Point:
        return substituted(self.by_fraction, E.wrap(value))


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """A span in a boundary, ``back`` where the way round the region runs against it."""

    span: Span
    back: bool = False

    @property
    def start(self) -> Point:
        return self.span.end if self.back else self.span.start

    @property
    def end(self) -> Point:
        return self.span.start if self.back else self.span.end


Loop = tuple[Side, ...]


def substituted(point: Point, value: Expr) -> Point:
    return pair(substitute_all(point, {V: value}))


def between(name: str, a: Point, b: Point) -> Span:
    """The straight span from a to b that closes a boundary."""
    x, y = (E.add(p, E.mul(V, E.sub(q, p))) for p, q in zip(a, b, strict=True))
    return Span(name, (x, y), closing=True)


def minus(a: Point, b: Point) -> Point:
    return E.sub(a[0], b[0]), E.sub(a[1], b[1])


def dot(a: Point, b: Point) -> Expr:
    return E.add(E.mul(a[0], b[0]), E.mul(a[1], b[1]))


def scale(a: Point, factor: Expr) -> Point:
    return E.mul(a[0], factor), E.mul(a[1], factor)


def right_of(direction: Point, sign: Expr) -> Point:
    """The unit normal to the right of a direction, times a sign."""
    length = E.call("sqrt", E.maximum(dot(direction, direction), TINY))
    return scale((direction[1], E.neg(direction[0])), E.div(sign, length))


def samples(probe: Probe, span: Span, count: int) -> np.ndarray:
    """(rows, count + 1, 2): places at equal steps."""
    return probe.once(_samples, span.by_fraction, count)


def _samples(probe: Probe, curve: Point, count: int) -> np.ndarray:
    values = probe.along(curve, [k / count for k in range(count + 1)], V)
    return np.ascontiguousarray(values.transpose(2, 0, 1))


def turning(points: np.ndarray) -> np.ndarray:
    """(rows, n - 2): signed angles between successive chords of (rows, n, 2)."""
    chords = np.diff(points, axis=1)
    a, b = chords[:, :-1], chords[:, 1:]
    return np.arctan2(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1])


def straight(probe: Probe, span: Span) -> bool:
    """Whether a span is a straight line, for every test value."""
    return probe.once(_straight, span.by_fraction)


def _straight(probe: Probe, curve: Point) -> bool:
    if all(derive(derive(c, "v"), "v") is ZERO for c in curve):
        return True
    seen = probe.once(_samples, curve, 12)
    return bool((np.abs(np.nan_to_num(turning(seen), nan=1.0)) < 1e-9).all())


def _cuts(probe: Probe, span: Span, symmetry: Fold) -> list[Cut]:
    """A span, or the part of it that its symmetry leaves, cut so that it turns by little in each cut."""
    turns = np.abs(np.nan_to_num(turning(samples(probe, span, FINE))))
    found = halved(np.concatenate([turns, turns[:, -1:]], axis=1), _BEND)
    return [(low, min(high, symmetry.high)) for low, high in found if low < symmetry.high]


def equal_steps(probe: Probe, span: Span, bend: float, most: int) -> int:
    """Into how many equal steps a span is cut so that it turns by little in each; at most ``most``."""
    fine = 48
    turns = np.abs(np.nan_to_num(turning(samples(probe, span, fine))))
    turns = np.concatenate([turns, turns[:, -1:]], axis=1)
    for count in (1, 2, 3, 4, 6, 8, 12, 16, 24):
        if count >= most or turns.reshape(len(turns), count, fine // count).sum(axis=2).max() <= bend:
            return min(count, most)
    return most


def area(loop: Loop, count: int = 4) -> Expr:
    """Twice the signed area of a loop through a few places of each span: positive where it runs anticlockwise."""
    points: list[Point] = []
    for side in loop:
        steps = [k / count for k in range(count + 1)]
        points += [side.span.fraction(s) for s in (reversed(steps) if side.back else steps)]
    ring = zip(points, [*points[1:], points[0]], strict=True)
    return E.total(E.sub(E.mul(a[0], b[1]), E.mul(b[0], a[1])) for a, b in ring)


def orientation(probe: Probe, loop: Loop) -> Expr:
    """+1 where a loop runs anticlockwise, -1 where clockwise; a constant where the test values agree."""
    twice = area(loop)
    seen = np.sign(probe(twice)[0])
    return E.const(float(seen[0])) if (seen == seen[0]).all() else E.call("sign", twice)


def distance(probe: Probe, loops: Sequence[tuple[Loop, bool]], point: Point) -> Expr:
    """How far ``point`` lies from the boundary, negative within.

    ``loops`` pairs a loop with whether it is a hole. A loop may be open where both its ends lie on x = 0: the region
    goes on beyond as its mirror image, and the point has x >= 0.
    """
    nearest: list[tuple[Expr, Expr]] = []
    for loop, hole in loops:
        sign = orientation(probe, loop)
        sign = E.neg(sign) if hole else sign
        for k, side in enumerate(loop):
            outward = E.neg(sign) if side.back else sign
            before, after = loop[k - 1], loop[(k + 1) % len(loop)]
            first, last = corner(probe, before, side, side, sign), corner(probe, side, after, side, sign)
            ends = (last, first) if side.back else (first, last)
            nearest += reaches(probe, side.span, outward, ends, point)
    square, way = nearest[0]
    for other, other_way in nearest[1:]:
        way = E.where(E.call("lt", other, square), other_way, way)
        square = E.minimum(square, other)
    length = E.mul(E.call("sqrt", square), SLOPE)
    return E.where(E.call("lt", way, ZERO), E.neg(length), length)


def direction(side: Side, at_end: bool) -> Point:
    """The tangent at an end of a side, in the direction of the way round."""
    span = side.span
    place = span.high if at_end != side.back else span.low
    tangent = substituted(pair(derive(c, "v") for c in span.position), place)
    away = E.sub(span.high, span.low)
    tangent = scale(tangent, away)
    return (E.neg(tangent[0]), E.neg(tangent[1])) if side.back else tangent


def corner(probe: Probe, before: Side, after: Side, own: Side, sign: Expr) -> Point:
    """What tells the sides of a corner apart: the sum of the outward normals of the two spans that meet there.

    Where they do not meet, ``own`` ends on the axis and goes on as its mirror image.
    """
    a, b = right_of(direction(before, True), sign), right_of(direction(after, False), sign)
    if probe.same(before.end, after.start):
        return E.add(a[0], b[0]), E.add(a[1], b[1])
    return ZERO, (a if own is before else b)[1]


def reaches(
    probe: Probe, span: Span, outward: Expr, ends: tuple[Point, Point], point: Point
) -> list[tuple[Expr, Expr]]:
    """Squared distance of the point to a span, and a number with the sign of its side; where two places of it may be nearest, of both."""
    if straight(probe, span):
        a, b = span.start, span.end
        along = minus(b, a)
        t = E.div(dot(minus(point, a), along), E.maximum(dot(along, along), TINY))
        t = clamp(t, 0.0, 1.0)
        away = minus(minus(point, a), scale(along, t))
        return [(dot(away, away), _side_of(away, right_of(along, outward), t, ends, ZERO, ONE))]
    arc = circular(probe, span)
    if arc is not None:
        return [arc.reach(outward, ends, point)]
    curve = span.by_fraction
    symmetry = _fold(probe, span, ends)
    cuts = _cuts(probe, span, symmetry)
    point = symmetry(point)
    speed: Point = pair(derive(c, "v") for c in curve)
    bend: Point = pair(derive(c, "v") for c in speed)
    closed = symmetry.high < 1.0 and probe.same(span.start, span.end)
    found = []
    for begin in starts(point, curve, cuts, rivals(samples(probe, span, FINE), symmetry)):
        t = last = begin.v
        for number in range(STEPS + 1):
            t, last = last, within(E.add(last, step(point, curve, speed, bend, last, number)), begin.low, begin.high)
        here, tangent = substituted(curve, t), substituted(speed, t)
        away = minus(minus(point, here), scale(tangent, E.sub(last, t)))
        normal = right_of(tangent, outward)
        own = (normal if closed else ends[0], normal if symmetry.high < 1.0 else ends[1])
        found.append((dot(away, away), _side_of(away, normal, last, own, ZERO, ONE)))
    return found


def _fold(probe: Probe, span: Span, ends: tuple[Point, Point]) -> Fold:
    """The symmetry of a span; an open one has its corners mirrored with it, or none."""
    found = fold(samples(probe, span, FINE))
    if found.high == 1.0 or probe.same(span.start, span.end):
        return found
    image = pair(c if sign is None else E.neg(c) for c, sign in zip(ends[1], found.signs, strict=True))
    return found if probe.same(ends[0], image) else WHOLE


@dataclass(frozen=True, slots=True, eq=False)
class Arc:
    """A circular span: its centre and radius, the direction from the centre to its middle, +1 where it turns left,
    and half its angle.
    """

    center: Point
    radius: Expr
    middle: Point
    left: Expr
    half: Expr

    def reach(self, outward: Expr, ends: tuple[Point, Point], point: Point) -> tuple[Expr, Expr]:
        """Squared distance of a point, and a number with the sign of its side."""
        away = minus(point, self.center)
        onwards = scale((E.neg(self.middle[1]), self.middle[0]), self.left)
        angle = E.call("atan2", dot(away, onwards), dot(away, self.middle))
        angle = E.minimum(E.maximum(angle, E.neg(self.half)), self.half)
        c, s = E.call("cos", angle), E.call("sin", angle)
        out = (
            E.add(E.mul(self.middle[0], c), E.mul(onwards[0], s)),
            E.add(E.mul(self.middle[1], c), E.mul(onwards[1], s)),
        )
        rest = minus(away, scale(out, self.radius))
        normal = scale(out, E.mul(self.left, outward))
        return dot(rest, rest), _side_of(rest, normal, angle, ends, E.neg(self.half), self.half)


def circular(probe: Probe, span: Span) -> Arc | None:
    """The circle that a span is an arc of, for every test value; None where it is none."""
    points = samples(probe, span, FINE)
    turns = turning(points)
    if not (np.abs(turns - turns[:, :1]) < 1e-6).all() or (np.abs(turns.sum(axis=1)) * 64 / 63 > TURN + 1e-6).any():
        return None
    start, middle = span.start, span.fraction(0.5)
    speed = pair(derive(c, "v") for c in span.by_fraction)
    bend = pair(derive(c, "v") for c in speed)
    (x, y), (ax, ay) = (substituted(q, ZERO) for q in (speed, bend))
    square, cross = E.add(E.mul(x, x), E.mul(y, y)), E.sub(E.mul(x, ay), E.mul(y, ax))
    to_center = E.div(square, cross)
    center = E.sub(start[0], E.mul(y, to_center)), E.add(start[1], E.mul(x, to_center))
    center = probe.tidy(center[0]), probe.tidy(center[1])
    radius = probe.tidy(E.call("abs", E.mul(E.call("sqrt", square), to_center)))
    seen = np.stack([probe(c)[0] for c in center], axis=-1)[:, None]
    off = np.sqrt(((points - seen) ** 2).sum(axis=-1)) / probe(radius)[0][:, None] - 1
    if not (np.abs(off) < 1e-11).all():
        return None
    to_middle = pair(probe.tidy(E.div(c, radius)) for c in minus(middle, center))
    to_start = pair(E.sub(a, b) for a, b in zip(start, center, strict=True))
    side, ahead = E.sub(E.mul(to_middle[0], to_start[1]), E.mul(to_middle[1], to_start[0])), dot(to_middle, to_start)
    half = E.call("atan2", E.call("abs", side), ahead)
    whole = bool((np.abs(points[:, 0] - points[:, -1]).max(axis=1) < SMALL).all())
    left = probe(cross)[0]
    sign = E.const(float(np.sign(left[0]))) if (np.sign(left) == np.sign(left[0])).all() else E.call("sign", cross)
    return Arc(center, radius, to_middle, sign, E.const(TURN / 2) if whole else half)


def step(point: Point, curve: Point, speed: Point, bend: Point, t: Expr, number: int) -> Expr:
    """One step towards the foot of the perpendicular on a curve."""
    away, tangent = minus(point, substituted(curve, t)), substituted(speed, t)
    return onwards(dot(away, tangent), dot(tangent, tangent), dot(away, substituted(bend, t)), number)


def onwards(residual: Expr, square: Expr, curved: Expr, number: int) -> Expr:
    """A step of Newton's method; the first ones go slowly where the point lies on the hollow side of the curve."""
    square = E.maximum(square, TINY)
    least = ONE if number < SLOW else E.const(LEAST)
    return E.div(residual, E.maximum(E.sub(square, curved), E.mul(least, square)))


def _side_of(away: Point, normal: Point, t: Expr, ends: tuple[Point, Point], low: Expr, high: Expr) -> Expr:
    """Positive outside: by the normal at the foot, or where the foot is an end by what tells the sides apart there."""
    way = dot(away, normal)
    if ends[0] is not normal:
        way = E.where(E.call("le", t, low), dot(away, ends[0]), way)
    if ends[1] is not normal:
        way = E.where(E.call("le", high, t), dot(away, ends[1]), way)
    return way


def extreme(probe: Probe, spans: Sequence[Span], axis: int, sign: int) -> Expr:
    """The greatest (``sign`` 1) or least (-1) coordinate along an axis that the spans reach."""
    return probe.once(_extreme, tuple(span.by_fraction for span in spans), axis, sign)


def _extreme(probe: Probe, curves: Sequence[Point], axis: int, sign: int) -> Expr:
    factor = E.const(float(sign))
    found: list[Expr] = []
    for curve in curves:
        height = E.mul(factor, curve[axis])
        line = probe.once(_straight, curve)
        found += [substitute(height, {V: end}) for end in (ZERO, ONE)] if line else tops(probe, height)
    greatest = probe.greatest(found)
    return greatest if sign > 0 else E.neg(greatest)


def tops(probe: Probe, height: Expr, windows: int = 1) -> list[Expr]:
    """Places of which the highest is the highest of a function of v: the ends of equal windows, and summits within."""
    return [substitute(height, {V: v}) for v in (*steps(windows), *summits(probe, height, windows))]


def crests(probe: Probe, height: Expr, windows: int) -> list[Expr]:
    """The summit of a function of v in each of equal windows where it has one for some test value."""
    return [substitute(height, {V: v}) for v in summits(probe, height, windows)]


def steps(windows: int) -> list[Expr]:
    """The ends of equal windows of 0 .. 1."""
    return [E.const(k / windows) for k in range(windows + 1)]


def summits(probe: Probe, height: Expr, windows: int) -> list[Expr]:
    """Where in each of equal windows a function of v has its summit, if it has one there for some test value."""
    found = []
    for k in range(windows):
        share = E.mul(E.add(V, E.const(float(k))), E.const(1 / windows))
        part = height if windows == 1 else substitute(height, {V: share})
        values = probe.along([part], [k / _STEPS for k in range(_STEPS + 1)], V)[:, 0]
        slope = derive(part, "v")
        if _rises(probe, slope, values):
            found.append(substitute(share, {V: _summit(probe, part, slope, values)}))
    return found


def _rises(probe: Probe, slope: Expr, values: np.ndarray) -> bool:
    """Whether a function of v is greater somewhere between its ends than at both: at some step (``values``), or by its slopes there."""
    ends = np.maximum(values[0], values[-1])
    if (values.max(axis=0) > ends + 1e-12).any():
        return True
    begin, end = probe(*(substitute(slope, {V: v}) for v in (ZERO, ONE)))
    return bool(((values[0] >= ends) & (begin > FLAT) | (values[-1] >= ends) & (end < -FLAT)).any())


def _summit(probe: Probe, height: Expr, slope: Expr, values: np.ndarray) -> Expr:
    """Where a function of v is greatest over 0 .. 1: a step at which it is for all test values; or the best of steps, then Newton's method
    on the slope.
    """
    near = np.flatnonzero((values >= values.max(axis=0) - SMALL).all(axis=1))
    for k in map(int, near):
        if (np.abs(probe(substitute(slope, {V: E.const(k / _STEPS)}))) < SMALL).all():
            return E.const(k / _STEPS)
    best: Expr = ZERO
    top = substitute(height, {V: ZERO})
    for k in range(1, _COARSE + 1):
        value = substitute(height, {V: E.const(k / _COARSE)})
        best = E.where(E.call("lt", top, value), E.const(k / _COARSE), best)
        top = E.maximum(top, value)
    low, high = (E.add(best, E.const(d / _COARSE)) for d in (-1.0, 1.0))
    second = derive(slope, "v")
    for _ in range(6):
        rise, bend = (substitute(f, {V: best}) for f in (slope, second))
        moved = E.sub(best, E.div(rise, E.minimum(bend, E.const(-1e-12))))
        best = clamp(within(moved, low, high), 0.0, 1.0)
    return best
