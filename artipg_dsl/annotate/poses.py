"""Poses and sizes of parts: 7 degrees of freedom (turn, place, scale) and the normalised part coordinates they define.

With T the centre of a part's box, R its turn and S its three edges, a point p of the object has the coordinates
``R^T (p - T) / |S|`` (NPCS): the box's diagonal has length 1 and the coordinates lie within -0.5 .. 0.5.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..records import dataclass
from .frames import compose, quaternion, rotate

if TYPE_CHECKING:
    from ..runtime.batch import Batch
    from ..runtime.tables import PartTable

_AXES = "xyz"


@dataclass(frozen=True, slots=True)
class PartPoses:
    """Per part instance of a batch: rotation (P, 3, 3), quaternion (P, 4) w x y z, center (P, 3) and size (P, 3) in
    metres, scale (P,), the length of the diagonal. In the object's frame."""

    rotation: np.ndarray
    quaternion: np.ndarray
    center: np.ndarray
    size: np.ndarray
    scale: np.ndarray


def part_poses(batch: Batch, states: np.ndarray | None = None) -> PartPoses:
    """Poses of all parts with the joints at ``states`` (J,), at rest by default."""
    parts, links = batch.parts(), batch.links()
    link = np.searchsorted(links.owner, parts.owner) + parts.link
    turn, shift = batch.pose(states)
    rotation = compose(turn[link], parts.rotation)
    size = parts.high - parts.low
    center = rotate(turn[link], centers_of(parts)) + shift[link]
    return PartPoses(rotation, quaternion(rotation), center, size, diagonal(size))


def centers_of(parts: PartTable) -> np.ndarray:
    """Centres (P, 3) of the boxes of parts at joint values 0."""
    return rotate(parts.rotation, (parts.high + parts.low) / 2) + parts.translation


def diagonal(size: np.ndarray) -> np.ndarray:
    return np.sqrt(size[:, 0] ** 2 + size[:, 1] ** 2 + size[:, 2] ** 2)


def symmetry_words(symmetry: np.ndarray) -> list[str | None]:
    """``(turns, axis)`` (P, 2) as words such as "2 about z"; "any about z" for a body of revolution, None for none."""
    return [
        None if turns == 1 else f"{'any' if turns == 0 else turns} about {_AXES[axis]}"
        for turns, axis in np.asarray(symmetry, dtype=np.int64).tolist()
    ]
