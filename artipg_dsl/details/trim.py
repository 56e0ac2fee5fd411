"""What objects can borrow of details: that which belongs to the surface, not what makes up for a structure that does not fit.

A mutant has the faults of the structure that its donor was given, and the offsets that make up for them; on another object these become
spikes and tears. So what reaches farther than its primitive is thick goes, and what does not go where its neighbours go.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.vectors import dot
from .elements import Solids
from .record import Details

_THICK, _WIDE = (
    1.0,
    0.3,
)  # offsets are at most as long as the primitive is thick, or this share of its second side if that is more
_APART = 0.012  # diagonals: so far an offset may lie off the median of its neighbours'
_TURN = 0.03  # what two normals of opposite direction add to the distance of neighbours, half of it, in diagonals
_AROUND = 12  # neighbours, the point itself among them
_ROUNDS = 2
_ELSEWHERE = 10.0  # diagonals between elements


def trim(details: Details, solids: Solids) -> Details:
    """The points whose offsets other objects can wear."""
    low, high = solids.boxes(details.elements)
    size = np.sort(high - low, axis=1)[details.element]
    length = np.sqrt(dot(details.offset, details.offset))
    found = details.take(np.flatnonzero(length <= np.maximum(_THICK * size[:, 0], _WIDE * size[:, 1])))
    for _ in range(_ROUNDS):
        found = found.take(np.flatnonzero(_strayed(found, solids) <= _APART))
    return found


def _strayed(details: Details, solids: Solids) -> np.ndarray:
    """(E,) how far each offset lies off the median of those around it on the same element, in diagonals."""
    if not len(details):
        return np.zeros(0)
    frames = solids.frames(details.elements, details.element, details.patch, details.u, details.v)
    scale = details.diagonal[details.owner][:, None]
    offset = frames.out_of(details.offset) / scale
    places = np.concatenate(
        [frames.place / scale, _TURN * frames.normal, _ELSEWHERE * details.element[:, None]], axis=1
    )
    _, near = cKDTree(places).query(places, k=min(_AROUND, len(details)))
    near = near.reshape(len(details), -1)
    alike = details.element[near] == details.element[:, None]
    middle = np.median(offset[np.where(alike, near, near[:, :1])], axis=1)
    way = offset - middle
    return np.asarray(np.sqrt(dot(way, way)))
