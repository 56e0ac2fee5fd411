"""What a reader found in the files of one object, in one shape for all formats, and what our model says it should be."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from artipg_dsl.robot.model import Robot, RobotJoint
from artipg_dsl.robot.pose import follow_leaders, link_poses

Values = dict[str, float]
Matrix = np.ndarray  # (4, 4)


@dataclass(frozen=True)
class Body:
    """A link: mass (None where the format has none), centre and inertia about it in its own frame, how many colliders."""

    mass: float | None = None
    center: np.ndarray | None = None
    inertia: np.ndarray | None = None
    colliders: int | None = None


@dataclass(frozen=True)
class Reading:
    """``joints`` has the limits of what moves, None for none; ``poses`` tells where links are at joint values, in the
    object's frame; ``bounds`` (2, 3) is the box of what is seen at the values ``seen_at``. None: the format has it not."""

    bodies: dict[str, Body]
    joints: dict[str, tuple[float, float] | None] | None = None
    poses: Callable[[Values], dict[str, Matrix]] | None = None
    bounds: np.ndarray | None = None
    seen_at: Values | None = None
    source: Any = None  # kept alive while ``poses`` may be asked


def matrix(turn: np.ndarray, shift: np.ndarray) -> Matrix:
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = turn, shift
    return found


def from_quaternion(w: float, x: float, y: float, z: float) -> np.ndarray:
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def principal_to_full(moments: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """The inertia tensor of principal moments along the columns of ``turn``."""
    return turn @ np.diag(moments) @ turn.T


def random_values(robot: Robot, seed: int) -> Values:
    """A random state within the limits, followers with their leaders."""
    random = np.random.default_rng(seed)
    spans = {j.name: (j.low, j.high) if j.low is not None and j.high is not None else (-3.0, 3.0) for j in robot.joints}
    return follow_leaders(robot, {name: float(random.uniform(*span)) for name, span in spans.items()})


def from_the_root(robot: Robot) -> list[RobotJoint]:
    """The joints in an order in which parents come before their children."""
    above = {joint.child: joint for joint in robot.joints}

    def depth(link: int) -> int:
        return 1 + depth(above[link].parent) if link in above else 0

    return sorted(robot.joints, key=lambda joint: depth(joint.child))


def model_poses(robot: Robot, values: Values) -> dict[str, Matrix]:
    return {
        link.name: matrix(turn, shift)
        for link, (turn, shift) in zip(robot.links, link_poses(robot, values), strict=True)
    }


def model_bounds(robot: Robot, values: Values) -> np.ndarray:
    """The box (2, 3) of what is seen."""
    poses = model_poses(robot, values)
    points = [
        v.shape.vertices @ poses[link.name][:3, :3].T + poses[link.name][:3, 3]
        for link in robot.links
        for v in link.visuals
    ]
    every = np.concatenate(points)
    return np.stack([every.min(axis=0), every.max(axis=0)])
