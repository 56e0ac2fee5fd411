"""``sweep(circle(r)[, circle(bore)]) along path up y``: a round bar or pipe along a path.

The skin is one surface ``skin`` (and ``lining``) per piece of the path; the ends are ``start`` and ``end``, which are
ports too: frames whose ``out`` points away from the solid. Arcs must be wider than the section.
"""

from __future__ import annotations

import numpy as np

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import Patch, Piece, Triple, triple
from ...syntax import ast
from ..expressions.builtins import bound
from ..expressions.context import Draft
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.handed import Handed
from ..values.vectors import cross, dot, minus, plus, times
from .curves import TURN
from .frames import ROOM, Vector, tightest
from .frames import frames as frames_of
from .made import FULL, NARROW, Demand, Made, U
from .paths import Stretch, steps_of, stretches, windows
from .probe import Probe
from .profiles import SLOPE, V, crests
from .rails import NEAR, P, about_arc, cap, check_directions, disc, nearest, path_of, ports_of

_CORNERS = 12  # of a round piece


def sweep(env: Env, solid: ast.SolidDecl) -> Made:
    """A tube along a path."""
    path = path_of(env, solid)
    ev = Evaluator(env)
    radii = [_section_radius(ev, a) for a in solid.arguments]
    upwards = ast.value_of(solid.up)
    pieces = stretches(path.steps if isinstance(path, Handed) else steps_of(path))
    probe = Probe(env, solid.span)
    check_directions(env, probe, solid, pieces)
    frames = [(f.side, f.up) for f in frames_of(probe, pieces, None if upwards is None else ev.direction(upwards))]
    radius, bore = radii[0], radii[1] if len(radii) == 2 else None
    patches = [tube("skin", piece, frame, radius) for piece, frame in zip(pieces, frames, strict=True)]
    if bore is not None:
        patches += [tube("lining", piece, frame, bore) for piece, frame in zip(pieces, frames, strict=True)]
    ends = ((pieces[0], frames[0], 0.0, "start"), (pieces[-1], frames[-1], 1.0, "end"))
    for piece, frame, at, name in ends:
        wide = E.mul(V, radius) if bore is None else E.add(bore, E.mul(V, E.sub(radius, bore)))
        patches.append(Patch(name, ring(piece.at(at), (frame[0](at), frame[1](at)), wide), FULL, (ZERO, ONE)))
    requires = [Demand(radius, p.radius, NARROW, (radius, p.radius)) for p in pieces if p.center is not None]
    bends = [tightest(piece) for piece in pieces if piece.length is ZERO]
    requires += [Demand(radius, E.mul(ROOM, bend), NARROW, (radius, bend)) for bend in bends]
    if bore is not None:
        requires.append(Demand(bore, radius, "the bore is wider than the section"))
    ports = ports_of(pieces, frames[0][1], frames[-1][1])
    low, high = (triple(reach(probe, pieces, radius, k, sign) for k in range(3)) for sign in (-1, 1))
    return Made(
        tuple(patches),
        _tube_pieces(probe, pieces, frames, radius, bore),
        inside(probe, pieces, radius, bore),
        low,
        high,
        ports,
        tuple(requires),
    )


def round_sections(context: Draft, solid: ast.SolidDecl) -> bool:
    """Whether all sections are circles; others are swept by ``loft``."""
    forms = (context.form(a.value) for a in solid.arguments)
    return all(form is not None and form.meaning == "circle" for form in forms)


def _section_radius(ev: Evaluator, argument: ast.Argument) -> Expr:
    node, form = argument.value, ev.env.context.form(argument.value)
    assert isinstance(node, ast.CallExpr) and form is not None
    return ev.scalar(bound(node, form)["radius"])


def ring(center: Triple, axes: tuple[Triple, Triple], radius: Expr, angle: Expr = U) -> Triple:
    """A place on a circle across the path."""
    c, s = E.mul(radius, E.call("cos", angle)), E.mul(radius, E.call("sin", angle))
    return plus(center, plus(times(axes[0], c), times(axes[1], s)))


