"""Vectors, matrices and poses whose entries are expressions of the graph, with exact zeros and ones kept."""

from __future__ import annotations

from collections.abc import Iterable

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr
from ...graph.primitive import Triple, triple
from ...graph.program import Pose

Matrix = tuple[Triple, Triple, Triple]
AXES = ("x", "y", "z")
MINUS = E.const(-1.0)
IDENTITY: Matrix = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))
ORIGIN: Triple = (ZERO, ZERO, ZERO)
HERE = Pose(IDENTITY, ORIGIN, ONE)


def matrix(rows: Iterable[Iterable[Expr]]) -> Matrix:
    """Three rows of three expressions."""
    a, b, c = (triple(row) for row in rows)
    return a, b, c


def unit(axis: int, sign: int = 1) -> Triple:
    return triple(E.const(float(sign)) if k == axis else ZERO for k in range(3))


def plus(a: Triple, b: Triple) -> Triple:
    (x, y, z), (u, v, w) = a, b
    return E.add(x, u), E.add(y, v), E.add(z, w)


def minus(a: Triple, b: Triple) -> Triple:
    (x, y, z), (u, v, w) = a, b
    return E.sub(x, u), E.sub(y, v), E.sub(z, w)


def times(a: Triple, factor: Expr) -> Triple:
    x, y, z = a
    return E.mul(x, factor), E.mul(y, factor), E.mul(z, factor)


def dot(a: Iterable[Expr], b: Iterable[Expr]) -> Expr:
    (x, y, z), (u, v, w) = a, b
    return E.add(E.add(E.mul(x, u), E.mul(y, v)), E.mul(z, w))


def cross(a: Triple, b: Triple) -> Triple:
    return (
        E.sub(E.mul(a[1], b[2]), E.mul(a[2], b[1])),
        E.sub(E.mul(a[2], b[0]), E.mul(a[0], b[2])),
        E.sub(E.mul(a[0], b[1]), E.mul(a[1], b[0])),
    )


def norm(a: Triple) -> Expr:
    nonzero = [c for c in a if c is not ZERO]
    if len(nonzero) == 1:
        return E.call("abs", nonzero[0])
    return E.call("sqrt", dot(a, a))


def normalized(a: Triple) -> Triple:
    length = norm(a)
    return a if length is ONE else triple(E.div(c, length) for c in a)


def transpose(m: Matrix) -> Matrix:
    return matrix(zip(*m, strict=True))


def turn(m: Matrix, v: Triple) -> Triple:
    return v if m == IDENTITY else triple(dot(row, v) for row in m)


def product(a: Matrix, b: Matrix) -> Matrix:
    if a == IDENTITY:  # most parts stand straight
        return b
    if b == IDENTITY:
        return a
    columns = transpose(b)
    return matrix((dot(row, c) for c in columns) for row in a)


def columns(a: Triple, b: Triple, c: Triple) -> Matrix:
    return transpose((a, b, c))


def rotation_about(axis: Triple, angle: Expr) -> Matrix:
    """Rotation about a unit axis (Rodrigues' formula; about x, y or z with exact zeros and ones)."""
    c, s = E.call("cos", angle), E.call("sin", angle)
    found = signed_axis(axis)
    if found is not None:
        at, sign = found
        i, j = (at + 1) % 3, (at + 2) % 3
        rows = [list(row) for row in IDENTITY]
        rows[i][i] = rows[j][j] = c
        turned = E.mul(E.const(float(sign)), s)
        rows[i][j], rows[j][i] = E.neg(turned), turned
        return matrix(rows)
    k = E.sub(ONE, c)
    x, y, z = axis

    def entry(a: Expr, b: Expr, rest: Expr) -> Expr:
        return E.add(E.mul(E.mul(a, b), k), rest)

    return (
        (entry(x, x, c), entry(x, y, E.neg(E.mul(z, s))), entry(x, z, E.mul(y, s))),
        (entry(y, x, E.mul(z, s)), entry(y, y, c), entry(y, z, E.neg(E.mul(x, s)))),
        (entry(z, x, E.neg(E.mul(y, s))), entry(z, y, E.mul(x, s)), entry(z, z, c)),
    )


def _flip(v: Triple, mirror: Expr) -> Triple:
    return v if mirror is ONE else (v[0], E.mul(mirror, v[1]), v[2])


def place(pose: Pose, point: Triple) -> Triple:
    """A point of the inner frame in the outer one."""
    return plus(turn(pose.rotation, _flip(point, pose.mirror)), pose.translation)


def direct(pose: Pose, direction: Triple) -> Triple:
    return turn(pose.rotation, _flip(direction, pose.mirror))


def _unplace(pose: Pose, point: Triple) -> Triple:
    """A point of the outer frame in the inner one."""
    return _flip(turn(transpose(pose.rotation), minus(point, pose.translation)), pose.mirror)


def _mirrored(rotation: Matrix, mirror: Expr) -> Matrix:
    """M R M, where M is the mirror in y that a pose begins with, or none."""
    if mirror is ONE:
        return rotation
    rows = enumerate(rotation)
    return matrix((E.mul(mirror, c) if (i == 1) != (j == 1) else c for j, c in enumerate(row)) for i, row in rows)


def compose(outer: Pose, inner: Pose) -> Pose:
    """The pose of something placed by ``inner`` in a frame that ``outer`` places.

    A mirror in the outer frame is carried to the geometry: M (R x + t) = (M R M)(M x) + M t, M R M being proper.
    """
    if outer is HERE or inner is HERE:
        return inner if outer is HERE else outer
    rotation = _mirrored(inner.rotation, outer.mirror)
    return Pose(product(outer.rotation, rotation), place(outer, inner.translation), E.mul(outer.mirror, inner.mirror))


def inverse(pose: Pose) -> Pose:
    if pose is HERE:
        return HERE
    return Pose(_mirrored(transpose(pose.rotation), pose.mirror), _unplace(pose, ORIGIN), pose.mirror)


def along(direction: Triple) -> Matrix:
    """The axis orientation that takes z to a signed axis, the others in cyclic order."""
    axis = next((k for k in range(3) if direction[k].constant in (1.0, -1.0)), 2)
    sign = direction[axis].constant
    x, y, z = unit((axis + 1) % 3), unit((axis + 2) % 3), unit(axis)
    if sign == -1.0:
        x, z = times(x, MINUS), times(z, MINUS)
    return columns(x, y, z)


def signed_axis(direction: Triple) -> tuple[int, int] | None:
    """(axis, sign) when a direction is an axis by construction, else None."""
    for k in range(3):
        if direction[k].constant in (1.0, -1.0) and all(direction[j] is ZERO for j in range(3) if j != k):
            return k, 1 if direction[k].constant == 1.0 else -1
    return None


def sole_axis(direction: Triple) -> int | None:
    """The axis of a unit direction whose other components are 0 by construction (its sign may differ from row to row)."""
    nonzero = [k for k in range(3) if direction[k] is not ZERO]
    return nonzero[0] if len(nonzero) == 1 else None
