"""Clouds of objects: arrays of what is known of each point, and which real object each cloud is or was made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

Arrays = dict[str, np.ndarray]


@dataclass(frozen=True, slots=True, eq=False)
class Clouds:
    """K clouds of n points. ``arrays`` by name (K, n, ...), ``points`` (K, n, 3) float32 with x to the front and z up among them;
    ``category`` (K,) int64 indexes ``known``; ``names`` of the objects. ``origin`` (K,) int64: the row of the real object that a cloud is
    or was made from, -1 for none.
    """

    arrays: Mapping[str, np.ndarray]
    category: np.ndarray
    known: tuple[str, ...]
    names: tuple[str, ...]
    origin: np.ndarray

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.arrays[name]

    def take(self, rows: np.ndarray) -> Clouds:
        arrays = {name: values[rows] for name, values in self.arrays.items()}
        return Clouds(arrays, self.category[rows], self.known, tuple(self.names[k] for k in rows), self.origin[rows])

    def without(self, held: np.ndarray) -> Clouds:
        """The clouds that are not, and were not made from, the real objects in the rows ``held``."""
        return self.take(np.flatnonzero(~np.isin(self.origin, held)))

    @property
    def of_real(self) -> bool:
        """Whether any cloud is, or was made from, a real object."""
        return bool((self.origin >= 0).any())


def join(parts: Sequence[Clouds]) -> Clouds:
    """All clouds of several; they know the same categories."""
    arrays = {name: np.concatenate([part[name] for part in parts]) for name in parts[0].arrays}
    return Clouds(
        arrays,
        np.concatenate([part.category for part in parts]),
        parts[0].known,
        tuple(name for part in parts for name in part.names),
        np.concatenate([part.origin for part in parts]),
    )


def draw(sources: Sequence[Clouds], batch: int, size: int, draws: np.random.Generator) -> Arrays:
    """``batch`` random clouds, as many of each source, with ``size`` random points of each; ``category`` (batch,) among the arrays."""
    found: dict[str, list[np.ndarray]] = {}
    for clouds in sources:
        rows = draws.integers(0, len(clouds), batch // len(sources))
        at = draws.permuted(np.tile(np.arange(clouds["points"].shape[1]), (len(rows), 1)), axis=1)[:, :size]
        for name, values in clouds.arrays.items():
            found.setdefault(name, []).append(values[rows[:, None], at])
        found.setdefault("category", []).append(clouds.category[rows])
    return {name: np.concatenate(parts) for name, parts in found.items()}


def ball(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of clouds (..., n, 3) the centre (..., 1, 3) of the box and the distance (..., 1, 1) of the farthest point from it."""
    low, high = points.min(axis=-2, keepdims=True), points.max(axis=-2, keepdims=True)
    centre = (low + high) / 2
    return centre, np.sqrt(((points - centre) ** 2).sum(axis=-1)).max(axis=-1)[..., None, None]


def normalise(points: np.ndarray) -> np.ndarray:
    """Clouds (..., n, 3) about the centre of their box, as large as fits a ball of radius 1."""
    centre, radius = ball(points)
    return ((points - centre) / radius).astype(np.float32)


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) with length 1; those without a length stay 0."""
    return (vectors / np.maximum(np.sqrt((vectors**2).sum(axis=-1, keepdims=True)), 1e-12)).astype(np.float32)
