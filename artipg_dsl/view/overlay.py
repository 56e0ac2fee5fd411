"""A cloud beside the object that was fitted to it, and on top of it: three pictures in a row."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..robot.robots import Robots
from .camera import Camera, look_at
from .png import srgb
from .scene import hex_colour, make_scene
from .sheet import BACKDROP, VIEWS, Painter, Shot, by_pixels

if TYPE_CHECKING:
    from ..runtime.batch import Batch

_INK = "d8324a"
_CELL = 6  # pixels within which a point hides those behind it
_BEHIND = 0.04  # of the distance: so far behind others a point is hidden


def overlay(
    batch: Batch, row: int, cloud: np.ndarray, painter: Painter, *, states: np.ndarray | None = None
) -> np.ndarray:
    """(tile, 3 * tile, 3) uint8, in tiles of the painter: the ``cloud`` (n, 3) in the frame of object ``row`` of a batch, the object
    with its joints at ``states`` (J,), at rest by default, and both."""
    robots = Robots(batch, resolution=by_pixels(batch, painter.tile), physics=False)
    shown = make_scene(robots, row, batch.pose(states))
    azimuth, elevation = VIEWS["iso"]
    camera = look_at(np.concatenate([shown.vertices, cloud]), -azimuth, elevation)
    structure = painter.paint(Shot(shown, camera, float(shown.vertices[:, 2].min())))
    empty = np.empty_like(structure)
    empty[:] = srgb(hex_colour(BACKDROP))
    dark = np.array([70, 78, 90], dtype=np.uint8)
    return np.concatenate(
        [_dotted(empty, camera, cloud, dark), structure, _dotted(structure, camera, cloud, srgb(hex_colour(_INK)))],
        axis=1,
    )


def _dotted(image: np.ndarray, camera: Camera, cloud: np.ndarray, ink: np.ndarray) -> np.ndarray:
    """The picture with a dot for each point that no other hides, those behind fainter."""
    size = len(image)
    place, depth = camera.picture(cloud)
    x, y = ((place + 1.0) * (size / 2)).astype(np.int64)
    inside = (x >= 0) & (x < size) & (y >= 0) & (y < size)
    x, y, depth = x[inside], y[inside], depth[inside]
    wide = -(-size // _CELL)
    cell = y // _CELL * wide + x // _CELL
    front = np.full(wide * wide, np.inf)
    np.minimum.at(front, cell, depth)
    seen = np.flatnonzero(depth <= front[cell] * (1.0 + _BEHIND))
    out = image.copy()
    out[y[seen], x[seen]] = ink
    return out
