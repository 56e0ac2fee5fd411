"""The faces of convex hulls by compiled code, which ``geometry.wrap`` would find, too."""

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
