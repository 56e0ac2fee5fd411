"""Doors that a text holds by its own friction stay shut: gravity, at rest, is less than what rubs."""

from __future__ import annotations

import os

import numpy as np
import pytest

from artipg_dsl.export.pose import link_poses, rest_values
from artipg_dsl.export.robot import Robot, RobotJoint, Robots
from artipg_dsl.session import Session, categories


def fall(robot: Robot, joint: RobotJoint) -> float:
    """What gravity moves a joint with at rest, newton metres or newton; 0 where it presses against an end."""
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
    value = rest[joint.name]
    end = joint.low if rise > 0 else joint.high
    return 0.0 if end is not None and abs(value - end) < 1e-6 else abs(rise)


@pytest.mark.parametrize("category", categories() if os.environ.get("ARTIPG_EVERY") else ["Oven"])
def test_what_hangs_stays_where_it_rests(category: str) -> None:
    robots = Robots(Session.of(category).sampler.batch(np.arange(30), 1))
    seen = 0
    for robot in map(robots.robot, range(30)):
        for joint in robot.joints:
            if joint.kind != "fixed":
                load = fall(robot, joint)
                assert load <= joint.friction, (joint.name, load, joint.friction)
                seen += load > 0
    assert seen > 20 or category != "Oven", "of ovens something always hangs"
