"""Regions of a plane between chains of curves: their boundary, and the strips and triangles that fill them."""

from __future__ import annotations

import numpy as np

from ...graph import expr as E
from ...graph.expr import ZERO, Expr
from ...graph.primitive import Triple, pair, triple
from ...syntax import ast
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.vectors import signed_axis
from .curves import spans_of
from .probe import Probe
from .profiles import Loop, Point, Side, Span, V, between, samples, straight


def chains_of(env: Env, probe: Probe, solid: ast.SolidDecl) -> list[list[Span]]:
    """The chains of curves that are given; the curves of each meet end to end."""
    chains = [spans_of(Evaluator(env), a.value) for a in solid.arguments]
    for chain, argument in zip(chains, solid.arguments, strict=True):
        for a, b in zip(chain, chain[1:], strict=False):
            if not probe.same(a.end, b.start):
                raise env.context.error(
                    "broken-chain",
                    argument.span,
                    f"`{b.name}` does not begin where `{a.name}` ends",
                    hint="the curves of a chain must meet end to end, for every test value",
                )
    return chains


def axis_of(env: Env, solid: ast.SolidDecl, clause: ast.Clause[ast.Expr] | None) -> int:
    """The axis that follows ``about`` or ``along``; z where the clause is left out."""
    if clause is None:
        return 2
    found = signed_axis(Evaluator(env).direction(clause.value))
    if found is None or found[1] < 0:
        message = f"`{solid.operator}` takes x, y or z after `{clause.word}`"
        raise env.context.error(
            "bad-axis",
            clause.value.span,
            message,
            hint=f"write `{clause.word} x`, `{clause.word} y` or `{clause.word} z`",
        )
    return found[0]


def turned(axis: int, across: Point, height: Expr) -> Triple:
    """A place given across and along an axis; across are the two other axes in cyclic order."""
    place: list[Expr] = [ZERO] * 3
    place[(axis + 1) % 3], place[(axis + 2) % 3], place[axis] = across[0], across[1], height
    return triple(place)


def check_values(env: Env, probe: Probe, solid: ast.SolidDecl, span: Span) -> None:
    if np.isnan(samples(probe, span, 16)).any():
        raise env.context.error(
            "bad-curve",
            solid.span,
            f"the curve `{span.name}` has no value at some of the test values",
            hint="narrow the ranges after `test`, or add a `require`",
        )


Strips = list[tuple[Span, Span]]


def outline(
    env: Env, probe: Probe, solid: ast.SolidDecl, chains: list[list[Span]]
) -> tuple[list[tuple[Loop, bool]], Strips]:
    """The loops of a region (with whether they are holes), and the pairs of curves between which it lies."""
    closed = [probe.same(chain[0].start, chain[-1].end) for chain in chains]
    for chain in chains:
        for span in chain:
            check_values(env, probe, solid, span)
    outer = chains[0]
    if len(chains) == 1:
        sides = [Side(s) for s in outer]
        if not closed[0]:
            sides.append(Side(between("rim", outer[-1].end, outer[0].start)))
        filled = _fan(probe, [side.span for side in sides]) or triangles(probe, tuple(sides))
        if filled is None:
            raise env.context.error(
                "bad-curve",
                solid.span,
                "the region within this outline cannot be filled: it is curved and winding, or crosses itself",
                hint="use straight lines between corners, or an outline that is visible as a whole from one of its corners or "
                "its middle; or split the solid into several primitives",
            )
        return [(tuple(sides), False)], filled
    inner = chains[1]
    if closed[0] != closed[1] or len(outer) != len(inner):
        raise env.context.error(
            "broken-chain",
            solid.span,
            "the two chains do not match",
            hint="both must be closed or both open, with the same number of curves",
        )
    strips = [(a, matched(a, b)) for a, b in zip(outer, inner, strict=True)]
    if closed[0]:
        return [(tuple(map(Side, outer)), False), (tuple(map(Side, inner)), True)], strips
    sides = [Side(s) for s in outer]
    if not probe.same(outer[-1].end, inner[-1].end):
        sides.append(Side(between("rim", outer[-1].end, inner[-1].end)))
    sides += [Side(s, back=True) for s in reversed(inner)]
    if not probe.same(inner[0].start, outer[0].start):
        sides.append(Side(between("rim", inner[0].start, outer[0].start)))
    return [(tuple(sides), False)], strips


