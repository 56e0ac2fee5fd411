"""What a format has no words for, refused before anything of an object is written in it."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from .write import ExportError

if TYPE_CHECKING:
    from ..robot.model import Robot


def refuse_joints(robot: Robot, kinds: Collection[str], reader: str, name: str) -> None:
    """Raises ExportError for the format ``name`` where a joint is none of the ``kinds`` that ``reader`` has."""
    for joint in robot.joints:
        if joint.kind not in kinds:
            raise ExportError(
                f"{robot.name}: joint {joint.name} is a {joint.kind} joint, which {reader} cannot express",
                f"{reader} has {', '.join(kinds)}; leave {name} out of --format",
            )


def refuse_coupled_balls(robot: Robot, reader: str, name: str) -> None:
    """Raises ExportError for the format ``name`` where a ball follows a joint or a joint a ball, which ``reader`` cannot have."""
    for joint in robot.joints:
        led = robot.leader(joint)
        if led is not None and (joint.traits.tilts or led.traits.tilts):
            raise ExportError(
                f"{robot.name}: joint {joint.name} follows {led.name}, and {reader} couples no ball joints",
                f"leave {name} out of --format",
            )
