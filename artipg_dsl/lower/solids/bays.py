"""A stretch of a path with sections at its ends, and the convex pieces that fill it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import Piece, Triple, pair
from ...graph.substitution import substitute, substitute_all
from ...records import dataclass
from ..values.vectors import dot, minus, plus, times
from .curves import TURN
from .frames import Frames, turning
from .paths import Stretch, turned
from .probe import Probe
from .profiles import Loop, Point, Side, Span, between, equal_steps, extreme, orientation, right_of, straight
from .profiles import dot as flat_dot
from .profiles import minus as flat_minus
from .regions import Strips
from .smooth import Course
from .strips import parts

BLEND = E.var("section")  # 0 at the first section of a bay, 1 at its last
_CUT = 0.2  # of the inradius of a section may be cut off by a step of a piece
_GAP = 0.06  # of that of a part of a section: the gaps lie within the solid
_ALIKE = 1e-3  # so much do steps differ in what they lose that are one piece with a number
_INNER = (0.25, 0.5, 0.75)  # places of a step at which a smooth course is compared with a straight one
MOST = 24  # steps of a bay, for each turn of a path that winds
Chains = list[list[Span]]


@dataclass(frozen=True, slots=True, eq=False)
class Bay:
    """A stretch of the path with the sections at its ends, and how they stand across it."""

    rail: Stretch
    frames: Frames
    first: Chains
    last: Chains
    course: Course | None = None  # how one becomes the other; None: along straight lines

    def section(self, blend: Expr) -> Chains:
        """The section between the two."""
        mix = mixed if self.course is None else self.course.mixed
        return [
            [mix(a, b, blend) for a, b in zip(*pair, strict=True)] for pair in zip(self.first, self.last, strict=True)
        ]

    def place(self, across: Point, v: Expr | float) -> Triple:
        return plus(self.rail.at(v), plus(times(self.frames.side(v), across[0]), times(self.frames.up(v), across[1])))

    @property
    def even(self) -> bool:
        return self.first is self.last

    @property
    def ends(self) -> tuple[Chains, Chains]:
        return self.first, self.last


def mixed(a: Span, b: Span, blend: Expr) -> Span:
    """A curve between two, both over v = 0 .. 1."""
    if a is b:
        return a
    ends = zip(a.by_fraction, b.by_fraction, strict=True)
    position = pair(E.add(p, E.mul(blend, E.sub(q, p))) for p, q in ends)
    return Span(a.name, position, ZERO, ONE, a.closing)


def swapped(point: Sequence[Expr], mapping: dict[Expr, Expr]) -> Point:
    return pair(substitute_all(point, mapping))


# ---------------------------------------------------------------- pieces


def polygons(probe: Probe, loops: list[tuple[Loop, bool]], fill: Strips, solid_section: bool) -> list[list[Point]]:
    """Convex polygons that fill a section: one, or the steps of its strips."""
    if solid_section:
        corners = []
        for side in loops[0][0]:
            count = 1 if straight(probe, side.span) else equal_steps(probe, side.span, np.radians(30.0), 12)
            corners += [side.span.fraction(k / count) for k in range(count)]
        return [corners]
    return parts(probe, fill, orientation(probe, loops[0][0]))


def bay_pieces(seen: Probe, probe: Probe, bay: Bay, name: str, sections: list[list[Point]]) -> list[Piece]:
    """Hulls between the polygons at the ends of steps, drawn in by what the bend and the change of section cut off."""
    made = []
    spans = [span for side in (bay.first, bay.last) for span in side[0]]
    ends: list[Point] = [(extreme(probe, spans, 0, sign), ZERO) for sign in (-1, 1)]
    if not bay.frames.plain:
        ends += [(ZERO, extreme(probe, spans, 1, sign)) for sign in (-1, 1)]
    twist, wide = turning(bay.rail, bay.frames), E.maximum(*(E.call("hypot", *end) for end in ends))
    bent = bay.rail.center is not None or bay.rail.length is ZERO
    for number, corners in enumerate(sections):
        corners = [c for k, c in enumerate(corners) if not seen.same(c, corners[k - 1])]
        rings = Rings(probe, corners)
        middle = pair(E.div(E.total(c[k] for c in corners), E.const(float(len(corners)))) for k in (0, 1))
        narrow = _inradius(corners, middle)
        ring = zip(corners, [*corners[1:], corners[0]], strict=True)
        sign = ONE if bay.course is None else orientation(seen, tuple(Side(between("", a, b)) for a, b in ring))
        drawn = _Steps(bay, rings, middle, narrow, sign, ends if bent else [], wide, twist)
        turns = turned(probe, bay.rail) / TURN if bay.rail.length is ZERO else 1.0
        most = MOST if turns < 1.01 else 2 * MOST * np.ceil(turns)
        for count in (c for c in (1, 2, 3, 4, 6, 8, 12, 16, 24, 48, 72, 96, 144, 192) if c <= most):
            if bent and count < 3:
                continue
            lost = [rings.change(narrow, k / count, (k + 1) / count) for k in range(count)]
            share = probe(*(drawn.share(E.const(float(k)), count) for k in range(count)))
            if ((share.max(axis=0) + max(lost)) <= (_CUT if len(sections) == 1 else _GAP)).mean() > 0.98:
                break
        label = f"{name}_{number}"
        if count > 1 and max(lost) - min(lost) < _ALIKE:
            made.append(Piece(label, drawn.corners(E.var("i"), count, max(lost)), E.const(float(count))))
        else:
            made += [
                Piece(f"{label}_{k}", drawn.corners(E.const(float(k)), count, share)) for k, share in enumerate(lost)
            ]
    return made


@dataclass(frozen=True, slots=True, eq=False)
class _Steps:
    """The hulls between a polygon and itself a step on; ``k``, a formula, is the step, of ``count``."""

    bay: Bay
    rings: Rings
    middle: Point
    narrow: Expr
    sign: Expr
    ends: list[Point]  # the sides of the section, where the path bends
    wide: Expr
    twist: Expr

    def share(self, k: Expr, count: int) -> Expr:
        """Of the inradius there, what the bend, the turn about the path and the change of section cut off."""
        low, half, high = (_place(k, f, count) for f in (0.0, 0.5, 1.0))
        if self.bay.course is not None:
            cut = _hollow(self.rings, self.sign, low, high)
            least = E.minimum(*(substitute(self.narrow, {BLEND: _place(k, f, count)}) for f in _INNER))
        else:
            cut = _sagitta(self.bay, self.ends, low, half, high) if self.ends else ZERO
            if self.twist is not ZERO:
                cut = E.add(cut, _screwed(self.bay, self.wide, self.twist, low, high))
            least = substitute(self.narrow, {BLEND: half})
        return E.div(cut, least)

    def corners(self, k: Expr, count: int, lost: float) -> tuple[Triple, ...]:
        """Of both polygons, drawn in by their share and what else is ``lost``."""
        keep = E.maximum(E.sub(E.const(1.0 - lost), self.share(k, count)), E.const(0.02))
        points = []
        for v in (_place(k, f, count) for f in (0.0, 1.0)):
            hub = swapped(self.middle, {BLEND: v})
            for here in self.rings.at(v):
                drawn = pair(E.add(h, E.mul(keep, E.sub(c, h))) for c, h in zip(here, hub, strict=True))
                points.append(self.bay.place(drawn, v))
        return tuple(points)


def _place(k: Expr, share: float, count: int) -> Expr:
    """The place along a bay at a share of step ``k``."""
    return E.div(E.add(k, E.const(share)), E.const(float(count)))


def _inradius(corners: list[Point], middle: Point) -> Expr:
    """How far the edges of a polygon lie from its middle, at least."""
    found = []
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        edge, away = (
            [E.sub(q, p) for p, q in zip(a, b, strict=True)],
            [E.sub(m, p) for m, p in zip(middle, a, strict=True)],
        )
        area = E.sub(E.mul(edge[0], away[1]), E.mul(edge[1], away[0]))
        found.append(E.div(E.call("abs", area), E.maximum(E.call("hypot", *edge), E.const(1e-300))))
    return E.minimum(*found)


def _hollow(rings: Rings, sign: Expr, low: Expr, high: Expr) -> Expr:
    """How far a hull between two polygons reaches beyond the edges of what a smooth course leaves between them, at most.

    ``sign`` is +1 where they run anticlockwise. Three places of the step are asked: between them a cubic lies no more than
    a twentieth further off.
    """
    ends = [rings.at(v) for v in (low, high)]
    found = []
    for f in _INNER:
        ring = rings.at(E.add(low, E.mul(E.const(f), E.sub(high, low))))
        away = [flat_minus(_toward(a, b, f), c) for a, b, c in zip(*ends, ring, strict=True)]
        edges = [right_of(flat_minus(b, a), sign) for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
        found += [flat_dot(away[(k + d) % len(ring)], edge) for k, edge in enumerate(edges) for d in (0, 1)]
    return E.mul(E.maximum(ZERO, *found), E.const(1.1))


def _toward(a: Point, b: Point, share: float) -> Point:
    return pair(E.add(p, E.mul(E.const(share), E.sub(q, p))) for p, q in zip(a, b, strict=True))


class Rings:
    """The corners of a polygon at places along a bay, and their test values (rows, corners, 2): neighbours ask for the same ones."""

    def __init__(self, probe: Probe, corners: Sequence[Point]):
        self.probe, self.corners = probe, corners
        self.known: dict[float, np.ndarray] = {}
        self.even = not any(c.reads & BLEND.reads for corner in corners for c in corner)
        self.changes: dict[tuple[float, float], float] = {}

    def at(self, v: Expr) -> list[Point]:
        return [swapped(corner, {BLEND: v}) for corner in self.corners]

    def shown(self, v: float) -> np.ndarray:
        if v not in self.known:
            values = self.probe(*(c for corner in self.at(E.const(v)) for c in corner))
            self.known[v] = values.T.reshape(values.shape[1], len(self.corners), 2)
        return self.known[v]

    def change(self, narrow: Expr, low: float, high: float) -> float:
        """By what share a hull between two polygons must be drawn in to lie within the straight lines between partners.

        Halfway the hull is the polygon of all middles between a corner of one and a corner of the other.
        """
        step = (0.0, 0.0) if self.even else (low, high)
        if step not in self.changes:
            first, last = map(self.shown, step)
            half = (first + last) / 2
            pairs = (first[:, :, None] + last[:, None]).reshape(len(half), -1, 2) / 2
            least = self.probe(substitute(narrow, {BLEND: E.const((low + high) / 2)}))[0]
            share = float((_beyond(half, pairs).max(axis=(1, 2)) / least).max())
            self.changes[step] = 0.0 if share < 1e-7 else min(1.05 * share, 0.9)
        return self.changes[step]


def _beyond(ring: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(rows, points, edges): how far points (rows, points, 2) lie beyond each edge of a polygon (rows, edges, 2)."""
    following = np.roll(ring, -1, axis=1)
    edge = following - ring
    turns = np.sign((ring[..., 0] * following[..., 1] - ring[..., 1] * following[..., 0]).sum(axis=1))
    away = points[:, :, None] - ring[:, None]
    reach = (away[..., 0] * edge[:, None, :, 1] - away[..., 1] * edge[:, None, :, 0]) * turns[:, None, None]
    return reach / np.sqrt((edge**2).sum(axis=-1))[:, None]


def _sagitta(bay: Bay, ends: list[Point], low: Expr, half: Expr, high: Expr) -> Expr:
    """How far a chord along the path cuts off a bend, at the sides of the section."""
    cuts = []
    for across in ends:
        a, middle, b = (bay.place(across, v) for v in (low, half, high))
        away = minus(middle, times(plus(a, b), E.const(0.5)))
        cuts.append(E.call("sqrt", dot(away, away)))
    return E.mul(E.maximum(*cuts), E.const(1.02 if bay.rail.center is not None else 1.2))


def _screwed(bay: Bay, wide: Expr, twist: Expr, low: Expr, high: Expr) -> Expr:
    """What a hull between two sections reaches beyond what turns about the path from one to the other, at most."""
    way = minus(bay.rail.at(high), bay.rail.at(low))
    angle = E.mul(twist, E.call("sqrt", dot(way, way)))
    return E.mul(wide, E.mul(angle, angle))
