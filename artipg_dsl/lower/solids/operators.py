"""The operators that make a solid of curves: ``lathe`` and ``extrude`` here, ``sweep`` and ``loft`` in ``sweeps`` and ``loft``.

An operator supplies surfaces that close, the inside function, the box and convex pieces. Surfaces bear the names of
the curves; what closes them is ``start``, ``end`` or ``rim``:

* ``lathe(skin) about z``: where the chain does not begin or end on the axis, a disc ``start`` or ``end``.
* ``lathe(skin, lining) about z``: the ends of the two chains are joined by a ring, ``start`` at their first ends and
  ``rim`` at their last; chains that begin on the axis both need none. So a vessel with a bottom begins both its chains
  on the axis (``lathe([base, side], [floor, lining])``), and one without a bottom is open below.
* ``extrude(outline[, inner]) along z from a to b``: the ends are ``start`` and ``end``. Two closed curves make a tube,
  further ones, or one of another number of curves, are holes (``holes``);
  two open ones are the two sides of a strip, joined by ``rim`` at both their ends; one open curve is closed by ``rim``.

Several curves in brackets are one chain, which must meet end to end.
"""

from __future__ import annotations

import math

import numpy as np

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import Patch, Piece, Triple, pair
from ...syntax import ast
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from .curves import TURN
from .cuts import clamp
from .holes import holed, several
from .loft import loft, swept
from .made import FULL, Demand, Made, U
from .parity import signed
from .probe import SMALL, Probe
from .profiles import (
    Loop,
    Point,
    Side,
    Span,
    between,
    distance,
    dot,
    equal_steps,
    extreme,
    orientation,
    right_of,
    samples,
)
from .regions import axis_of, chains_of, check_values, outline, turned
from .strips import MOST, Quad, chord, convex, parts, strip
from .sweeps import round_sections, sweep

_BORED = 0.98  # of a wall, at most

PX, PY, PZ = (E.var(f"p.{a}") for a in "xyz")
_ROUND = 24  # corners of a slice


def solid_of(env: Env, solid: ast.SolidDecl) -> Made:
    """The solid of ``solid = operator(curves) ...``; raises Abort after a diagnostic where it cannot be made."""
    swung = sweep if round_sections(env.context, solid) else swept
    makers = {"lathe": lathe, "extrude": extrude, "sweep": swung, "loft": loft}
    return makers[solid.operator](env, solid)


# ---------------------------------------------------------------- lathe


def lathe(env: Env, solid: ast.SolidDecl) -> Made:
    """A solid of revolution; profile curves give [radius, height]."""
    probe = Probe(env, solid.span)
    axis = axis_of(env, solid, solid.about)
    chains = chains_of(env, probe, solid)
    loop = _profile_loop(probe, chains)
    for side in loop:
        _check_radius(env, probe, solid, side.span)
    patches = []
    for side in loop:
        radius, height = side.span.position
        place = turned(axis, (E.mul(radius, E.call("cos", U)), E.mul(radius, E.call("sin", U))), height)
        patches.append(Patch(side.span.name, place, FULL, (side.span.low, side.span.high)))
    point = _turned_back(axis)
    flat = (E.call("hypot", point[0], point[1]), point[2])
    inside = signed(probe, [(loop, False)], flat) or distance(probe, [(loop, False)], flat)
    spans = [side.span for side in loop]
    wide = extreme(probe, spans, 0, 1)
    low = turned(axis, (E.neg(wide), E.neg(wide)), extreme(probe, spans, 1, -1))
    high = turned(axis, (wide, wide), extreme(probe, spans, 1, 1))
    pieces = _lathe_pieces(env, probe, solid, chains, loop, axis)
    return Made(tuple(patches), pieces, inside, low, high)


