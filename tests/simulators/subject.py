"""An exported object on disk, and what a drive has to know about it: from our model, the same for every simulator."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from artipg_dsl.export.mjcf import mjcf_files
from artipg_dsl.export.urdf import urdf_files
from artipg_dsl.robot.model import Robot, RobotJoint
from artipg_dsl.robot.pose import follow_leaders, link_poses, rest_values
from artipg_dsl.robot.substitute import simple_joints

G = 9.81
WRITERS = {"mjcf": mjcf_files, "urdf": urdf_files}


@dataclass(frozen=True)
class Subject:
    """One object in one format: ``robot`` is what the files state, with screws and balls replaced where URDF needs it.

    For joints in closed loops ``ways`` has the values of all on the way of one to an end; ``bound`` joints follow from it.
    """

    robot: Robot
    form: str
    folder: Path
    ways: dict[tuple[str, float], list[dict[str, float]]] = field(default_factory=dict)
    bound: frozenset[str] = frozenset()

    @cached_property
    def rest(self) -> dict[str, float]:
        return rest_values(self.robot)

    @cached_property
    def moving(self) -> list[RobotJoint]:
        return [joint for joint in self.robot.joints if joint.kind != "fixed"]

    @cached_property
    def low(self) -> np.ndarray:
        """The lowest corner of what is seen at rest, in the object's frame."""
        poses = link_poses(self.robot, self.rest)
        return np.min(
            [
                (v.shape.vertices @ turn.T + shift).min(axis=0)
                for link, (turn, shift) in zip(self.robot.links, poses, strict=True)
                for v in link.visuals
            ],
            axis=0,
        )

    def values(self, given: dict[str, float]) -> dict[str, float]:
        """All joint values with the followers' set."""
        return follow_leaders(self.robot, self.rest | given)

    def carried(self, joint: RobotJoint) -> list[int]:
        """The links that a joint moves."""
        found, count = {joint.child}, 0
        while len(found) > count:
            count = len(found)
            found |= {other.child for other in self.robot.joints if other.parent in found}
        return sorted(found)

    def inertia(self, joint: RobotJoint, values: dict[str, float]) -> float:
        """What the joint moves at these values, kg m2 about a hinge's axis or kg along a slide's."""
        poses = link_poses(self.robot, values)
        links = [(self.robot.links[k], *poses[k]) for k in self.carried(joint)]
        if joint.kind == "prismatic":
            return sum(link.mass for link, _, _ in links)
        turn, place = poses[joint.child]
        axis, total = turn @ joint.axis, 0.0
        for link, turn, shift in links:
            arm = np.cross(axis, turn @ link.center + shift - place)
            total += axis @ (turn @ link.inertia @ turn.T) @ axis + link.mass * (arm @ arm)
        return float(total)


@contextmanager
def written(robot: Robot, form: str, **loops: Any) -> Iterator[Subject]:
    """A robot in a folder of its own that vanishes afterwards."""
    with TemporaryDirectory() as place:
        folder = Path(place)
        for name, data in WRITERS[form](robot).items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(data)
        yield Subject(simple_joints(robot) if form == "urdf" else robot, form, folder, **loops)
