"""A plane region with holes, filled with triangles that hold for every test value.

Straight curves are edges of a polygon as they are. A bent one is cut into short arcs: where it bulges out of the region its
chord is the edge, where it bulges into the region the two tangents at its ends are, and a strip fills what lies between.
The polygons of the holes are joined to the outer one by bridges, and the one polygon that comes of it is cut up ear by
ear (Meisters, "Polygons have ears", 1975; bridges after Eberly, "Triangulation by ear clipping", 2002).
"""

from __future__ import annotations

from dataclasses import field

import numpy as np

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import Expr
from ...graph.primitive import pair
from ...records import dataclass
from ...syntax import ast
from ..expressions.env import Env
from .probe import Probe
from .profiles import Loop, Point, Side, Span, between, equal_steps, minus, samples, scale, substituted, turning
from .regions import Strips, check_values, cross, matched, occupied
from .strips import parts

_BENDS = (46.0, 31.0, 16.0)  # degrees: how far an arc turns at most; finer ones come nearer to what is narrow
ARCS = 24
_CORNERS = 4  # of the convex piece between an arc and its chord
CLOSE = 1e-9  # of the size of the region


@dataclass(slots=True, eq=False)
class Holed:
    """``loops`` bound the region (with whether they are holes), ``walls`` are the same cut into arcs, ``strips`` fill it and
    ``polygons`` are its convex parts."""

    loops: list[tuple[Loop, bool]]
    walls: list[Span] = field(default_factory=list)
    strips: Strips = field(default_factory=list)
    polygons: list[list[Point]] = field(default_factory=list)


def several(probe: Probe, chains: list[list[Span]]) -> bool:
    """Whether chains are an outline and holes that do not go with it curve by curve."""
    closed = all(probe.same(chain[0].start, chain[-1].end) for chain in chains)
    return len(chains) > 2 or len(chains) == 2 and closed and len(chains[0]) != len(chains[1])


def holed(env: Env, probe: Probe, solid: ast.SolidDecl, chains: list[list[Span]]) -> Holed:
    """The region within the first chain and outside the others. Raises Abort where it cannot be filled."""
    for chain, argument in zip(chains, solid.arguments, strict=True):
        for span in chain:
            check_values(env, probe, solid, span)
        if not probe.same(chain[0].start, chain[-1].end):
            raise env.context.error(
                "broken-chain",
                argument.span,
                "this outline is not closed",
                hint="an outline with holes, and each hole, must end where it begins",
            )
    loops = [(tuple(map(Side, chain)), number > 0) for number, chain in enumerate(chains)]
    for bend in _BENDS:
        region = Holed(loops)
        if fill(probe, region, chains, np.radians(bend)):
            return region
    raise env.context.error(
        "bad-curve",
        solid.span,
        "the region between this outline and its holes cannot be filled at all test values",
        hint="holes must lie within the outline and apart from one another: add a `require`, or narrow the ranges after `test`",
    )


def fill(probe: Probe, region: Holed, chains: list[list[Span]], bend: float) -> bool:
    """Fill a region with arcs of at most ``bend``; whether that worked."""
    net = _Net(probe)
    ways: list[float] = []
    # an arc, its chord or tip, on which side the region lies, its bulge
    bent: list[tuple[Span, Span, float, float]] = []
    for number, chain in enumerate(chains):
        arcs = [arc for span in chain for arc in cut(probe, span, bend)]
        way = _round_way(probe, arcs)
        if way == 0.0:
            return False
        ways.append(way)
        left = way if number == 0 else -way  # +1 where the region lies to the left
        ring: list[int] = []
        corners = [net.corner(arc.start) for arc in arcs]
        for k, arc in enumerate(arcs):
            a, b = corners[k], corners[(k + 1) % len(arcs)]
            ring.append(a)
            side = _bulge(probe, arc, left)
            if side is None:
                return False
            if side == 0.0:
                net.edges[a, b] = arc
            elif side > 0:
                net.edges[a, b] = edge = between("", net.corners[a], net.corners[b])
                bent.append((arc, matched(arc, edge), left, side))
            else:
                tip = tangents(arc)
                ring.append(net.corner(tip))
                bent.append((arc, Span("", tip, arc.low, arc.high), left, side))
        net.rings.append(ring if left > 0 else ring[::-1])
        region.walls += arcs
    triangles = net.triangles()
    if triangles is None:
        return False
    for arc, other, left, side in bent:
        pair = (arc, other) if left == ways[0] else (other, arc)
        region.strips.append(pair)
        if side > 0:
            region.polygons.append([arc.fraction(s / (_CORNERS - 1)) for s in range(_CORNERS)])
        else:
            region.polygons += parts(probe, [pair], E.const(ways[0]))
    filling: Strips = []
    for a, b, c in triangles:
        line = net.line(a, b)
        filling.append((line, Span("", net.corners[c], line.low, line.high)))
    region.strips += filling
    region.polygons += parts(probe, filling, E.const(ways[0]))
    return True


