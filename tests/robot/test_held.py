"""What a text holds by its own friction stays where it rests: gravity pulls less than what rubs."""

from __future__ import annotations

import os

import numpy as np
import pytest

from artipg_dsl.robot.model import Robot, RobotJoint
from artipg_dsl.robot.pose import follow_leaders, link_poses, rest_values
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session, categories


def weight(robot: Robot, joint: RobotJoint) -> float:
    """What gravity moves a joint with at rest, newton metres or newton."""
    rest = rest_values(robot)
    poses, carried = link_poses(robot, rest), {joint.child}
    for _ in robot.joints:
        carried |= {other.child for other in robot.joints if other.parent in carried}
    turn, place = poses[joint.child]
    axis, rise = turn @ joint.axis, 0.0
    for k in carried:
        link, (own, shift) = robot.links[k], poses[k]
        arm = own @ link.center + shift - place
        rise += 9.81 * link.mass * (axis[2] if joint.kind == "prismatic" else np.cross(axis, arm)[2])
    return float(rise)


def slopes(robot: Robot, leader: RobotJoint) -> dict[str, float]:
    """How fast joints move at rest with one that leads: itself 1, those that follow it, others not at all."""
    rest, step = rest_values(robot), 1e-6
    before, after = (follow_leaders(robot, rest | {leader.name: rest[leader.name] + way}) for way in (-step, step))
    return {name: (after[name] - before[name]) / (2 * step) for name in rest if after[name] != before[name]}


def fall(robot: Robot, leader: RobotJoint) -> tuple[float, float]:
    """What gravity moves a joint with at rest, those that follow it included, 0 where it presses against an end; and what rubs."""
    moved = slopes(robot, leader)
    joints = {joint.name: joint for joint in robot.joints}
    rise = sum(slope * weight(robot, joints[name]) for name, slope in moved.items())
    rubs = sum(abs(slope) * joints[name].friction for name, slope in moved.items())
    end = leader.low if rise > 0 else leader.high
    held = end is not None and abs(rest_values(robot)[leader.name] - end) < 1e-6
    return 0.0 if held else abs(rise), rubs


EVERY = os.environ.get("ARTIPG_EVERY") == "1"
COUNT = 30 if EVERY else 8


@pytest.mark.parametrize("category", categories() if EVERY else ["Oven"])
def test_what_hangs_stays_where_it_rests(category: str) -> None:
    robots = Robots(Session.of(category).sampler.batch(np.arange(COUNT), 1))
    seen = 0
    for robot in map(robots.robot, range(COUNT)):
        for joint in robot.joints:
            if joint.kind != "fixed" and joint.mimic is None:
                load, rubs = fall(robot, joint)
                assert load <= rubs, (joint.name, load, rubs)
                seen += load > 0
    assert seen >= COUNT or category != "Oven", "of ovens something always hangs"
