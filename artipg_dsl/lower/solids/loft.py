"""Sections along a path: ``loft`` between two or more of them, and ``sweep`` of one that is not a circle.

* ``loft(base, ..., top) along z from a to b`` (or ``at [a, ..., b]``): closed curves at levels of an axis, given in the
  two coordinates across it in cyclic order; from one to the next every place runs straight, or, with ``smooth``, so
  that the outline has no kink (see ``smooth``).
* ``loft(first, last) along path up y``: a bar whose section changes evenly over the length of a path of lines and arcs, or
  over the parameter of a formula.
* ``sweep(outer[, inner]) along path up y``: one section all along. Sections are given in (side, up) coordinates, side
  = up x direction of the path.

How a section stands across its path is told in ``frames``. Curves of two sections are paired in their order. Surfaces
bear the names of the first section's curves; the ends are ``start`` and ``end``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import Patch, Triple, pair, triple
from ...graph.substitution import substitute
from ...syntax import ast
from ..expressions.context import Abort
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.handed import Handed
from ..values.kinds import Value
from ..values.vectors import dot, unit
from .bays import BLEND, Bay, Chains, swapped
from .curves import TURN, Curve, named_curve, spans_of
from .frames import PLACES, ROOM, Frames, bend, inwards, slowest, turning
from .frames import frames as frames_of
from .made import NARROW, Demand, Made, U
from .numbered import NUMBER, Bays, numbered
from .paths import Stretch, steps_of, stretches, windows
from .pieces import bay_pieces, polygons
from .probe import Probe
from .profiles import SLOPE, Side, Span, V, circular, distance, extreme, orientation, straight
from .rails import NEAR, P, check_directions, foot, path_of, ports_of, reach
from .regions import axis_of, chains_of, outline
from .regions import turned as at_level
from .smooth import courses
from .strips import convex
from .summits import W
from .summits import reached as summits

X, Y = E.var("section.at.x"), E.var("section.at.y")
_BLENDS = (0.0, 0.25, 0.5, 0.75, 1.0)


def loft(env: Env, solid: ast.SolidDecl) -> Made:
    """A solid through several sections."""
    probe = Probe(env, solid.span)
    node = ast.value_of(solid.along)
    flowing = solid.smooth
    path = named_curve(Evaluator(env), node)
    sections = alike(probe, [spans_of(Evaluator(env), a.value) for a in solid.arguments])
    for section, argument in zip(sections, solid.arguments, strict=True):
        if len(section) != len(sections[0]):
            raise env.context.error(
                "broken-chain",
                argument.span,
                f"the first section has {len(sections[0])} curves, this one {len(section)}",
                hint="all sections need the same number of curves, in the same order: each curve is joined to its partner",
            )
        ends = zip(section, [*section[1:], section[0]], strict=True)
        if not all(probe.same(a.end, b.start) for a, b in ends):
            raise _open_section(env, argument)
    if isinstance(path, Curve | Handed):
        if len(sections) != 2:
            raise env.context.error(
                "wrong-arguments",
                solid.span,
                "along a path `loft` takes two sections",
                hint="write `loft` with the section at the beginning and the one at the end",
            )
        if flowing is not None:
            raise env.context.error(
                "wrong-arguments",
                flowing.span,
                "`smooth` has no effect along a path: there is no section between its two",
                hint="drop `smooth`",
            )
        return _along_path(env, probe, solid, path, [sections[0]], [sections[1]])
    axis = axis_of(env, solid, solid.along)
    levels = _levels_of(env, solid, len(sections))
    if flowing is not None and len(sections) < 3:
        raise env.context.error(
            "wrong-arguments",
            flowing.span,
            "`smooth` needs at least three sections: between two there is no kink",
            hint="add a section, or drop `smooth`",
        )
    ways = [None] * (len(sections) - 1) if flowing is None else courses(probe, sections, levels)
    bays = []
    for k in range(len(sections) - 1):
        height = E.sub(levels[k + 1], levels[k])
        rail = Stretch(at_level(axis, (ZERO, ZERO), E.add(levels[k], E.mul(V, height))), unit(axis), height)
        across = Frames(lambda v: unit((axis + 1) % 3), lambda v: unit((axis + 2) % 3), plain=True)
        bays.append(Bay(rail, across, [sections[k]], [sections[k + 1]], ways[k]))
    spans = [span for section in sections for span in section]
    low, high = (
        at_level(axis, (extreme(probe, spans, 0, s), extreme(probe, spans, 1, s)), levels[-(s > 0)]) for s in (-1, 1)
    )
    rises = tuple(
        Demand(a, b, "the levels of the sections must rise") for a, b in zip(levels, levels[1:], strict=False)
    )
    groups = numbered(bays)

    def inside(flats: Sequence[Expr]) -> Expr:
        return _inside_levels(probe, axis, levels, groups, flats)

    return _made_of(env, probe, solid, groups, inside, low, high, {}, rises)


def _open_section(env: Env, node: ast.Node) -> Abort:
    return env.context.error(
        "broken-chain",
        node.span,
        "a section must be a closed curve, but this one is open",
        hint="let the last curve end where the first begins",
    )


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
            arcs.append(Span(section[0].name, pair(place)))
        found.append(arcs)
    return found


def _levels_of(env: Env, solid: ast.SolidDecl, count: int) -> list[Expr]:
    """Where the sections of a loft along an axis stand."""
    ev = Evaluator(env)
    at, ends = ast.value_of(solid.at), (ast.value_of(solid.from_), ast.value_of(solid.to))
    if at is not None:
        if isinstance(at, ast.VectorExpr) and len(at.items) == count:
            return [ev.scalar(level) for level in at.items]
        raise env.context.error(
            "wrong-arguments",
            at.span,
            f"there are {count} sections, so `at` takes a list of {count} levels",
            hint="write one level for each section, in rising order, or `from` and `to`",
        )
    if ends[0] is None or ends[1] is None:
        raise env.context.error(
            "wrong-arguments",
            solid.span,
            "`loft` needs the levels of its sections",
            hint="loft(base, top) along z from 0 to h, or: along z at [0, h1, h2]",
        )
    low, high = (ev.scalar(node) for node in ends if node is not None)
    return [E.add(low, E.mul(E.const(k / (count - 1)), E.sub(high, low))) for k in range(count - 1)] + [high]


def swept(env: Env, solid: ast.SolidDecl) -> Made:
    """``sweep`` of a section that is no circle."""
    probe, path = Probe(env, solid.span), path_of(env, solid)
    chains = chains_of(env, probe, solid)
    return _along_path(env, probe, solid, path, chains, chains)


def _along_path(
    env: Env, probe: Probe, solid: ast.SolidDecl, path: Curve | Handed, first: Chains, last: Chains
) -> Made:
    node = ast.value_of(solid.up)
    rails = stretches(path.steps if isinstance(path, Handed) else steps_of(path))
    check_directions(env, probe, solid, rails)
    across = frames_of(probe, rails, None if node is None else Evaluator(env).direction(node))
    total = E.total(rail.length for rail in rails)
    bays, gone = [], ZERO
    whole = Bay(rails[0], across[0], first, last)
    for rail, made in zip(rails, across, strict=True):
        ahead = E.add(gone, rail.length)
        if first is last:
            ends = first, first
        elif len(rails) == 1:
            ends = first, last
        else:
            ends = whole.section(E.div(gone, total)), last if rail is rails[-1] else whole.section(E.div(ahead, total))
        bays.append(Bay(rail, made, *ends))
        gone = ahead
    requires = [narrow(probe, bay) for bay in bays if bay.rail.center is not None or bay.rail.length is ZERO]
    low, high = (triple(far(probe, bays, axis, sign) for axis in range(3)) for sign in (-1, 1))
    ports = ports_of(rails, across[0].up, across[-1].up)

    def inside(flats: Sequence[Expr]) -> Expr:
        ends = range(len(bays))
        each = [_inside_bay(probe, bay, flats[k], k == 0, k == ends[-1]) for k, bay in enumerate(bays)]
        return E.minimum(*each)

    groups = [Bays((bay,), bay) for bay in bays]
    return _made_of(env, probe, solid, groups, inside, low, high, ports, tuple(requires))


def narrow(probe: Probe, bay: Bay) -> Demand:
    """No section reaches as far towards the inside of a bend as the centre of curvature."""
    if bay.rail.center is not None:
        wide = _reaching(probe, bay)
        return Demand(wide, bay.rail.radius, NARROW, (wide, bay.rail.radius))
    shares, sizes, radii = [], [], []
    for k, bent in enumerate(inwards(bay.rail)):
        v = k / PLACES
        side, up = dot(bent, bay.frames.side(v)), dot(bent, bay.frames.up(v))
        here = [
            E.add(E.mul(side, x), E.mul(up, y))
            for span in bay.section(E.const(v))[0]
            for x, y in (span.fraction(i / 12) for i in range(0, 12, 12 if straight(probe, span) else 1))
        ]
        shares.append(E.maximum(*here))
        length = E.maximum(E.call("sqrt", dot(bent, bent)), E.const(1e-9))
        radii.append(E.div(ONE, length))
        sizes.append(E.div(shares[-1], length))
    return Demand(E.maximum(*shares), ROOM, NARROW, (E.maximum(*sizes), E.minimum(*radii)))


def _reaching(probe: Probe, bay: Bay) -> Expr:
    """How far the sections of an arc reach towards its axis."""
    assert bay.rail.out is not None
    x, y = (E.neg(dot(across(0.0), bay.rail.out)) for across in (bay.frames.side, bay.frames.up))
    spans = [span for section in bay.ends for span in section[0]]
    turned = [
        Span(s.name, (E.add(E.mul(x, s.position[0]), E.mul(y, s.position[1])), ZERO), s.low, s.high) for s in spans
    ]
    return extreme(probe, turned, 0, 1)


def far(probe: Probe, bays: list[Bay], axis: int, sign: int) -> Expr:
    """The greatest (``sign`` 1) or least (-1) coordinate along an axis."""
    if all(bay.frames.plain and (bay.even or bay.rail.length is not ZERO) for bay in bays):
        upright = bays[0].frames.up(0.0)[axis].constant or 0.0
        if upright:
            spans = [span for section in (bays[0].first, bays[-1].last) for span in section[0]]
            level = bays[0].rail.at(0.0)[axis]
            return E.add(level, E.mul(E.const(upright), extreme(probe, spans, 1, int(sign * upright))))
        reached = [[extreme(probe, c[0], 0, s) for c in bay.ends] for bay in bays for s in (-1, 1)]
        return reach(probe, [(b.rail, b.frames.side) for b in bays for _ in (0, 1)], reached, axis, sign)
    factor, found = E.const(float(sign)), []
    for bay in bays:
        level, x, y = (E.mul(factor, vector[axis]) for vector in (bay.rail.place, bay.frames.side(V), bay.frames.up(V)))
        line = bay.rail.center is None and bay.rail.length is not ZERO
        found += summits(probe, moving(bay), level, x, y, line=line, windows=windows(probe, bay.rail))
    greatest = probe.greatest(found)
    return greatest if sign > 0 else E.neg(greatest)


def moving(bay: Bay) -> list[Span]:
    """The outer curves of a bay's section over W, where the section changes along the path by its v."""
    found = []
    for a, b in zip(bay.first[0], bay.last[0], strict=True):
        one, other = (tuple(substitute(c, {V: W}) for c in span.by_fraction) for span in (a, b))
        mixing = (E.add(p, E.mul(V, E.sub(q, p))) for p, q in zip(one, other, strict=True))
        found.append(Span(a.name, pair(mixing), closing=a.closing))
    return found