def tube(name: str, piece: Stretch, frame: tuple[Vector, Vector], radius: Expr) -> Patch:
    return Patch(name, ring(piece.place, (frame[0](V), frame[1](V)), radius), FULL, (ZERO, ONE))


# ---------------------------------------------------------------- inside


def inside(probe: Probe, pieces: list[Stretch], radius: Expr, bore: Expr | None) -> Expr:
    """The distance to the path less the radius, cut flat at the two ends of the path."""
    outer: Expr | None = None
    middle: Expr | None = None
    for k, piece in enumerate(pieces):
        away, v = _path_distance(probe, piece)
        value = E.sub(away, radius)
        ends = [end for end, here in ((0.0, k == 0), (1.0, k == len(pieces) - 1)) if here]
        if piece.length is ZERO:  # it may come near its ends again
            near = E.mul(radius, NEAR)
            value = E.maximum(value, *(E.minimum(disc(piece, v, end, radius), near) for end in ends))
        else:
            value = E.maximum(value, *(_end_plane(piece, end) for end in ends))
        outer = value if outer is None else E.minimum(outer, value)
        middle = away if middle is None else E.minimum(middle, away)
    assert outer is not None and middle is not None
    found = outer if bore is None else E.maximum(outer, E.sub(bore, middle))
    return E.mul(found, SLOPE) if any(p.length is ZERO for p in pieces) else found


def _end_plane(piece: Stretch, end: float) -> Expr:
    """How far p lies beyond the plane that cuts off a piece of a path; of an arc, a half plane from its axis."""
    if piece.center is not None:
        angle, away, half = about_arc(piece)
        return cap(E.sub(angle, half) if end else E.neg(E.add(angle, half)), away)
    beyond = minus(P, piece.at(end))
    return dot(beyond if end else times(beyond, E.const(-1.0)), piece.towards(end))


def _length_of(vector: Triple) -> Expr:
    return E.call("sqrt", dot(vector, vector))


def _path_distance(probe: Probe, piece: Stretch) -> tuple[Expr, Expr]:
    """The distance of p to a piece of a path, and of a formula's the parameter there."""
    if piece.center is not None and piece.out is not None:
        return _arc_distance(piece), ZERO
    if piece.length is not ZERO:
        away = minus(P, piece.at(0.0))
        t = E.minimum(E.maximum(dot(away, piece.direction), ZERO), piece.length)
        return _length_of(minus(away, times(piece.direction, t))), ZERO
    square, v = nearest(probe, piece)
    return E.call("sqrt", square), v


def _arc_distance(piece: Stretch) -> Expr:
    """The angle of p about the arc's axis, from its middle, is cut to the arc."""
    assert piece.center is not None and piece.out is not None
    angle, away, half = about_arc(piece)
    beyond = E.sub(angle, E.minimum(E.maximum(angle, E.neg(half)), half))
    x = E.sub(E.mul(away, E.call("cos", beyond)), piece.radius)
    y = E.mul(away, E.call("sin", beyond))
    h = dot(minus(P, piece.center), cross(piece.out, piece.towards(0.0)))
    return E.call("sqrt", dot((x, y, h), (x, y, h)))


# ---------------------------------------------------------------- box and pieces


def reach(probe: Probe, pieces: list[Stretch], radius: Expr, axis: int, sign: int) -> Expr:
    """How far a tube reaches along an axis: a section reaches radius * sin(angle between path and axis)."""
    factor = E.const(float(sign))
    found: list[Expr] = []
    for piece in pieces:
        count = windows(probe, piece)
        for value in (k / count for k in range(count + 1)):
            slope = piece.towards(value)[axis]
            across = E.call("sqrt", E.maximum(E.sub(ONE, E.mul(slope, slope)), ZERO))
            found.append(E.add(E.mul(factor, piece.at(value)[axis]), E.mul(radius, across)))
        if piece.center is not None and piece.out is not None:
            x, y = (E.mul(factor, vector[axis]) for vector in (piece.out, piece.towards(0.0)))
            if x is ZERO and y is ZERO:
                continue
            top = E.call("mod", E.call("atan2", y, x), E.const(TURN))
            height = E.add(E.mul(factor, piece.center[axis]), E.add(E.mul(piece.radius, E.call("hypot", x, y)), radius))
            found.append(E.where(E.call("le", top, piece.angle), height, found[-1]))
        elif piece.length is ZERO:
            height = E.mul(factor, piece.place[axis])
            found += [E.add(top, radius) for top in crests(probe, height, count)]
    greatest = probe.greatest(found)
    return greatest if sign > 0 else E.neg(greatest)


