"""Which points of a cloud lie on what can be seen from without: no depth picture of the cloud hides them from all sides.

Clouds of meshes and of structures have surfaces inside, scans have none. So that both can be compared, points behind
others are set aside, seen from many sides in pictures whose cells are wide enough that a surface leaves none of them empty.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import repeat

import numpy as np

from ..geometry.outside import spread_directions
from ..records import dataclass

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
    return _outer(points, spacing(points) if apart is None else apart)


class Screens:
    """The clouds (T, M, 3) of targets, whose points lie ``apart`` (T,), to tell what of candidates they hide. The few points of a candidate
    hide only what lies far below its surface: most of a drawer inside a housing would pass for visible."""

    def __init__(self, clouds: np.ndarray, apart: np.ndarray):
        self._cell = _cells(apart)
        self._low = clouds.min(axis=1)
        self._pictures = [picture for picture, _, _ in _pictures(clouds, self._cell)]

    def outer(self, points: np.ndarray, target: np.ndarray) -> np.ndarray:
        """(K, n) bool: which points of candidates (K, n, 3) can be seen from without, neither these nor those of the ``target`` (K,) of each
        being in the way."""
        return _outer(points, spacing(points), (self, target))

    def passed(self, points: np.ndarray, target: np.ndarray) -> Iterator[np.ndarray]:
        """From each side: which points (K, n) are not hidden by the targets of candidates."""
        cell, own = self._cell[target][:, None], target[:, None]
        centred = points - self._low[target][:, None]
        for (first, second, way), one in zip(_frames(), self._pictures, strict=True):
            x, y = (
                np.floor((centred @ axis - low[target]) / cell)
                for axis, low in zip((first, second), one.least, strict=True)
            )
            beside = (x < 0) | (y < 0) | (x >= one.across) | (y >= one.across)
            place = np.where(beside, 0, (own * one.across + x) * one.across + y).astype(np.int64)
            yield beside | (centred @ way >= one.front[place] - cell)


def _outer(points: np.ndarray, apart: np.ndarray, others: tuple[Screens, np.ndarray] | None = None) -> np.ndarray:
    count, n = points.shape[:2]
    found = np.zeros((count, n), dtype=bool)
    step = max(1, _BLOCK // (n * _SIDES))
    for start in range(0, count, step):
        part = slice(start, start + step)
        sides = np.zeros((len(points[part]), n), dtype=np.int64)
        passed = repeat(True) if others is None else others[0].passed(points[part], others[1][part])
        for (_, seen), other in zip(_sides(points[part], _cells(apart[part])), passed, strict=False):
            sides += seen & other
        found[part] = sides >= _FROM
    return found


def _cells(apart: np.ndarray) -> np.ndarray:
    return np.maximum(_CELL * apart, 1e-12)


def _sides(points: np.ndarray, cell: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """From each side: the way there (3,), and which points (K, n) are seen from it."""
    for (_, _, way), (picture, place, depth) in zip(_frames(), _pictures(points, cell), strict=True):
        yield way, depth >= picture.front[place] - cell[:, None]


@dataclass(frozen=True, slots=True, eq=False)
class _Picture:
    """Clouds (K, n, 3) from one side: where their pictures begin along its two axes, ``least`` (K, 1) twice; how many cells each is
    ``across``, and the ``front`` (K * across * across,) in these."""

    least: tuple[np.ndarray, np.ndarray]
    across: int
    front: np.ndarray


def _pictures(points: np.ndarray, cell: np.ndarray) -> Iterator[tuple[_Picture, np.ndarray, np.ndarray]]:
    """From each side: the picture of clouds; of each point its cell (K, n), and its depth (K, n)."""
    count, cell = len(points), cell[:, None]
    centred = points - points.min(axis=1, keepdims=True)
    across = int(np.ceil((np.sqrt((np.ptp(points, axis=1) ** 2).sum(axis=1)) / cell[:, 0]).max())) + 2
    own = np.arange(count)[:, None] * across * across
    for first, second, way in _frames():
        x, y, depth = (centred @ axis for axis in (first, second, way))
        least = x.min(axis=1, keepdims=True), y.min(axis=1, keepdims=True)
        x, y = ((c - low) / cell for c, low in zip((x, y), least, strict=True))
        place = own + x.astype(np.int64) * across + y.astype(np.int64)
        front = np.full(count * across * across, -np.inf)
        np.maximum.at(front, place.ravel(), depth.ravel())  # of one axis: several times faster
        yield _Picture(least, across, front), place, depth


@cache
def _frames() -> np.ndarray:
    """(sides, 3, 3): two axes of the picture from each side, and the way there."""
    return np.array([(*_axes(way), way) for way in spread_directions(_SIDES)])


def towards(points: np.ndarray, apart: float) -> np.ndarray:
    """(n, 3) for points of one cloud: about where it is seen from, the sum of the sides from which it can be."""
    found = np.zeros(points.shape)
    for way, seen in _sides(points[None], _cells(np.array([apart]))):
        found += seen[0][:, None] * way
    return found


def _axes(way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    other = np.eye(3)[int(np.argmin(np.abs(way)))]
    first = np.cross(way, other)
    first /= np.sqrt((first * first).sum())
    return first, np.cross(way, first)