def _made_of(
    env: Env,
    probe: Probe,
    solid: ast.SolidDecl,
    groups: Sequence[Bays],
    inside: Callable[[Sequence[Expr]], Expr],
    low: Triple,
    high: Triple,
    ports: dict[str, Value],
    requires: tuple[Demand, ...],
) -> Made:
    """Surfaces, inside function and pieces of bays one after another. ``inside`` makes one function of how far places in the section of
    each group lie from its outline, by the greatest slope that this has in space."""
    patches, pieces = [], []
    flats: list[Expr] = []
    steepest = E.maximum(*(_lean(probe, bay) for group in groups for bay in group.members))
    number, many = 0, sum(len(group.members) for group in groups)
    for group in groups:
        bay, name = group.one, f"bay_{number}"
        chains = bay.section(BLEND)
        seen = probe if bay.even else probe.spread(str(BLEND.value), _BLENDS)
        seen = group.spread(seen)
        loops, fill = outline(env, seen, solid, chains)
        if any(side.span.closing for loop, _ in loops for side in loop):
            raise _open_section(env, solid)
        for k, member in enumerate(group.members):
            for chain in member.section(BLEND):
                for span in chain:
                    across = swapped(span.position, {V: U, BLEND: V})
                    patches.append(Patch(span.name, member.place(across, V), (span.low, span.high), (ZERO, ONE)))
            here = {NUMBER: E.const(float(k))}
            for closing, end, cut in (("start", 0.0, number == 0), ("end", 1.0, number == many - 1)):
                for one, other in fill if cut else ():
                    within = [
                        E.add(b, E.mul(U, E.sub(a, b))) for a, b in zip(one.position, other.position, strict=True)
                    ]
                    place = member.place(swapped(within, {BLEND: E.const(end), **here}), end)
                    ends = (substitute(v, here) for v in (one.low, one.high))
                    patches.append(Patch(closing, place, (ZERO, ONE), pair(ends)))
            number += 1
        flats.append(E.div(distance(seen, loops, (X, Y)), steepest))
        solid_section = len(loops) == 1 and convex(seen, loops[0][0], mirrored=False)
        pieces += bay_pieces(seen, probe, group, name, polygons(seen, loops, fill, solid_section))
    return Made(tuple(patches), tuple(pieces), inside(flats), low, high, ports, requires)


