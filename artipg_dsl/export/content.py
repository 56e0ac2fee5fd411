"""What the files of objects hold beyond what they always do: how many points, in which joint states, seen by which cameras."""

from __future__ import annotations

from ..annotate.cameras import Cameras
from ..annotate.gripper import STANDARD as STANDARD_GRIPPER
from ..annotate.gripper import Gripper
from ..annotate.sampling import Sampling
from ..annotate.states import REST, States
from ..details.dressing import Dressing
from ..geometry.resolution import STANDARD as STANDARD_RESOLUTION
from ..geometry.resolution import Resolution
from ..records import dataclass

SHARD = 256  # objects in one
_LARGEST = 512_000_000  # bytes of images in one
PIXEL_BYTES, POINT_BYTES = 34, 80  # about
_PER = {"object": 1, "link": 4, "semantic": 8, "instance": 16, "primitive": 64}  # of these in an object, about


@dataclass(frozen=True, slots=True)
class Content:
    """``points``: how they are sampled; ``states`` of the joints; ``motion``: velocities of points, too; ``cameras`` of
    views; ``gripper`` that grasps are made with, None: all of them; ``resolution`` of meshes; ``details`` that points wear."""

    points: Sampling = Sampling()
    states: States = REST
    motion: bool = False
    cameras: Cameras | None = None
    gripper: Gripper | None = STANDARD_GRIPPER
    resolution: Resolution = STANDARD_RESOLUTION
    details: Dressing | None = None

    def shard_size(self, largest: int = _LARGEST) -> int:
        """How many objects go into one shard: less than usual where points or images would make it larger
        than so many bytes."""
        size, pixels = SHARD, 0
        points = self.points.count * self.states.count * _PER[self.points.per]
        if self.cameras is not None:
            pixels = self.cameras.count * self.cameras.width * self.cameras.height * self.states.count
        while size > 1 and size * max(pixels * PIXEL_BYTES, points * POINT_BYTES) > largest:
            size //= 2
        return size
