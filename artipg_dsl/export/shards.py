"""Shards of points, views and annotations, the same bytes for the same objects."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from ..annotate.annotation import annotation_lines
from ..annotate.cameras import Cameras
from ..annotate.cloud import sample_points
from ..annotate.sampling import Sampling
from ..annotate.states import REST, States, joint_values, state_table
from ..annotate.views import NONE, make_views
from ..details.dressing import Dressing
from ..sampling.columns import to_columns
from .containers import Arrays
from .content import Content

if TYPE_CHECKING:
    from ..runtime.batch import Batch


def point_arrays(
    batch: Batch, how: Sampling | int, states: States = REST, motion: bool = False, details: Dressing | None = None
) -> dict[str, np.ndarray]:
    """The arrays of a points shard, by name: those of ``meanings``, then one per label."""
    values = None if states.only_rest else joint_values(batch, states)
    worn = None
    if details is not None:
        from ..details.store import dress, origins  # start-up: most objects wear none, and k-d trees load slowly

        worn = partial(dress, dressing=details)
    points = sample_points(batch, how, values, motion=motion, dress=worn)
    arrays: dict[str, np.ndarray] = {
        "object": np.asarray(batch.numbers, dtype=np.int64)[points.object],
        "points": points.position.astype(np.float32),
        "normals": points.normal.astype(np.float32),
        "semantic": _narrow(points.semantic),
        "instance": _narrow(points.instance),
        "link": _narrow(points.link),
        "material": np.where(points.material < 0, NONE, _narrow(np.maximum(points.material, 0))).astype(np.uint16),
        "npcs": points.npcs.astype(np.float32),
        "primitive": _narrow(points.primitive, np.uint16),
        "element": _narrow(points.element),
        "patch": _narrow(points.patch, np.uint16),
        "u": points.u.astype(np.float32),
        "v": points.v.astype(np.float32),
    }
    if isinstance(how, Sampling) and how.uneven:
        assert points.area is not None
        arrays["area"] = points.area.astype(np.float32)
    if details is not None and points.worn is not None:
        arrays["worn"] = points.worn >= 0
        label, arrays["completed"] = origins(batch, points.worn, details)
        arrays["real_label"] = label.astype(np.int16)
    if values is not None:
        arrays["state"] = state_table(batch, values)[points.object]
    if points.motion is not None:
        assert points.drivers is not None and points.velocities is not None
        arrays["motion"] = points.motion.astype(np.float32)
        arrays["drivers"] = np.where(points.drivers < 0, NONE, _narrow(np.maximum(points.drivers, 0))).astype(np.uint16)
        arrays["velocities"] = points.velocities.astype(np.float32)
    if points.acting is not None:
        for name, joint in points.acting.items():
            arrays[f"{name}.joint"] = np.where(joint < 0, NONE, _narrow(np.maximum(joint, 0))).astype(np.uint16)
    labels = {name: a if a.dtype == bool else a.astype(np.float32) for name, a in sorted(points.labels.items())}
    return arrays | labels


def view_arrays(batch: Batch, cameras: Cameras, states: States = REST) -> dict[str, np.ndarray]:
    """The arrays of a views shard, by name; those of clouds begin with ``cloud_``."""
    values = None if states.only_rest else joint_values(batch, states)
    views = make_views(batch, cameras, values)
    arrays = {"object": np.asarray(batch.numbers, dtype=np.int64)}
    if values is not None:
        arrays["state"] = state_table(batch, values)
    arrays |= {"intrinsics": views.intrinsics, "extrinsics": views.extrinsics} | views.images
    return arrays | {f"cloud_{name}": values for name, values in views.cloud.items()}


def _narrow(values: np.ndarray, dtype: type = np.uint16) -> np.ndarray:
    """Small numbers in a type that does not depend on what a shard happens to hold."""
    values = np.asarray(values)
    if values.size and int(values.max()) > np.iinfo(dtype).max:
        raise OverflowError(f"{int(values.max())} does not fit {np.dtype(dtype).name}")
    return values.astype(dtype)


def points_shard(batch: Batch, content: Content) -> Arrays:
    """The arrays of ``points-<shard>.npz``."""
    return point_arrays(batch, content.points, content.states, content.motion, content.details)


def views_shard(batch: Batch, content: Content) -> Arrays:
    """The arrays of ``views-<shard>.npz``."""
    return view_arrays(batch, content.cameras or Cameras(), content.states)


def tables_shard(batch: Batch, content: Content) -> Arrays:
    """The arrays of ``tables-<shard>.npz``: the values that the objects are made of."""
    del content
    return to_columns(batch)


def annotation_shard(batch: Batch, content: Content) -> bytes:
    """The lines of ``annotation-<shard>.jsonl``: one object each."""
    values = None if content.states.only_rest else joint_values(batch, content.states)
    details = None
    if content.details is not None:
        from ..details.store import tell  # start-up: as above

        details = tell(batch, content.details)
    lines = annotation_lines(batch, values, content.gripper, details)
    return "".join([line + "\n" for line in lines]).encode("utf-8")