def _inside_levels(
    probe: Probe, axis: int, levels: Sequence[Expr], groups: Sequence[Bays], flats: Sequence[Expr]
) -> Expr:
    """Along an axis a place lies in the section at its level, so the bay of that level alone tells how far it is."""
    height, found, begin = P[axis], None, len(levels) - 1
    for group, flat in zip(reversed(groups), reversed(flats), strict=True):
        above, begin = begin, begin - len(group.members)
        at = foot(probe, group.one.rail, group.one.frames.side, group.one.frames.up, ZERO)
        value = substitute(flat, {X: at.x, Y: at.y, BLEND: at.v})
        value = substitute(value, group.at_level(height, levels[begin:above]))
        found = value if found is None else E.where(E.call("lt", height, levels[above]), value, found)
    assert found is not None
    return E.maximum(found, E.sub(levels[0], height), E.sub(height, levels[-1]))


def _inside_bay(probe: Probe, bay: Bay, flat: Expr, begins: bool, closes: bool) -> Expr:
    """``flat``, a length in the section, where the foot of p on the path lies; cut off at the ends of the whole path."""
    wide = _widest(probe, bay)
    at = foot(probe, bay.rail, bay.frames.side, bay.frames.up, wide)
    value = substitute(flat, {X: at.x, Y: at.y, BLEND: at.v})
    if bay.rail.length is ZERO:  # further out than the section reaches, the distance to the path counts
        value = E.maximum(E.div(value, _twisted(probe, bay, wide)), at.start, at.end)
        return E.mul(E.maximum(E.minimum(value, E.mul(wide, NEAR)), E.sub(at.gap, wide)), SLOPE)
    if not bay.even and bay.rail.center is not None:  # near the axis of an arc the section changes ever faster
        value = E.mul(value, E.minimum(ONE, E.div(at.away, clearance(probe, bay))))
    gaps = [gap for gap, cut in ((at.before, begins), (at.after, closes)) if not cut]
    if gaps:  # beyond a joint the next bay goes on
        gap = E.maximum(*gaps)
        value = E.where(E.call("lt", ZERO, gap), E.maximum(value, gap), value)
    return E.maximum(value, *(cap for cap, cut in ((at.start, begins), (at.end, closes)) if cut))


