"""Sections along a path: ``loft`` between two or more of them, and ``sweep`` of one that is not a circle.

* ``loft(base, ..., top) along z from a to b`` (or ``at [a, ..., b]``): closed curves at levels of an axis, given in the
  two coordinates across it in cyclic order; from one to the next every place runs straight.
* ``loft(first, last) along path up y``: a bar whose section changes evenly over the length of a path.
* ``sweep(outer[, inner]) along path up y``: one section all along. Sections are given in (side, up) coordinates, side
  = up x direction of the path.

The path lies in a plane across ``up``, an axis, so that the section never turns about it. Curves of two sections are
paired in their order. Surfaces bear the names of the first section's curves; the ends are ``start`` and ``end``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..graph import expr as E
from ..graph.expr import ONE, ZERO, Expr
from ..graph.primitive import Patch, Piece, Triple
from ..syntax import ast
from .curves import TURN, Curve, spans_of
from .env import Env
from .evaluate import Evaluator
from .faces import frame_of
from .made import Made, U, clause
from .paths import Handed, Stretch, steps_of, stretches
from .probe import Probe
from .profiles import SLOPE, Point, Side, Span, V, circular, distance, equal_steps, extreme, orientation, straight
from .rails import foot, path_of, reach
from .regions import axis_of, chains_of, outline, turned
from .strips import convex, parts
from .values import Frame
from .vectors import cross, dot, minus, plus, signed_axis, times, unit

BLEND = E.var("section")  # 0 at the first section of a bay, 1 at its last
X, Y = E.var("section.x"), E.var("section.y")
BLENDS = (0.0, 0.25, 0.5, 0.75, 1.0)
CUT = 0.2  # of the inradius of a section may be cut off by a step of a piece
GAP = 0.06  # of that of a part of a section: the gaps lie within the solid
MOST = 24  # steps of a bay
Chains = list[list[Span]]


@dataclass(frozen=True, slots=True, eq=False)
class Bay:
    """A stretch of the path with the sections at its ends; ``side`` gives the vector across at v."""

    rail: Stretch
    side: Callable[[float | Expr], Triple]
    up: Triple
    first: Chains
    last: Chains

    def section(self, blend: Expr) -> Chains:
        """The section between the two."""
        return [
            [mixed(a, b, blend) for a, b in zip(*pair, strict=True)] for pair in zip(self.first, self.last, strict=True)
        ]

    def place(self, across: Point, v: Expr | float) -> Triple:
        at = tuple(E.substitute(c, {V: E.wrap(v)}) for c in self.rail.place)
        return plus(at, plus(times(self.side(v), across[0]), times(self.up, across[1])))  # type: ignore[arg-type]

    @property
    def even(self) -> bool:
        return self.first is self.last


def mixed(a: Span, b: Span, blend: Expr) -> Span:
    """A curve between two, both over v = 0 .. 1."""
    if a is b:
        return a
    ends = zip(a.by_fraction, b.by_fraction, strict=True)
    position = tuple(E.add(p, E.mul(blend, E.sub(q, p))) for p, q in ends)
    return Span(a.name, position, ZERO, ONE, a.closing)  # type: ignore[arg-type]


def loft(env: Env, solid: ast.SolidDecl) -> Made:
    """A solid through several sections."""
    if len(solid.arguments) < 2:
        raise env.context.error(
            "wrong-arguments",
            solid.span,
            "`loft` takes two sections or more",
            hint="loft(base, top) along z from 0 to h",
        )
    probe = Probe(env, solid.span)
    node = clause(solid, "along")
    path = env.find(node.name) if isinstance(node, ast.NameExpr) else None
    sections = alike(probe, [spans_of(Evaluator(env), a.value) for a in solid.arguments])
    for section, argument in zip(sections, solid.arguments, strict=True):
        if len(section) != len(sections[0]):
            raise env.context.error(
                "broken-chain", argument.span,
                f"the first section has {len(sections[0])} curves, this one {len(section)}",
                hint="sections have as many curves each, in the same order: each runs to its partner",
            )  # fmt: skip
        ends = zip(section, [*section[1:], section[0]], strict=True)
        if not all(probe.same(a.end, b.start) for a, b in ends):
            raise env.context.error("broken-chain", argument.span, "a section is a closed curve, but this one is open")
    if isinstance(path, Curve | Handed):
        if len(sections) != 2:
            raise env.context.error("wrong-arguments", solid.span, "along a path `loft` takes two sections")
        return along_path(env, probe, solid, path, [sections[0]], [sections[1]])
    axis = axis_of(env, solid, "along")
    levels = levels_of(env, solid, len(sections))
    bays = []
    for k in range(len(sections) - 1):
        height = E.sub(levels[k + 1], levels[k])
        rail = Stretch(turned(axis, (ZERO, ZERO), E.add(levels[k], E.mul(V, height))), unit(axis), height)
        bays.append(Bay(rail, lambda v: unit((axis + 1) % 3), unit((axis + 2) % 3), [sections[k]], [sections[k + 1]]))
    spans = [span for section in sections for span in section]
    low, high = (
        turned(axis, (extreme(probe, spans, 0, s), extreme(probe, spans, 1, s)), levels[-(s > 0)]) for s in (-1, 1)
    )
    rises = tuple((a, b, "the sections do not rise") for a, b in zip(levels, levels[1:], strict=False))
    return made_of(env, probe, solid, bays, low, high, {}, rises)


def alike(probe: Probe, sections: Chains) -> Chains:
    """Sections where a circle beside outlines of several curves is cut into as many arcs, from the nearest 15 degrees."""
    pattern = next((s for s in sections if len(s) > 1), None)
    if pattern is None:
        return sections
    found = []
    for section in sections:
        arc = circular(probe, section[0]) if len(section) == 1 else None
        if arc is None or not probe.same(section[0].start, section[0].end):
            found.append(section)
            continue
        x, y = probe(*pattern[0].start)
        step = TURN / 24
        begin = round(float(np.arctan2(np.sign(y).mean(), np.sign(x).mean())) / step) * step
        way = float(probe(orientation(probe, tuple(map(Side, pattern))))[0, 0]) * TURN / len(pattern)
        arcs = []
        for k in range(len(pattern)):
            angle = E.add(E.const(begin + way * k), E.mul(V, E.const(way)))
            place = (
                E.add(c, E.mul(arc.radius, E.call(f, angle))) for c, f in zip(arc.center, ("cos", "sin"), strict=True)
            )
            arcs.append(Span(section[0].name, tuple(place)))  # type: ignore[arg-type]
        found.append(arcs)
    return found


def levels_of(env: Env, solid: ast.SolidDecl, count: int) -> list[Expr]:
    """Where the sections of a loft along an axis stand."""
    ev = Evaluator(env)
    at, ends = clause(solid, "at"), [clause(solid, word) for word in ("from", "to")]
    if at is not None:
        if isinstance(at, ast.VectorExpr) and len(at.items) == count:
            return [ev.scalar(level) for level in at.items]
        raise env.context.error(
            "wrong-arguments", at.span, f"there are {count} sections, so `at` takes a list of {count} levels"
        )
    if ends[0] is None or ends[1] is None:
        raise env.context.error(
            "wrong-arguments", solid.span, "`loft` needs the levels of its sections",
            hint="loft(base, top) along z from 0 to h, or: along z at [0, h1, h2]",
        )  # fmt: skip
    low, high = (ev.scalar(node) for node in ends if node is not None)
    return [E.add(low, E.mul(E.const(k / (count - 1)), E.sub(high, low))) for k in range(count - 1)] + [high]


def swept(env: Env, solid: ast.SolidDecl) -> Made:
    """``sweep`` of a section that is no circle."""
    probe, path = Probe(env, solid.span), path_of(env, solid)
    chains = chains_of(env, probe, solid)
    return along_path(env, probe, solid, path, chains, chains)


def along_path(env: Env, probe: Probe, solid: ast.SolidDecl, path: Curve | Handed, first: Chains, last: Chains) -> Made:
    node = clause(solid, "up")
    up = Evaluator(env).direction(node) if node is not None else unit(2)
    rails = stretches(path.steps if isinstance(path, Handed) else steps_of(path))
    upright = signed_axis(up)
    across = [dot(up, rail.towards(k / 4)) for rail in rails for k in range(5)]
    if upright is None or not probe.zero(*across):
        raise env.context.error(
            "bad-curve", solid.span if node is None else node.span,
            "a section that is no circle is swept along a path in a plane, and `up` is the axis across that plane",
            hint="a path in the plane of x and z goes with `up y`",
        )  # fmt: skip
    if first is not last and any(rail.length is ZERO for rail in rails):
        raise env.context.error(
            "bad-curve", solid.span, "a section that changes goes along a path of lines and arcs",
            hint="write the path as from(point, direction) line(length) arc(...)",
        )  # fmt: skip
    total = sum_of([rail.length for rail in rails])
    bays, gone = [], ZERO
    whole = Bay(rails[0], lambda v: up, up, first, last)
    for rail in rails:
        side = beside(cross(up, rail.direction))
        ahead = E.add(gone, rail.length)
        if first is last:
            ends = first, first
        elif len(rails) == 1:
            ends = first, last
        else:
            ends = whole.section(E.div(gone, total)), last if rail is rails[-1] else whole.section(E.div(ahead, total))
        bays.append(Bay(rail, side, up, *ends))
        gone = ahead
    requires = []
    spans = [span for section in (first[0], *([] if first is last else [last[0]])) for span in section]
    sides = [extreme(probe, spans, 0, sign) for sign in (-1, 1)]
    for bay in bays:
        if bay.rail.center is not None and bay.rail.out is not None:
            inward = E.neg(dot(bay.side(0.0), bay.rail.out))
            wide = E.maximum(E.mul(inward, sides[0]), E.mul(inward, sides[1]))
            requires.append((wide, bay.rail.radius, "an arc of the path is narrower than the section"))
    ports = {
        "start": Frame(rails[0].at(0.0), frame_of(times(rails[0].towards(0.0), E.const(-1.0)), up)),
        "end": Frame(rails[-1].at(1.0), frame_of(rails[-1].towards(1.0), up)),
    }
    bounds = []
    for sign in (-1, 1):
        rows = []
        for axis in range(3):
            if axis == upright[0]:
                level = rails[0].at(0.0)[axis]
                highest = extreme(probe, spans, 1, sign * upright[1])
                rows.append(E.add(level, highest if upright[1] > 0 else E.neg(highest)))
            else:
                reached = [[extreme(probe, c[0], 0, s) for c in (bay.first, bay.last)] for bay in bays for s in (-1, 1)]
                rows.append(reach(probe, [(b.rail, b.side) for b in bays for _ in (0, 1)], reached, axis, sign))
        bounds.append(tuple(rows))
    return made_of(env, probe, solid, bays, bounds[0], bounds[1], ports, tuple(requires))  # type: ignore[arg-type]


def beside(vector: Triple) -> Callable[[float | Expr], Triple]:
    """A vector along a path as a function of v."""
    return lambda v: tuple(E.substitute(c, {V: E.wrap(v)}) for c in vector)  # type: ignore[return-value]


def made_of(
    env: Env,
    probe: Probe,
    solid: ast.SolidDecl,
    bays: list[Bay],
    low: Triple,
    high: Triple,
    ports: dict,
    requires: tuple,
) -> Made:
    """Surfaces, inside function and pieces of bays one after another."""
    patches, pieces = [], []
    inside: Expr | None = None
    slowest = E.maximum(*(lean(probe, bay) for bay in bays))
    for number, bay in enumerate(bays):
        chains = bay.section(BLEND)
        seen = probe if bay.even else probe.spread(str(BLEND.value), BLENDS)
        loops, fill = outline(env, seen, solid, chains)
        if any(side.span.closing for loop, _ in loops for side in loop):
            raise env.context.error("broken-chain", solid.span, "a section is a closed curve, but this one is open")
        for chain in chains:
            for span in chain:
                across = swapped(span.position, {V: U, BLEND: V})
                patches.append(Patch(span.name, bay.place(across, V), (span.low, span.high), (ZERO, ONE)))
        for name, here, end in (("start", number == 0, 0.0), ("end", number == len(bays) - 1, 1.0)):
            for one, other in fill if here else ():
                within = [E.add(b, E.mul(U, E.sub(a, b))) for a, b in zip(one.position, other.position, strict=True)]
                place = bay.place(swapped(within, {BLEND: E.const(end)}), end)
                patches.append(Patch(name, place, (ZERO, ONE), (one.low, one.high)))
        value = inside_bay(
            probe, bay, E.div(distance(seen, loops, (X, Y)), slowest), number == 0, number == len(bays) - 1
        )
        inside = value if inside is None else E.minimum(inside, value)
        solid_section = len(loops) == 1 and convex(seen, loops[0][0], mirrored=False)
        pieces += bay_pieces(seen, probe, bay, f"bay_{number}", polygons(seen, loops, fill, solid_section))
    assert inside is not None
    return Made(tuple(patches), tuple(pieces), inside, low, high, ports, requires)


def swapped(point: Sequence[Expr], mapping: dict[Expr, Expr]) -> Point:
    return tuple(E.substitute(c, mapping) for c in point)  # type: ignore[return-value]


def inside_bay(probe: Probe, bay: Bay, flat: Expr, begins: bool, closes: bool) -> Expr:
    """``flat``, a length in the section, where the foot of p on the path lies; cut off at the ends of the whole path."""
    at = foot(probe, bay.rail, bay.side, bay.up)
    value = E.substitute(flat, {X: at.x, Y: at.y, BLEND: at.v})
    if not bay.even and bay.rail.center is not None:  # near the axis of an arc the section changes ever faster
        value = E.mul(value, E.minimum(ONE, E.div(at.away, clearance(probe, bay))))
    gaps = [gap for gap, cut in ((at.before, begins), (at.after, closes)) if not cut]
    if gaps:  # beyond a joint the next bay goes on
        gap = E.maximum(*gaps)
        value = E.where(E.call("lt", ZERO, gap), E.maximum(value, gap), value)
    value = E.maximum(value, *(cap for cap, cut in ((at.start, begins), (at.end, closes)) if cut))
    return E.mul(value, SLOPE) if bay.rail.length is ZERO else value


def clearance(probe: Probe, bay: Bay) -> Expr:
    """How far the sections of an arc stay from its axis."""
    spans = [span for side in (bay.first, bay.last) for span in side[0]]
    inward = E.neg(dot(bay.side(0.0), bay.rail.out))  # type: ignore[arg-type]
    reached = (E.mul(inward, extreme(probe, spans, 0, sign)) for sign in (-1, 1))
    return E.sub(bay.rail.radius, E.maximum(*reached))


def lean(probe: Probe, bay: Bay) -> Expr:
    """The greatest slope that a distance in the section has in space, for the section changes along the path."""
    if bay.even:
        return ONE
    moves = []
    for a, b in zip(bay.first[0], bay.last[0], strict=True):
        count = 1 if straight(probe, a) and straight(probe, b) else 16
        for k in range(count + 1):
            d = [E.sub(q, p) for p, q in zip(a.fraction(k / count), b.fraction(k / count), strict=True)]
            moves.append(E.mul(E.call("hypot", *d), E.const(1.0 if count == 1 else 1.05)))
    change = E.div(E.maximum(*moves), bay.rail.length)
    if bay.rail.center is None:
        return E.call("hypot", ONE, change)
    steep = E.div(bay.rail.radius, clearance(probe, bay))
    half = E.mul(bay.rail.angle, E.const(0.5))
    change = E.mul(change, E.maximum(ONE, E.div(half, E.sub(E.const(TURN / 2), half))))  # behind the axis it turns back
    return E.add(E.call("hypot", ONE, E.mul(change, steep)), E.mul(E.const(1.5), steep))  # the second for the fading


# ---------------------------------------------------------------- pieces


def polygons(probe: Probe, loops: list, fill: list, solid_section: bool) -> list[list[Point]]:
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
    ends = [extreme(probe, spans, 0, sign) for sign in (-1, 1)]
    bent = bay.rail.center is not None or bay.rail.length is ZERO
    for number, corners in enumerate(sections):
        corners = [c for k, c in enumerate(corners) if not seen.same(c, corners[k - 1])]
        middle = tuple(E.div(sum_of([c[k] for c in corners]), E.const(float(len(corners)))) for k in (0, 1))
        narrow = inradius(corners, middle)  # type: ignore[arg-type]
        for count in (1, 2, 3, 4, 6, 8, 12, 16, MOST):
            if bent and count < 3:
                continue
            lost = [change(probe, corners, narrow, k / count, (k + 1) / count) for k in range(count)]
            cuts = [sagitta(bay, ends, k / count, (k + 1) / count) if bent else ZERO for k in range(count)]
            least = [E.substitute(narrow, {BLEND: E.const((k + 0.5) / count)}) for k in range(count)]
            share = probe(*(E.div(a, b) for a, b in zip(cuts, least, strict=True)))
            if ((share.max(axis=0) + max(lost)) <= (CUT if len(sections) == 1 else GAP)).mean() > 0.98:
                break
        for k in range(count):
            keep = E.maximum(E.sub(E.const(1.0 - lost[k]), E.div(cuts[k], least[k])), E.const(0.02))
            points = []
            for v in (k / count, (k + 1) / count):
                hub = swapped(middle, {BLEND: E.const(v)})
                for corner in corners:
                    here = swapped(corner, {BLEND: E.const(v)})
                    drawn = tuple(E.add(h, E.mul(keep, E.sub(c, h))) for c, h in zip(here, hub, strict=True))
                    points.append(bay.place(drawn, v))  # type: ignore[arg-type]
            made.append(Piece(f"{name}_{number}_{k}", tuple(points)))
    return made


def sum_of(values: Sequence[Expr]) -> Expr:
    total = ZERO
    for value in values:
        total = E.add(total, value)
    return total


def inradius(corners: list[Point], middle: Point) -> Expr:
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


def change(probe: Probe, corners: list[Point], narrow: Expr, low: float, high: float) -> float:
    """By what share a hull between two polygons must be drawn in to lie within the straight lines between partners.

    Halfway the hull is the polygon of all middles between a corner of one and a corner of the other.
    """
    places = []
    for blend in (low, high, (low + high) / 2):
        values = probe(*(c for corner in corners for c in swapped(corner, {BLEND: E.const(blend)})))
        places.append(values.T.reshape(values.shape[1], len(corners), 2))
    first, last, half = places
    between = (first[:, :, None] + last[:, None]).reshape(len(half), -1, 2) / 2
    edge = np.roll(half, -1, axis=1) - half
    away = between[:, :, None] - half[:, None]
    turns = np.sign(
        (half[..., 0] * np.roll(half, -1, axis=1)[..., 1] - half[..., 1] * np.roll(half, -1, axis=1)[..., 0]).sum(
            axis=1
        )
    )
    reach = (away[..., 0] * edge[:, None, :, 1] - away[..., 1] * edge[:, None, :, 0]) * turns[:, None, None]
    reach = reach / np.sqrt((edge**2).sum(axis=-1))[:, None]
    least = probe(E.substitute(narrow, {BLEND: E.const((low + high) / 2)}))[0]
    share = float((reach.max(axis=(1, 2)) / least).max())
    return 0.0 if share < 1e-7 else min(1.05 * share, 0.9)


def sagitta(bay: Bay, ends: list[Expr], low: float, high: float) -> Expr:
    """How far a chord along the path cuts off a bend, at either side of the section."""
    cuts = []
    for x in ends:
        a, b, half = (bay.place((x, ZERO), v) for v in (low, high, (low + high) / 2))
        away = minus(half, times(plus(a, b), E.const(0.5)))
        cuts.append(E.call("sqrt", dot(away, away)))
    return E.mul(E.maximum(*cuts), E.const(1.02 if bay.rail.center is not None else 1.2))
