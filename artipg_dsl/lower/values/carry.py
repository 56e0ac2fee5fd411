"""Values carried from frame to frame and from table to table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import overload

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr, Scope
from ...graph.primitive import triple
from ...graph.program import Pose
from .faces import extent
from .kinds import Box, Choice, Frame, Line, Lying, Placed, Plane, Ports, Ref, Surface, Value, Vec, alike
from .vectors import HERE, compose, direct, matrix, place, sole_axis, times, unit


@overload
def mapped(value: Expr, scalar: Callable[[Expr], Expr]) -> Expr: ...
@overload
def mapped(value: Box, scalar: Callable[[Expr], Expr]) -> Box: ...
@overload
def mapped(value: Frame, scalar: Callable[[Expr], Expr]) -> Frame: ...
@overload
def mapped(value: Value, scalar: Callable[[Expr], Expr]) -> Value: ...
def mapped(value: Value, scalar: Callable[[Expr], Expr]) -> Value:
    """A geometric value with every scalar replaced by a function of it (gather, element, ...)."""
    match value:
        case Expr():
            return scalar(value)
        case Vec():
            return replace(value, items=tuple(map(scalar, value.items)))
        case Frame():
            rotation = matrix(map(scalar, row) for row in value.rotation)
            return Frame(triple(map(scalar, value.origin)), rotation, value.on, value.face)
        case Plane():
            return replace(value, coordinate=scalar(value.coordinate), side=scalar(value.side))
        case Line():
            to = None if value.to is None else triple(map(scalar, value.to))
            point, direction = triple(map(scalar, value.point)), triple(map(scalar, value.direction))
            return Line(point, direction, to, value.on)
        case Box():
            low, high = triple(map(scalar, value.low)), triple(map(scalar, value.high))
            return replace(value, low=low, high=high, pose=mapped_pose(value.pose, scalar))
        case Choice():
            return replace(value, code=scalar(value.code))
        case Ports():
            return Ports(value.name, {k: mapped(v, scalar) for k, v in value.settled().items()})
        case _:
            return value


def mapped_pose(pose: Pose, scalar: Callable[[Expr], Expr]) -> Pose:
    if pose is HERE:
        return pose
    rotation = matrix(map(scalar, row) for row in pose.rotation)
    return Pose(rotation, triple(map(scalar, pose.translation)), scalar(pose.mirror))


def scalars(value: Value) -> tuple[Expr, ...]:
    """The scalars of a value in the order in which ``mapped`` visits them."""
    found: list[Expr] = []

    def note(e: Expr) -> Expr:
        found.append(e)
        return e

    mapped(value, note)
    return tuple(found)


@overload
def merged(parent: Scope, branches: Sequence[tuple[Scope, Box]]) -> Box: ...
@overload
def merged(parent: Scope, branches: Sequence[tuple[Scope, Frame]]) -> Frame: ...
@overload
def merged(parent: Scope, branches: Sequence[tuple[Scope, Value]]) -> Value: ...
def merged(parent: Scope, branches: Sequence[tuple[Scope, Value]]) -> Value:
    """One value in ``parent`` out of values of exclusive child scopes (of equal kinds; a face beside a plane is one)."""
    if any(isinstance(v, Plane) for _, v in branches):
        branches = [(s, _flat(v)) for s, v in branches]
    first = branches[0][1]
    if isinstance(first, Plane) and any(isinstance(v, Plane) and v.axis != first.axis for _, v in branches):
        first = replace(first, axis=None)
    if isinstance(first, Ports):
        arrays = [(s, v.settled()) for s, v in branches if isinstance(v, Ports)]
        keys = sorted({k for _, a in arrays for k in a})
        return Ports(first.name, {k: merged(parent, [(s, a[k]) for s, a in arrays if k in a]) for k in keys})
    lists = [scalars(extent(v) if isinstance(v, Box) and len(branches) > 1 else v) for _, v in branches]
    if isinstance(first, Box) and len(branches) > 1:
        first = extent(first)
    position = iter(range(len(lists[0])))

    def pick(_: Expr) -> Expr:
        k = next(position)
        return E.phi(parent, [(s, values[k]) for (s, _), values in zip(branches, lists, strict=True)])

    value = mapped(first, pick)
    if not isinstance(value, Lying):
        return value
    return replace(value, on=tuple(dict.fromkeys(p for _, v in branches if isinstance(v, Lying) for p in v.on)))


def _flat(value: Value) -> Value:
    """The plane of a face."""
    if not isinstance(value, Frame):
        return value
    axis = sole_axis(value.out)
    return Plane(axis, ZERO, value.on) if axis is None else Plane(axis, value.origin[axis], value.on, value.out[axis])


@overload
def whichever(cases: Sequence[tuple[Expr, Frame]]) -> Frame: ...
@overload
def whichever(cases: Sequence[tuple[Expr, Value]]) -> Value: ...
def whichever(cases: Sequence[tuple[Expr, Value]]) -> Value:
    """Of values of one kind the first whose condition holds, the last where none does."""
    value = cases[-1][1]
    for here, other in reversed(cases[:-1]):
        value = mapped(value, partial(_either, here, iter(scalars(other))))
    return value


def _either(here: Expr, others: Iterator[Expr], otherwise: Expr) -> Expr:
    """The next of the others where ``here`` holds."""
    return E.where(here, next(others), otherwise)


@overload
def moved(value: Box, pose: Pose) -> Box: ...
@overload
def moved(value: Frame, pose: Pose) -> Frame: ...
@overload
def moved(value: Value, pose: Pose) -> Value: ...
def moved(value: Value, pose: Pose) -> Value:
    """A value of an inner frame in the outer frame that ``pose`` places it in."""
    if pose is HERE:
        return value
    match value:
        case Vec():
            return replace(value, items=place(pose, triple(value.items))) if value.point else value
        case Frame():
            inner = compose(pose, Pose(value.rotation, value.origin, ONE))
            return Frame(inner.translation, inner.rotation, value.on, value.face)
        case Line():
            to = None if value.to is None else place(pose, value.to)
            return Line(place(pose, value.point), direct(pose, value.direction), to, value.on)
        case Plane():
            return _moved_plane(value, pose)
        case Box():
            return replace(value, pose=compose(pose, value.pose))
        case Ports():
            return Ports(value.name, {k: moved(v, pose) for k, v in value.settled().items()})
        case Surface():
            return Surface(tuple((s, part, compose(pose, outer), name) for s, part, outer, name in value.branches))
        case Ref():
            return replace(value, frame=compose(pose, value.frame) if value.frame is not HERE else pose)
        case Placed():
            return value.carried(pose)
        case _:
            return value


def united(name: str, values: Sequence[tuple[Scope | None, Value]]) -> Ref | Surface | None:
    """One reference to the parts, or the surfaces, that alternatives refer to, each in its table; None for other values."""
    if (surfaces := alike(Surface, values)) is not None:
        return Surface(tuple((b[0] or scope, *b[1:]) for scope, v in surfaces for b in v.branches))
    if (references := alike(Ref, values)) is not None:
        return Ref(name, tuple(replace(b, scope=b.scope or s) for s, v in references for b in _baked(v).branches))
    return None


def _baked(ref: Ref) -> Ref:
    """A reference with its common frame carried by each member."""
    if ref.frame is HERE:
        return ref
    held = (replace(b, members=tuple((p, compose(ref.frame, q)) for p, q in b.members)) for b in ref.branches)
    return Ref(ref.name, tuple(held), ref.own)


def _moved_plane(value: Plane, pose: Pose) -> Plane:
    if value.axis is None:
        return value
    normal = direct(pose, unit(value.axis))
    axis = sole_axis(normal)
    if axis is None:
        return replace(value, axis=None)
    point = place(pose, times(unit(value.axis), value.coordinate))
    return replace(value, axis=axis, coordinate=point[axis], side=E.mul(value.side, normal[axis]))
