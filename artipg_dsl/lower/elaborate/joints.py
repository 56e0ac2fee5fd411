"""Joints: their axes, ranges and physics, in the object's frame."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.primitive import Triple, triple
from ...graph.program import Joint, Pose
from ...language import JOINTS
from ...semantics.meanings import Clearance
from ...syntax import ast
from ..expressions.context import where
from ..expressions.env import Hinge
from ..expressions.evaluate import Evaluator
from ..values.kinds import Frame, Line, Vec
from ..values.vectors import direct, normalized, place
from .connect import Attachment, named_box
from .part import Component
from .place import bare, moved

if TYPE_CHECKING:
    from .links import Links


def build_joint(links: Links, part: Component, attachment: Attachment) -> None:
    """The joint by which an attachment moves a part, put among those of the program."""
    statement = attachment.joint
    assert statement is not None and statement.child is not None
    env, program = attachment.env, links.context.program
    ev = Evaluator(env)
    kind = statement.kind or "fixed"
    child = links.own_link(part, attachment)
    parents = links.base(env) if attachment.base else links.carried(attachment.to, statement.span)
    origin, axis = axis_of(ev, part, statement, kind)
    outer = links.world(env)
    low = high = None
    if statement.range is not None:
        low, high = ends(ev, statement.range.value, kind, len(program.joints))
    rest = _rest_of(ev, statement, low, high)
    if statement.mimic is not None:
        links.mimics[len(program.joints)] = (env, statement.mimic.value)
    if statement.when is not None:
        links.gates[len(program.joints)] = (env, statement.when.value)
    given = (
        statement.damping,
        statement.friction,
        statement.stiffness,
        statement.effort,
        statement.velocity,
        statement.pitch,
        statement.positions,
    )
    physics: dict[str, Any] = {c.word: ev.scalar(c.value) for c in given if c is not None}
    if "pitch" in physics:
        physics["pitch"] = carried_pitch(outer, physics["pitch"])
    path = env.path + statement.name
    joint = Joint(
        path,
        part.path if statement.name in ("motion", "") else path,
        program.links[child].scope,
        kind,
        parents,
        child,
        place(outer, origin),
        carried_axis(outer, axis, kind),
        low,
        high,
        rest,
        where=where(statement.span),
        **physics,
    )
    links.joints[child] = links.made[Hinge(env, statement)] = len(program.joints)
    links.stated[len(program.joints)] = statement
    program.joints.append(joint)


def limit(ev: Evaluator, node: ast.Expr, kind: str) -> Expr:
    """An end of a range; ``clearance`` stands for a whole turn or ten metres, which is narrowed when objects are made."""
    if clears(ev, node):
        return E.const(10.0 if JOINTS[kind].slides else 2 * math.pi)
    return ev.scalar(node)


def ends(ev: Evaluator, interval: ast.RangeExpr, kind: str, joint: int) -> tuple[Expr, Expr]:
    """Both ends of the range of a joint, by its number."""
    low, high = interval.low, interval.high
    if clears(ev, low):
        ev.env.context.unclear.append((low.span, "only the high end of a range can be `clearance`"))
    elif clears(ev, high) and not JOINTS[kind].clears:
        ev.env.context.unclear.append((high.span, f"a {kind} joint cannot end at `clearance`"))
    elif clears(ev, high):
        ev.env.context.clearances[joint] = high.span
        if isinstance(high, ast.AllExpr):
            ev.env.context.whatever.add(joint)
    return limit(ev, low, kind), limit(ev, high, kind)


def _rest_of(ev: Evaluator, statement: ast.JointDecl, low: Expr | None, high: Expr | None) -> Expr:
    """The given rest value, else the value of the range nearest 0."""
    if statement.rest is not None:
        return ev.scalar(statement.rest.value)
    if low is None or high is None:
        return E.ZERO
    return E.minimum(E.maximum(E.ZERO, low), high)


def axis_of(ev: Evaluator, part: Component, statement: ast.JointDecl, kind: str) -> tuple[Triple, Triple]:
    """Origin and direction in the frame of the statement."""
    if part.env is ev.env:
        center = place(part.pose, part.box().center)
    else:
        center = named_box(ev, part, part.span).center
    clause = statement.about or statement.along
    node = statement.parent if clause is None else clause.value
    assert node is not None
    match None if clause is None and bare(ev.env, node) else ev.value(node):
        case Line(point=point, direction=direction):
            return point, direction
        case Frame(out=direction) as frame:
            return moved(ev, frame, statement.at if clause is None else None), direction
        case Vec(items=(a, b, c), point=False) if clause is not None:
            return center, (a, b, c)
    if clause is not None:
        raise ev.env.context.error(
            "bad-axis",
            clause.span,
            "this is not an axis",
            hint="an axis is an edge (door.left.back), a line port, line(...) or a direction",
        )
    if not JOINTS[kind].axis:
        at = statement.at
        return (ev.vector(at.value[0].value) if at is not None else center), (E.ONE, E.ZERO, E.ZERO)
    raise ev.env.context.error(
        "bad-axis",
        statement.span,
        f"this {kind} joint has no axis",
        hint="write `about` and an edge or a line (door.left.back), or for a prismatic joint `along` and a direction",
    )


def clears(ev: Evaluator, node: ast.Expr) -> bool:
    """Whether an end of a range is as far as nothing is in the way."""
    return isinstance(node, ast.AllExpr) or isinstance(ev.env.context.meaning(node), Clearance)


def carried_axis(outer: Pose, axis: Triple, kind: str) -> Triple:
    """An axis in the object's frame; an axis of rotation is a pseudo-vector, which a mirror turns round once more."""
    carried = normalized(direct(outer, axis))
    return triple(E.mul(outer.mirror, c) for c in carried) if JOINTS[kind].turns else carried


def carried_pitch(outer: Pose, pitch: Expr) -> Expr:
    """The pitch of a screw in the object's frame: a mirror turns a right-handed thread into a left-handed one."""
    return E.mul(outer.mirror, pitch)
