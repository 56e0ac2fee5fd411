"""The operators that make a solid of curves: ``lathe`` and ``extrude`` here, ``sweep`` and ``loft`` in ``sweeps``.

An operator supplies surfaces that close, the inside function, the box and convex pieces. Surfaces bear the names of
the curves; what closes them is ``start``, ``end`` or ``rim``:

* ``lathe(skin) about z``: where the chain does not begin or end on the axis, a disc ``start`` or ``end``.
* ``lathe(skin, lining) about z``: the ends of the two chains are joined by a ring, ``start`` at their first ends and
  ``rim`` at their last; chains that begin on the axis both need none. So a vessel with a bottom begins both its chains
  on the axis (``lathe([base, side], [floor, lining])``), and one without a bottom is open below.
* ``extrude(outline[, inner]) along z from a to b``: the ends are ``start`` and ``end``. Two closed curves make a tube;
  two open ones are the two sides of a strip, joined by ``rim`` at both their ends; one open curve is closed by ``rim``.

Several curves in brackets are one chain, which must meet end to end.
"""

from __future__ import annotations

import math

import numpy as np

from ..graph import expr as E
from ..graph.expr import ONE, ZERO, Expr
from ..graph.primitive import Patch, Piece, Triple
from ..syntax import ast
from .curves import TURN, spans_of
from .env import Env
from .evaluate import Evaluator
from .made import FULL, Made, U, clause
from .probe import SMALL, Probe
from .profiles import Loop, Point, Side, Span, between, distance, equal_steps, extreme, orientation, samples
from .strips import MOST, chord, convex, strip
from .sweeps import sweep
from .values import signed_axis

PX, PY, PZ = (E.var(f"p.{a}") for a in "xyz")
ROUND = 24  # corners of a slice


def solid_of(env: Env, solid: ast.SolidDecl) -> Made:
    """The solid of ``solid = operator(curves) ...``; raises Abort after a diagnostic where it cannot be made."""
    makers = {"lathe": lathe, "extrude": extrude, "sweep": sweep}
    if solid.operator not in makers:
        raise env.context.error(
            "unknown-function", solid.span, f"there is no operator `{solid.operator}`",
            hint="there are " + ", ".join(makers),
        )  # fmt: skip
    return makers[solid.operator](env, solid)


def chains_of(env: Env, probe: Probe, solid: ast.SolidDecl) -> list[list[Span]]:
    """One chain or two; the curves of each meet end to end."""
    if not 1 <= len(solid.arguments) <= 2:
        raise env.context.error(
            "wrong-arguments", solid.span, f"`{solid.operator}` takes one chain of curves, or an outer and an inner one"
        )
    chains = [spans_of(Evaluator(env), a.value) for a in solid.arguments]
    for chain, argument in zip(chains, solid.arguments, strict=True):
        for a, b in zip(chain, chain[1:], strict=False):
            if not probe.same(a.end, b.start):
                raise env.context.error(
                    "broken-chain", argument.span, f"`{b.name}` does not begin where `{a.name}` ends",
                    hint="the curves of a chain meet end to end, for every test value",
                )  # fmt: skip
    return chains


def axis_of(env: Env, solid: ast.SolidDecl, word: str) -> int:
    """The axis that follows ``about`` or ``along``; z where the clause is left out."""
    node = clause(solid, word)
    if node is None:
        return 2
    found = signed_axis(Evaluator(env).direction(node))
    if found is None or found[1] < 0:
        raise env.context.error("bad-axis", node.span, f"`{solid.operator}` takes x, y or z after `{word}`")
    return found[0]


def turned(axis: int, across: Point, height: Expr) -> Triple:
    """A place given across and along an axis; across are the two other axes in cyclic order."""
    place: list[Expr] = [ZERO] * 3
    place[(axis + 1) % 3], place[(axis + 2) % 3], place[axis] = across[0], across[1], height
    return tuple(place)  # type: ignore[return-value]


# ---------------------------------------------------------------- lathe


def lathe(env: Env, solid: ast.SolidDecl) -> Made:
    """A solid of revolution; profile curves give [radius, height]."""
    probe = Probe(env, solid.span)
    axis = axis_of(env, solid, "about")
    chains = chains_of(env, probe, solid)
    loop = profile_loop(probe, chains)
    for side in loop:
        check_radius(env, probe, solid, side.span)
    patches = []
    for side in loop:
        radius, height = side.span.position
        place = turned(axis, (E.mul(radius, E.call("cos", U)), E.mul(radius, E.call("sin", U))), height)
        patches.append(Patch(side.span.name, place, FULL, (side.span.low, side.span.high)))
    point = turned_back(axis)
    inside = distance(probe, [(loop, False)], (E.call("hypot", point[0], point[1]), point[2]))
    spans = [side.span for side in loop]
    wide = extreme(probe, spans, 0, 1)
    low = turned(axis, (E.neg(wide), E.neg(wide)), extreme(probe, spans, 1, -1))
    high = turned(axis, (wide, wide), extreme(probe, spans, 1, 1))
    pieces = lathe_pieces(env, probe, solid, chains, loop, axis)
    return Made(tuple(patches), pieces, inside, low, high)


