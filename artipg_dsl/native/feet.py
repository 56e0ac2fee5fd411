"""On what objects stand, by compiled code: what ``validity.hull`` and ``validity.stance`` compute, with the same bits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

import numpy as np

from . import loops
from .calls import call

if TYPE_CHECKING:
    from .backend import Machine


def outlines(
    machine: Machine, points: np.ndarray, valid: np.ndarray, few: int, ways: np.ndarray, near: float, well: float
) -> tuple[np.ndarray, np.ndarray]:
    """Corners (n, 2) of the hulls of points (M, K, 2) where ``valid`` (M, K), one hull after the other, and how many each has (M,): nan for
    a set without points. Of more than ``few`` points what lies ``well`` inside those outermost along ``ways`` (w, 2) is left out first."""
    sets, each = valid.shape
    count, room = np.empty(sets, dtype=np.int64), np.empty(6 * each)
    found = np.empty((int(np.count_nonzero(valid)) + 2 * sets, 2))
    angle, data = loops.loop(np.arctan2, "dd->d")
    given = np.ascontiguousarray(points), np.ascontiguousarray(valid), few, len(ways), ways, near, well
    call(
        machine.library.outlines, sets, each, *given, ctypes.c_void_p(angle), ctypes.c_void_p(data), room, count, found
    )
    return found[: int(count.sum())], count
