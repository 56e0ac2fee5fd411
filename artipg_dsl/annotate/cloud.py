"""Labelled point clouds: points on the visible surface of every object of a batch, with all that is known of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..geometry import points as geometry
from ..graph import random
from .frames import rotate
from .points import label_points
from .states import twist

if TYPE_CHECKING:
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True)
class Points:
    """n points for each of B objects, in the object's frame, metres.

    ``position``, ``normal`` (B, n, 3); ``semantic``, ``instance`` (part number), ``link``, ``primitive`` (site number)
    and ``patch`` (B, n); ``u``, ``v`` (B, n) patch fractions; ``labels`` such as ``affordance.pull``, (B, n) each.
    With K states, ``position``, ``normal`` and ``motion`` are (B, K, n, 3): the same points, moved. ``motion`` is the
    velocity per unit (radian, metre) of the point's own joint, None unless asked for.
    """

    position: np.ndarray
    normal: np.ndarray
    semantic: np.ndarray
    instance: np.ndarray
    link: np.ndarray
    primitive: np.ndarray
    patch: np.ndarray
    u: np.ndarray
    v: np.ndarray
    labels: dict[str, np.ndarray]
    motion: np.ndarray | None = None


def sample_points(
    batch: Batch, n_points: int = 2048, states: np.ndarray | None = None, *, motion: bool = False
) -> Points:
    """Exactly ``n_points`` per object, uniform by area, joints at ``states`` (J,) or (K, J), by default at rest.

    Points lie on the surface that is visible with all joints at 0, where objects are closed, and move with their links.
    The points of an object are the same in any batch. Raises PointsError for objects without visible surface.
    """
    tables = batch.sites()
    address = np.asarray(batch.numbers).astype(np.uint64)
    made = geometry.sample(tables, len(batch), n_points, random.key(batch.seed, "points"), address)
    labels = label_points(batch, tables, made)
    starts = np.zeros(len(batch.program.sites), dtype=np.int64)
    sizes = [len(table.owner) for table in tables]
    starts[[table.number for table in tables]] = np.cumsum([0, *sizes[:-1]])
    at = starts[made.site] + made.row
    instance = np.concatenate([table.instance for table in tables])[at]
    link = np.concatenate([table.link for table in tables])[at]
    own = np.searchsorted(batch.links().owner, np.arange(len(batch)))[:, None] + link
    several = states is not None and np.ndim(states) == 2
    shown = [moved(batch, made, own, one, motion) for one in (np.asarray(states) if several else [states])]
    position, normal, velocity = (
        None if arrays[0] is None else np.stack(arrays, axis=1) if several else arrays[0]
        for arrays in zip(*shown, strict=True)
    )
    assert position is not None and normal is not None
    binding = made.site, made.patch, made.u, made.v
    return Points(position, normal, labels.semantic, instance, link, *binding, labels.fields, velocity)


def moved(
    batch: Batch, made: geometry.PointSet, link: np.ndarray, states: np.ndarray | None, motion: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Position, normal and, if asked for, velocity (B, n, 3) of points on the link rows ``link`` (B, n)."""
    turn, shift = batch.pose(states)
    position = rotate(turn[link], made.position) + shift[link]
    return position, rotate(turn[link], made.normal), twist(batch, states).at(link, position) if motion else None
