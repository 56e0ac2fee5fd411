"""Frames of parts seen from a body around them, and boxes around parts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Scope
from ...graph.primitive import triple
from ...graph.program import Pose
from ..values.carry import moved
from ..values.faces import around, extent
from ..values.kinds import Box
from ..values.vectors import HERE, ORIGIN, compose
from .env import Env

if TYPE_CHECKING:
    from ..elaborate.part import Component


def frame_in(env: Env, root: Env | None) -> Pose:
    """The frame of an environment in that of a body around it, through repeats and parts."""
    pose, at = HERE, env
    while at is not root:
        if at.outer is not None:
            pose, at = compose(at.frame, pose), at.outer
        elif at.instance is not None:
            pose, at = compose(at.instance.part.pose, pose), at.instance.part.env
        else:
            break
    return pose


def raised(box: Box, scope: Scope | None, to: Scope) -> Box:
    """A box of the rows of ``scope``, as the box around all its rows per row of ``to``."""
    while scope is not None and scope is not to and scope.within(to) and scope.parent is not None:
        if scope.kind == "repeat":
            low = tuple(E.reduce("min", scope, c) for c in box.low)
            high = tuple(E.reduce("max", scope, c) for c in box.high)
        else:
            inf = E.const(float("inf"))
            low = tuple(E.phi(scope.parent, [(scope, c)], inf) for c in box.low)
            high = tuple(E.phi(scope.parent, [(scope, c)], E.neg(inf)) for c in box.high)
        box, scope = Box(triple(low), triple(high), on=box.on), scope.parent
    return box


def _boxes_in(env: Env) -> Iterator[tuple[Component, Box]]:
    """Every part of an environment and of those inside it with its box, in the environment's frame."""
    for part in env.parts:
        yield part, moved(part.box(), part.pose)
    for inner in env.inner:
        for part, box in _boxes_in(inner):
            yield part, moved(box, inner.frame)


def union_of(env: Env, scope: Scope) -> Box:
    """The axis-aligned box around all parts of an environment and of those inside it, in its frame and ``scope``."""
    boxes = []
    for part, found in _boxes_in(env):
        box = extent(found)
        if part.exists is not E.TRUE:
            box = Box(
                triple(E.where(part.exists, c, E.const(float("inf"))) for c in box.low),
                triple(E.where(part.exists, c, E.const(float("-inf"))) for c in box.high),
            )
        boxes.append(raised(box, part.env.scope, scope))
    return around(boxes) if boxes else Box(ORIGIN, ORIGIN)
