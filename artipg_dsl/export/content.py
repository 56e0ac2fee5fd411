"""What shards are to hold beside what they always do: how many points, in which joint states, seen by which cameras."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ..annotate.cameras import Cameras
from ..annotate.states import REST, States
from ..geometry.rays import best_engine

SHARD = 256  # objects in one
LARGEST = 512_000_000  # bytes of images in one
PIXEL_BYTES = 34


@dataclass(frozen=True, slots=True)
class Content:
    """``points`` per object; ``states`` of the joints; ``motion``: velocities of points; ``cameras`` for views, None:
    the default ones if views are wanted at all."""

    points: int = 2048
    states: States = REST
    motion: bool = False
    cameras: Cameras | None = None

    def of(self, formats: list[str]) -> Content:
        """The same without what none of the formats holds."""
        return replace(self, cameras=(self.cameras or Cameras()) if "views" in formats else None)

    def identity(self) -> dict[str, Any]:
        """What two runs must have in common for their shards to belong together, as plain data."""
        views = None if self.cameras is None else self.cameras.plain() | {"engine": best_engine()}
        return {"points": self.points, "states": str(self.states), "motion": self.motion, "views": views}

    def shard_size(self) -> int:
        """How many objects go into one shard: less than usual where images would make it unwieldy."""
        if self.cameras is None:
            return SHARD
        pixels = self.cameras.count * self.cameras.width * self.cameras.height * self.states.count
        size = SHARD
        while size > 1 and size * pixels * PIXEL_BYTES > LARGEST:
            size //= 2
        return size


STANDARD = Content()
