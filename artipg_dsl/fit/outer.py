"""Which points of a cloud lie on what can be seen from without: no depth picture of the cloud hides them from all sides.

Clouds of meshes and of structures have surfaces inside, scans have none. So that both can be compared, points behind
others are set aside, seen from many sides in pictures whose cells are wide enough that a surface leaves none of them empty.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

from ..geometry.outside import spread_directions
from ..geometry.vectors import corners
from ..native import backend, depths

_SIDES = 42
_FROM = 3  # sides from which a point is seen at least: through a gap between points it is from one
_CELL = 2.6  # of a picture, in distances between points
_BLOCK = 4_000_000  # points at a time, all sides together


def spacing(points: np.ndarray) -> np.ndarray:
    """(K,) about how far the points (K, n, 3) of closed surfaces lie apart, were their surfaces that of their boxes."""
    low, high = corners(points)
    x, y, z = np.moveaxis(high - low, -1, 0)
    return np.sqrt(2.0 * (x * y + y * z + z * x) / points.shape[1])


def outer(points: np.ndarray, apart: np.ndarray | None = None) -> np.ndarray:
    """(K, n) bool: which points of the clouds (K, n, 3) can be seen from without; ``apart`` (K,) is their spacing."""
    return _often(_sides(points, _cells(spacing(points) if apart is None else apart)))


class Screens:
    """The clouds (T, M, 3) of targets, whose points lie ``apart`` (T,), to tell what of candidates they hide. The few points of a candidate
    hide only what lies far below its surface: most of a drawer inside a housing would pass for visible."""

    def __init__(self, clouds: np.ndarray, apart: np.ndarray):
        self.low, high = corners(clouds)
        self.cell = _cells(apart)
        across = int(_across(high - self.low, self.cell).max(initial=1))
        machine = backend.machine()
        if machine is not None:
            self.least, self.front = depths.pictures(machine, clouds, self.low, self.cell, _frames(), across)
            return
        drawn = list(_pictures(clouds, self.low, self.cell, across))
        self.least = np.stack([least for least, _, _, _ in drawn], axis=1)
        self.front = np.stack([front.reshape(len(clouds), across, across) for _, front, _, _ in drawn], axis=1)

    def outer(self, points: np.ndarray, target: np.ndarray) -> np.ndarray:
        """(K, n) bool: which points of candidates (K, n, 3) can be seen from without, neither these nor those of the ``target`` (K,) of each
        being in the way."""
        return _often(_sides(points, _cells(spacing(points)), (self, target)))

    def passed(self, side: int, points: np.ndarray, target: np.ndarray) -> np.ndarray:
        """Which points (K, n) the targets of candidates do not hide from a side."""
        cell, wide = self.cell[target][:, None], self.front.shape[-1]
        x, y, depth = (_along(points - self.low[target][:, None], axis) for axis in _frames()[side])
        x, y = (np.floor((c - self.least[target, side, k, None]) / cell) for k, c in enumerate((x, y)))
        beside = (x < 0) | (y < 0) | (x >= wide) | (y >= wide)
        x, y = (np.where(beside, 0, c).astype(np.int64) for c in (x, y))
        return np.asarray(beside | (depth >= self.front[target[:, None], side, x, y] - cell))


def _often(sides: np.ndarray) -> np.ndarray:
    """Which points are seen from enough sides, these being bits."""
    for _ in range(_FROM - 1):
        sides = sides & (sides - np.uint64(1))  # without the lowest bit
    return np.asarray(sides != 0)


def _cells(apart: np.ndarray) -> np.ndarray:
    return np.maximum(_CELL * apart, 1e-12)


def _across(size: np.ndarray, cell: np.ndarray) -> np.ndarray:
    """(K,) how many cells wide pictures of clouds of a ``size`` (K, 3) are."""
    return np.ceil(np.sqrt((size**2).sum(axis=1)) / cell).astype(np.int64) + 2


def _sides(points: np.ndarray, cell: np.ndarray, others: tuple[Screens, np.ndarray] | None = None) -> np.ndarray:
    """(K, n) uint64, a bit for each side: from which points of clouds (K, n, 3) are seen; ``others`` tells what else may hide them."""
    low, high = corners(points)
    across, machine = _across(high - low, cell), backend.machine()
    if machine is not None:
        told = None if others is None else (_shown(others[0]), others[1])
        return depths.sides(machine, points, low, cell, _frames(), across, told)
    count, n = points.shape[:2]
    found = np.zeros((count, n), dtype=np.uint64)
    step = max(1, _BLOCK // (n * _SIDES))
    for start in range(0, count, step):
        part = slice(start, start + step)
        drawn = _pictures(points[part], low[part], cell[part], int(across[part].max()))
        for side, (_, front, place, depth) in enumerate(drawn):
            seen = depth >= front[place] - cell[part, None]
            if others is not None:
                seen &= others[0].passed(side, points[part], others[1][part])
            found[part] |= seen.astype(np.uint64) << np.uint64(side)
    return found


def _shown(screens: Screens) -> depths.Pictures:
    return screens.low, screens.cell, screens.least, screens.front


def _pictures(
    points: np.ndarray, low: np.ndarray, cell: np.ndarray, across: int
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """From each side: where the pictures of clouds begin along their two axes (K, 2), and how near the nearest of each of their cells is
    (K * across * across,); of each point its cell (K, n), and its depth (K, n)."""
    count, centred = len(points), points - low[:, None]
    own = np.arange(count)[:, None] * across * across
    for first, second, way in _frames():
        x, y, depth = (_along(centred, axis) for axis in (first, second, way))
        least = np.stack([x.min(axis=1), y.min(axis=1)], axis=1)
        x, y = ((c - least[:, k, None]) / cell[:, None] for k, c in enumerate((x, y)))
        place = own + x.astype(np.int64) * across + y.astype(np.int64)
        front = np.full(count * across * across, -np.inf)
        np.maximum.at(front, place.ravel(), depth.ravel())  # of one axis: several times faster
        yield least, front, place, depth


def _along(points: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """(K, n) of points (K, n, 3), rounded as compiled code does, which a product of matrices is not."""
    return np.asarray(points[..., 0] * axis[0] + points[..., 1] * axis[1] + points[..., 2] * axis[2])


@cache
def _frames() -> np.ndarray:
    """(sides, 3, 3): two axes of the picture from each side, and the way there."""
    return np.array([(*_axes(way), way) for way in spread_directions(_SIDES)])


def towards(points: np.ndarray, apart: float) -> np.ndarray:
    """(n, 3) for points of one cloud: about where it is seen from, the sum of the sides from which it can be."""
    found, sides = np.zeros(points.shape), _sides(points[None], _cells(np.array([apart])))[0]
    for side, (_, _, way) in enumerate(_frames()):
        found += ((sides >> np.uint64(side)) & np.uint64(1)).astype(np.float64)[:, None] * way
    return found


def _axes(way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    other = np.eye(3)[int(np.argmin(np.abs(way)))]
    first = np.cross(way, other)
    first /= np.sqrt((first * first).sum())
    return first, np.cross(way, first)