def matched(a: Span, b: Span) -> Span:
    """The curve ``b`` over the range of ``a``."""
    if b.low is a.low and b.high is a.high:
        return b
    v = E.div(E.sub(V, a.low), E.sub(a.high, a.low))
    return Span(b.name, b.fraction(v), a.low, a.high)


def mean(spans: list[Span]) -> Point:
    """A place in the middle: the mean of a few places of the boundary."""
    points = [span.fraction(k / 4) for span in spans for k in range(4)]
    share = E.const(1.0 / len(points))
    return pair(E.total(E.mul(point[k], share) for point in points) for k in (0, 1))


def _fan(probe: Probe, spans: list[Span]) -> Strips | None:
    """Each curve with a place that sees the whole outline: its middle, or else a corner; None where neither does.

    The curves that end at such a corner lie in the sides of their neighbours, so they must be straight.
    """
    lines = [samples(probe, span, 12) for span in spans]
    twice = sum((cross(line[:, :-1], line[:, 1:]).sum(axis=1) for line in lines), np.zeros(len(lines[0])))
    size = np.sqrt(np.abs(twice))[:, None]
    if not size.all():
        return None

    def sees(middle: Point, skipped: tuple[int, ...] = ()) -> bool:
        at = np.stack([probe(c)[0] for c in middle], axis=-1)[:, None] / size[..., None]
        rest = [line / size[..., None] - at for k, line in enumerate(lines) if k not in skipped]
        seen = [(cross(r[:, :-1], r[:, 1:]) * np.sign(twice)[:, None]).min() for r in rest]
        return bool(seen) and min(seen) > 1e-9

    def about(middle: Point, skipped: tuple[int, ...] = ()) -> Strips:
        kept = [span for k, span in enumerate(spans) if k not in skipped]
        return [(span, Span("", middle, span.low, span.high)) for span in kept]

    middle = mean(spans)
    if sees(middle):
        return about(middle)
    for k, span in enumerate(spans):
        beside = ((k - 1) % len(spans), k)
        if len(spans) > 3 and all(straight(probe, spans[j]) for j in beside) and sees(span.start, beside):
            return about(span.start, beside)
    return None


def triangles(probe: Probe, loop: Loop) -> Strips | None:
    """Triangles that fill a polygon, found by cutting off corners that are ears for every test value."""
    spans = [side.span for side in loop]
    if not all(straight(probe, span) for span in spans):
        return None
    corners = [span.start for span in spans]
    points = np.stack([np.stack([probe(c)[0] for c in corner], axis=-1) for corner in corners], axis=1)
    twice = cross(points, np.roll(points, -1, axis=1)).sum(axis=1)
    if not twice.all():
        return None
    points = points / np.sqrt(np.abs(twice))[:, None, None]
    points[..., 0] *= np.sign(twice)[:, None]  # mirrored where they run clockwise
    left = list(range(len(corners)))
    found: Strips = []

    def line(a: int, b: int) -> Span:
        return spans[a] if b == (a + 1) % len(spans) else between("", corners[a], corners[b])

    while len(left) >= 3:
        best, ear = 0.0, -1
        for k in range(len(left)):
            a, b, c = left[k - 1], left[k], left[(k + 1) % len(left)]
            wide = cross(points[:, b] - points[:, a], points[:, c] - points[:, b]).min()
            if wide > max(best, 1e-9) and not occupied(points, (a, b, c), left):
                best, ear = float(wide), k
        if ear < 0:
            return None
        a, b, c = left[ear - 1], left[ear], left[(ear + 1) % len(left)]
        side = line(a, b)
        found.append((side, Span("", corners[c], side.low, side.high)))
        left.pop(ear)
        if len(left) == 2:
            break
    return found


def occupied(points: np.ndarray, ear: tuple[int, int, int], left: list[int]) -> bool:
    """Whether another corner lies in a triangle that runs anticlockwise, or on its edge, for some test value."""
    others = sorted(set(left) - set(ear))
    inside = np.ones((len(points), len(others)), dtype=bool)
    for a, b in zip(ear, (*ear[1:], ear[0]), strict=True):
        inside &= cross(points[:, [b]] - points[:, [a]], points[:, others] - points[:, [a]]) > -1e-9
    return bool(inside.any())


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