def _lathe_pieces(
    env: Env, probe: Probe, solid: ast.SolidDecl, chains: list[list[Span]], loop: Loop, axis: int
) -> tuple[Piece, ...]:
    """None for a convex solid (the hull of its mesh); slices of one that is not; wedges of a hollow one."""
    sign = orientation(probe, loop)
    if len(chains) == 1:
        return () if convex(probe, loop, mirrored=True) else _slices(env, probe, solid, chains[0], sign, axis)
    if len(chains[0]) != len(chains[1]):
        raise env.context.error(
            "broken-chain",
            solid.span,
            f"the outer chain has {len(chains[0])} curves, the inner one {len(chains[1])}",
            hint="both chains of a hollow solid need the same number of curves: each wall lies between a curve and its partner",
        )
    pieces = []
    for number, quad in enumerate(strip(probe, chains[0], chains[1], sign)):
        wide = E.maximum(quad.outer[0][0], quad.outer[1][0])
        fit = E.call("ceil", E.mul(E.const(TURN / 2), E.call("sqrt", E.div(E.mul(E.const(2.0), wide), quad.wall))))
        count = E.minimum(E.maximum(fit, E.const(12.0)), E.const(72.0))
        half = E.div(E.const(TURN / 2), count)
        tangent = E.sub(E.div(ONE, E.call("cos", half)), ONE)
        inner = _bored(quad, tangent)
        corners = []
        for k in (0.0, 1.0):
            angle = E.mul(E.mul(E.const(2.0), half), E.add(E.var("i"), E.const(k)))
            c, s = E.call("cos", angle), E.call("sin", angle)
            for radius, height in (*quad.outer, *inner):
                corners.append(turned(axis, (E.mul(radius, c), E.mul(radius, s)), height))
        pieces.append(Piece(f"{quad.name}_{number}", tuple(corners), count))
    return tuple(pieces)


def _bored(quad: Quad, tangent: Expr) -> list[Point]:
    """The inner corners moved out so that chords around the axis are tangents of the bore (by a share of the radius).

    They move along the lines that close the step, to where these meet the widened bore: so they stay on the ring that
    closes the wall, and a flat floor stays where it is. Where another curve begins, its bore must be cleared too. A line that
    hardly leaves the bore meets it far away or behind: no corner leaves the wall, nor do all lie on its far side.
    """
    wide = [(E.mul(r, E.add(ONE, tangent)), h) for r, h in quad.inner]
    normal = right_of((E.sub(wide[1][0], wide[0][0]), E.sub(wide[1][1], wide[0][1])), ONE)
    found = []
    for outer, inner, end in zip(quad.outer, quad.inner, quad.ends, strict=True):
        across = (E.sub(outer[0], inner[0]), E.sub(outer[1], inner[1]))
        move = E.mul(inner[0], tangent)
        share = E.div(E.mul(move, normal[0]), dot(across, normal))
        if end:
            leads = E.call("lt", E.mul(E.const(0.3), quad.wall), across[0])
            share = E.where(leads, E.maximum(share, E.div(move, across[0])), share)
        share = clamp(share, 0.0, _BORED)
        found.append((E.add(inner[0], E.mul(share, across[0])), E.add(inner[1], E.mul(share, across[1]))))
    return found


def _slices(
    env: Env, probe: Probe, solid: ast.SolidDecl, chain: list[Span], sign: Expr, axis: int
) -> tuple[Piece, ...]:
    """Frusta between equal steps of a solid profile, whose height must rise or fall all the way."""
    pieces = []
    way = 0.0
    angles = [(math.cos(TURN * k / _ROUND), math.sin(TURN * k / _ROUND)) for k in range(_ROUND)]
    for span in chain:
        climb = np.diff(samples(probe, span, 48)[..., 1], axis=1)
        if np.abs(climb).max() < SMALL:
            continue
        rise = 1.0 if climb.sum() > 0 else -1.0
        if (climb * rise).min() < -SMALL or way == -rise:
            raise env.context.error(
                "bad-curve",
                solid.span,
                f"the height turns back along `{span.name}`, so the solid has no simple convex pieces",
                hint="let the height rise all the way, or split the solid into several primitives",
            )
        way = rise
        count = equal_steps(probe, span, math.radians(25.0), MOST)
        for k in range(count):
            ends = chord(probe, span, k / count, (k + 1) / count, sign)
            corners = [
                turned(axis, (E.mul(radius, E.const(c)), E.mul(radius, E.const(s))), height)
                for radius, height in ends
                for c, s in angles
            ]
            pieces.append(Piece(f"{span.name}_{k}", tuple(corners)))
    return tuple(pieces)


def _turned_back(axis: int) -> Triple:
    """p across (two coordinates) and along an axis."""
    p = (PX, PY, PZ)
    return p[(axis + 1) % 3], p[(axis + 2) % 3], p[axis]


