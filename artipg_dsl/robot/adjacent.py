"""Which links a joint or a closed loop holds together, or the text lets overlap, so that simulators are told not to let them collide."""

from __future__ import annotations

import numpy as np

from .model import Robot, RobotJoint

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
    below: dict[int, list[RobotJoint]] = {}
    for joint in robot.joints:
        below.setdefault(joint.parent, []).append(joint)
    held += [
        (a.parent, b.child) for a in robot.joints for b in below.get(a.child, ()) if _is_light(robot, a.child, b.child)
    ]
    held += [(a.child, b.child) for a, b in _followers(robot) if _on_one_axle(a, b)]
    pairs = [(a, b) for one, other in held for a in groups[welded[one]] for b in groups[welded[other]]]
    pairs += [pair for pair in robot.overlaps if pair[::-1] not in pairs]
    pairs += [(a, b) for group in groups.values() for i, a in enumerate(group) for b in group[i + 1 :]]
    return [(robot.links[a].name, robot.links[b].name) for a, b in dict.fromkeys(pairs)]


def _is_light(robot: Robot, between: int, link: int) -> bool:
    """Whether two joints are one mechanism: the ring in which a stem slides and with which it turns weighs next to nothing."""
    return robot.links[between].mass < _LIGHT * robot.links[link].mass


def _followers(robot: Robot) -> list[tuple[RobotJoint, RobotJoint]]:
    """Pairs of joints of which one follows the other, in their order."""
    number = {joint.name: k for k, joint in enumerate(robot.joints)}
    led = {(number[joint.mimic[0]], k) for k, joint in enumerate(robot.joints) if joint.mimic is not None}
    return [(robot.joints[a], robot.joints[b]) for a, b in sorted({(min(pair), max(pair)) for pair in led})]


def _on_one_axle(one: RobotJoint, other: RobotJoint) -> bool:
    """Whether two links turn about one line of their parent: the halves of scissors on their pin, one following the other."""
    if one.parent != other.parent or any(joint.advance is not None or not joint.traits.turns for joint in (one, other)):
        return False
    off = [np.cross(one.axis, vector) for vector in (other.axis, other.origin - one.origin)]
    return bool(np.abs(off).max() < 1e-6)
