"""What moves as a whole of real objects whose joints are known: all links behind the same joint, that nearest to the root.

A knob goes with its door, be it a link of its own or not.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..records import dataclass

_ALIKE = 0.94  # cosine of the angle of two axes that are alike, 20 degrees
_APART = 0.05  # diagonals between two axes that are alike


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """``of`` (N,): the body that each name of a cloud's labels is of; ``twist`` (B, 6): how each moves, see ``twists``; 0 for what does
    not; ``joints`` (B,): the name of what moves it, "" where nothing does."""

    of: np.ndarray
    twist: np.ndarray
    joints: tuple[str, ...]

    def scaled(self, unit: float) -> Bodies:
        """The same in a frame whose unit is a share of theirs."""
        return replace(self, twist=self.twist * np.repeat([1.0, unit], 3))

    def turned(self, matrix: np.ndarray) -> Bodies:
        """The same in a frame that is turned by ``matrix`` (3, 3)."""
        return replace(self, twist=(self.twist.reshape(-1, 2, 3) @ matrix.T).reshape(-1, 6))

    def placed(self, scale: float, shift: np.ndarray) -> Bodies:
        """The same in the frame of an object that is ``scale`` times as large in theirs, and shifted by ``shift`` (3,)."""
        turns, slides = self.twist[:, :3], self.twist[:, 3:]
        return replace(self, twist=np.concatenate([turns, (slides - np.cross(shift, turns)) / scale], axis=1))


def twists(moves: np.ndarray, axis: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """(J, 6) of joints that ``turns``, ``slides`` or move otherwise (J,), about or along ``axis`` (J, 3) through ``origin`` (J, 3): NaN
    of those whose motion has no axis of its own."""
    turns, slides = (np.where((moves == way)[:, None], axis, 0.0) for way in ("turns", "slides"))
    found = np.concatenate([turns, slides + np.cross(origin, turns)], axis=1)
    found[moves == "tilts"] = np.nan
    return found


def alike(one: np.ndarray, other: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
    """(...) whether two twists (..., 6) may be of one joint: one is 0 or NaN, or both slide along, or turn about one axis."""
    free = [~(twist != 0.0).any(axis=-1) | np.isnan(twist).any(axis=-1) for twist in (one, other)]
    turning = [(twist[..., :3] != 0.0).any(axis=-1) for twist in (one, other)]
    way = [
        np.where(turns[..., None], twist[..., :3], twist[..., 3:])
        for turns, twist in zip(turning, (one, other), strict=True)
    ]
    length = [np.sqrt((one * one).sum(axis=-1)) for one in way]
    parallel = np.abs((way[0] * way[1]).sum(axis=-1)) > _ALIKE * length[0] * length[1]
    near = [np.cross(twist[..., :3], twist[..., 3:]) for twist in (one, other)]  # of an axis, nearest to the origin
    between = np.cross(near[0] - near[1], way[1])
    close = np.sqrt((between**2).sum(axis=-1)) < _APART * diagonal
    same = parallel & (turning[0] == turning[1]) & (close | ~turning[0])
    return np.asarray(free[0] | free[1] | same)
