"""The instances of one primitive site of a program, as a table."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..graph.primitive import Primitive
from . import pieces as convex
from .quadrature import volume_inertia


@dataclass(frozen=True, eq=False)
class SiteTable:
    """All instances of one site in a batch, k rows sorted by ``owner`` and then ``rank``.

    A local point (x, y, z) of row r lies at ``rotation[r] @ (x, mirror[r] * y, z) + translation[r]`` of its object.
    """

    number: int  # of the site in the program
    path: str
    primitive: Primitive
    params: dict[str, np.ndarray]  # (k,) float64 each
    owner: np.ndarray  # (k,) int64 object index within the batch, ascending
    rotation: np.ndarray  # (k, 3, 3) proper
    translation: np.ndarray  # (k, 3) metres
    mirror: np.ndarray  # (k,) +1.0 or -1.0
    link: np.ndarray  # (k,) int64 link instance number within its object
    instance: np.ndarray  # (k,) int64 part instance number within its object
    semantic: np.ndarray  # (k,) int64 semantic id of the whole site
    rank: np.ndarray  # (k,) int64 rank of the row among the rows of this site in its object

    def __len__(self) -> int:
        return len(self.owner)

    @cached_property
    def pieces(self) -> list[convex.PieceGroup]:
        """The convex pieces of all rows, in their own frames; built once, whoever asks."""
        return [group for cloud in self.clouds for group in cloud.groups()]

    @cached_property
    def clouds(self) -> list[convex.Cloud]:
        """The points of the convex pieces, before their faces are looked for."""
        return convex.clouds(self.primitive, self.params) if len(self) else []

    @cached_property
    def moments(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Volume (k,) m3, centre (k, 3) m and inertia about it per unit density (k, 3, 3) m5 of the rows, in their own frames."""
        return volume_inertia(self.primitive, self.params)

    @property
    def weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Volume and centre alone."""
        return self.moments[:2] if "moments" in self.__dict__ else self._weights

    @cached_property
    def _weights(self) -> tuple[np.ndarray, np.ndarray]:
        return volume_inertia(self.primitive, self.params, inertia=False)[:2]
