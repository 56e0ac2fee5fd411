"""``pushes(joint)`` and its kin in formulas of labels: whether a force along the normal of a surface moves a joint.

A point of what the joint carries moves as the joint's value grows: along the axis of a slide, about that of a hinge.
The force along its normal does so too where the two are near enough to one another, and, about a hinge, where the point
is far enough from the axis. Neither depends on where the joint stands, as normal and motion turn together.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.primitive import Triple, triple
from ...graph.program import Joint, Pose
from ...graph.reference import definitions_of
from ...language import JOINTS, Form
from ...syntax import ast
from ..expressions.context import Draft
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..solve.guarded import lifted
from ..values.vectors import cross, dot, inverse, minus, norm, place, plus, times
from .joints import carried_axis, carried_pitch
from .links import Links
from .part import Component
from .paths import elements_named, joints

if TYPE_CHECKING:
    from .labels import Aim

FORCES = {"pushes": (-1, 1), "pulls": (1, 1), "pushes_back": (-1, -1), "pulls_back": (1, -1)}
"""By name: the force along the normal, and whether it moves the joint from rest (1) or back to it (-1)."""
NEAR = E.const(0.6)  # the cosine of the widest angle between force and motion: 53 degrees
_LEVER = E.const(0.5)  # of the longest lever arm of a target, the shortest that is enough
ROOM = E.const(1e-3)  # of a range, what is no way to go


def driven(ev: Evaluator, node: ast.CallExpr, form: Form) -> Expr:
    """``pushes(joint)`` in the formula of a label."""
    assert ev.drive is not None
    return ev.drive.truth(node, form)


class Drive:
    """The functions of one target: ``origin`` places the frame of its formulas, centred, in the object."""

    def __init__(self, links: Links, env: Env, aim: Aim, origin: Pose):
        self.links, self.env, self.aim, self.origin = links, env, aim, origin

    def truth(self, node: ast.CallExpr, form: Form) -> Expr:
        """The value of a call, a predicate over ``p`` and ``n``; false on what is there without the joint."""
        force, way = FORCES[form.name]
        target = node.arguments[0].value
        held = E.FALSE
        for guard, joint in self.lifted(target):
            held = E.either(held, E.both(guard, self.drives(joint, force, way)))
        return held

    def there(self, node: ast.Expr) -> Expr:
        """Where a joint of a name is there to move the target."""
        return E.any_of(guard for guard, _ in self.lifted(node))

    def lifted(self, node: ast.Expr) -> Iterator[tuple[Expr, Joint]]:
        """The joints of a name in the table of the target, and where each exists there."""
        named = elements_named(self.env, node)
        for joint in self.joints(node):
            guard, joint = self.lift(joint)
            yield E.both(guard, named), joint

    def joints(self, node: ast.Expr) -> list[Joint]:
        """The joints of a name that may carry the target: one, or those of several alternatives."""
        context = self.env.context
        program, found = context.program, joints(self.links, self.env, node)
        if any(not JOINTS[program.joints[k].kind].moves for k in found):
            raise context.error(
                "wrong-kind",
                node.span,
                f"the joint `{node.span.words}` is fixed and cannot move",
                hint="name a joint that moves, or leave the condition out",
            )
        carriers, scope = self.carriers(), self.aim.scope
        carried = [program.joints[k] for k in found if k in carriers]
        if found:
            context.driven[node.span] = bool(carried) or context.driven.get(node.span, False)
        return [j for j in carried if all(s.kind == "guard" for s in apart(j.scope, scope))]

    def carriers(self) -> set[int]:
        """The joints that move the target: all on the way from its links to the root."""
        joints = self.links.context.program.joints
        todo = [k for link in self.links_of(self.aim.part) for k in link]
        seen: set[int] = set()
        carried: set[int] = set()
        while todo:
            link = todo.pop()
            if link in seen:
                continue
            seen.add(link)
            for number, joint in enumerate(joints):
                if joint.child == link:
                    carried.add(number)
                    todo.extend(definitions_of(joint.parent))
        return carried

    def links_of(self, part: Component) -> list[tuple[int, ...]]:
        """The links of a part and of all parts in it."""
        inner = [p for body in part.bodies for p in body.all_parts()]
        return [definitions_of(self.links.of(part)), *(link for p in inner for link in self.links_of(p))]

    def lift(self, joint: Joint) -> tuple[Expr, Joint]:
        """A joint in the table of the target, and where it exists there."""
        scope = self.aim.scope
        if scope.within(joint.scope):
            return E.TRUE, joint
        counts = (s.count for s in apart(joint.scope, scope) if s.count is not None)
        there = E.all_of(lifted(count, scope, E.FALSE) for count in counts)

        def up(value: Expr) -> Expr:
            return lifted(value, scope)

        low, high, pitch = (None if e is None else up(e) for e in (joint.low, joint.high, joint.pitch))
        origin, axis = triple(map(up, joint.origin)), triple(map(up, joint.axis))
        return there, replace(joint, origin=origin, axis=axis, rest=up(joint.rest), low=low, high=high, pitch=pitch)

    def drives(self, joint: Joint, force: int, way: int) -> Expr:
        into = inverse(self.origin)
        at, axis = place(into, joint.origin), carried_axis(into, joint.axis, joint.kind)
        p: Triple = triple(E.var(f"p.{a}") for a in "xyz")
        n: Triple = triple(E.var(f"n.{a}") for a in "xyz")
        if JOINTS[joint.kind].tilts:  # it tilts towards any side
            arm = minus(p, at)
            enough = E.call("le", E.mul(_LEVER, self.reach(at, None)), norm(arm))
            return E.both(enough, E.call("le", E.mul(NEAR, norm(arm)), norm(cross(arm, n))))
        enough, motion = E.TRUE, axis
        if JOINTS[joint.kind].turns:
            motion = cross(axis, minus(p, at))
            enough = E.call("le", E.mul(_LEVER, self.reach(at, axis)), norm(motion))
            if joint.pitch is not None:
                motion = plus(motion, times(axis, E.div(carried_pitch(into, joint.pitch), E.const(2 * math.pi))))
        turned = dot(n, motion)
        share = E.mul(NEAR, norm(motion))
        grows, falls = E.call("le", share, turned), E.call("le", share, E.neg(turned))
        if force < 0:
            grows, falls = falls, grows
        up, down = room(joint)
        if way < 0:
            up, down = down, up
        return E.both(enough, E.either(E.both(up, grows), E.both(down, falls)))

    def reach(self, at: Triple, axis: Triple | None) -> Expr:
        """The longest lever arm of the target's box about an axis, or about a point."""
        half = times(triple(self.aim.box.size), E.const(0.5))
        arms = []
        for signs in itertools.product((-1.0, 1.0), repeat=3):
            corner: Triple = triple(E.mul(E.const(s), h) for s, h in zip(signs, half, strict=True))
            arm = minus(corner, at)
            arms.append(norm(arm if axis is None else cross(axis, arm)))
        return E.maximum(*arms)


def report(context: Draft) -> None:
    """Refuse functions of joints that carry none of the targets, in no instance of their template."""
    for span, carried in context.driven.items():
        if not carried:
            context.error(
                "wrong-kind",
                span,
                f"the joint `{span.words}` does not move what this is on",
                hint="name the joint that carries the target, or one that carries that joint",
            )


def apart(inner: Scope, scope: Scope) -> list[Scope]:
    """The tables above ``inner``, itself first, in whose rows those of ``scope`` do not lie."""
    return list(itertools.takewhile(lambda s: not scope.within(s), inner.ancestors()))


def room(joint: Joint) -> tuple[Expr, Expr]:
    """Whether a joint's value may grow from rest, and whether it may fall."""
    if joint.low is None or joint.high is None:
        return E.TRUE, E.TRUE
    slack = E.mul(ROOM, E.sub(joint.high, joint.low))
    return (E.call("lt", slack, E.sub(joint.high, joint.rest)), E.call("lt", slack, E.sub(joint.rest, joint.low)))
