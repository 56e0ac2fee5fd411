"""Primitives written directly as formulas, in the manner of those that the library declares."""

from __future__ import annotations

import math

from artipg_dsl.graph.expr import ZERO, Expr, call, const, maximum, minimum, var, where, wrap
from artipg_dsl.graph.primitive import Patch, Piece, Primitive, Triple
from artipg_dsl.graph.substitution import substitute

TURN = 2 * math.pi
U, V, I = var("u"), var("v"), var("i")  # noqa: E741
PX, PY, PZ = var("p.x"), var("p.y"), var("p.z")
UNIT = (ZERO, const(1.0))
FULL = (ZERO, const(TURN))


def cos(x: Expr) -> Expr:
    return call("cos", x)


def sin(x: Expr) -> Expr:
    return call("sin", x)


def hypot(a: Expr, b: Expr) -> Expr:
    return call("hypot", a, b)


def abs_(x: Expr) -> Expr:
    return call("abs", x)


def patch(name: str, position: Triple, u=UNIT, v=UNIT, guard: Expr | None = None, count: int | None = None) -> Patch:
    return Patch(name, tuple(p if isinstance(p, Expr) else const(p) for p in position), u, v, guard, count)


def at(position: Triple, u, v) -> Triple:
    return tuple(substitute(p, {U: wrap(u), V: wrap(v)}) for p in position)


def size(unit: str = "size") -> Triple:
    return var(f"{unit}.x"), var(f"{unit}.y"), var(f"{unit}.z")


def centred(x: Expr, y: Expr, z: Expr) -> dict:
    return {"low": (-(x / 2), -(y / 2), -(z / 2)), "high": (x / 2, y / 2, z / 2)}


def cuboid(**changes) -> Primitive:
    x, y, z = size()
    h = const(0.5)
    patches = (
        patch("front", (x / 2, (U - h) * y, (V - h) * z)),
        patch("back", (-(x / 2), (h - U) * y, (V - h) * z)),
        patch("left", ((h - U) * x, y / 2, (V - h) * z)),
        patch("right", ((U - h) * x, -(y / 2), (V - h) * z)),
        patch("bottom", ((U - h) * x, (h - V) * y, -(z / 2))),
        patch("top", ((U - h) * x, (V - h) * y, z / 2)),
    )
    fields = {
        "name": "Cuboid",
        "parameters": ("size.x", "size.y", "size.z"),
        "test": ((0.001, 1.0),) * 3,
        "patches": patches,
        "inside": maximum(abs_(PX) - x / 2, abs_(PY) - y / 2, abs_(PZ) - z / 2),
        **centred(x, y, z),
    }
    return Primitive(**{**fields, **changes})


def cylinder(**changes) -> Primitive:
    """A frustum; `bottom` is declared inwards, as its author is free to."""
    r0, r1, h = var("radius"), var("top_radius"), var("height")
    r = r0 + (r1 - r0) * V
    patches = (
        patch("side", (r * cos(U), r * sin(U), (V - 0.5) * h), u=FULL),
        patch("top", (U * r1 * cos(V), U * r1 * sin(V), h / 2), v=FULL),
        patch("bottom", (U * r0 * cos(V), U * r0 * sin(V), -(h / 2)), v=FULL),
    )
    lean = call("sqrt", ((r1 - r0) / h) * ((r1 - r0) / h) + 1.0)
    wide = maximum(r0, r1) * 2.0
    fields = {
        "name": "Cylinder",
        "parameters": ("radius", "top_radius", "height"),
        "test": ((0.001, 1.0), (0.001, 1.0), (0.001, 2.0)),
        "patches": patches,
        "inside": maximum((hypot(PX, PY) - (r0 + (r1 - r0) * (PZ / h + 0.5))) / lean, abs_(PZ) - h / 2),
        **centred(wide, wide, h),
    }
    return Primitive(**{**fields, **changes})


