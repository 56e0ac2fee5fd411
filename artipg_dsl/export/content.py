"""What shards are to hold beside what they always do: how many points, in which joint states, seen by which cameras."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from ..annotate.camera_file import from_description
from ..annotate.cameras import Cameras
from ..annotate.gripper import STANDARD as STANDARD_GRIPPER
from ..annotate.gripper import Gripper
from ..annotate.sampling import Sampling, read_weights
from ..annotate.states import REST, States, read_states
from ..geometry.rays import best_engine
from ..geometry.resolution import STANDARD as STANDARD_RESOLUTION
from ..geometry.resolution import Resolution

SHARD = 256  # objects in one
LARGEST = 512_000_000  # bytes of images in one
PIXEL_BYTES, POINT_BYTES = 34, 80  # about
_PER = {"object": 1, "link": 4, "semantic": 8, "instance": 16, "primitive": 64}  # of these in an object, about


@dataclass(frozen=True, slots=True)
class Content:
    """``points`` for each ``per``, from which ``surface``, how ``spread``, over what in ``balance`` by which ``weights`` (see
    ``Sampling``); ``states`` of the joints;
    ``gripper`` that grasps are made with, None: all of them;
    ``resolution`` of meshes; ``motion``: velocities of points; ``cameras`` for views, None: the default ones if views are wanted at all."""

    points: int = 2048
    states: States = REST
    motion: bool = False
    cameras: Cameras | None = None
    surface: str = "boundary"
    spread: str = "random"
    per: str = "object"
    gripper: Gripper | None = STANDARD_GRIPPER
    resolution: Resolution = STANDARD_RESOLUTION
    balance: str = ""
    weights: tuple[tuple[str, float], ...] = ()

    @property
    def sampling(self) -> Sampling:
        """How points are taken. Raises UsageError."""
        return Sampling(self.points, self.surface, self.spread, self.per, self.balance, self.weights)

    def of(self, formats: list[str]) -> Content:
        """The same without what none of the formats holds."""
        return replace(self, cameras=(self.cameras or Cameras()) if "views" in formats else None)

    @staticmethod
    def read(identity: Mapping[str, Any]) -> Content:
        """The content that ``identity`` has told of. Raises UserError."""
        views, gripper = identity["views"], identity["gripper"]
        cameras = None if views is None else from_description({k: v for k, v in views.items() if k != "engine"})
        return Content(
            identity["points"], read_states(identity["states"]), identity["motion"], cameras, identity["surface"],
            identity["spread"], identity["per"], None if gripper is None else Gripper(**gripper),
            Resolution(**identity.get("meshes", {})), identity.get("balance", ""), read_weights(identity.get("weights")),
        )  # fmt: skip

    def identity(self) -> dict[str, Any]:
        """What two runs must have in common for their shards to belong together, as plain data."""
        views = None if self.cameras is None else self.cameras.plain() | {"engine": best_engine()}
        gripper = None if self.gripper is None else self.gripper.plain()
        held = {"states": str(self.states), "motion": self.motion, "views": views, "gripper": gripper}
        meshes = self.resolution.plain()
        return self.sampling.plain() | held | ({"meshes": meshes} if meshes else {})

    def shard_size(self) -> int:
        """How many objects go into one shard: less than usual where points or images would make it unwieldy."""
        size, pixels = SHARD, 0
        points = self.points * self.states.count * _PER[self.per]
        if self.cameras is not None:
            pixels = self.cameras.count * self.cameras.width * self.cameras.height * self.states.count
        while size > 1 and size * max(pixels * PIXEL_BYTES, points * POINT_BYTES) > LARGEST:
            size //= 2
        return size


STANDARD = Content()
