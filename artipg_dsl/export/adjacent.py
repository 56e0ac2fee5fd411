"""Which links a joint or a closed loop holds together, or the text lets overlap, so that simulators are told not to let them collide."""

from __future__ import annotations

import numpy as np

from .robot import Robot, RobotJoint

_LIGHT = 0.05  # of the mass of what a link carries


def find_adjacent(robot: Robot) -> list[tuple[str, str]]:
    """Names of pairs of links that a joint, two joints with but a light link between, a common axle or a loop's closing holds together,
    or that the text allows to overlap.

    Links that fixed joints hold together count as one.
    """
    fixed_to = {joint.child: joint.parent for joint in robot.joints if not joint.traits.moves}
    welded = list(range(len(robot.links)))
    for link in range(len(welded)):
        while welded[link] in fixed_to:
            welded[link] = fixed_to[welded[link]]
    groups: dict[int, list[int]] = {}
    for link, group in enumerate(welded):
        groups.setdefault(group, []).append(link)
    held = [(joint.parent, joint.child) for joint in robot.joints if joint.traits.moves]
    held += [closure.links for closure in robot.closures]
    held += [(a.parent, b.child) for a in robot.joints for b in robot.joints if _through_a_light_link(robot, a, b)]
    held += [
        (a.child, b.child) for i, a in enumerate(robot.joints) for b in robot.joints[i + 1 :] if _on_one_axle(a, b)
    ]
    pairs = [(a, b) for one, other in held for a in groups[welded[one]] for b in groups[welded[other]]]
    pairs += [pair for pair in robot.overlaps if pair[::-1] not in pairs]
    pairs += [(a, b) for group in groups.values() for i, a in enumerate(group) for b in group[i + 1 :]]
    return [(robot.links[a].name, robot.links[b].name) for a, b in dict.fromkeys(pairs)]


def _through_a_light_link(robot: Robot, one: RobotJoint, other: RobotJoint) -> bool:
    """Whether two joints are one mechanism: the ring in which a stem slides and with which it turns weighs next to nothing."""
    return one.child == other.parent and robot.links[one.child].mass < _LIGHT * robot.links[other.child].mass


def _on_one_axle(one: RobotJoint, other: RobotJoint) -> bool:
    """Whether two links turn about one line of their parent, one following the other: the halves of scissors on their pin."""
    if one.parent != other.parent or any(joint.advance is not None or not joint.traits.turns for joint in (one, other)):
        return False
    if (one.mimic or ("",))[0] != other.name and (other.mimic or ("",))[0] != one.name:
        return False
    off = [np.cross(one.axis, vector) for vector in (other.axis, other.origin - one.origin)]
    return bool(np.abs(off).max() < 1e-6)