def cut(probe: Probe, span: Span, bend: float) -> list[Span]:
    """A span in equal arcs that turn by little each."""
    count = equal_steps(probe, span, bend, ARCS)
    reach = E.sub(span.high, span.low)
    ends = [E.add(span.low, E.mul(reach, E.const(k / count))) for k in range(count)] + [span.high]
    return [Span(span.name, span.position, a, b) for a, b in zip(ends, ends[1:], strict=False)] if count > 1 else [span]


def _round_way(probe: Probe, arcs: list[Span]) -> float:
    """+1 where a loop runs anticlockwise, -1 where clockwise, 0 where the test values differ."""
    lines = [samples(probe, arc, 4) for arc in arcs]
    signs = np.sign(sum(cross(line[:, :-1], line[:, 1:]).sum(axis=1) for line in lines))
    return float(signs[0]) if (signs == signs[0]).all() else 0.0


def _bulge(probe: Probe, arc: Span, left: float) -> float | None:
    """+1 where an arc bulges out of the region, -1 where into it, 0 where it is straight; None where it does both."""
    turns = turning(samples(probe, arc, 12)) * left
    if np.abs(turns).max() < CLOSE:
        return 0.0
    return 1.0 if turns.min() > -CLOSE else -1.0 if turns.max() < CLOSE else None


def tangents(arc: Span) -> Point:
    """Where the tangents at both ends of an arc meet."""
    speed: Point = pair(derive(c, "v") for c in arc.position)
    first, last = substituted(speed, arc.low), substituted(speed, arc.high)
    share = E.div(_crossed(minus(arc.end, arc.start), last), _crossed(first, last))
    x, y = scale(first, share)
    return E.add(arc.start[0], x), E.add(arc.start[1], y)


def _crossed(a: Point, b: Point) -> Expr:
    return E.sub(E.mul(a[0], b[1]), E.mul(a[1], b[0]))


class _Net:
    """Corners by number, and rings of them with the region to the left: the outer one first, then the holes."""

    def __init__(self, probe: Probe):
        self.probe = probe
        self.corners: list[Point] = []
        self.edges: dict[tuple[int, int], Span] = {}  # where an edge is no line from corner to corner that is made here
        self.rings: list[list[int]] = []

    def corner(self, point: Point) -> int:
        self.corners.append(point)
        return len(self.corners) - 1

    def line(self, a: int, b: int) -> Span:
        found = self.edges.get((a, b)) or self.edges.get((b, a))
        return between("", self.corners[a], self.corners[b]) if found is None else found

    def triangles(self) -> list[tuple[int, int, int]] | None:
        """Triangles that fill the region at every test value; None where there are none."""
        at = np.stack([np.stack([self.probe(c)[0] for c in corner], axis=-1) for corner in self.corners], axis=1)
        if not np.isfinite(at).all():
            return None
        outer = at[:, self.rings[0]]
        at = at / np.sqrt(np.abs(cross(outer, np.roll(outer, -1, axis=1)).sum(axis=1)))[:, None, None]
        outline = self.joined(at)
        return None if outline is None else _ears(at, outline)

    def joined(self, at: np.ndarray) -> list[int] | None:
        """One ring of all, each hole tied to what is there by a bridge that nothing crosses."""
        lines = np.array([(a, b) for ring in self.rings for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)])
        if any(meets(at, a, b, lines).any() for a, b in lines) or not self.apart(at):
            return None
        outline = list(self.rings[0])
        tied: set[int] = set()
        for hole in sorted(self.rings[1:], key=lambda ring: -at[0, ring, 0].max()):
            far = ((at[:, outline, None] - at[:, None, hole]) ** 2).sum(axis=-1).max(axis=0)
            for place in np.argsort(far, axis=None, kind="stable"):
                k, m = divmod(int(place), len(hole))
                a, b = outline[k], hole[m]
                if a not in tied and not meets(at, a, b, lines).any():
                    break
            else:
                return None
            tied |= {a, b}
            lines = np.concatenate([lines, [(a, b)]])
            outline[k : k + 1] = [a, *hole[m:], *hole[:m], b, a]
        return outline

    def apart(self, at: np.ndarray) -> bool:
        """Whether every hole lies within the outer ring and outside the other holes, at a corner of it."""
        for hole in self.rings[1:]:
            place = at[:, hole[0]]
            if not _contains(at[:, self.rings[0]], place).all():
                return False
            if any(_contains(at[:, other], place).any() for other in self.rings[1:] if other is not hole):
                return False
        return True


