"""From a primitive to another: places on boxes as places on maps, where (patch, u, v) mean nothing to one another.

Of two long primitives the longest axes correspond, then the next: a grip that is upright wears one that lies. Otherwise those do that point
the same way in their objects. A long primitive is mapped as onto a cylinder about its longest axis (the azimuth and the place along the
axis: Lambert's cylindrical projection without its scale); one that is not, as onto a sphere about its centre, whose points stand for
themselves: azimuth and elevation of the equirectangular projection without its seam and poles. What faces the centre, as the inside of a
tub does, has a map of its own. J. P. Snyder, *Map Projections: A Working Manual*, USGS Professional Paper 1395, 1987, p. 76 and p. 90.
"""

from __future__ import annotations

from itertools import permutations

import numpy as np

from ..geometry.vectors import cross, dot
from ..records import dataclass

_LONG = 2.0  # times as long as wide: mapped by a cylinder
_ORDERS = np.array(list(permutations(range(3))))
_OPPOSITE = 1e-6  # 1 + the cosine of two normals
_TOWARDS = 0.5  # cosine: axes that are less alike have no direction in common


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """N boxes of primitives: their corners ``low`` and ``high`` (N, 3), and their ``axes`` (N, 3, 3), columns in the frame of the object."""

    low: np.ndarray
    high: np.ndarray
    axes: np.ndarray

    def take(self, at: np.ndarray) -> Boxes:
        return Boxes(self.low[at], self.high[at], self.axes[at])

    @property
    def size(self) -> np.ndarray:
        return self.high - self.low

    @property
    def order(self) -> np.ndarray:
        """(N, 3) the axes, the longest first; of equal ones the later."""
        return np.argsort(-np.round(self.size[:, ::-1], 9), axis=1, kind="stable") * -1 + 2

    @property
    def long(self) -> np.ndarray:
        """(N,) which are mapped by a cylinder."""
        size = np.sort(self.size, axis=1)
        return np.asarray(size[:, 2] > _LONG * size[:, 1])

    def within(self, place: np.ndarray) -> np.ndarray:
        """(N, 3) places, from the middle of each box in units of half of it."""
        return (place - (self.low + self.high) / 2) / np.maximum(self.size / 2, 1e-9)

    def inward(self, place: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """(N,) whether a surface at places faces the middle of its box."""
        return np.asarray(dot(normal, place - (self.low + self.high) / 2) < 0)


def find_turns(boxes: Boxes, onto: Boxes) -> np.ndarray:
    """(N, 3, 3) of N pairs of boxes: matrices of 0, 1 and -1 that take axes of the first to those of the second that correspond."""
    towards = np.einsum("nki,nkj->nij", onto.axes, boxes.axes)
    several = np.arange(len(towards))[:, None]
    alike = np.abs(towards)[several, np.arange(3), _ORDERS[:, None]].sum(axis=2).T
    source = _ORDERS[np.argmax(np.round(alike, 9), axis=1)]
    by_length = np.empty_like(source)
    np.put_along_axis(by_length, onto.order, boxes.order, axis=1)
    source = np.where((boxes.long & onto.long)[:, None], by_length, source)
    cosine = np.take_along_axis(towards, source[:, :, None], axis=2)[:, :, 0]
    turns = np.zeros((len(towards), 3, 3))
    turns[several, np.arange(3), source] = np.where(cosine < -_TOWARDS, -1.0, 1.0)
    return turns


def on_map(local: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """(m, 3) places ``within`` boxes on the map: of a cylinder about ``axis`` (m,), of a sphere where that is -1."""
    along = np.arange(3) == axis[:, None]
    around = np.where(along, 0.0, local)
    around = around / np.maximum(np.sqrt(dot(around, around)), 1e-9)[:, None]
    return np.where(along, local, around)


def turn_along(vectors: np.ndarray, normal: np.ndarray, onto: np.ndarray) -> np.ndarray:
    """Vectors (m, 3) turned as far as takes a unit ``normal`` (m, 3) ``onto`` another, about the axis across both; of opposite ones, which
    have none, what lies along the normal alone."""
    axis, cosine = cross(normal, onto), dot(normal, onto)
    once = cross(axis, vectors)
    turned = vectors + once + cross(axis, once) / np.maximum(1.0 + cosine, _OPPOSITE)[:, None]
    return np.where((1.0 + cosine < _OPPOSITE)[:, None], dot(vectors, normal)[:, None] * onto, turned)