def _widest(probe: Probe, bay: Bay) -> Expr:
    """A circle about the path that no section reaches beyond."""
    spans = [span for side in (bay.first, bay.last) for span in side[0]]
    ends = [[E.call("abs", extreme(probe, spans, k, sign)) for sign in (-1, 1)] for k in (0, 1)]
    return E.call("hypot", E.maximum(*ends[0]), E.maximum(*ends[1]))


def _twisted(probe: Probe, bay: Bay, wide: Expr) -> Expr:
    """The greatest slope in space of a distance in a section that turns about the path of a formula and changes along it."""
    outer = E.mul(wide, E.const(1.1))
    tight = E.maximum(E.sub(ONE, E.mul(outer, bend(bay.rail))), E.const(0.1))
    moved = E.mul(outer, turning(bay.rail, bay.frames))
    if not bay.even:
        moved = E.add(moved, E.div(changed(probe, bay), slowest(bay.rail)))
    return E.call("hypot", ONE, E.div(moved, tight))


def clearance(probe: Probe, bay: Bay) -> Expr:
    """How far the sections of an arc stay from its axis."""
    return E.sub(bay.rail.radius, _reaching(probe, bay))


def _lean(probe: Probe, bay: Bay) -> Expr:
    """The greatest slope that a distance in the section has in space, for the section changes along the path."""
    if bay.even:
        return ONE
    if bay.course is not None:
        speed = bay.course.fastest(list(zip(bay.first[0], bay.last[0], strict=True)))
        return E.call("hypot", ONE, E.div(speed, bay.rail.length))
    if bay.rail.length is ZERO:  # along a formula it depends on where (see `twisted`)
        return ONE
    change = E.div(changed(probe, bay), bay.rail.length)
    if bay.rail.center is None:
        return E.call("hypot", ONE, change)
    steep = E.div(bay.rail.radius, clearance(probe, bay))
    half = E.mul(bay.rail.angle, E.const(0.5))
    change = E.mul(change, E.maximum(ONE, E.div(half, E.sub(E.const(TURN / 2), half))))  # behind the axis it turns back
    return E.add(E.call("hypot", ONE, E.mul(change, steep)), E.mul(E.const(1.5), steep))  # the second for the fading


def changed(probe: Probe, bay: Bay) -> Expr:
    """How far the places of a section move in its plane from the first to the last, at most."""
    moves = []
    for a, b in zip(bay.first[0], bay.last[0], strict=True):
        count = 1 if straight(probe, a) and straight(probe, b) else 16
        for k in range(count + 1):
            d = [E.sub(q, p) for p, q in zip(a.fraction(k / count), b.fraction(k / count), strict=True)]
            moves.append(E.mul(E.call("hypot", *d), E.const(1.0 if count == 1 else 1.05)))
    return E.maximum(*moves)