def _contains(ring: np.ndarray, place: np.ndarray) -> np.ndarray:
    """(rows,): whether places (rows, 2) lie in rings (rows, n, 2), by how often a ray to +x crosses them."""
    a, b, p = ring, np.roll(ring, -1, axis=1), place[:, None]
    passes = (a[..., 1] <= p[..., 1]) != (b[..., 1] <= p[..., 1])
    right = (cross(b - a, p - a) > 0) == (b[..., 1] > a[..., 1])
    return (passes & right).sum(axis=1) % 2 == 1


def meets(at: np.ndarray, a: int, b: int, lines: np.ndarray) -> np.ndarray:
    """(lines,): whether the line from corner a to corner b meets others beyond a common corner, at some test value."""
    one, other = lines[:, 0], lines[:, 1]
    start, way = at[:, None, a], at[:, None, b] - at[:, None, a]
    first, second = at[:, one], at[:, other]
    across = cross(way, first - start) * cross(way, second - start)
    along = second - first
    back = cross(along, start - first) * cross(along, start + way - first)
    apart = (one != a) & (one != b) & (other != a) & (other != b)
    reach = np.minimum(np.maximum(start, start + way), np.maximum(first, second)) - np.maximum(
        np.minimum(start, start + way), np.minimum(first, second)
    )
    found = (across <= CLOSE**2) & (back <= CLOSE**2) & (reach >= -CLOSE).all(axis=-1) & apart
    for own, end, sign in ((a, b, 1.0), (b, a, -1.0)):
        shared = ((one == own) ^ (other == own)) & (one != end) & (other != end)
        away = np.where((one == own)[:, None], second, first) - at[:, None, own]
        ahead = (away * way).sum(axis=-1) * sign > 0
        found |= shared & ahead & (np.abs(cross(way, away)) <= CLOSE)
    return found.any(axis=0)


def _ears(at: np.ndarray, outline: list[int]) -> list[tuple[int, int, int]] | None:
    """Triangles that fill a ring, cut off corner by corner, the best shaped first; None where no corner can be."""
    left, found = list(outline), []
    while len(left) > 2:
        a, b, c = np.roll(left, 1), np.array(left), np.roll(left, -1)
        wide = cross(at[:, b] - at[:, a], at[:, c] - at[:, b])
        long = np.maximum.reduce([((at[:, q] - at[:, p]) ** 2).sum(axis=-1) for p, q in ((a, b), (b, c), (c, a))])
        shape = np.where((wide > CLOSE) & (a != c), wide / np.maximum(long, CLOSE), -1.0).min(axis=0)
        for k in np.argsort(-shape, kind="stable"):
            ear = int(a[k]), int(b[k]), int(c[k])
            if shape[k] <= 0:
                return None
            if not occupied(at, ear, left):
                break
        else:
            return None
        found.append(ear)
        left.pop(k)
    return found
