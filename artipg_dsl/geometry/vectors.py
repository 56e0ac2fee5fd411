"""Products and lengths of arrays of vectors (..., 3), written out: the same bits whatever the batch."""

from __future__ import annotations

import numpy as np


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Scalar products (...)."""
    found = a[..., 0] * b[..., 0]
    found += a[..., 1] * b[..., 1]  # in place: large temporaries cost more than the sums
    found += a[..., 2] * b[..., 2]
    return found


def corners(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The low and high corners (..., 3) of the boxes around points (..., n, 3): axis by axis, since NumPy reduces rows of three slowly."""
    axes = [points[..., axis] for axis in range(3)]
    return np.stack([one.min(axis=-1) for one in axes], axis=-1), np.stack([one.max(axis=-1) for one in axes], axis=-1)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Vector products (..., 3); exactly opposite when the arguments are exchanged."""
    cells = [a[..., i - 2] * b[..., i - 1] - a[..., i - 1] * b[..., i - 2] for i in range(3)]
    return np.stack(cells, axis=-1)


def length(vectors: np.ndarray) -> np.ndarray:
    """Lengths (..., 1)."""
    return np.sqrt(vectors[..., :1] ** 2 + vectors[..., 1:2] ** 2 + vectors[..., 2:] ** 2)


def unit(vectors: np.ndarray) -> np.ndarray:
    """The same directions at length 1."""
    return vectors / length(vectors)


def extent(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least and the most (..., 3) of points (..., n, 3), n > 0, along each axis.

    Halves are compared until one point is left: NumPy reduces an axis before a last one of three some five times slower.
    """
    return _folded(np.minimum, points), _folded(np.maximum, points)


def _folded(best: np.ufunc, points: np.ndarray) -> np.ndarray:
    while (count := points.shape[-2]) > 1:
        half = count // 2
        found = best(points[..., :half, :], points[..., half : 2 * half, :])
        if count % 2:
            best(found[..., 0, :], points[..., -1, :], out=found[..., 0, :])
        points = found
    one: np.ndarray = points[..., 0, :]
    return one
