"""Convex pieces that fill bays: the hulls between polygons of a section and the same ones a step on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise

import numpy as np

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import Piece, Triple, pair, triple
from ...graph.substitution import substitute, substitute_all
from ...records import dataclass
from ..values.vectors import dot, minus, plus, times
from .bays import BLEND, Bay, swapped
from .curves import TURN
from .frames import turning
from .numbered import NUMBER, Bays, select
from .paths import turned
from .probe import Probe
from .profiles import Loop, Point, Side, between, equal_steps, extreme, orientation, right_of, straight
from .profiles import dot as flat_dot
from .profiles import minus as flat_minus
from .regions import Strips
from .strips import parts

_CUT = 0.2  # of the inradius of a section may be cut off by a step of a piece
_GAP = 0.06  # of that of a part of a section: the gaps lie within the solid
_INNER = (0.25, 0.5, 0.75)  # places of a step at which a smooth course is compared with a straight one
_MOST = 24  # steps of a bay, for each turn of a path that winds


def polygons(probe: Probe, loops: list[tuple[Loop, bool]], fill: Strips, solid_section: bool) -> list[list[Point]]:
    """Convex polygons that fill a section: one, or the steps of its strips."""
    if solid_section:
        corners = []
        for side in loops[0][0]:
            count = 1 if straight(probe, side.span) else equal_steps(probe, side.span, np.radians(30.0), 12)
            corners += [side.span.fraction(k / count) for k in range(count)]
        return [corners]
    return parts(probe, fill, orientation(probe, loops[0][0]))


def bay_pieces(seen: Probe, probe: Probe, group: Bays, name: str, sections: list[list[Point]]) -> list[Piece]:
    """Hulls between the polygons at the ends of steps, drawn in by what the bend and the change of section cut off."""
    made = []
    bay, probe = group.one, group.spread(probe)
    twist = turning(bay.rail, bay.frames)
    bent = bay.rail.center is not None or bay.rail.length is ZERO
    ends = _ends(probe, bay) if bent or twist is not ZERO else []
    turns = turned(probe, bay.rail) / TURN if bay.rail.length is ZERO else 1.0
    most = _MOST if turns < 1.01 else 2 * _MOST * np.ceil(turns)
    counts = [c for c in (1, 2, 3, 4, 6, 8, 12, 16, 24, 48, 72, 96, 144, 192) if (3 if bent else 1) <= c <= most]
    for number, corners in enumerate(sections):
        corners = [c for k, c in enumerate(corners) if not seen.same(c, corners[k - 1])]
        middle = pair(E.div(E.total(c[k] for c in corners), E.const(float(len(corners)))) for k in (0, 1))
        narrow = _inradius(corners, middle)
        rings = Rings(probe, corners, narrow)
        ring = zip(corners, [*corners[1:], corners[0]], strict=True)
        sign = ONE if bay.course is None else orientation(seen, tuple(Side(between("", a, b)) for a, b in ring))
        wide = E.maximum(*(E.call("hypot", *end) for end in ends)) if ends else ZERO
        drawn = _Steps(bay, rings, middle, narrow, sign, ends if bent else [], wide, twist)
        fit = _fitting(probe, drawn, counts, len(group.members), _CUT if len(sections) == 1 else _GAP)
        for first, count, lost in fit:
            made.append(_piece(drawn, f"{name}_{number}", first, count, lost))
    return made


def _ends(probe: Probe, bay: Bay) -> list[Point]:
    """The sides of a section, and where it turns its upper and lower ends."""
    spans = [span for side in (bay.first, bay.last) for span in side[0]]
    ends: list[Point] = [(extreme(probe, spans, 0, sign), ZERO) for sign in (-1, 1)]
    if not bay.frames.plain:
        ends += [(ZERO, extreme(probe, spans, 1, sign)) for sign in (-1, 1)]
    return ends


def _fitting(
    probe: Probe, drawn: _Steps, counts: Sequence[int], bays: int, most: float
) -> Iterator[tuple[int, int, np.ndarray]]:
    """Into how few steps bays are cut that lose at most a share of their inradius: for bays one after another that are cut alike, the
    first of them, the count, and what each step of each loses beside what its formula tells (bays, steps)."""
    found: dict[int, tuple[int, np.ndarray]] = {}
    for count in counts:
        lost = np.array([drawn.rings.change(k, count, bays) for k in range(count)]).T
        share = probe(*(drawn.share(E.const(float(k)), count) for k in range(count))).max(axis=0).reshape(bays, -1)
        fits = ((share + lost.max(axis=1, keepdims=True)) <= most).mean(axis=1) > 0.98
        for bay in range(bays):
            if bay not in found and (fits[bay] or count == counts[-1]):
                found[bay] = count, lost[bay]
        if len(found) == bays:
            break
    for count, alike in groupby(range(bays), key=lambda bay: found[bay][0]):
        held = list(alike)
        yield held[0], count, np.stack([found[bay][1] for bay in held])


def _piece(drawn: _Steps, label: str, first: int, count: int, lost: np.ndarray) -> Piece:
    """The hulls of all steps of bays, told apart by ``i``."""
    many, index = lost.size, E.var("i")
    if many == 1:
        corners, bay, each = drawn.corners(ZERO, 1, E.const(float(lost[0, 0]))), E.const(float(first)), None
    else:
        behind = E.call("floor", E.div(index, E.const(float(count)))) if len(lost) > 1 else ZERO
        step = E.sub(index, E.mul(E.const(float(count)), behind))
        corners = drawn.corners(step, count, select(index, [E.const(one) for one in lost.ravel().tolist()]))
        bay, each = E.add(E.const(float(first)), behind), E.const(float(many))
    if first or many > 1:
        label = f"{label}_{first}"
    return Piece(label, tuple(triple(substitute_all(corner, {NUMBER: bay})) for corner in corners), each)


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

    def corners(self, k: Expr, count: int, lost: Expr) -> tuple[Triple, ...]:
        """Of both polygons, drawn in by their share and what else is ``lost``."""
        keep = E.maximum(E.sub(E.sub(ONE, lost), self.share(k, count)), E.const(0.02))
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
    """The corners of a polygon at places along a bay, and its inradius; with their test values at the places where steps end, and in the
    middle of steps: neighbours ask for the same ones, and all steps of a bay are one call of the formulas."""

    def __init__(self, probe: Probe, corners: Sequence[Point], narrow: Expr):
        self.probe, self.corners, self.narrow = probe, corners, narrow
        self.ends: dict[float, np.ndarray] = {}  # (rows, corners, 2)
        self.least: dict[float, np.ndarray] = {}  # (rows,)
        self.even = not any(c.reads & BLEND.reads for corner in corners for c in corner)
        self.changes: dict[tuple[float, float], np.ndarray] = {}

    def at(self, v: Expr) -> list[Point]:
        return [swapped(corner, {BLEND: v}) for corner in self.corners]

    def change(self, k: int, count: int, bays: int) -> np.ndarray:
        """By what share the hull between two polygons, a step ``k`` of ``count``, must be drawn in to lie within the straight lines between
        partners, in each of the bays over which the rows are spread.

        Halfway the hull is the polygon of all middles between a corner of one and a corner of the other.
        """
        step = (0.0, 0.0) if self.even else (k / count, (k + 1) / count)
        if step not in self.changes:
            self._look(1 if self.even else count)
            first, last = (self.ends[v] for v in step)
            half = (first + last) / 2
            pairs = (first[:, :, None] + last[:, None]).reshape(len(half), -1, 2) / 2
            least = self.least[0.5 if self.even else sum(step) / 2]
            share = (_beyond(half, pairs).max(axis=(1, 2)) / least).reshape(bays, -1).max(axis=1)
            self.changes[step] = np.where(share < 1e-7, 0.0, np.minimum(1.05 * share, 0.9))
        return self.changes[step]

    def _look(self, count: int) -> None:
        """Find the test values of all steps of so many."""
        ends = [k / count for k in range(count + 1)]
        middles = [(a + b) / 2 for a, b in pairwise(ends)]
        if new := [v for v in ends if v not in self.ends]:
            seen = self.probe.along([c for corner in self.corners for c in corner], new, BLEND)
            self.ends.update(
                (v, values.T.reshape(-1, len(self.corners), 2)) for v, values in zip(new, seen, strict=True)
            )
        if new := [v for v in middles if v not in self.least]:
            self.least.update(zip(new, self.probe.along([self.narrow], new, BLEND)[:, 0], strict=True))


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
