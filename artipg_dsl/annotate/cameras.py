"""Cameras around an object: described in a file or by default, drawn by address, as matrices."""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import random
from ..geometry.vectors import length, unit
from ..records import dataclass
from .frames import rotate

Range = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Cameras:
    """Pinhole cameras that look at the centre of the object's box from within spans of ``azimuth`` (0: the front, 90:
    the object's left) and ``elevation``, in degrees, and of ``distance``: 1 is where the sphere around the box just
    fits the picture. ``fov`` is vertical, in degrees. ``points``: how many a partial cloud has.

    With ``poses``, cameras of their own: (eye, target, up) in metres in the object's frame, no target: the centre.
    """

    count: int = 8
    width: int = 320
    height: int = 240
    fov: float = 35.0
    azimuth: Range = (-60.0, 60.0)
    elevation: Range = (10.0, 60.0)
    distance: Range = (1.0, 1.3)
    points: int = 2048
    poses: tuple[tuple[tuple[float, ...], tuple[float, ...] | None, tuple[float, ...]], ...] = ()

    def plain(self) -> dict[str, Any]:
        """The description as a camera file has it."""
        made: dict[str, Any] = {"views": self.count, "width": self.width, "height": self.height, "fov": self.fov}
        if self.poses:
            named = [dict(zip(("eye", "target", "up"), pose, strict=True)) for pose in self.poses]
            made["poses"] = [{k: list(v) for k, v in pose.items() if v is not None} for pose in named]
            del made["views"]
        else:
            made |= {name: list(getattr(self, name)) for name in ("azimuth", "elevation", "distance")}
        return made | {"points": self.points}

    @property
    def focal(self) -> float:
        """The focal length in pixels."""
        return self.height / 2 / float(np.tan(np.radians(self.fov / 2)))

    def intrinsics(self) -> np.ndarray:
        """(3, 3): pixels from directions in the camera's frame; the centre of the first pixel is (0.5, 0.5)."""
        return np.array([[self.focal, 0, self.width / 2], [0, self.focal, self.height / 2], [0, 0, 1.0]])

    def place(
        self, key: random.Key, address: np.ndarray, centre: np.ndarray, radius: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Turns (B, V, 3, 3) into the cameras' frames and eyes (B, V, 3) for B objects.

        ``address`` (B,) uint64 names each to ``key``; ``centre`` (B, 3) and ``radius`` (B,) bound it.
        """
        if self.poses:
            shape = (len(centre), len(self.poses), 3)
            middle = np.broadcast_to(centre[:, None], shape)
            eye = np.broadcast_to(np.array([pose[0] for pose in self.poses]), shape)
            given = np.array([pose[1] or (np.nan,) * 3 for pose in self.poses])
            target = np.where(np.isnan(given), middle, given)
            return _looking(eye, target, np.broadcast_to(np.array([pose[2] for pose in self.poses]), shape)), eye
        view, where = np.arange(self.count), address[:, None]
        shares = [random.uniform(key, where, lane, view) for lane in range(3)]
        spans = (self.azimuth, self.elevation, self.distance)
        a, e, d = (low + share * (high - low) for share, (low, high) in zip(shares, spans, strict=True))
        a, e = np.radians(a), np.radians(e)
        half = np.radians(self.fov / 2)
        if self.width < self.height:
            half = np.arctan(np.tan(half) * (self.width / self.height))
        away = d * radius[:, None] / np.sin(half)
        back = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=-1)
        eye = centre[:, None] + back * away[..., None]
        target = np.broadcast_to(centre[:, None], eye.shape)
        return _looking(eye, target, np.broadcast_to([0.0, 0.0, 1.0], eye.shape)), eye


def _looking(eye: np.ndarray, target: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Turns (..., 3, 3) into cameras at ``eye`` that look at ``target``: rows x right, y down, z forward."""
    forward = unit(target - eye)
    straight = length(np.cross(forward, unit(up))) < 1e-6  # looking along `up`: what lies in front is up instead
    right = unit(np.cross(forward, np.where(straight, [1.0, 0.0, 0.0], up)))
    return np.stack([right, np.cross(forward, right), forward], axis=-2)


def extrinsics(turn: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """World-to-camera matrices (..., 4, 4)."""
    made = np.zeros((*turn.shape[:-2], 4, 4))
    made[..., :3, :3] = turn
    made[..., :3, 3] = -rotate(turn, eye)
    made[..., 3, 3] = 1.0
    return made