def lathe_pieces(
    env: Env, probe: Probe, solid: ast.SolidDecl, chains: list[list[Span]], loop: Loop, axis: int
) -> tuple[Piece, ...]:
    """None for a convex solid (the hull of its mesh); slices of one that is not; wedges of a hollow one."""
    sign = orientation(probe, loop)
    if len(chains) == 1:
        return () if convex(probe, loop, mirrored=True) else slices(env, probe, solid, chains[0], sign, axis)
    if len(chains[0]) != len(chains[1]):
        raise env.context.error(
            "broken-chain", solid.span, f"the outer chain has {len(chains[0])} curves, the inner one {len(chains[1])}",
            hint="the chains of a hollow solid have as many curves each: the wall lies between one and its partner",
        )  # fmt: skip
    pieces = []
    for number, quad in enumerate(strip(probe, *chains, sign)):
        wide = E.maximum(quad.outer[0][0], quad.outer[1][0])
        fit = E.call("ceil", E.mul(E.const(TURN / 2), E.call("sqrt", E.div(E.mul(E.const(2.0), wide), quad.wall))))
        count = E.minimum(E.maximum(fit, E.const(12.0)), E.const(72.0))
        half = E.div(E.const(TURN / 2), count)
        bore = E.div(ONE, E.call("cos", half))
        corners = []
        for k in (0.0, 1.0):
            angle = E.mul(E.mul(E.const(2.0), half), E.add(E.var("i"), E.const(k)))
            c, s = E.call("cos", angle), E.call("sin", angle)
            for radius, height in (*quad.outer, *((E.mul(r, bore), h) for r, h in quad.inner)):
                corners.append(turned(axis, (E.mul(radius, c), E.mul(radius, s)), height))
        pieces.append(Piece(f"{quad.name}_{number}", tuple(corners), count))
    return tuple(pieces)


def slices(env: Env, probe: Probe, solid: ast.SolidDecl, chain: list[Span], sign: Expr, axis: int) -> tuple[Piece, ...]:
    """Frusta between equal steps of a solid profile, whose height must rise or fall all the way."""
    pieces = []
    way = 0.0
    angles = [(math.cos(TURN * k / ROUND), math.sin(TURN * k / ROUND)) for k in range(ROUND)]
    for span in chain:
        climb = np.diff(samples(probe, span, 48)[..., 1], axis=1)
        if np.abs(climb).max() < SMALL:
            continue
        rise = 1.0 if climb.sum() > 0 else -1.0
        if (climb * rise).min() < -SMALL or way == -rise:
            raise env.context.error(
                "bad-curve", solid.span, f"the height turns back along `{span.name}`: this solid has no simple convex pieces",
                hint="let the height rise all the way, or make the solid of several primitives",
            )  # fmt: skip
        way = rise
        count = equal_steps(probe, span, math.radians(25.0), MOST)
        for k in range(count):
            ends = chord(probe, span, k / count, (k + 1) / count, sign)
            corners = [
                turned(axis, (E.mul(radius, E.const(c)), E.mul(radius, E.const(s))), height)
                for radius, height in ends for c, s in angles
            ]  # fmt: skip
            pieces.append(Piece(f"{span.name}_{k}", tuple(corners)))
    return tuple(pieces)


def turned_back(axis: int) -> tuple[Expr, Expr, Expr]:
    """p across (two coordinates) and along an axis."""
    p = (PX, PY, PZ)
    return p[(axis + 1) % 3], p[(axis + 2) % 3], p[axis]


def profile_loop(probe: Probe, chains: list[list[Span]]) -> Loop:
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


def check_radius(env: Env, probe: Probe, solid: ast.SolidDecl, span: Span) -> None:
    seen = samples(probe, span, 16)
    if np.isnan(seen).any():
        raise env.context.error(
            "bad-curve", solid.span, f"the curve `{span.name}` has no value at some of the test values",
            hint="narrow the ranges after `test`, or add a `require`",
        )  # fmt: skip
    if seen[..., 0].min() < -1e-9:
        raise env.context.error(
            "bad-curve", solid.span, f"the curve `{span.name}` reaches a radius below 0 at some of the test values",
            hint="profile curves of `lathe` give [radius, height] with radius >= 0",
        )  # fmt: skip


# ---------------------------------------------------------------- extrude


def extrude(env: Env, solid: ast.SolidDecl) -> Made:
    raise env.context.error("wrong-kind", solid.span, "not yet")
