"""What a network learns from: the arrays of each task, made of a batch of objects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..annotate.camera_file import cameras_of
from ..annotate.cameras import Cameras
from ..annotate.cloud import Dress, sample_points, sample_surface
from ..annotate.sampling import Sampling
from ..annotate.states import draw_values, joint_values, read_states
from ..annotate.views import see_points
from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError
from ..records import dataclass

if TYPE_CHECKING:
    from ..runtime.batch import Batch

Arrays = dict[str, np.ndarray]


@dataclass(frozen=True, slots=True)
class Task:
    """``points``: arrays of the cloud (B, n, ...) beside ``points`` itself; ``vocabulary``: that of their labels; ``partial``: also a
    cloud seen by one camera."""

    name: str
    points: tuple[str, ...]
    vocabulary: str = "semantic"
    partial: bool = False


_ALL = (
    Task("segmentation", ("normals", "semantic", "instance", "link")),
    Task("pose", ("normals", "npcs", "semantic", "instance", "link", "motion")),
    Task("completion", (), partial=True),
    Task("affordance", ("normals", "affordance", "motion"), "affordance"),
)
TASKS: dict[str, Task] = {task.name: task for task in _ALL}

DTYPES = {"semantic": np.int64, "instance": np.int64, "link": np.int64}
"""Classes are as losses want them; all other arrays of points are float32."""

_AFFORDANCE = "affordance."


def find_task(name: str) -> Task:
    """Raises UsageError."""
    if not isinstance(name, str):
        raise UsageError(f"a task is named by a text, not {name!r}", f"the tasks are {', '.join(TASKS)}")
    if name not in TASKS:
        raise UsageError(f"there is no task {name!r}", did_you_mean(name, TASKS) or f"the tasks are {', '.join(TASKS)}")
    return TASKS[name]


def state_of(batch: Batch, states: str, epoch: int) -> np.ndarray:
    """Joint values (J,): "rest", "open", "random" (new ones in every epoch), or joints by name, ``lid=20%``.

    Raises UsageError.
    """
    if states == "random":
        return batch.settle(draw_values(batch, epoch))
    wanted = read_states(states)
    if wanted.count != 1:
        raise UsageError(
            f"`{states}` are {wanted.count} states", "a batch shows an object once: give one, such as random"
        )
    return np.asarray(joint_values(batch, wanted)[0])


def one_camera(view: Mapping[str, object], points: int) -> Cameras:
    """The camera that a view describes, whose clouds have so many points unless it says otherwise. Raises UsageError, UserError."""
    camera = cameras_of({"points": points, **({} if "poses" in view else {"views": 1}), **view})
    if camera.count != 1:
        raise UsageError(
            f"view has {camera.count} cameras", "each object is seen by one: leave out `views`, give one pose"
        )
    return camera


def make_arrays(
    batch: Batch,
    task: Task,
    points: int,
    states: np.ndarray,
    words: Mapping[str, Sequence[str]],
    camera: Cameras | None,
    dress: Dress | None,
) -> Arrays:
    """The arrays of a task for B objects with their joints at ``states`` (J,), in the object's frame, metres.

    ``points``, ``normals``, ``npcs``, ``motion`` (B, n, 3) float32, ``motion`` the velocity by the own joint per radian or metre;
    ``semantic``, ``instance``, ``link`` (B, n) int64; ``affordance`` (B, n, W) float32 in the order of ``words["affordance"]``;
    ``partial`` (B, n, 3): what the one ``camera`` sees, which other tasks have not. ``dress`` moves points to where their details are.
    """
    if camera is not None:
        # for one picture embree's tree takes longer to build than a z-buffer to fill, which is there without an extra, too
        seen = see_points(batch, camera, states, "numpy")[:, 0]
        return {"points": sample_surface(batch, Sampling(points), states).position.astype(np.float32), "partial": seen}
    motion = "motion" in task.points
    made = sample_points(batch, points, states, motion=motion, dress=dress, vocabulary=task.vocabulary)
    found: Arrays = {"points": made.position.astype(np.float32)}
    sources = {"normals": made.normal, "npcs": made.npcs, "motion": made.motion}
    sources |= {"semantic": made.semantic, "instance": made.instance, "link": made.link}
    for name in task.points:
        if name == "affordance":
            found[name] = stack_words(made.labels, words["affordance"], made.position.shape[:2])
        else:
            array = sources[name]
            assert array is not None
            found[name] = array.astype(DTYPES.get(name, np.float32))
    return found


def stack_words(labels: Mapping[str, np.ndarray], words: Sequence[str], shape: tuple[int, ...]) -> np.ndarray:
    """(B, n, W) float32: an affordance each, 0 where a category does not know the word."""
    none = np.zeros(shape, np.float32)
    each = [np.asarray(labels.get(_AFFORDANCE + word, none), dtype=np.float32) for word in words]
    return np.stack(each, axis=-1) if each else np.zeros((*shape, 0), np.float32)