def _profile_loop(probe: Probe, chains: list[list[Span]]) -> Loop:
    """The boundary of a profile in the half plane (radius, height), without what runs along the axis."""
    outer = chains[0]
    first, last = outer[0].start, outer[-1].end
    sides = [Side(s) for s in outer]
    if len(chains) == 1:
        if not probe.zero(first[0]):
            sides.insert(0, Side(between("start", (ZERO, first[1]), first)))
        if not probe.zero(last[0]):
            sides.append(Side(between("end", last, (ZERO, last[1]))))
        return tuple(sides)
    inner = chains[1]
    begin, end = inner[0].start, inner[-1].end
    if not probe.zero(last[0], end[0]):
        sides.append(Side(between("rim", last, end)))
    sides += [Side(s, back=True) for s in reversed(inner)]
    if not probe.zero(first[0], begin[0]):
        sides.append(Side(between("start", begin, first)))
    return tuple(sides)


def _check_radius(env: Env, probe: Probe, solid: ast.SolidDecl, span: Span) -> None:
    check_values(env, probe, solid, span)
    if samples(probe, span, 16)[..., 0].min() < -1e-9:
        raise env.context.error(
            "bad-curve",
            solid.span,
            f"the curve `{span.name}` reaches a radius below 0 at some of the test values",
            hint="a profile curve of `lathe` gives [radius, height] with radius >= 0",
        )


# ---------------------------------------------------------------- extrude


def extrude(env: Env, solid: ast.SolidDecl) -> Made:
    """A prism over a region of the plane; curves give the two coordinates across the axis, in cyclic order."""
    probe = Probe(env, solid.span)
    axis = axis_of(env, solid, solid.along)
    assert solid.from_ is not None and solid.to is not None
    low, high = (Evaluator(env).scalar(end.value) for end in (solid.from_, solid.to))
    if (tall := E.sub(high, low).constant) is not None and tall <= 0.0:
        hint = "`from` names the lower end, `to` the upper"
        raise env.context.error(
            "bad-curve", solid.to.span, "the prism has no height: it ends no higher than it begins", hint=hint
        )
    chains = chains_of(env, probe, solid)
    region = holed(env, probe, solid, chains) if several(probe, chains) else None
    if region is None:
        loops, strips = outline(env, probe, solid, chains)
        walls = list({id(side.span): side.span for loop, _ in loops for side in loop if not side.span.closing}.values())
    else:
        loops, strips, walls = region.loops, region.strips, region.walls
    patches = []
    for span in [*walls, *(side.span for loop, _ in loops for side in loop if side.span.closing)]:
        place = turned(axis, span.position, E.add(low, E.mul(U, E.sub(high, low))))
        patches.append(Patch(span.name, place, (ZERO, ONE), (span.low, span.high)))
    for name, height in (("start", low), ("end", high)):
        for one, other in strips:
            across = pair(E.add(b, E.mul(U, E.sub(a, b))) for a, b in zip(one.position, other.position, strict=True))
            patches.append(Patch(name, turned(axis, across, height), (ZERO, ONE), (one.low, one.high)))
    point = _turned_back(axis)
    flat = signed(probe, loops, (point[0], point[1])) or distance(probe, loops, (point[0], point[1]))
    inside = E.maximum(flat, E.sub(low, point[2]), E.sub(point[2], high))
    spans = [side.span for loop, _ in loops for side in loop]
    bounds = [
        turned(axis, (extreme(probe, spans, 0, sign), extreme(probe, spans, 1, sign)), end)
        for sign, end in ((-1, low), (1, high))
    ]
    pieces: tuple[Piece, ...] = ()
    if len(loops) > 1 or not convex(probe, loops[0][0], mirrored=False):
        polygons = parts(probe, strips, orientation(probe, loops[0][0])) if region is None else region.polygons
        pieces = tuple(
            Piece(f"part_{number}", tuple(turned(axis, corner, end) for end in (low, high) for corner in corners))
            for number, corners in enumerate(polygons)
        )
    return Made(
        tuple(patches), pieces, inside, bounds[0], bounds[1], {}, (Demand(low, high, "the prism has no height"),)
    )
