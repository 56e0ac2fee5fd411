"""From a primitive to another: places on boxes as places on maps, where (patch, u, v) mean nothing to one another.

Axes correspond by length, the longest to the longest. A long primitive is mapped as onto a cylinder about its longest axis (the azimuth and
the place along the axis: Lambert's cylindrical projection without its scale); one that is not, as onto a sphere about its centre, whose
points stand for themselves: azimuth and elevation of the equirectangular projection without its seam and poles. J. P. Snyder, *Map
Projections: A Working Manual*, USGS Professional Paper 1395, 1987, p. 76 and p. 90.
"""

from __future__ import annotations

import numpy as np

from ..geometry.frames import Frames
from ..geometry.vectors import cross, dot

_LONG = 2.0  # times as long as wide: mapped by a cylinder


def _axes_by_length(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(N, 3) the axes of boxes, the longest first; of equal ones the later."""
    return np.argsort(-np.round((high - low)[:, ::-1], 9), axis=1, kind="stable") * -1 + 2


def is_long(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(N,) which boxes are mapped by a cylinder."""
    size = np.sort(high - low, axis=1)
    return size[:, 2] > _LONG * size[:, 1]


def on_map(place: np.ndarray, low: np.ndarray, high: np.ndarray, cylinder: np.ndarray) -> np.ndarray:
    """(m, 3) places of boxes (m, 3) on the map: of a cylinder where that is asked for (m,), of a sphere elsewhere; units of half a box."""
    half = np.maximum((high - low) / 2, 1e-9)
    local = np.take_along_axis((place - (low + high) / 2) / half, _axes_by_length(low, high), axis=1)
    around = np.where(cylinder[:, None], local * np.array([0.0, 1.0, 1.0]), local)
    length = np.sqrt(dot(around, around))
    around = around / np.maximum(length, 1e-9)[:, None]
    around[:, 0] = np.where(cylinder, local[:, 0], around[:, 0])
    return around


def map_frames(frames: Frames, low: np.ndarray, high: np.ndarray) -> Frames:
    """Frames whose tangents follow the longest axis of the box (the next one, where that is normal to the surface)."""
    order = _axes_by_length(low, high)
    every = np.eye(3)
    first, second = every[order[:, 0]], every[order[:, 1]]
    steep = np.abs(dot(first, frames.normal)) > 0.9
    axis = np.where(steep[:, None], second, first)
    axis = axis - dot(axis, frames.normal)[:, None] * frames.normal
    tangent = axis / np.maximum(np.sqrt(dot(axis, axis)), 1e-9)[:, None]
    return Frames(frames.place, frames.normal, tangent, cross(frames.normal, tangent), frames.speed)
