"""Joints that a format does not have, as chains of those that it has, with links of next to no mass between.

A screw is a hinge and a slide on one axis that follows it. A ball is three hinges through one point: the tilt that its
value is (see ``runtime.motion.freedoms``), the tilt about the third direction, and the twist about its own axis. What follows
another by a formula follows by the straight line between its ends. A spring is left out. An object
of one link gets a second one, of next to no mass and fixed to the first: SAPIEN takes no file without a joint for an articulation.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.vectors import cross
from ..runtime.motion import perpendicular_to
from .model import SMALLEST_MASS, Robot, RobotJoint, RobotLink
from .naming import Names

ADVANCE, SWING, TWIST, MARK = "_advance", "_swing", "_twist", "_mark"
_SHARE = 1e-3  # of the moved link's mass and inertia, for a link that is there for the format alone


def simple_joints(robot: Robot) -> Robot:
    """The same robot with hinges, slides and fixed joints alone; a joint that needs more keeps its name and value."""
    links, joints = list(robot.links), []
    link_names = Names(link.name for link in robot.links)
    names = Names(joint.name for joint in robot.joints)
    for joint in (_unsprung(replace(joint, curve=None)) for joint in robot.joints):
        kind = "revolute" if joint.limited else "continuous"
        if joint.traits.advances:
            advance = (joint.name, joint.pitch / (2.0 * np.pi), 0.0)
            ends = [value * advance[1] for value in (joint.low, joint.high) if value is not None]
            low, high = (min(ends), max(ends)) if len(ends) == 2 else (None, None)
            slide = replace(
                joint,
                name=names(joint.name + ADVANCE),
                kind="prismatic",
                low=low,
                high=high,
                rest=joint.rest * advance[1],
                effort=joint.effort / max(abs(advance[1]), 1e-3),
                velocity=joint.velocity * abs(advance[1]),
                damping=0.0,
                friction=0.0,
                mimic=advance,
                pitch=0.0,
            )
            joints += _chain([slide, replace(joint, kind=kind, pitch=0.0)], links, link_names)
        elif joint.traits.tilts:
            tilt = perpendicular_to(joint.axis[None])[0]
            tilted = replace(joint, kind=kind, axis=tilt)
            if joint.low is not None and joint.high is not None:  # a range is that of the angle, in any direction
                reach = max(abs(joint.low), abs(joint.high))
                tilted = replace(tilted, low=-reach, high=reach)
            other = replace(tilted, rest=0.0, mimic=None)
            swing = replace(other, name=names(joint.name + SWING), axis=cross(joint.axis, tilt))
            twist = replace(other, name=names(joint.name + TWIST), axis=joint.axis)
            joints += _chain([tilted, swing, twist], links, link_names)
        else:
            joints.append(joint)
    if not joints:
        links.append(_mark(links[0]))
        joints.append(_fixed_joint(links[0].name + MARK))
    return replace(robot, links=tuple(links), joints=tuple(joints))


def _unsprung(joint: RobotJoint) -> RobotJoint:
    if joint.unsprung is None:
        return joint
    friction, damping, effort = joint.unsprung
    return replace(joint, stiffness=0.0, friction=friction, damping=damping, effort=effort, unsprung=None)


def _mark(root: RobotLink) -> RobotLink:
    """A link that is there to have a joint, at the root's origin."""
    inertia = 1e-6 * SMALLEST_MASS * np.eye(3)
    return RobotLink(root.name + MARK, root.origin, SMALLEST_MASS, np.zeros(3), inertia, (), ())


def _fixed_joint(name: str) -> RobotJoint:
    """A fixed joint from the first link to the second."""
    axis = np.array([0.0, 0.0, 1.0])
    return RobotJoint(name, "fixed", 0, 1, np.zeros(3), axis, None, None, 0.0, 0.0, 0.0, 0.0, 0.0, None)


def _chain(steps: list[RobotJoint], links: list[RobotLink], names: Names) -> list[RobotJoint]:
    """The joints one behind the other at one place; the links between are added to ``links``."""
    moved = links[steps[0].child]
    chained, parent = [], steps[0].parent
    for i, step in enumerate(steps):
        child = step.child
        if i + 1 < len(steps):
            child = len(links)
            trace = float(moved.inertia[0, 0] + moved.inertia[1, 1] + moved.inertia[2, 2])
            inertia = _SHARE * max(trace, 1e-9) * np.eye(3)
            name = names(f"{moved.name}_carrier_{i + 1}" if i else f"{moved.name}_carrier")
            links.append(RobotLink(name, moved.origin, _SHARE * moved.mass, np.zeros(3), inertia, (), ()))
        chained.append(replace(step, parent=parent, child=child, origin=step.origin if i == 0 else np.zeros(3)))
        parent = child
    return chained
