"""Whole numbers in a row: many ranges one after the other, and where runs of one value begin."""

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
