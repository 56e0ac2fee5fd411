"""Whole numbers in a row: many ranges one after the other, where runs of one value begin, which values there are and are not."""

from __future__ import annotations

import numpy as np


def runs(start: np.ndarray, count: np.ndarray) -> np.ndarray:
    """``start[0], start[0] + 1, ...`` (count[0] of them), then those from ``start[1]`` on, and so forth."""
    return np.arange(int(count.sum())) + np.repeat(start - (np.cumsum(count) - count), count)


def changes(values: np.ndarray) -> np.ndarray:
    """(n,) bool: where another value stands than before, and the first."""
    found = np.ones(len(values), dtype=bool)
    np.not_equal(values[1:], values[:-1], out=found[1:])
    return found


def distinct(values: np.ndarray) -> np.ndarray:
    """The values of an array, each once and in order. ``np.unique`` finds the same; it loads ``numpy.ma`` first, a tenth of what NumPy
    itself takes to load."""
    found = np.sort(values, axis=None)
    return found[changes(found)]


def absent(count: int, present: np.ndarray) -> np.ndarray:
    """Which of the numbers below ``count`` are not among those ``present``, in order."""
    found = np.ones(count, dtype=bool)
    found[present] = False
    return np.flatnonzero(found)
