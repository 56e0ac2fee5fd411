"""The nearest of points that stand in many sets, as ``geometry.nearest`` has it: by compiled code where there is some, in less than half the
time. Of points that are equally far either finds any, so that only what is drawn at random is to be asked."""

from __future__ import annotations

import numpy as np

from ..geometry.nearest import Nearest as Trees
from ..native import backend
from ..native.near import Forest


class Nearest:
    """Points (n, d), each in the set ``of`` (n,), a whole number from 0 on; sets lie less than ``apart`` across."""

    def __init__(self, points: np.ndarray, of: np.ndarray, apart: float):
        machine = backend.machine()
        self._forest = None if machine is None else Forest(machine, points, of)
        self._trees = Trees(points, of, apart) if machine is None else None

    def find(self, points: np.ndarray, of: np.ndarray, within: float = np.inf) -> tuple[np.ndarray, np.ndarray]:
        """The distance (m,) of points (m, d) to the nearest of their sets ``of`` (m,), and its index (m,). Where none is ``within`` that
        distance, inf and the number of points."""
        if self._trees is not None:
            return self._trees.find(points, of, within)
        assert self._forest is not None
        distance, index = self._forest.nearest(points, of, within=within)
        return distance[:, 0], index[:, 0]

    def several(self, points: np.ndarray, of: np.ndarray, count: int) -> np.ndarray:
        """(m, count) the nearest ones of the sets ``of`` (m,) of points (m, d), the nearest first; what follows all of a set means nothing."""
        if self._trees is not None:
            return self._trees.several(points, of, count)
        assert self._forest is not None
        return self._forest.nearest(points, of, count)[1]
