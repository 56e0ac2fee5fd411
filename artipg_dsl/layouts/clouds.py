"""Points as the field's data sets hold them: their axes, their size, and the classes of points in other vocabularies."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..annotate.cloud import Points, sample_points
from ..annotate.sampling import Sampling
from ..records import dataclass

if TYPE_CHECKING:
    from ..runtime.batch import Batch
    from .words import Term


def shapenet_axes(vectors: np.ndarray) -> np.ndarray:
    """Ours (..., 3), x front, y left, z up, in the axes of ShapeNet: x to the object's right, y up, z to its back."""
    return vectors[..., [1, 2, 0]] * np.array([-1.0, 1.0, -1.0])


def partnet_axes(vectors: np.ndarray) -> np.ndarray:
    """Ours (..., 3) in the axes of PartNet: x to the object's left, y up, z to its front."""
    return vectors[..., [1, 2, 0]]


@dataclass(frozen=True, slots=True)
class Fit:
    """Where objects are put and how they are scaled: ``center`` (B, 3), ``unit`` (B,) in metres, a length of 1."""

    center: np.ndarray
    unit: np.ndarray

    def apply(self, points: np.ndarray) -> np.ndarray:
        """Points (B, ..., 3) of the objects."""
        lead = (len(self.unit), *(1,) * (points.ndim - 2))
        return (points - self.center.reshape(*lead, 3)) / self.unit.reshape(*lead, 1)


def fit_diagonal(points: np.ndarray) -> Fit:
    """Boxes of points (B, n, 3) are centred, their diagonals 1: as ShapeNet has it."""
    low, high = points.min(axis=1), points.max(axis=1)
    return Fit((low + high) / 2, norms(high - low))


def fit_radius(points: np.ndarray) -> Fit:
    """Boxes of points (B, n, 3) are centred, the farthest point is at 1."""
    center = (points.min(axis=1) + points.max(axis=1)) / 2
    return Fit(center, norms(points - center[:, None]).max(axis=1))


def norms(vectors: np.ndarray) -> np.ndarray:
    """Lengths of vectors (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.sqrt(x * x + y * y + z * z)


def draw(batch: Batch, count: int) -> Points:
    """Points of all objects at rest."""
    return sample_points(batch, Sampling(count))


def classify(batch: Batch, points: Points, term: Term, number: Callable[[Any], int]) -> np.ndarray:
    """``number(part)`` of every point (B, n): of the part that its word is on its link, or, first, a formula of the term."""
    words = batch.program.vocabularies.get("semantic", ("",))
    links = batch.links()
    row = np.searchsorted(links.owner, points.object)[:, None] + points.link
    key = links.semantic[row] * len(words) + points.semantic
    formulas = term.formulas()
    held = [points.labels[name] >= 0.5 if name in points.labels else np.zeros(key.shape, bool) for name in formulas]
    by_formula = np.select(held, range(1, len(held) + 1)) if held else np.zeros(key.shape, dtype=np.int64)
    rest = by_formula == 0
    found, place = np.unique(key[rest], return_inverse=True)
    above = ("", *words[1:])  # the word of a link, "" for none
    parts = [term.part(words[k % len(words)], above[k // len(words)]) for k in found.tolist()]
    classes = np.array([0, *map(number, formulas.values())], dtype=np.int64)[by_formula]
    classes[rest] = np.array([number(part) for part in parts], dtype=np.int64)[place]
    return classes


def similarity_error(source: np.ndarray, target: np.ndarray) -> float:
    """How far points (n, 3) are from their images under the best motion and scaling, which does not mirror."""
    if len(source) < 3:
        return 0.0
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    u, s, vt = np.linalg.svd(b.T @ a)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    scale = float((s * sign).sum()) / max(float((a * a).sum()), 1e-300)
    return float(norms(scale * a @ (u * sign @ vt).T - b).max())


def turn_about(points: np.ndarray, pivot: np.ndarray, axis: np.ndarray, angle: float) -> np.ndarray:
    """Points (n, 3) turned about a line, by Rodrigues' formula."""
    arm = points - pivot
    along = (arm * axis).sum(axis=1)[:, None] * axis
    return pivot + along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(axis, arm)
