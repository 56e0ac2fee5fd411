"""Surfaces that have been moved, without what turns inside out.

A face is folded where it has turned by more than a right angle against the structure's, and a sheet is crossed where one side has come
out of the other. What all of a mesh is moved by alike folds nothing. So folds are undone by giving each vertex around one the
mean of its neighbours' ways, ever farther around, and what is folded even then is moved as a whole.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from ..geometry.nearest import Nearest
from ..geometry.vectors import cross, dot
from .skin import neighbours, tie_breakers, total

_RINGS = ((1, 8), (2, 8), (4, 12), (8, 12))  # so far around a fold ways are smoothed, so many times
_SHEET = 0.05  # diagonals: what is thicker is no sheet
_TURN = 0.06  # what two normals of opposite direction add to the distance of two sides, half of it, in diagonals
_FACING = -0.7  # the cosine between the normals of two sides of a sheet, at most
_LEAST = 0.3  # of its thickness: what is left of a sheet
_PASSES = 3
_FIRM = 20.0  # times harder to move: a side that wears a detail of its own
_APART = 10.0  # diagonals between elements


def normals(place: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F, 3) twice the areas of faces times their unit normals."""
    first = place[faces[:, 0]]
    return cross(place[faces[:, 1]] - first, place[faces[:, 2]] - first)


def find_folded(before: np.ndarray, place: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F,) which faces have turned by more than a right angle; ``before`` (F, 3): their normals as they were."""
    return np.asarray(dot(before, normals(place, faces)) < 0.0)


def unfold(place: np.ndarray, way: np.ndarray, faces: np.ndarray, mesh: np.ndarray) -> np.ndarray:
    """The ways (V, 3) of vertices at ``place``, as far as they fold no face; ``mesh`` (V,) numbers what each vertex is of."""
    before = normals(place, faces)
    folded = find_folded(before, place + way, faces)
    if not folded.any():
        return way
    count, way = len(place), way.copy()
    means = neighbours(faces, place)
    held = csr_matrix((np.ones(faces.size), (faces.ravel(), np.repeat(np.arange(len(faces)), 3))), (count, len(faces)))
    for rings, times in _RINGS:
        for _ in range(times):
            some = np.unique(faces[folded])
            for _ in range(rings):
                some = np.unique(faces[held[some].indices])
            way[some] = means[some] @ way
            look = np.unique(held[some].indices)
            folded[look] = find_folded(before[look], place + way, faces[look])
            if not folded.any():
                return way
    many = int(mesh.max()) + 1
    mean = total(mesh, way, many) / np.maximum(np.bincount(mesh, minlength=many), 1)[:, None]
    whole = np.isin(mesh, mesh[faces[folded, 0]])
    way[whole] = mean[mesh[whole]]
    return way


def keep_apart(
    place: np.ndarray, normal: np.ndarray, way: np.ndarray, firm: np.ndarray, mesh: np.ndarray, scale: np.ndarray
) -> np.ndarray:
    """Ways (m, 3) of places of thin sheets whose two sides stay in their order. A side that is ``firm`` (m,), and has another opposite
    that is not, stays where it is; else both give way. ``scale`` (m,): the diagonals of their objects."""
    here, there, thick = find_sheets(place, normal, mesh, scale)
    weight = np.where(firm, _FIRM, 1.0)
    own = weight[there] / (weight[here] + weight[there])
    for _ in range(_PASSES):
        left = thick + dot(way[here] - way[there], normal[here])
        short = np.maximum(_LEAST * thick - left, 0.0)
        if not short.any():
            return way
        way = way.copy()
        way[here] += (own * short)[:, None] * normal[here]
        # what is opposite several takes the mean of what they ask for
        asked = np.maximum(np.bincount(there, short > 0.0, len(way)), 1.0)
        way -= total(there, ((1.0 - own) * short)[:, None] * normal[here], len(way)) / asked[:, None]
    return way


def find_sheets(
    place: np.ndarray, normal: np.ndarray, mesh: np.ndarray, scale: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For places (m, 3) that have another side of a sheet behind them (k,), what lies opposite (k,), and how thick it is there (k,)."""
    shape, facing, mark = place / scale[:, None], _TURN * normal, tie_breakers(mesh)
    sides = Nearest(np.concatenate([shape, facing, mark], axis=1), mesh, _APART)
    apart, found = sides.find(np.concatenate([shape, -facing, 0.0 * mark], axis=1), mesh, _SHEET)
    here = np.flatnonzero(np.isfinite(apart))
    there = found[here]
    thick = dot(place[here] - place[there], normal[here])
    good = (dot(normal[here], normal[there]) < _FACING) & (thick > 0.0)
    return here[good], there[good], thick[good]
