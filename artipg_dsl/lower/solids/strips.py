"""Convex pieces of plane regions: a strip between two chains cut at equal steps, and what stands on or turns with it.

Pieces lie within the solid. Where a curve bulges into the region its chord would leave it, so the corners of the step
are moved in until the chord is a tangent.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...graph import expr as E
from ...graph.expr import ZERO, Expr
from ...records import dataclass
from .probe import Probe
from .profiles import Loop, Point, Span, dot, equal_steps, minus, right_of, samples, scale, straight, turning

MOST = 16  # steps of a curve
_SAFE = E.const(1.05)  # a bulge is measured at a few places; what lies between them
_QUARTER = 0.25  # of a wall may be cut


@dataclass(frozen=True, slots=True, eq=False)
class Quad:
    """A step of a strip: its outer corners, its inner ones against them, the wall's thickness in its middle.

    ``ends`` tells where another curve of the chain begins.
    """

    name: str
    outer: tuple[Point, Point]
    inner: tuple[Point, Point]
    wall: Expr
    ends: tuple[bool, bool]


def convex(probe: Probe, loop: Loop, mirrored: bool) -> bool:
    """Whether a region is convex for every test value; ``mirrored`` adds its image beyond x = 0."""
    sides = [samples(probe, side.span, 16)[:, :: -1 if side.back else 1] for side in loop]
    points = np.concatenate([side[:, :-1] for side in sides], axis=1)
    last = loop[-1]
    points = np.concatenate([points, np.stack([probe(c)[0] for c in last.end], axis=-1)[:, None]], axis=1)
    if mirrored:
        points = np.concatenate([points, points[:, ::-1] * np.array([-1.0, 1.0])], axis=1)
    for row in points:
        size = (row.max(axis=0) - row.min(axis=0)).max()
        apart = np.abs(row - np.roll(row, 1, axis=0)).max(axis=1) > 1e-9 * size
        ring = row[apart]
        turns = turning(np.concatenate([ring, ring[:2]])[None])[0]
        if turns.min() < -1e-7 and turns.max() > 1e-7 or abs(abs(turns.sum()) - 2 * np.pi) > 1e-6:
            return False
    return True


def steps(probe: Probe, outer: Span, inner: Span) -> int:
    """Into how many steps a pair of curves is cut so that no chord cuts more than a quarter of the wall."""
    if straight(probe, outer) and straight(probe, inner):
        return 1
    count = max(equal_steps(probe, outer, np.radians(30.0), MOST), equal_steps(probe, inner, np.radians(30.0), MOST))
    while count < MOST:
        fine = [samples(probe, s, 2 * count) for s in (outer, inner)]
        wall = np.sqrt(((fine[0] - fine[1]) ** 2).sum(axis=-1))[:, 1::2]
        cut = [np.sqrt(((p[:, 1::2] - (p[:, :-1:2] + p[:, 2::2]) / 2) ** 2).sum(axis=-1)) for p in fine]
        if (np.maximum(*cut) <= _QUARTER * wall).mean() > 0.98:
            break
        count += 2
    return min(count, MOST)


def _bulge(probe: Probe, span: Span, low: float, high: float, outward: Expr) -> Expr:
    """How far a step of a span bulges into the region beyond its chord, at most; 0 where it never does."""
    a, b = span.fraction(low), span.fraction(high)
    normal = right_of(minus(b, a), outward)
    found = [dot(minus(a, span.fraction(low + (high - low) * s)), normal) for s in (0.25, 0.5, 0.75)]
    if not (np.nan_to_num(probe(*found)) > 1e-12).any():
        return ZERO
    return E.mul(E.maximum(ZERO, *found), _SAFE)


def chord(probe: Probe, span: Span, low: float, high: float, outward: Expr) -> tuple[Point, Point]:
    """The ends of a step, moved into the region by what bulges into it."""
    a, b = span.fraction(low), span.fraction(high)
    depth = _bulge(probe, span, low, high, outward)
    if depth is ZERO:
        return a, b
    move = scale(right_of(minus(b, a), outward), depth)
    return minus(a, move), minus(b, move)


def strip(probe: Probe, outer: list[Span], inner: list[Span], sign: Expr) -> list[Quad]:
    """The steps between two chains of as many curves; ``sign`` is the orientation of the loop out along the outer."""
    quads = []
    for one, other in zip(outer, inner, strict=True):
        count = steps(probe, one, other)
        for k in range(count):
            low, high = k / count, (k + 1) / count
            across = minus(one.fraction((low + high) / 2), other.fraction((low + high) / 2))
            quads.append(
                Quad(
                    one.name,
                    chord(probe, one, low, high, sign),
                    chord(probe, other, low, high, E.neg(sign)),
                    E.call("sqrt", dot(across, across)),
                    (k == 0, k == count - 1),
                )
            )
    return quads


def parts(probe: Probe, pairs: Sequence[tuple[Span, Span]], sign: Expr) -> list[list[Point]]:
    """Convex polygons that fill the strips between pairs of curves; neighbours that are convex together are one."""
    found: list[list[Point]] = []
    for one, other in pairs:
        for quad in strip(probe, [one], [other], sign):
            corners = [*quad.outer, *reversed(quad.inner)]
            corners = [c for k, c in enumerate(corners) if c != corners[k - 1]]
            if found and len(corners) == 3 and found[-1][-1] == corners[-1] and found[-1][-2] == corners[0]:
                joined = [*found[-1][:-1], *corners[1:]]
                if _round_about(probe, joined):
                    found[-1] = joined
                    continue
            found.append(corners)
    return found


def _round_about(probe: Probe, corners: Sequence[Point]) -> bool:
    """Whether a polygon is convex for every test value, its corners in their order."""
    points = np.stack([np.stack([probe(c)[0] for c in corner], axis=-1) for corner in corners], axis=1)
    size = np.sqrt(((points.max(axis=1) - points.min(axis=1)) ** 2).sum(axis=-1))
    ring = np.concatenate([points, points[:, :2]], axis=1) / size[:, None, None]
    turns = turning(ring)
    return bool(
        ((turns > -1e-9).all(axis=1) | (turns < 1e-9).all(axis=1)).all() and (np.abs(turns.sum(axis=1)) < 6.3).all()
    )
