"""The nearest of points that stand in many sets, each looked for in a set of its own: all of them in one query."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree


class Nearest:
    """Points (n, d), each in the set ``of`` (n,). Along one more axis sets lie ``apart`` from one another, farther than a point and
    the nearest of its set."""

    def __init__(self, points: np.ndarray, of: np.ndarray, apart: float):
        self._apart = apart
        # cut at the middles of boxes rather than at medians: searched in three quarters of the time
        self._tree = cKDTree(self._parted(points, of), balanced_tree=False)

    def find(self, points: np.ndarray, of: np.ndarray, within: float = np.inf) -> tuple[np.ndarray, np.ndarray]:
        """The distance (m,) of points (m, d) to the nearest of their sets ``of`` (m,), and its index (m,). Where none is ``within`` that
        distance, inf and the number of points: not to look farther is faster."""
        distance, index = self._tree.query(self._parted(points, of), distance_upper_bound=within)
        return distance, index

    def two(self, points: np.ndarray, of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(m, 2) the distances of points (m, d) to the nearest two of their sets ``of`` (m,), and their indices: inf and the number of points
        where there is one in all, and something far off where a set has one."""
        distance, index = self._tree.query(self._parted(points, of), k=2)
        return distance, index

    def several(self, points: np.ndarray, of: np.ndarray, count: int) -> np.ndarray:
        """(m, count) the nearest ones of the sets ``of`` (m,) of points (m, d), the nearest first. After all of a set follow others, and
        after all there are the number of points."""
        return np.asarray(self._tree.query(self._parted(points, of), k=np.arange(1, count + 1))[1])

    def _parted(self, points: np.ndarray, of: np.ndarray) -> np.ndarray:
        return np.concatenate([points, self._apart * of[:, None]], axis=1)
