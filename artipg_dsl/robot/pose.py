"""Joint values of one robot, and where its links are at them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..annotate.frames import axis_angle
from ..runtime.motion import perpendicular_to

if TYPE_CHECKING:
    from .model import Robot, RobotJoint

LinkPose = tuple[np.ndarray, np.ndarray]


def rest_values(robot: Robot) -> dict[str, float]:
    """The value of every joint at rest; a follower's comes from its leader."""
    return follow_leaders(robot, {joint.name: joint.rest for joint in robot.joints})


def open_values(robot: Robot) -> dict[str, float]:
    """The value of every joint at the end of its range that is farther from rest (without limits: a full turn on)."""
    return follow_leaders(robot, {joint.name: _other_end(joint) for joint in robot.joints})


def follow_leaders(robot: Robot, values: dict[str, float]) -> dict[str, float]:
    """``values`` with those of mimicking joints set from their leaders' (chains of followers are followed)."""
    by_name = {joint.name: joint for joint in robot.joints}
    found = {}
    for name in values:
        chain = [name]
        while (mimic := by_name[chain[-1]].mimic) is not None and len(chain) <= len(by_name):
            chain.append(mimic[0])
        value = values[chain.pop()]
        for follower in reversed(chain):
            value = float(by_name[follower].following(np.asarray(value)))
        found[name] = value
    return found


def _other_end(joint: RobotJoint) -> float:
    if joint.low is None or joint.high is None:
        return joint.rest + 2 * np.pi
    return joint.high if joint.high - joint.rest >= joint.rest - joint.low else joint.low


def link_poses(robot: Robot, values: dict[str, float]) -> list[LinkPose]:
    """Rotation (3, 3) and origin (3,) of every link's frame in the object's, at the values of all joints."""
    above = {joint.child: joint for joint in robot.joints}
    found: dict[int, LinkPose] = {}
    for link in range(len(robot.links)):
        chain = []
        while link not in found and link in above:
            chain.append(above[link])
            link = above[link].parent
        if link not in found:
            found[link] = np.eye(3), robot.links[link].origin
        for joint in reversed(chain):
            found[joint.child] = _beyond(found[joint.parent], joint, values[joint.name])
    return [found[link] for link in range(len(robot.links))]


def _beyond(parent: LinkPose, joint: RobotJoint, value: float) -> LinkPose:
    """The pose of a joint's child link. No BLAS: the same bits everywhere."""
    turn, shift = parent
    tilts = joint.traits.tilts
    origin = joint.origin + value * (joint.advance or 0.0) * joint.axis
    axis = perpendicular_to(joint.axis[None])[0] if tilts else joint.axis  # the tilt that a ball's value is
    own = axis_angle(axis, np.asarray(value)) if tilts or joint.traits.turns else np.eye(3)
    return _product(turn, own), _product(turn, origin) + shift


def _product(turn: np.ndarray, other: np.ndarray) -> np.ndarray:
    """A matrix (3, 3) times a matrix or vector, summed in a fixed order."""
    terms = turn.T.reshape(3, 3, *[1] * (other.ndim - 1)) * other[:, None]
    return terms[0] + terms[1] + terms[2]


def rest_poses(robot: Robot) -> list[LinkPose]:
    """The poses of all links with the joints at rest."""
    return link_poses(robot, rest_values(robot))
