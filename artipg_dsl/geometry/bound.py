"""Bound points (row, patch, u, v) in any number and order: the surface there."""

from __future__ import annotations

import numpy as np

from .block import Block
from .patches import surfaces
from .surface import PatchEvaluator


def normals_at(rows: Block, row: np.ndarray, patch: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Outward unit normals (m, 3) in the objects' frames at points on rows of a block."""
    local = np.empty((3, len(row)))
    widest = max((len(surfaces(shelf.primitive)) for shelf in rows.shelves), default=0)
    shelf_of = np.searchsorted([shelf.start for shelf in rows.shelves], row, side="right") - 1
    cell = shelf_of * widest + patch
    narrow = cell.astype(np.int16) if len(rows.shelves) * widest < 2**15 else cell  # sorted by its digits
    order = np.argsort(narrow, kind="stable")
    sorted_cell = cell[order]
    starts = (
        np.flatnonzero(np.append(True, sorted_cell[1:] != sorted_cell[:-1])) if len(cell) else np.empty(0, np.int64)
    )
    for which, at in zip(sorted_cell[starts].tolist(), np.split(order, starts[1:]), strict=True):
        shelf, number = rows.shelves[which // widest], which % widest
        _, normal = PatchEvaluator(shelf.primitive, number, shelf.params).at(row[at] - shelf.start, u[at], v[at])
        for axis in range(3):
            local[axis][at] = normal[axis]
    local[1] *= rows.mirror[row]
    out = np.empty((len(row), 3))
    for axis in range(3):
        a, b, c = (rows.rotation[3 * axis + k][row] for k in range(3))
        out[:, axis] = a * local[0] + b * local[1] + c * local[2]
    return out
