"""The nearest of points in many sets, by compiled code: what ``fit.near`` asks for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .calls import call

if TYPE_CHECKING:
    from .backend import Machine

AXES, BESIDE = 6, 16  # at most: of points, and neighbours of each


class Forest:
    """Points (n, d) in trees, one for each of the sets ``of`` (n,), whole numbers from 0 on."""

    def __init__(self, machine: Machine, points: np.ndarray, of: np.ndarray):
        count, axes = points.shape
        number = np.argsort(of, kind="stable")
        many = np.bincount(of)
        place = np.ascontiguousarray(points[number], dtype=np.float64)
        node, gap = np.empty((2 * count, 3), dtype=np.int64), np.empty((2 * count, 2))
        root, box = np.empty(len(many), dtype=np.int64), np.empty((len(many), 2, axes))
        call(machine.library.plant, len(many), many, axes, place, number, node, gap, root, box)
        self._machine, self._count = machine, count
        self._trees = (axes, place, number, node, gap, len(many), root, box)

    def nearest(
        self, points: np.ndarray, of: np.ndarray, count: int = 1, within: float = np.inf
    ) -> tuple[np.ndarray, np.ndarray]:
        """How far (m, count) the nearest of their sets ``of`` (m,) lie from points (m, d), and their numbers, the nearest first; inf and the
        number of all points where there are no more ``within`` that distance."""
        found, apart = np.empty((len(of), count), dtype=np.int64), np.empty((len(of), count))
        places = np.ascontiguousarray(points, dtype=np.float64), np.ascontiguousarray(of, dtype=np.int64)
        asked = (count, float(within), self._count, found, apart)
        call(self._machine.library.nearest_of, len(of), *places, *self._trees, *asked)
        return apart, found