def hollow_frustum(**changes) -> Primitive:
    """A tapering tube over an angle, with cut faces that exist below a full turn."""
    r0, r1, b0, b1, h, span = (var(n) for n in ("radius", "top_radius", "bore", "top_bore", "height", "span"))
    half = span / 2
    arc = (-half, half)
    part = call("lt", span, const(TURN))

    def r(v):
        return r0 + (r1 - r0) * v

    def b(v):
        return b0 + (b1 - b0) * v

    z = (V - 0.5) * h
    outer = (r(V) * cos(U), r(V) * sin(U), z)
    across = b(V) + (r(V) - b(V)) * U
    back = r(V) - (r(V) - b(V)) * U
    patches = (
        patch("outer", outer, u=arc),
        patch("inner", (b(V) * cos(-U), b(V) * sin(-U), z), u=arc),
        patch("top", ((b1 + (r1 - b1) * U) * cos(V), (b1 + (r1 - b1) * U) * sin(V), h / 2), v=arc),
        patch("bottom", ((b0 + (r0 - b0) * V) * cos(U), (b0 + (r0 - b0) * V) * sin(U), -(h / 2)), u=arc),
        patch("start", (across * cos(half), -(across * sin(half)), z), guard=part),
        patch("end", (back * cos(half), back * sin(half), z), guard=part),
    )

    def lean(a, c):
        return call("sqrt", ((a - c) / h) * ((a - c) / h) + 1.0)

    height = PZ / h + 0.5
    cut = where(call("le", const(TURN), span), -r0, abs_(PY) * cos(half) - PX * sin(half))
    inside = maximum(
        (hypot(PX, PY) - r(height)) / lean(r1, r0), (b(height) - hypot(PX, PY)) / lean(b1, b0), abs_(PZ) - h / 2, cut
    )
    wide = maximum(r0, r1)
    low_x = minimum(minimum(b0, b1) * cos(half), wide * cos(half))
    top_y = wide * sin(minimum(half, const(math.pi / 2)))
    tangent = const(1.0) / cos(span / 48)

    def angle(k):
        return (k / 24 - 0.5) * span

    def bored(a, v):
        return tangent * b(const(v)) * cos(a), tangent * b(const(v)) * sin(a), (const(v) - 0.5) * h

    ends = [(angle(I + k), v) for v in (0.0, 1.0) for k in (0.0, 1.0)]
    wedge = (*(at(outer, a, v) for a, v in ends), *(bored(a, v) for a, v in ends))
    fields = {
        "name": "HollowFrustum",
        "parameters": ("radius", "top_radius", "bore", "top_bore", "height", "span"),
        "test": ((0.05, 1.0), (0.05, 1.0), (0.001, 0.04), (0.001, 0.04), (0.001, 2.0), (math.radians(1), TURN)),
        "patches": patches,
        "inside": inside,
        "low": (low_x, -top_y, -(h / 2)),
        "high": (wide, top_y, h / 2),
        "pieces": (Piece("wedge", wedge, const(24.0)),),
    }
    return Primitive(**{**fields, **changes})


def rounded_cuboid(**changes) -> Primitive:
    """Six faces, twelve quarter cylinders, eight octants of a sphere."""
    x, y, z = size()
    r = var("radius")
    half = (x / 2 - r, y / 2 - r, z / 2 - r)
    quarter = (ZERO, const(TURN / 4))
    patches = []
    names = ("x", "y", "z")
    for axis in range(3):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        for sign in (1.0, -1.0):
            point: list = [ZERO] * 3
            point[axis] = (half[axis] + r) * sign
            point[one] = (U * 2.0 - 1.0) * half[one]
            point[other] = (V * 2.0 - 1.0) * half[other]
            patches.append(patch(f"face_{names[axis]}{sign:+.0f}", tuple(point)))
        for first in (1.0, -1.0):
            for second in (1.0, -1.0):
                point = [ZERO] * 3
                point[axis] = (V * 2.0 - 1.0) * half[axis]
                point[one] = (half[one] + r * cos(U)) * first
                point[other] = (half[other] + r * sin(U)) * second
                patches.append(patch(f"edge_{names[axis]}{first:+.0f}{second:+.0f}", tuple(point), u=quarter))
    for sx in (1.0, -1.0):
        for sy in (1.0, -1.0):
            for sz in (1.0, -1.0):
                point = [(half[0] + r * cos(V) * cos(U)) * sx, (half[1] + r * cos(V) * sin(U)) * sy]
                point.append((half[2] + r * sin(V)) * sz)
                patches.append(patch(f"corner_{sx:+.0f}{sy:+.0f}{sz:+.0f}", tuple(point), u=quarter, v=quarter))
    q = [abs_(p) - h for p, h in zip((PX, PY, PZ), half, strict=True)]
    out = [maximum(d, ZERO) for d in q]
    fields = {
        "name": "RoundedCuboid",
        "parameters": ("size.x", "size.y", "size.z", "radius"),
        "test": ((0.01, 1.0), (0.01, 1.0), (0.01, 1.0), (0.0005, 0.004)),
        "patches": tuple(patches),
        "inside": hypot(hypot(out[0], out[1]), out[2]) + minimum(maximum(*q), ZERO) - r,
        "requires": (call("le", r, minimum(x, y, z) * 0.495),),
        **centred(x, y, z),
    }
    return Primitive(**{**fields, **changes})