def _tube_pieces(
    probe: Probe, pieces: list[Stretch], frames: list[tuple[Vector, Vector]], radius: Expr, bore: Expr | None
) -> tuple[Piece, ...]:
    """Hulls of the sections at the ends of each step, smaller by what the path's chord cuts; sectors of a pipe."""
    made = []
    for number, (piece, frame) in enumerate(zip(pieces, frames, strict=True)):
        count = _step_count(probe, piece, radius, bore)
        winding = piece.length is ZERO and bore is None  # many alike: one piece with an index
        for k in range(1 if winding else count):
            low, high, half = (
                E.mul(E.add(E.var("i"), E.const(d)), E.const(1 / count)) if winding else E.const((k + d) / count)
                for d in (0.0, 1.0, 0.5)
            )
            chord = times(plus(piece.at(low), piece.at(high)), E.const(0.5))
            cut = ZERO if count == 1 and piece.center is None else _length_of(minus(piece.at(half), chord))
            cut = E.mul(cut, E.const(1.02 if piece.center is not None else 1.2))
            wide = E.sub(radius, cut)
            ends = [(piece.at(v), (frame[0](v), frame[1](v))) for v in (low, high)]
            name = f"skin_{number}" if winding else f"skin_{number}_{k}"
            if bore is None:
                angles = [E.const(TURN * j / _CORNERS) for j in range(_CORNERS)]
                corners = tuple(ring(*end, wide, a) for end in ends for a in angles)
                made.append(Piece(name, corners, E.const(float(count)) if winding else None))
                continue
            wall = E.sub(radius, bore)
            fit = E.call("ceil", E.mul(E.const(TURN / 2), E.call("sqrt", E.div(E.mul(E.const(4.0), radius), wall))))
            sectors = E.minimum(E.maximum(fit, E.const(12.0)), E.const(64.0))
            each = E.div(E.const(TURN), sectors)
            tilt = _length_of(times(plus(piece.towards(low), piece.towards(high)), E.const(0.5)))
            inner = E.div(E.add(bore, cut), E.mul(tilt, E.call("cos", E.mul(each, E.const(0.5)))))
            angles = [E.mul(each, E.add(E.var("i"), E.const(j))) for j in (0.0, 1.0)]
            corners = tuple(ring(*end, r, a) for end in ends for r in (wide, inner) for a in angles)
            made.append(Piece(name, corners, sectors))
    return tuple(made)


def _step_count(probe: Probe, piece: Stretch, radius: Expr, bore: Expr | None) -> int:
    """Steps so short that the chord cuts at most an eighth of the wall, and no more than 30 degrees of a bend."""
    if piece.center is None and piece.length is not ZERO:
        return 1
    wall = probe(E.sub(radius, bore) if bore is not None else E.mul(radius, E.const(0.5)))[0]
    for count in (*range(3, 24), 32, 48, 64, 96, 128, 192):
        seen = probe.along(piece.place, [k / (2 * count) for k in range(2 * count + 1)], V)
        off = seen[1::2] - (seen[:-1:2] + seen[2::2]) / 2
        cuts = np.sqrt((off**2).sum(axis=1))
        turns = probe(piece.angle)[0] / count if piece.center is not None else np.zeros(1)
        if (cuts.max(axis=0) <= wall / 8).mean() > 0.98 and turns.max() <= np.radians(31.0):
            return count
    return 192
