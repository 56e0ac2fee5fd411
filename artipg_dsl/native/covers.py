"""Pictures of triangles by compiled code: what ``geometry.rays`` computes, with the same bits."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .calls import call

if TYPE_CHECKING:
    from .backend import Machine


def cover(
    machine: Machine, planes: np.ndarray, low: np.ndarray, high: np.ndarray, columns: int, rows: int
) -> np.ndarray:
    """(rows * columns,) uint64: at each place of a picture the bits of the nearness, in single precision, of the nearest of T triangles, and
    its number plus 1; 0 where there is none. ``planes`` (T, 4, 3); ``low``, ``high`` (T, 2) int64, within the picture."""
    keys = np.zeros(rows * columns, dtype=np.uint64)
    given = np.ascontiguousarray(planes), np.ascontiguousarray(low), np.ascontiguousarray(high)
    call(machine.library.cover, len(planes), *given, columns, keys)
    return keys
