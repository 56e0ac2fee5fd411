"""What an expression of the text means while it is lowered: scalars are ``graph`` expressions, the rest is built of them.

Every geometric value is expressed in the frame of the environment that evaluates it. ``on`` lists the parts whose
links a value lies on (see ``links``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from ..graph import expr as E
from ..graph.expr import ONE, ZERO, Expr, Scope
from ..graph.linear import tidy
from ..graph.program import Pose

if TYPE_CHECKING:
    from .part import Part

Triple = tuple[Expr, Expr, Expr]
Matrix = tuple[Triple, Triple, Triple]

AXES = ("x", "y", "z")
FACES = {"front": (0, 1), "back": (0, -1), "left": (1, 1), "right": (1, -1), "top": (2, 1), "bottom": (2, -1)}
MINUS = E.const(-1.0)
IDENTITY: Matrix = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))
ORIGIN: Triple = (ZERO, ZERO, ZERO)
HERE = Pose(IDENTITY, ORIGIN, ONE)


# ---------------------------------------------------------------- vectors and matrices of expressions


def unit(axis: int, sign: int = 1) -> Triple:
    return tuple(E.const(float(sign)) if k == axis else ZERO for k in range(3))  # type: ignore[return-value]


def plus(a: Triple, b: Triple) -> Triple:
    return tuple(E.add(x, y) for x, y in zip(a, b, strict=True))  # type: ignore[return-value]


def minus(a: Triple, b: Triple) -> Triple:
    return tuple(E.sub(x, y) for x, y in zip(a, b, strict=True))  # type: ignore[return-value]


def times(a: Triple, factor: Expr) -> Triple:
    return tuple(E.mul(x, factor) for x in a)  # type: ignore[return-value]


def dot(a: Iterable[Expr], b: Iterable[Expr]) -> Expr:
    total = ZERO
    for x, y in zip(a, b, strict=True):
        total = E.add(total, E.mul(x, y))
    return total


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
    return a if length is ONE else tuple(E.div(c, length) for c in a)  # type: ignore[return-value]


def transpose(m: Matrix) -> Matrix:
    return tuple(zip(*m, strict=True))  # type: ignore[return-value]


def turn(m: Matrix, v: Triple) -> Triple:
    return tuple(dot(row, v) for row in m)  # type: ignore[return-value]


def product(a: Matrix, b: Matrix) -> Matrix:
    columns = transpose(b)
    return tuple(tuple(dot(row, c) for c in columns) for row in a)  # type: ignore[return-value]


def columns(a: Triple, b: Triple, c: Triple) -> Matrix:
    return transpose((a, b, c))


def rotation_about(axis: Triple, angle: Expr) -> Matrix:
    """Rotation about a unit axis (Rodrigues' formula; about x, y or z with exact zeros and ones)."""
    c, s = E.call("cos", angle), E.call("sin", angle)
    found = signed_axis(axis)
    if found is not None:
        k, sign = found
        i, j = (k + 1) % 3, (k + 2) % 3
        rows = [list(row) for row in IDENTITY]
        rows[i][i] = rows[j][j] = c
        turned = E.mul(E.const(float(sign)), s)
        rows[i][j], rows[j][i] = E.neg(turned), turned
        return tuple(map(tuple, rows))  # type: ignore[return-value]
    k = E.sub(ONE, c)
    x, y, z = axis

    def entry(a: Expr, b: Expr, rest: Expr) -> Expr:
        return E.add(E.mul(E.mul(a, b), k), rest)

    return (
        (entry(x, x, c), entry(x, y, E.neg(E.mul(z, s))), entry(x, z, E.mul(y, s))),
        (entry(y, x, E.mul(z, s)), entry(y, y, c), entry(y, z, E.neg(E.mul(x, s)))),
        (entry(z, x, E.neg(E.mul(y, s))), entry(z, y, E.mul(x, s)), entry(z, z, c)),
    )


# ---------------------------------------------------------------- poses


def flip(v: Triple, mirror: Expr) -> Triple:
    return v if mirror is ONE else (v[0], E.mul(mirror, v[1]), v[2])


def place(pose: Pose, point: Triple) -> Triple:
    """A point of the inner frame in the outer one."""
    return plus(turn(pose.rotation, flip(point, pose.mirror)), pose.translation)


def direct(pose: Pose, direction: Triple) -> Triple:
    return turn(pose.rotation, flip(direction, pose.mirror))


def unplace(pose: Pose, point: Triple) -> Triple:
    """A point of the outer frame in the inner one."""
    return flip(turn(transpose(pose.rotation), minus(point, pose.translation)), pose.mirror)


def undirect(pose: Pose, direction: Triple) -> Triple:
    return flip(turn(transpose(pose.rotation), direction), pose.mirror)


def compose(outer: Pose, inner: Pose) -> Pose:
    """The pose of something placed by ``inner`` in a frame that ``outer`` places.

    A mirror in the outer frame is carried to the geometry: M (R x + t) = (M R M)(M x) + M t, M R M being proper.
    """
    rotation, mirror = inner.rotation, outer.mirror
    if mirror is not ONE:
        rotation = tuple(
            tuple(E.mul(mirror, c) if (i == 1) != (j == 1) else c for j, c in enumerate(row))
            for i, row in enumerate(rotation)
        )  # type: ignore[assignment]
    return Pose(
        product(outer.rotation, rotation), place(outer, inner.translation), E.mul(outer.mirror, inner.mirror)
    )


def inverse(pose: Pose) -> Pose:
    rotation = transpose(pose.rotation)
    if pose.mirror is not ONE:
        rotation = tuple(
            tuple(E.mul(pose.mirror, c) if (i == 1) != (j == 1) else c for j, c in enumerate(row))
            for i, row in enumerate(rotation)
        )  # type: ignore[assignment]
    at = unplace(pose, ORIGIN)
    return Pose(rotation, at, pose.mirror)


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
            return k, int(direction[k].constant)  # type: ignore[arg-type]
    return None


def sole_axis(direction: Triple) -> int | None:
    """The axis of a unit direction whose other components are 0 by construction (its sign may differ from row to row)."""
    nonzero = [k for k in range(3) if direction[k] is not ZERO]
    return nonzero[0] if len(nonzero) == 1 else None


# ---------------------------------------------------------------- values


@dataclass(frozen=True, slots=True)
class Vec:
    """Two or three scalars: a size or displacement, or (``point``) a place, which moves with its frame."""

    items: tuple[Expr, ...]
    on: tuple[Part, ...] = ()
    point: bool = False


@dataclass(frozen=True, slots=True)
class Frame:
    """Origin and axes; ``rotation`` has the columns out, up x out, up. A face of a box is a frame with ``face``."""

    origin: Triple
    rotation: Matrix
    on: tuple[Part, ...] = ()
    face: bool = False

    @property
    def out(self) -> Triple:
        return tuple(row[0] for row in self.rotation)  # type: ignore[return-value]

    @property
    def up(self) -> Triple:
        return tuple(row[2] for row in self.rotation)  # type: ignore[return-value]


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane across ``axis`` (None where its normal is no axis by construction) at ``coordinate``."""

    axis: int | None
    coordinate: Expr
    on: tuple[Part, ...] = ()


@dataclass(frozen=True, slots=True)
class Line:
    """A directed line through ``point``; ``to`` is its other end where it has one."""

    point: Triple
    direction: Triple
    to: Triple | None = None
    on: tuple[Part, ...] = ()


@dataclass(frozen=True, slots=True)
class Box:
    """A box: ``low`` and ``high`` in the frame that ``pose`` places. ``exists`` where it may be absent (a gap)."""

    low: Triple
    high: Triple
    pose: Pose = HERE
    on: tuple[Part, ...] = ()
    exists: Expr = E.TRUE

    @property
    def size(self) -> Triple:
        return tuple(tidy(c) for c in minus(self.high, self.low))  # type: ignore[return-value]

    @property
    def center(self) -> Triple:
        return tuple(tidy(c) for c in times(plus(self.low, self.high), E.const(0.5)))  # type: ignore[return-value]


@dataclass(frozen=True, slots=True)
class Face(Frame):
    """A face of ``box``: the plane and the frame (its centre, out = normal, up = z, or x on top and bottom)."""

    box: Box | None = None
    axis: int = 0
    sign: int = 1


@dataclass(frozen=True, slots=True)
class Edge(Line):
    """The edge of two faces of a box, directed along normal(first) x normal(second)."""

    first: Face | None = None
    second: Face | None = None


@dataclass(frozen=True, slots=True)
class Choice:
    """One of named options, as a number."""

    code: Expr
    options: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Branch:
    """Parts that exist together in ``scope`` (None: wherever the reference is made), each with its pose."""

    scope: Scope | None
    members: tuple[tuple[Part, Pose], ...]


@dataclass(frozen=True, slots=True)
class Ref:
    """A reference to parts: a part has one branch with one member, a slot of a role one branch per alternative."""

    name: str
    branches: tuple[Branch, ...]
    own: bool = False  # seen from the part's own frame, while its pose is being sought
    frame: Pose = HERE  # carries what all branches have in common into the frame of the environment that names it


@dataclass(frozen=True, slots=True)
class Surface:
    """A surface of a primitive part, or one of each alternative: (table, part, pose of the part's frame, name)."""

    branches: tuple[tuple[Scope | None, Part, Pose, str], ...]


@dataclass(slots=True, eq=False)
class Ports:
    """``port socket[2]``: values by index."""

    name: str
    values: dict[int, object]

    def settled(self) -> dict[int, object]:
        return self.values


Value = object


def frame_of(out: Triple, up: Triple) -> Matrix:
    """Axes from ``out`` and ``up``; ``up`` is made square to ``out`` where it is not."""
    out = normalized(out)
    if dot(out, up) is not ZERO:
        up = minus(up, times(out, dot(out, up)))
    up = normalized(up)
    return columns(out, cross(up, out), up)


def face_of(box: Box, name: str) -> Face:
    """A face of a box by its name."""
    axis, sign = FACES[name]
    center = list(box.center)
    center[axis] = box.high[axis] if sign > 0 else box.low[axis]
    out, up = unit(axis, sign), unit(0 if axis == 2 else 2)
    axes = frame_of(direct(box.pose, out), direct(box.pose, up))
    return Face(place(box.pose, tuple(center)), axes, box.on, True, box, axis, sign)  # type: ignore[arg-type]


def edge_of(first: Face, name: str) -> Edge | None:
    """The edge where a face meets the named other face; None for a parallel one."""
    box = first.box
    axis, sign = FACES[name]
    if box is None or axis == first.axis:
        return None
    second = face_of(box, name)
    at = list(box.center)
    at[first.axis] = box.high[first.axis] if first.sign > 0 else box.low[first.axis]
    at[axis] = box.high[axis] if sign > 0 else box.low[axis]
    direction = cross(unit(first.axis, first.sign), unit(axis, sign))
    return Edge(place(box.pose, tuple(at)), direct(box.pose, direction), None, box.on, first, second)  # type: ignore[arg-type]


def corner_of(edge: Edge, name: str) -> Vec | None:
    """The corner where an edge meets the named third face."""
    axis, sign = FACES[name]
    first, second = edge.first, edge.second
    if first is None or second is None or first.box is None or axis in (first.axis, second.axis):
        return None
    at = [first.box.low[k] for k in range(3)]
    for k, s in ((first.axis, first.sign), (second.axis, second.sign), (axis, sign)):
        at[k] = first.box.high[k] if s > 0 else first.box.low[k]
    return Vec(place(first.box.pose, tuple(at)), edge.on, point=True)  # type: ignore[arg-type]


def squared(box: Box) -> Box:
    """The same box written in the frame of the environment, when its pose turns it by right angles only.

    Where a direction may differ from row to row (the halves of a mirror), low and high follow from centre and size.
    """
    if box.pose is HERE:
        return box
    turned = box.pose.rotation
    if any(sole_axis(row) is None for row in turned) or any(sole_axis(row) is None for row in transpose(turned)):
        return box
    if box.pose.mirror.constant is None or any(signed_axis(row) is None for row in turned):
        center = place(box.pose, box.center)
        half = tuple(E.mul(box.size[sole_axis(row)], E.const(0.5)) for row in turned)  # type: ignore[index]
        return Box(minus(center, half), plus(center, half), HERE, box.on, box.exists)  # type: ignore[arg-type]
    ends = place(box.pose, box.low), place(box.pose, box.high)
    low, high = [], []
    for k in range(3):
        sign = next(c.constant for c in box.pose.rotation[k] if c is not ZERO)
        own = next(j for j, c in enumerate(box.pose.rotation[k]) if c is not ZERO)
        if own == 1:
            sign *= box.pose.mirror.constant  # type: ignore[operator]
        low.append(ends[0 if sign > 0 else 1][k])  # type: ignore[operator]
        high.append(ends[1 if sign > 0 else 0][k])  # type: ignore[operator]
    return Box(tuple(low), tuple(high), HERE, box.on, box.exists)  # type: ignore[arg-type]


def extent(box: Box) -> Box:
    """The axis-aligned box of the environment's frame that holds a box, turned however."""
    straight = squared(box)
    if straight.pose is HERE:
        return straight
    half = times(box.size, E.const(0.5))
    center = place(box.pose, box.center)
    reach = tuple(dot((E.call("abs", c) for c in row), half) for row in box.pose.rotation)
    return Box(minus(center, reach), plus(center, reach), HERE, box.on, box.exists)  # type: ignore[arg-type]


def mapped(value: Value, scalar: Callable[[Expr], Expr]) -> Value:
    """A geometric value with every scalar replaced by a function of it (gather, element, ...)."""
    if isinstance(value, Expr):
        return scalar(value)
    if isinstance(value, Vec):
        return replace(value, items=tuple(map(scalar, value.items)))
    if isinstance(value, Frame):
        rotation = tuple(tuple(map(scalar, row)) for row in value.rotation)
        return Frame(tuple(map(scalar, value.origin)), rotation, value.on, value.face)  # type: ignore[arg-type]
    if isinstance(value, Plane):
        return replace(value, coordinate=scalar(value.coordinate))
    if isinstance(value, Line):
        to = None if value.to is None else tuple(map(scalar, value.to))
        point, direction = tuple(map(scalar, value.point)), tuple(map(scalar, value.direction))
        return Line(point, direction, to, value.on)  # type: ignore[arg-type]
    if isinstance(value, Box):
        low, high = tuple(map(scalar, value.low)), tuple(map(scalar, value.high))
        return replace(value, low=low, high=high, pose=mapped_pose(value.pose, scalar))
    if isinstance(value, Choice):
        return replace(value, code=scalar(value.code))
    if isinstance(value, Ports):
        return Ports(value.name, {k: mapped(v, scalar) for k, v in value.settled().items()})
    return value


def mapped_pose(pose: Pose, scalar: Callable[[Expr], Expr]) -> Pose:
    if pose is HERE:
        return pose
    rotation = tuple(tuple(map(scalar, row)) for row in pose.rotation)
    return Pose(rotation, tuple(map(scalar, pose.translation)), scalar(pose.mirror))  # type: ignore[arg-type]


def scalars(value: Value) -> tuple[Expr, ...]:
    """The scalars of a value in the order in which ``mapped`` visits them."""
    found: list[Expr] = []

    def note(e: Expr) -> Expr:
        found.append(e)
        return e

    mapped(value, note)
    return tuple(found)


def merged(parent: Scope, branches: list[tuple[Scope, Value]], on: tuple[Part, ...] = ()) -> Value:
    """One value in ``parent`` out of values of exclusive child scopes (of equal kinds)."""
    first = branches[0][1]
    if isinstance(first, Ports):
        arrays = [(s, v.settled()) for s, v in branches if isinstance(v, Ports)]
        keys = sorted({k for _, a in arrays for k in a})
        return Ports(first.name, {k: merged(parent, [(s, a[k]) for s, a in arrays if k in a], on) for k in keys})
    lists = [scalars(extent(v) if isinstance(v, Box) and len(branches) > 1 else v) for _, v in branches]
    if isinstance(first, Box) and len(branches) > 1:
        first = extent(first)
    position = iter(range(len(lists[0])))

    def pick(_: Expr) -> Expr:
        k = next(position)
        return E.phi(parent, [(s, values[k]) for (s, _), values in zip(branches, lists, strict=True)])

    value = mapped(first, pick)
    carriers: list[Part] = list(on)
    for _, v in branches:
        carriers.extend(p for p in getattr(v, "on", ()) if p not in carriers)
    return replace(value, on=tuple(carriers)) if hasattr(value, "on") else value  # type: ignore[type-var]


def moved(value: Value, pose: Pose) -> Value:
    """A value of an inner frame in the outer frame that ``pose`` places it in."""
    if pose is HERE or isinstance(value, Expr | Choice):
        return value
    if isinstance(value, Vec):
        return replace(value, items=place(pose, value.items)) if value.point else value  # type: ignore[arg-type]
    if isinstance(value, Frame):
        inner = compose(pose, Pose(value.rotation, value.origin, ONE))
        return Frame(inner.translation, inner.rotation, value.on, value.face)
    if isinstance(value, Line):
        to = None if value.to is None else place(pose, value.to)
        return Line(place(pose, value.point), direct(pose, value.direction), to, value.on)
    if isinstance(value, Plane):
        return moved_plane(value, pose)
    if isinstance(value, Box):
        return replace(value, pose=compose(pose, value.pose))
    if isinstance(value, Ports):
        return Ports(value.name, {k: moved(v, pose) for k, v in value.settled().items()})
    if isinstance(value, Surface):
        return Surface(tuple((s, part, compose(pose, outer), name) for s, part, outer, name in value.branches))
    if isinstance(value, Ref):
        return replace(value, frame=compose(pose, value.frame) if value.frame is not HERE else pose)
    return value


def baked(ref: Ref) -> Ref:
    """A reference with its common frame carried by each member."""
    if ref.frame is HERE:
        return ref
    held = (replace(b, members=tuple((p, compose(ref.frame, q)) for p, q in b.members)) for b in ref.branches)
    return Ref(ref.name, tuple(held), ref.own)


def moved_plane(value: Plane, pose: Pose) -> Plane:
    if value.axis is None:
        return value
    normal = direct(pose, unit(value.axis))
    axis = sole_axis(normal)
    if axis is None:
        return replace(value, axis=None)
    point = place(pose, times(unit(value.axis), value.coordinate))
    return replace(value, axis=axis, coordinate=point[axis])
