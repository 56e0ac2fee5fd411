"""Faces, edges and corners of boxes, and boxes written in the frame of their environment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...graph import expr as E
from ...graph.expr import ONE, ZERO
from ...graph.primitive import Triple, triple
from ...graph.program import Pose
from .kinds import Box, Carrier, Edge, Face, Vec
from .vectors import (
    HERE,
    Matrix,
    columns,
    compose,
    cross,
    direct,
    dot,
    minus,
    normalized,
    place,
    plus,
    product,
    signed_axis,
    sole_axis,
    times,
    transpose,
    unit,
)

FACES = {"front": (0, 1), "back": (0, -1), "left": (1, 1), "right": (1, -1), "top": (2, 1), "bottom": (2, -1)}


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
    return Face(place(box.pose, triple(center)), axes, box.on, True, box, axis, sign)


def carried_face(face: Face, pose: Pose) -> Face:
    """A face in the outer frame that ``pose`` places it in, of a box whose faces keep their names there."""
    box = None if face.box is None else replace(face.box, pose=compose(pose, face.box.pose))
    inner = compose(pose, Pose(face.rotation, face.origin, ONE))
    return replace(face, origin=inner.translation, rotation=inner.rotation, box=box)


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
    return Edge(place(box.pose, triple(at)), direct(box.pose, direction), None, box.on, first, second)


def corner_of(edge: Edge, name: str) -> Vec | None:
    """The corner where an edge meets the named third face."""
    axis, sign = FACES[name]
    first, second = edge.first, edge.second
    if first is None or second is None or first.box is None or axis in (first.axis, second.axis):
        return None
    at = [first.box.low[k] for k in range(3)]
    for k, s in ((first.axis, first.sign), (second.axis, second.sign), (axis, sign)):
        at[k] = first.box.high[k] if s > 0 else first.box.low[k]
    return Vec(place(first.box.pose, triple(at)), edge.on, point=True)


def squared(box: Box) -> Box:
    """The same box written in the frame of the environment, when its pose turns it by right angles only; if it turns it by another
    angle about an axis of the environment, the box whose faces along that axis have the names that they have in the environment.

    Where a direction may differ from row to row (the halves of a mirror), low and high follow from centre and size.
    """
    if box.pose is HERE:
        return box
    turned = box.pose.rotation
    if any(sole_axis(row) is None for row in turned) or any(sole_axis(row) is None for row in transpose(turned)):
        return _along_the_axis(box)
    if box.pose.mirror.constant is None or any(signed_axis(row) is None for row in turned):
        center = place(box.pose, box.center)
        half = triple(E.mul(box.size[k], E.const(0.5)) for k in map(sole_axis, turned) if k is not None)
        return Box(minus(center, half), plus(center, half), HERE, box.on, box.exists)
    ends = place(box.pose, box.low), place(box.pose, box.high)
    low, high = [], []
    for k in range(3):
        own, sign = next((j, c.constant or 0.0) for j, c in enumerate(box.pose.rotation[k]) if c is not ZERO)
        if own == 1:
            sign *= box.pose.mirror.constant
        low.append(ends[0 if sign > 0 else 1][k])
        high.append(ends[1 if sign > 0 else 0][k])
    return Box(triple(low), triple(high), HERE, box.on, box.exists)


def _along_the_axis(box: Box) -> Box:
    """A box that is turned about an axis of the environment, its own axes exchanged so that this one has its name and sense.

    Of the other two, z remains z if it can: a slanted bar keeps its top, whichever of its sides faces y.
    """
    if box.pose.mirror is not ONE:
        return box
    for k, row in enumerate(box.pose.rotation):
        found = signed_axis(row)
        if found is None or found == (k, 1):
            continue
        own, sign = found
        taken = [(own, sign)] * 3
        if 2 in (k, own):
            for shift in (1, 2):
                taken[(k + shift) % 3] = (own + shift) % 3, sign if shift == 2 else 1
        else:
            taken[2], taken[1 - k] = (2, 1), (1 - own, sign if own == k else -sign)
        pose = Pose(product(box.pose.rotation, columns(*(unit(*one) for one in taken))), box.pose.translation, ONE)
        low, high = (
            triple(E.mul(E.const(float(sign)), (ends if sign > 0 else others)[axis]) for axis, sign in taken)
            for ends, others in ((box.low, box.high), (box.high, box.low))
        )
        return Box(low, high, pose, box.on, box.exists)
    return box


def extent(box: Box) -> Box:
    """The axis-aligned box of the environment's frame that holds a box, turned however."""
    straight = squared(box)
    if straight.pose is HERE:
        return straight
    half = times(box.size, E.const(0.5))
    center = place(box.pose, box.center)
    reach = triple(dot((E.call("abs", c) for c in row), half) for row in box.pose.rotation)
    return Box(minus(center, reach), plus(center, reach), HERE, box.on, box.exists)


def around(boxes: Sequence[Box]) -> Box:
    """The axis-aligned box around several, at least one."""
    boxes = [extent(box) for box in boxes]
    low = triple(E.minimum(*(box.low[k] for box in boxes)) for k in range(3))
    high = triple(E.maximum(*(box.high[k] for box in boxes)) for k in range(3))
    return Box(low, high)


def centred(size: Triple, on: tuple[Carrier, ...] = ()) -> Box:
    """The box of a size around the origin."""
    half = times(size, E.const(0.5))
    return Box(times(half, E.const(-1.0)), half, on=on)
