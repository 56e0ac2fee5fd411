"""Which points of a cloud lie on what can be seen from without: no depth picture of the cloud hides them from all sides.

Clouds of meshes and of structures have surfaces inside, scans have none. So that both can be compared, points behind
others are set aside, seen from many sides in pictures whose cells are wide enough that a surface leaves none of them empty.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

from ..geometry.outside import spread_directions

_SIDES = 42
_FROM = 3  # sides from which a point is seen at least: through a gap between points it is from one
_CELL = 2.6  # of a picture, in distances between points
_BLOCK = 4_000_000  # points at a time, all sides together


def spacing(points: np.ndarray) -> np.ndarray:
    """(K,) about how far the points (K, n, 3) of closed surfaces lie apart, were their surfaces that of their boxes."""
    x, y, z = np.moveaxis(np.ptp(points, axis=1), -1, 0)
    return np.sqrt(2.0 * (x * y + y * z + z * x) / points.shape[1])


def outer(points: np.ndarray, apart: np.ndarray | None = None) -> np.ndarray:
    """(K, n) bool: which points of the clouds (K, n, 3) can be seen from without; ``apart`` (K,) is their spacing."""
    count, n = points.shape[:2]
    seen = np.zeros((count, n), dtype=bool)
    step = max(1, _BLOCK // (n * _SIDES))
    apart = spacing(points) if apart is None else apart
    for start in range(0, count, step):
        part = slice(start, start + step)
        seen[part] = _outer(points[part], np.maximum(_CELL * apart[part], 1e-12))
    return seen


def _outer(points: np.ndarray, cell: np.ndarray) -> np.ndarray:
    found = np.zeros(points.shape[:2], dtype=np.int64)
    for _, seen in _sides(points, cell):
        found += seen
    return found >= _FROM


def _sides(points: np.ndarray, cell: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """From each side: the way there (3,), and which points (K, n) are seen from it."""
    count, cell = len(points), cell[:, None]
    centred = points - points.min(axis=1, keepdims=True)
    across = int(np.ceil((np.sqrt((np.ptp(points, axis=1) ** 2).sum(axis=1)) / cell[:, 0]).max())) + 2
    own = np.arange(count)[:, None] * across * across
    front = np.empty(count * across * across)
    for first, second, way in _frames():
        x, y, depth = (centred @ axis for axis in (first, second, way))
        x, y = ((c - c.min(axis=1, keepdims=True)) / cell for c in (x, y))
        place = own + x.astype(np.int64) * across + y.astype(np.int64)
        front.fill(-np.inf)
        np.maximum.at(front, place.ravel(), depth.ravel())  # of one axis: several times faster
        yield way, depth >= front[place] - cell


@cache
def _frames() -> np.ndarray:
    """(sides, 3, 3): two axes of the picture from each side, and the way there."""
    return np.array([(*_axes(way), way) for way in spread_directions(_SIDES)])


def towards(points: np.ndarray, apart: float) -> np.ndarray:
    """(n, 3) for points of one cloud: about where it is seen from, the sum of the sides from which it can be."""
    found = np.zeros(points.shape)
    cell = np.array([max(_CELL * apart, 1e-12)])
    for way, seen in _sides(points[None], cell):
        found += seen[0][:, None] * way
    return found


def _axes(way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    other = np.eye(3)[int(np.argmin(np.abs(way)))]
    first = np.cross(way, other)
    first /= np.sqrt((first * first).sum())
    return first, np.cross(way, first)
