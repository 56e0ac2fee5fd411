"""Clouds against surfaces, both ways: which point is nearest to which, and how far off it lies.

Nearest is meant of places and normals together, so that the back of a sheet is not taken for its front. Candidates are
compared, each by products of matrices.
"""

from __future__ import annotations

import numpy as np

from ..geometry.vectors import dot
from ..records import dataclass
from .products import at_a_time
from .words import OTHER, factors

_TURN = 0.06  # what two normals of opposite direction add to a distance, half of it, in diagonals
_FAR = 1e4
REACH = 1.5  # how far a point stands for the surface around it, in distances between points: another is nearer than that nearly always


def nearest(
    points: np.ndarray, asked: np.ndarray, words: tuple[np.ndarray, np.ndarray], meant: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """For features ``points`` (K, n, d) and ``asked`` (K, m, d) with the ``words`` (K, n), (K, m) of both, of those ``meant``: of each asked
    one the nearest of its candidate (K, m), and of each point the nearest asked one (K, n)."""
    a, b = points.astype(np.float32), asked.astype(np.float32)
    one, other = (np.ones((*x.shape[:2], 1), dtype=np.float32) for x in (a, b))
    # the product of a row of one and a row of the other is the square of their distance
    left = [b, squared(b)[..., None], other]
    right = [-2.0 * a, one, squared(a)[..., None]]
    if len(meant):
        left.append(factors(words[1], meant)[0].astype(np.float32))
        right.append(OTHER**2 * factors(words[0], meant)[1].astype(np.float32))
    theirs, ours = np.concatenate(left, axis=2), np.concatenate(right, axis=2)
    there, here = np.empty(b.shape[:2], dtype=np.int64), np.empty(a.shape[:2], dtype=np.int64)
    for k in range(len(a)):  # a product at a time, since it stays in the cache
        _least(theirs[k], ours[k], there[k])
        _least(ours[k], theirs[k], here[k])
    return there, here


def squared(of: np.ndarray) -> np.ndarray:
    """(...) the squares of the lengths of vectors (..., d), column by column: NumPy sums up short rows slowly."""
    squares = of * of
    found = squares[..., 0].copy()
    for column in range(1, squares.shape[-1]):
        found += squares[..., column]
    return found


def _least(rows: np.ndarray, columns: np.ndarray, out: np.ndarray) -> None:
    """For each of the ``rows`` (n, d) with which of the ``columns`` (m, d) its product is least, into ``out`` (n,)."""
    step, across = at_a_time(columns.size), np.ascontiguousarray(columns.T)
    room = np.empty((min(step, len(rows)), len(columns)), dtype=rows.dtype)
    for start in range(0, len(rows), step):
        part = rows[start : start + step]
        np.matmul(part, across, out=room[: len(part)]).argmin(axis=1, out=out[start : start + step])


def features(
    points: np.ndarray, normals: np.ndarray, diagonal: np.ndarray, left_out: np.ndarray | None = None
) -> np.ndarray:
    """(..., 6) places and normals (..., 3) in diagonals (...), which broadcast; what is ``left_out`` (...) lies far from everything."""
    found = np.concatenate([points / diagonal[..., None], _TURN * normals], axis=-1)
    if left_out is not None:
        found[..., 0] += np.where(left_out, _FAR, 0.0)
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Gaps:
    """How far pairs of points lie apart (...), in diagonals, along ``way`` (..., 3): from the cloud to the surface."""

    value: np.ndarray
    way: np.ndarray


def gaps(surface: np.ndarray, cloud: np.ndarray, normal: np.ndarray, apart: np.ndarray, diagonal: np.ndarray) -> Gaps:
    """Of pairs of points of a surface and a cloud (..., 3): along the ``normal`` of the one that stands for its neighbours, which
    lie ``apart`` (...), and aside as far as the other lies beyond the reach of those; ``diagonal`` broadcasts to (...)."""
    way = surface - cloud
    along = dot(way, normal)
    aside = way - along[..., None] * normal
    length = np.sqrt(dot(aside, aside))
    beyond = np.maximum(length - REACH * apart, 0.0)
    aside *= (beyond / np.maximum(length, 1e-12))[..., None]
    whole = np.sqrt(along * along + beyond * beyond)
    straight = (along[..., None] * normal + aside) / np.maximum(whole, 1e-12)[..., None]
    flat = beyond == 0.0
    return Gaps(np.where(flat, along, whole) / diagonal, np.where(flat[..., None], normal, straight))
