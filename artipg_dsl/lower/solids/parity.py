"""Plane regions between straight lines and quarters of ellipses along the axes, in closed form.

On which side a point lies is told by how often a ray to +x crosses the boundary (even or odd; see Haines, "Point in
polygon strategies", Graphics Gems IV, 1994), so it does not hang on which curve is nearest. How far it is from the
boundary is bounded from below, curve by curve: exactly for a line, for a quarter of an ellipse by a function that is 0
on it alone and whose slope is at most 1. Most profiles of pots, bottles and rounded outlines are of this kind.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import pair
from ...records import dataclass
from .cuts import FINE, TINY, clamp
from .probe import Probe
from .profiles import Loop, Point, Span, dot, minus, samples, scale, straight

_THIN = E.const(1e-12)  # metres: the least half axis
EXACT = 1e-11  # relative: how well the test values must fit an ellipse


@dataclass(frozen=True, slots=True, eq=False)
class Quarter:
    """The quarter ``((x - cx) / a)^2 + ((y - cy) / b)^2 = 1`` on the sides of the centre that ``sign`` tells."""

    center: Point
    half: Point  # the half axes a, b
    sign: Point  # +1 or -1 along x, along y


Piece = tuple[Point, Point, Quarter | None]  # from, to, and what lies between: None for a straight line


def pieces(probe: Probe, span: Span) -> list[Piece] | None:
    """The lines or quarters that a span is made of for every test value; None where it is made of anything else."""
    if straight(probe, span):
        return [(span.start, span.end, None)]
    seen = samples(probe, span, FINE)
    for count in (1, 2, 4):
        found: list[Piece] = []
        step = FINE // count
        for k in range(count):
            part = seen[:, k * step : (k + 1) * step + 1]
            start = span.start if k == 0 else span.fraction(k / count)
            end = span.end if k == count - 1 else span.fraction((k + 1) / count)
            quarter = fitted(probe, part, start, end)
            if quarter is None:
                break
            found.append((start, end, quarter))
        else:
            return found
    return None


def fitted(probe: Probe, seen: np.ndarray, start: Point, end: Point) -> Quarter | None:
    """The quarter of an ellipse through the places ``seen`` (rows, n, 2), from its one axis to the other."""
    for flat in (False, True):  # the centre lies beside the start, or beside the end
        at, other = (0, -1) if flat else (-1, 0)
        middle = np.stack([seen[:, at, 0], seen[:, other, 1]], axis=-1)
        half = np.stack([seen[:, other, 0], seen[:, at, 1]], axis=-1) - middle
        with np.errstate(all="ignore"):
            off = (((seen - middle[:, None]) / half[:, None]) ** 2).sum(axis=-1) - 1
            inner = ((seen - middle[:, None]) / half[:, None]).min()
        if not ((np.abs(off) < EXACT).all() and inner > -EXACT):
            continue
        center = (start[0], end[1]) if flat else (end[0], start[1])
        reach = (
            (E.sub(end[0], center[0]), E.sub(start[1], center[1]))
            if flat
            else (E.sub(start[0], center[0]), E.sub(end[1], center[1]))
        )
        sign = pair(
            E.const(float(s[0])) if (s == s[0]).all() else E.call("sign", r)
            for r, s in zip(reach, np.sign(half).T, strict=True)
        )
        long = pair(E.maximum(E.mul(s, probe.tidy(r)), _THIN) for r, s in zip(reach, sign, strict=True))
        return Quarter(center, long, sign)
    return None


def signed(probe: Probe, loops: Sequence[tuple[Loop, bool]], point: Point) -> Expr | None:
    """Negative within, positive outside, 0 on the boundary, of slope at most 1; None where a curve is of another kind.

    ``loops`` and ``point`` as for ``profiles.distance``.
    """
    squares: list[Expr] = []
    outside: Expr = ONE
    bent = False
    for loop, _ in loops:
        made: list[Piece] = []
        for side in loop:
            own = pieces(probe, side.span)
            if own is None:
                return None
            made += [(b, a, q) for a, b, q in reversed(own)] if side.back else own
        for k, (start, end, quarter) in enumerate(made):
            if k and probe.same(made[k - 1][1], start):
                start = made[k - 1][1]  # one number for both, so that a ray never slips through
            if k == len(made) - 1 and probe.same(made[0][0], end):
                end = made[0][0]
            made[k] = start, end, quarter
            bent = bent or quarter is not None
            square, crossed = line(start, end, point) if quarter is None else arc(start, end, quarter, point)
            squares.append(square)
            outside = E.where(crossed, E.neg(outside), outside)
    return E.mul(outside, E.call("sqrt", E.minimum(*squares))) if bent else None


def between(start: Expr, end: Expr, level: Expr) -> tuple[Expr, Expr]:
    """Whether a level is passed upwards, downwards; of two that meet at it only one passes."""
    up = E.both(E.call("le", start, level), E.call("lt", level, end))
    return up, E.both(E.call("le", end, level), E.call("lt", level, start))


def line(start: Point, end: Point, point: Point) -> tuple[Expr, Expr]:
    """Squared distance to a straight line, and whether the ray crosses it."""
    along, away = minus(end, start), minus(point, start)
    t = clamp(E.div(dot(away, along), E.maximum(dot(along, along), TINY)), 0.0, 1.0)
    rest = minus(away, scale(along, t))
    left = E.sub(E.mul(along[0], away[1]), E.mul(away[0], along[1]))
    up, down = between(start[1], end[1], point[1])
    return dot(rest, rest), E.either(E.both(up, E.call("lt", ZERO, left)), E.both(down, E.call("lt", left, ZERO)))


def arc(start: Point, end: Point, quarter: Quarter, point: Point) -> tuple[Expr, Expr]:
    """A bound of the squared distance to a quarter of an ellipse, and whether the ray crosses it.

    Beside the quarter, the way to its quadrant counts, and from there the ellipse: two ways at right angles.
    """
    x, y = (E.mul(s, E.sub(p, c)) for p, c, s in zip(point, quarter.center, quarter.sign, strict=True))
    within = E.maximum(x, ZERO), E.maximum(y, ZERO)
    before = E.minimum(x, ZERO), E.minimum(y, ZERO)
    a, b = quarter.half
    share = E.call("hypot", E.div(within[0], a), E.div(within[1], b))
    beyond = E.mul(E.sub(share, ONE), E.minimum(a, b))
    up, down = between(start[1], end[1], point[1])
    # beside the quarter its x alone tells, so that a ray which touches the tip of an ellipse crosses both quarters or none
    inner = E.either(E.call("le", x, ZERO), E.call("lt", share, ONE))
    outer = E.both(E.call("lt", ZERO, x), E.call("lt", ONE, share))
    side = quarter.sign[0]
    crossed = (
        inner if side is ONE else outer if side is E.const(-1.0) else E.where(E.call("lt", ZERO, side), inner, outer)
    )
    return E.add(dot(before, before), E.mul(beyond, beyond)), E.both(E.either(up, down), crossed)
