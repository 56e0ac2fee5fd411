"""The frame of a folder of PartNet-Mobility: x to the left of the object, y up, z to the front; the half diagonal of the rest box is 1."""

from __future__ import annotations

import numpy as np

from ...records import dataclass


@dataclass(frozen=True, slots=True)
class DatasetFrame:
    """From the object's frame (metres, x front, y left, z up) to the data set's."""

    center: np.ndarray
    unit: float  # metres

    @staticmethod
    def around(low: np.ndarray, high: np.ndarray) -> DatasetFrame:
        """The frame of an object with a box of these corners: centred, its half diagonal 1."""
        half = (high - low) / 2
        return DatasetFrame((low + high) / 2, float(np.sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2])))

    def points(self, points: np.ndarray) -> np.ndarray:
        return to_dataset_axes((points - self.center) / self.unit)


def to_dataset_axes(vectors: np.ndarray) -> np.ndarray:
    """Directions (..., 3) in the data set's axes: left, up, front."""
    return vectors[..., [1, 2, 0]]
