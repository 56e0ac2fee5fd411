"""Labelled point clouds: points on the visible surface of every object of a batch, with all that is known of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..geometry import points as geometry
from ..graph import random
from .frames import rotate
from .points import label_points

if TYPE_CHECKING:
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True)
class Points:
    """n points for each of B objects, in the object's frame, metres.

    ``position``, ``normal`` (B, n, 3); ``semantic``, ``instance`` (part number), ``link``, ``primitive`` (site number)
    and ``patch`` (B, n); ``u``, ``v`` (B, n) patch fractions; ``labels`` such as ``affordance.pull``, (B, n) each.
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


def sample_points(batch: Batch, n_points: int = 2048, states: np.ndarray | None = None) -> Points:
    """Exactly ``n_points`` per object, uniform by area, with the joints at ``states`` (J,), at rest by default.

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
    turn, shift = batch.pose(states)
    moving = np.searchsorted(batch.links().owner, np.arange(len(batch)))[:, None] + link
    position = rotate(turn[moving], made.position) + shift[moving]
    normal = rotate(turn[moving], made.normal)
    return Points(
        position, normal, labels.semantic, instance, link, made.site, made.patch, made.u, made.v, labels.fields
    )
