"""Bound points (row, patch, u, v) in any number and order: where they are, and the surface there."""

from __future__ import annotations

import numpy as np

from .block import Block, to_object
from .patches import surfaces
from .surface import Evaluator


def surface_at(
    rows: Block, row: np.ndarray, patch: np.ndarray, u: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Position and outward unit normal, (m, 3) each in the object's frame, of points on rows of a block."""
    poses = (rows.rotation, rows.translation, rows.mirror)
    place, direction = np.empty((3, len(row))), np.empty((3, len(row)))
    widest = max((len(surfaces(shelf.primitive)) for shelf in rows.shelves), default=0)
    shelf_of = np.searchsorted([shelf.start for shelf in rows.shelves], row, side="right") - 1
    cell = shelf_of * widest + patch
    order = np.argsort(cell, kind="stable")
    found, starts = np.unique(cell[order], return_index=True)
    for which, at in zip(found.tolist(), np.split(order, starts[1:]), strict=True):
        shelf, number = rows.shelves[which // widest], which % widest
        made = Evaluator(shelf.primitive, number, shelf.params).at(row[at] - shelf.start, u[at], v[at])
        for axis in range(3):
            place[axis, at], direction[axis, at] = made[0][axis], made[1][axis]
    position, normal = to_object(poses, row, place, direction)
    return np.stack(position, axis=-1), np.stack(normal, axis=-1)
