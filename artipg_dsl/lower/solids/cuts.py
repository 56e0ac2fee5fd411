"""Where on a curve the foot of a perpendicular is sought: the nearest of its cuts, and the part of it that its symmetry leaves.

A curve is cut so that it turns by little in each cut, which a parabola through its ends and its middle follows closely: the nearest of
these tells in which cut the foot lies and about where. From there Newton's method needs to be written out once or twice, not for each cut.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...graph import expr as E
from ...graph.expr import ONE, Expr
from ...graph.primitive import triple
from ...graph.substitution import substitute_all
from ...records import dataclass
from .probe import SMALL

V = E.var("v")
TINY = E.const(1e-300)
FINE = 64  # steps at which a curve is looked at; a power of 2
_FAR = E.const(1e300)
Cut = tuple[float, float]


def clamp(value: Expr, low: float, high: float) -> Expr:
    return E.minimum(E.maximum(value, E.const(low)), E.const(high))


def within(value: Expr, low: Expr, high: Expr) -> Expr:
    return E.minimum(E.maximum(value, low), high)


def halved(turns: np.ndarray, bend: float) -> list[Cut]:
    """Cuts of 0 .. 1 from the angles (rows, steps) that a curve turns through in equal steps, a power of 2."""
    found: list[Cut] = []
    fine = turns.shape[1]

    def halve(low: int, high: int) -> None:
        if high - low <= 2 or turns[:, low:high].sum(axis=1).max() <= bend:
            found.append((low / fine, high / fine))
        else:
            halve(low, (low + high) // 2)
            halve((low + high) // 2, high)

    halve(0, fine)
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """Where the search begins, and between which values of v the foot lies."""

    v: Expr
    low: Expr
    high: Expr


def starts(point: Sequence[Expr], curve: Sequence[Expr], cuts: Sequence[Cut], most: int) -> list[Start]:
    """The places of a curve over v where its distance from a point is least of all around, about: the nearest, and where ``most`` is
    2 the next, as the parabolas may be wrong about which of two is nearer.
    """
    seen = [_by_parabola(point, curve, low, high) for low, high in cuts]
    most = min(most, (len(cuts) + 1) // 2)
    ranked: list[tuple[Expr, Expr, Expr]] = []
    for k, ((square, t), (low, high)) in enumerate(zip(seen, cuts, strict=True)):
        beside = [seen[j][0] for j in (k - 1, k + 1) if 0 <= j < len(cuts)]
        if most > 1 and beside:
            square = E.where(E.all_of(E.call("le", square, other) for other in beside), square, _FAR)
        new = square, t, E.const((high - low) / 2)
        for place, old in enumerate(ranked):
            nearer = E.call("lt", new[0], old[0])
            ranked[place] = triple(E.where(nearer, a, b) for a, b in zip(new, old, strict=True))
            new = triple(E.where(nearer, b, a) for a, b in zip(new, old, strict=True))
        if len(ranked) < most:
            ranked.append(new)
    begin, end = cuts[0][0], cuts[-1][1]
    found = []
    for _, t, half in ranked:
        more = E.mul(E.const(1.5), half)
        found.append(Start(t, E.maximum(E.sub(t, more), E.const(begin)), E.minimum(E.add(t, more), E.const(end))))
    return found


def _by_parabola(point: Sequence[Expr], curve: Sequence[Expr], low: float, high: float) -> tuple[Expr, Expr]:
    """Squared distance of a point to a cut, and its v there: where the point lies above the chord, on the parabola."""
    a, middle, b = (substitute_all(curve, {V: E.const(v)}) for v in (low, (low + high) / 2, high))
    chord = [E.sub(q, p) for p, q in zip(a, b, strict=True)]
    bulge = [
        E.mul(E.const(4.0), E.sub(m, E.mul(E.const(0.5), E.add(p, q)))) for p, m, q in zip(a, middle, b, strict=True)
    ]
    away = [E.sub(p, q) for p, q in zip(point, a, strict=True)]
    length = E.maximum(E.total(E.mul(c, c) for c in chord), TINY)
    s = clamp(E.total(E.mul(d, E.div(c, length)) for d, c in zip(away, chord, strict=True)), 0.0, 1.0)
    rise = E.mul(s, E.sub(ONE, s))
    rest = [E.sub(d, E.add(E.mul(s, c), E.mul(rise, m))) for d, c, m in zip(away, chord, bulge, strict=True)]
    return E.total(E.mul(r, r) for r in rest), E.add(E.const(low), E.mul(s, E.const(high - low)))


@dataclass(frozen=True, slots=True, eq=False)
class Fold:
    """How a point is mirrored into the part ``0 .. high`` of a symmetric curve: the sign of each coordinate there, or None."""

    high: float
    signs: tuple[float | None, float | None]

    def __call__(self, point: tuple[Expr, Expr]) -> tuple[Expr, Expr]:
        x, y = (
            p if sign is None else E.mul(E.const(sign), E.call("abs", p))
            for p, sign in zip(point, self.signs, strict=True)
        )
        return x, y


WHOLE = Fold(1.0, (None, None))


def fold(places: np.ndarray) -> Fold:
    """The symmetry of a curve about the axes, by its places (rows, steps + 1, 2) at equal steps, steps a multiple of 4.

    A curve that is its own image, run backwards, in one axis has half of its places on one side of it; where it is closed, that half may be its
    own image in the other axis.
    """
    steps = places.shape[1] - 1
    signs: list[float | None] = [None, None]
    share = 1
    closed = bool((np.abs(places[:, 0] - places[:, -1]) < SMALL).all())
    while share <= (2 if closed else 1):
        part = places[:, : steps // share + 1]
        axis = next((k for k in (0, 1) if signs[k] is None and _mirrors(part, k)), None)
        if axis is None:
            break
        side = part[:, : steps // share // 2 + 1, axis]
        sign = next((s for s in (1.0, -1.0) if (s * side > -SMALL).all()), None)
        if sign is None:
            break
        signs[axis] = sign
        share *= 2
    return Fold(1 / share, (signs[0], signs[1]))


def _mirrors(places: np.ndarray, axis: int) -> bool:
    image = places[:, ::-1].copy()
    image[..., axis] *= -1
    return bool((np.abs(image - places) < SMALL).all())


def rivals(places: np.ndarray, symmetry: Fold) -> int:
    """2 where some points lie about as far from one place of a curve as from another, else 1.

    ``places`` (rows, steps + 1, 2) are on the curve, at equal steps. Points are tried in a box around it, as the symmetry mirrors them.
    """
    places = places[:, : round(symmetry.high * (places.shape[1] - 1)) + 1]
    low, high = places.min(axis=1, keepdims=True), places.max(axis=1, keepdims=True)
    edge = np.linspace(-0.25, 1.25, 19)
    grid = np.stack(np.meshgrid(edge, edge, indexing="ij"), axis=-1).reshape(1, -1, 2)
    points = low + grid * (high - low)
    for k, sign in enumerate(symmetry.signs):
        if sign is not None:
            points[..., k] = sign * np.abs(points[..., k])
    return 2 if any(map(_near_two, points, places)) else 1  # the first of the rows often tells


def _near_two(points: np.ndarray, places: np.ndarray) -> bool:
    """Whether about one of the points (points, 2) two places of a curve are nearer than their neighbours, the second hardly farther."""
    x, y = (points[:, None, k] - places[:, k] for k in (0, 1))
    away = np.sqrt(x * x + y * y)
    falls = np.ones((len(points), len(places) + 1), dtype=bool)  # to a place from the one before
    falls[:, 1:-1] = away[:, 1:] < away[:, :-1]
    falls[:, -1] = False
    least = falls[:, :-1] & ~falls[:, 1:]
    several = np.count_nonzero(least, axis=1) > 1
    found = np.partition(np.where(least[several], away[several], np.inf), 1, axis=1)
    return bool((found[:, 1] < 1.1 * found[:, 0]).any())
