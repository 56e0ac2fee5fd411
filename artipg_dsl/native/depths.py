"""Depth pictures of clouds by compiled code: what ``fit.outer`` computes, with the same bits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from .calls import address, call

if TYPE_CHECKING:
    from .backend import Machine


class _Screens(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("low", "cell", "least", "front")]


Pictures = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def pictures(
    machine: Machine, points: np.ndarray, low: np.ndarray, cell: np.ndarray, frames: np.ndarray, across: int
) -> tuple[np.ndarray, np.ndarray]:
    """Of clouds (K, n, 3) with ``low`` corners (K, 3) and cells (K,), from each side, told by ``frames`` (sides, 3, 3): where pictures begin
    (K, sides, 2), and how near the nearest of each cell is (K, sides, across, across)."""
    count, n = points.shape[:2]
    least, front = np.empty((count, len(frames), 2)), np.empty((count, len(frames), across, across))
    room = np.empty((3, n)), np.empty(n, dtype=np.int64)
    clouds = np.ascontiguousarray(points), np.ascontiguousarray(low), np.ascontiguousarray(cell)
    call(machine.library.depth_pictures, count, n, *clouds, len(frames), frames, across, least, front, *room)
    return least, front


def sides(
    machine: Machine,
    points: np.ndarray,
    low: np.ndarray,
    cell: np.ndarray,
    frames: np.ndarray,
    across: np.ndarray,
    others: tuple[Pictures, np.ndarray] | None = None,
) -> np.ndarray:
    """(K, n) uint64, a bit for each side: from which points of clouds (K, n, 3) are seen, being hidden neither by these nor by the pictures of
    those which stand behind them, of which ``others`` tells: low corners and cells, what ``pictures`` gives, and which (K,) of them."""
    count, n = points.shape[:2]
    seen = np.empty((count, n), dtype=np.uint64)
    front = np.empty(int(across.max(initial=1)) ** 2)
    room = front, np.empty((3, n)), np.empty(n, dtype=np.int64)
    clouds = np.ascontiguousarray(points), np.ascontiguousarray(low), np.ascontiguousarray(cell)
    behind: tuple[object, ...] = (None, None, 0)
    if others is not None:
        target = np.ascontiguousarray(others[1], dtype=np.int64)
        behind = target, _Screens(*(address(array) for array in others[0])), others[0][3].shape[-1]
    call(machine.library.depth_sides, count, n, *clouds, len(frames), frames, across, *room, *behind, seen)
    return seen
