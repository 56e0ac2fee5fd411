"""A cloud beside the object that was fitted to it, and on top of it: three pictures in a row."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..export.robot import Robots
from .camera import Camera, look_at, place_lights
from .png import srgb
from .scene import hex_colour, make_scene
from .sheet import BACKDROP, VIEWS, by_pixels, make_renderer

if TYPE_CHECKING:
    from ..runtime.batch import Batch

_INK = "d8324a"
_CELL = 6  # pixels within which a point hides those behind it
_BEHIND = 0.04  # of the distance: so far behind others a point is hidden


def overlay(
    batch: Batch,
    row: int,
    cloud: np.ndarray,
    *,
    states: np.ndarray | None = None,
    tile: int = 320,
    which: str = "auto",
    draw: Any = None,
) -> np.ndarray:
    """(tile, 3 * tile, 3) uint8: the ``cloud`` (n, 3) in the frame of object ``row`` of a batch, the object with its joints at
    ``states`` (J,), at rest by default, and both."""
    draw = make_renderer(which, tile) if draw is None else draw
    robots = Robots(batch, resolution=by_pixels(batch, tile), physics=False)
    shown = make_scene(robots, row, batch.pose(states))
    azimuth, elevation = VIEWS["iso"]
    camera = look_at(np.concatenate([shown.vertices, cloud]), -azimuth, elevation)
    floor = float(shown.vertices[:, 2].min())
    structure = srgb(draw.render(shown, camera, place_lights(camera, *draw.light_counts), floor))
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