def sleeve(**changes) -> Primitive:
    """A rectangular sleeve, open along x, of indexed patches: two walls each of four kinds, two rims each."""
    x, y, z = size()
    t = var("wall")
    yo, zo, yi, zi = y / 2, z / 2, y / 2 - t, z / 2 - t
    side = I * 2.0 - 1.0  # -1 and 1
    ry, rz = yi + t * U, zi + t * U
    s = V * 2.0 - 1.0
    patches = (
        patch("front_y", (x / 2, side * ry, s * rz), count=2),
        patch("front_z", (x / 2, s * ry, side * rz), count=2),
        patch("back_y", (-(x / 2), side * ry, s * rz), count=2),
        patch("back_z", (-(x / 2), s * ry, side * rz), count=2),
        patch("outer_y", ((U - 0.5) * x, side * yo, s * zo), count=2),
        patch("outer_z", ((U - 0.5) * x, s * yo, side * zo), count=2),
        patch("inner_y", ((U - 0.5) * x, side * yi, s * zi), count=2),
        patch("inner_z", ((U - 0.5) * x, s * yi, side * zi), count=2),
    )

    def wall(first: Triple, second: Triple) -> tuple[Triple, ...]:
        return tuple(at(p, a, b) for p in (first, second) for a in (0.0, 1.0) for b in (0.0, 1.0))

    fields = {
        "name": "Sleeve",
        "parameters": ("size.x", "size.y", "size.z", "wall"),
        "test": ((0.001, 1.0), (0.1, 1.0), (0.1, 1.0), (0.005, 0.04)),
        "patches": patches,
        "inside": maximum(abs_(PX) - x / 2, abs_(PY) - yo, abs_(PZ) - zo, minimum(yi - abs_(PY), zi - abs_(PZ))),
        "pieces": (
            Piece("wall_y", wall(patches[0].position, patches[2].position), const(2.0)),
            Piece("wall_z", wall(patches[1].position, patches[3].position), const(2.0)),
        ),
        **centred(x, y, z),
    }
    return Primitive(**{**fields, **changes})


def torus_sector(**changes) -> Primitive:
    """A sector of a torus with an elliptic tube, about y and centred on +x; a full ring without its cut faces."""
    radius, tube, flat, span = (var(n) for n in ("radius", "tube", "flat", "span"))
    half = span / 2
    part = call("lt", span, const(TURN))
    ring = radius + tube * cos(U)
    disc = radius + U * tube * cos(V)
    patches = (
        patch("skin", (ring * cos(V), flat * sin(U), ring * sin(V)), u=FULL, v=(-half, half)),
        patch("start", (disc * cos(half), -(U * flat * sin(V)), -(disc * sin(half))), v=FULL, guard=part),
        patch("end", (disc * cos(half), U * flat * sin(V), disc * sin(half)), v=FULL, guard=part),
    )
    cut = where(call("le", const(TURN), span), -tube, abs_(PZ) * cos(half) - PX * sin(half))
    around = (hypot((hypot(PX, PZ) - radius) / tube, PY / flat) - 1.0) * minimum(tube, flat)
    low_x = minimum((radius - tube) * cos(half), (radius + tube) * cos(half))
    top_z = (radius + tube) * sin(minimum(half, const(math.pi / 2)))
    wide = const(1.0) / cos(span / 48)

    def angle(k):
        return (k / 24 - 0.5) * span

    def bent(degrees: float, a: Expr) -> Triple:
        turned = const(math.radians(degrees))
        reach = (radius + tube * cos(turned)) * (wide if 90 < degrees < 270 else const(1.0))
        return reach * cos(a), flat * sin(turned), reach * sin(a)

    corners = tuple(bent(22.5 + 45 * n, angle(I + k)) for k in (0.0, 1.0) for n in range(8))
    fields = {
        "name": "TorusSector",
        "parameters": ("radius", "tube", "flat", "span"),
        "test": ((0.05, 0.2), (0.005, 0.02), (0.005, 0.02), (math.radians(1), TURN)),
        "patches": patches,
        "inside": maximum(around, cut),
        "low": (low_x, -flat, -top_z),
        "high": (radius + tube, flat, top_z),
        "pieces": (Piece("segment", corners, const(24.0)),),
    }
    return Primitive(**{**fields, **changes})


ALL = (cuboid, cylinder, hollow_frustum, rounded_cuboid, sleeve, torus_sector)
