"""Clouds against surfaces, both ways: which point is nearest to which, and how far off it lies.

Nearest is meant of places and normals together, so that the back of a sheet is not taken for its front. All candidates are
compared in blocks, each as one product of matrices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .words import OTHER, factors

_TURN = 0.06  # what two normals of opposite direction add to a distance, half of it, in diagonals
_BLOCK = 12_000_000  # pairs at a time
_FAR = 1e4
REACH = 1.5  # how far a point stands for the surface around it, in distances between points: another is nearer than that nearly always


def nearest(
    points: np.ndarray, asked: np.ndarray, words: tuple[np.ndarray, np.ndarray], meant: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """For features ``points`` (K, n, d) and ``asked`` (K, m, d) with the ``words`` (K, n), (K, m) of both, of those ``meant``: of each asked
    one the nearest of its candidate (K, m), and of each point the nearest asked one (K, n)."""
    count, n, m = len(points), points.shape[1], asked.shape[1]
    there, here = np.empty((count, m), dtype=np.int64), np.empty((count, n), dtype=np.int64)
    step = max(1, _BLOCK // (n * m))
    for start in range(0, count, step):
        part = slice(start, start + step)
        a, b = points[part].astype(np.float32), asked[part].astype(np.float32)
        apart = (b * b).sum(axis=2)[:, :, None] + (a * a).sum(axis=2)[:, None, :]
        apart -= 2.0 * (b @ a.transpose(0, 2, 1))
        if len(meant):
            first, second = factors(words[1][part], meant)[0], factors(words[0][part], meant)[1]
            apart += OTHER**2 * (first.astype(np.float32) @ second.astype(np.float32).transpose(0, 2, 1))
        there[part], here[part] = apart.argmin(axis=2), apart.argmin(axis=1)
    return there, here


def features(
    points: np.ndarray, normals: np.ndarray, diagonal: np.ndarray, left_out: np.ndarray | None = None
) -> np.ndarray:
    """(K, n, 6) places and normals in diagonals; what is ``left_out`` (K, n) lies far from everything."""
    found = np.concatenate([points / diagonal[:, None, None], _TURN * normals], axis=2)
    if left_out is not None:
        found[..., 0] += np.where(left_out, _FAR, 0.0)
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Gaps:
    """How far pairs of points lie apart (K, m), in diagonals, along ``way`` (K, m, 3): from the cloud to the surface."""

    value: np.ndarray
    way: np.ndarray


def gaps(surface: np.ndarray, cloud: np.ndarray, normal: np.ndarray, apart: np.ndarray, diagonal: np.ndarray) -> Gaps:
    """Of pairs of points of a surface and a cloud (K, m, 3): along the ``normal`` of the one that stands for its neighbours, which
    lie ``apart`` (K, m), and aside as far as the other lies beyond the reach of those."""
    way = surface - cloud
    along = (way * normal).sum(axis=2)
    aside = way - along[:, :, None] * normal
    length = np.sqrt((aside * aside).sum(axis=2))
    beyond = np.maximum(length - REACH * apart, 0.0)
    aside *= (beyond / np.maximum(length, 1e-12))[:, :, None]
    whole = np.sqrt(along * along + beyond * beyond)
    straight = (along[:, :, None] * normal + aside) / np.maximum(whole, 1e-12)[:, :, None]
    flat = beyond == 0.0
    return Gaps(np.where(flat, along, whole) / diagonal[:, None], np.where(flat[:, :, None], normal, straight))
