"""Details as a mesh can wear them: of what points wear, that which a closed surface can follow.

Points may go where they like: of two that lie side by side one may go to a rim and one to the groove behind it, and a cloud shows both.
A surface has one place for each of its own. So what makes up for a part that is missing in the structure goes, which is what reaches
too far for the size of its primitive, and each offset becomes what a linear function of the place says that fits those around it, where
strays count little.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.vectors import cross, dot
from .elements import Solids
from .record import Details

_REACH = np.array(
    [1.0, 0.3, 0.15]
)  # of the sides of the primitive, the shortest first: offsets are no longer than the longest of these
_TURN = 0.15  # what two normals of opposite direction add to the distance of neighbours, half of it, in diagonals
_AROUND = 20  # neighbours, the point itself among them
_STIFF = 1e-5  # square diagonals
_STRAY = 0.02  # diagonals
_ROUNDS = 1
_ELSEWHERE = 10.0  # diagonals between elements


def calm(details: Details, solids: Solids) -> Details:
    """The points whose offsets meshes can follow, with offsets that change little from each to the next."""
    low, high = solids.boxes(details.elements)
    reach = (np.sort(high - low, axis=1) * _REACH).max(axis=1)[details.element]
    found = details.take(np.flatnonzero(np.sqrt(dot(details.offset, details.offset)) <= reach))
    if not len(found):
        return found
    frames = solids.frames(found.elements, found.element, found.patch, found.u, found.v)
    scale = found.diagonal[found.owner][:, None]
    places = np.concatenate([frames.place / scale, _TURN * frames.normal, _ELSEWHERE * found.element[:, None]], axis=1)
    _, near = cKDTree(places).query(places, k=min(_AROUND, len(found)))
    near = near.reshape(len(found), -1)
    alike = (found.element[near] == found.element[:, None]).astype(np.float64)
    offset = _planes(frames.place / scale, frames.out_of(found.offset) / scale, near, alike) * scale
    return replace(found, offset=frames.into(offset))


def _planes(place: np.ndarray, offset: np.ndarray, near: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Offsets (m, 3) at places (m, 3) as linear functions of place say that fit those ``near`` (m, k) by ``weight`` (m, k) best."""
    for again in range(_ROUNDS + 1):
        share = weight / _sum(weight)[:, None]
        middle, mean = (
            np.stack([_sum(share * values[near, k]) for k in range(3)], axis=-1) for values in (place, offset)
        )
        way, rest = place[near] - middle[:, None], offset[near] - mean[:, None]
        square = [np.stack([_sum(share * way[..., i] * way[..., j]) for j in range(3)], axis=-1) for i in range(3)]
        square = [row + _STIFF * np.eye(3)[i] for i, row in enumerate(square)]
        a, b, c = square
        bulk = dot(a, cross(b, c))[:, None]
        inverse = [cross(b, c) / bulk, cross(c, a) / bulk, cross(a, b) / bulk]  # its columns, of a symmetric matrix
        slope = []
        for k in range(3):
            mixed = [_sum(share * way[..., i] * rest[..., k])[:, None] for i in range(3)]
            slope.append(mixed[0] * inverse[0] + mixed[1] * inverse[1] + mixed[2] * inverse[2])
        if again < _ROUNDS:
            miss = np.stack([rest[..., k] - dot(way, slope[k][:, None]) for k in range(3)], axis=-1)
            weight = weight / (1.0 + dot(miss, miss) / _STRAY**2)
    own = place - middle
    return mean + np.stack([dot(own, slope[k]) for k in range(3)], axis=-1)


def _sum(values: np.ndarray) -> np.ndarray:
    """Sums (m,) of rows (m, k), one column after the other: the same bits in any batch."""
    found = np.zeros(len(values))
    for column in values.T:
        found += column
    return found
