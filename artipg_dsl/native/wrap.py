"""The faces of convex hulls by compiled code, which ``geometry.wrap`` would find, too, and what they fit, as ``geometry.hulls`` has it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .calls import call

if TYPE_CHECKING:
    from .backend import Machine


def wrap(machine: Machine, points: np.ndarray, start: np.ndarray, doubt: float) -> list[np.ndarray | None]:
    """The faces (F, 3) of sets of points (N, 3), set k from ``start[k]`` to ``start[k + 1]``, where they are beyond ``doubt``."""
    count = len(start) - 1
    many, found = np.zeros(count, dtype=np.int64), np.empty((2 * len(points), 3), dtype=np.int64)
    if call(machine.library.wrap, count, start, points, doubt, many, found) < 0:
        raise MemoryError("no memory for hulls")
    ends = np.cumsum(many)
    parts = np.split(found[: ends[-1]], ends[:-1]) if count else []
    return [faces if len(faces) else None for faces in parts]


def first_of_each(machine: Machine, keys: np.ndarray, start: np.ndarray) -> np.ndarray:
    """Which of keys (N,) are the first of their value (N,) in their set; set k is from ``start[k]`` to ``start[k + 1]``."""
    found = np.empty(len(keys), dtype=bool)
    if call(machine.library.first_of_each, len(start) - 1, start, keys, found) < 0:
        raise MemoryError("no memory for hulls")
    return found


def fit_faces(
    machine: Machine, points: np.ndarray, faces: np.ndarray, across: np.ndarray, others: np.ndarray, flat: float
) -> np.ndarray:
    """Which sets of points (k, P, 3) faces (F, 3) fit: no corner ``across`` their edges (F, 3), and no other of the points, stands out of
    one by more than ``flat`` of the extent."""
    found, (sets, count, _) = np.empty(len(points), dtype=bool), points.shape
    corners = (np.ascontiguousarray(column, dtype=np.int64) for column in (faces, across))
    given = np.ascontiguousarray(points, dtype=np.float64)
    room = np.empty(3 * count)
    call(machine.library.fit_faces, sets, count, given, len(faces), *corners, len(others), others, flat, room, found)
    return found
