"""Bounds of convex pieces about an axis: which of those that turn about it can come near which others, and at which angles."""

from __future__ import annotations

import numpy as np

from ..geometry.collide import DEPTH
from ..geometry.vectors import cross, dot
from ..records import dataclass
from .bodies import Pieces


@dataclass(slots=True, eq=False)
class Rings:
    """Bounds of pieces about an axis: height along it, distance from it, and angle ``start .. stop`` around it.

    A piece that holds the axis has the whole circle.
    """

    height: np.ndarray  # (k, 2)
    reach: np.ndarray  # (k, 2)
    angle: np.ndarray  # (k, 2)

    def grow(self, gap: np.ndarray) -> None:
        """The bounds of all that is nearer than ``gap`` (k,) to the pieces."""
        whole = self.reach[:, 0] <= gap
        wide = np.arcsin(np.minimum(gap / np.where(whole, 1.0, self.reach[:, 0]), 1.0))
        self.height += np.stack([-gap, gap], axis=-1)
        self.reach = np.stack([np.maximum(self.reach[:, 0] - gap, 0.0), self.reach[:, 1] + gap], axis=-1)
        middle = (self.angle[:, 0] + self.angle[:, 1]) / 2
        self.angle = np.where(
            whole[:, None],
            np.stack([middle - np.pi, middle + np.pi], axis=-1),
            self.angle + np.stack([-wide, wide], axis=-1),
        )


def bound_rings(body: Pieces, piece: np.ndarray, axis: np.ndarray, origin: np.ndarray) -> Rings:
    """The bounds of pieces (k,) about axes (k, 3) through origins (k, 3)."""
    margin = DEPTH / 2  # as far as insetting moves every side
    along, across = find_across(axis)
    height, reach, angle = (np.empty((len(piece), 2)) for _ in range(3))
    for at, corners in body.classes(piece):
        local = corners - origin[at, None]
        h, x, y = (dot(local, d[at, None]) for d in (axis, along, across))
        height[at] = np.stack([h.min(axis=1) + margin, h.max(axis=1) - margin], axis=-1)
        r = np.sqrt(x * x + y * y)
        cx, cy = (x.min(axis=1) + x.max(axis=1)) / 2, (y.min(axis=1) + y.max(axis=1)) / 2
        length = np.maximum(np.sqrt(cx * cx + cy * cy), 1e-300)
        ux, uy = (cx / length)[:, None], (cy / length)[:, None]
        ahead, aside = x * ux + y * uy, y * ux - x * uy
        least = ahead.min(axis=1)
        reach[at] = np.stack([np.maximum(least, -margin) + margin, r.max(axis=1) - margin], axis=-1)
        turn = np.where(r > 1e-7, np.arctan2(aside, ahead), 0.0)
        middle = np.arctan2(cy, cx)
        whole = (least < -1e-9) | (length < 1e-9)
        start = np.where(whole, -np.pi, turn.min(axis=1))
        stop = np.where(whole, np.pi, turn.max(axis=1))
        angle[at] = np.stack([middle + start, middle + stop], axis=-1)
    return Rings(height, reach, angle)


def find_across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors (k, 3) each, square to unit axes (k, 3) and to one another, right-handed."""
    other = np.where((np.abs(axis[:, 0]) < 0.6)[:, None], (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    along = cross(other, axis)
    along = along / np.sqrt(dot(along, along))[:, None]
    return along, cross(axis, along)
