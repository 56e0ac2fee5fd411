"""Which bound points are accidents of assignment rather than details of the surface they are bound to.

A real surface without a counterpart in the structure is assigned to whatever is near: the bezel of a screen to the thin inner side of a
frame, a recess to the knob in front of it. Five things tell such points from reliefs:

* a detail does not lie beneath others: of the two faces of a real board both may be nearest to the same face of ours;
* a detail is at most twice as long as the primitive is deep behind its place, to where a ray against the normal leaves its box;
* it goes where those around it go;
* as much real surface as structure: where a patch has several times the points that it has room for, another surface has collapsed onto it;
* a primitive of which most has no such points is not there in the original, and a few patches of details would tear it.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from ..geometry.vectors import dot
from .elements import Solids
from .record import Details

_DEEP = 2.0  # times the depth: where a slender part bends, both of its sides go the same way
_SHALLOW = 0.01  # diagonals: so long offsets may be anywhere
# an offset may lie off the median of its neighbours' by this share of the way to the farthest of them, but by no more than
_STEEP = 0.6
_LEAST = 0.004  # diagonals, or the depth if that is more
_ROUNDS = 2
_BELOW = 0.5  # of the depth
_ABOVE = 0.2  # of the neighbours
_CROWD = 2.5  # times as many points on a patch as on any other surface
_KNOWN = 0.55  # of what can be seen of a primitive: what has to be bound
_TURN = 0.03  # what two normals of opposite direction add to the distance of neighbours, half of it, in diagonals
_AROUND = 12  # neighbours, the point itself among them
_ELSEWHERE = 10.0  # diagonals between elements


def find_details(details: Details, solids: Solids, seen: tuple[np.ndarray, np.ndarray], density: float) -> np.ndarray:
    """The numbers (k,) of the points of one donor that are details. ``seen``: element and patch (m,) of points all over the visible surface;
    ``density``: how many bound points there are to each of these where everything is bound."""
    depth = _depth(details, solids)
    length = np.sqrt(dot(details.offset, details.offset)) / details.diagonal[details.owner]
    beneath = _beneath(details, solids, depth)
    kept = np.flatnonzero((length <= np.maximum(_DEEP * depth, _SHALLOW)) & ~beneath)
    for _ in range(_ROUNDS):
        stray, reach = strayed(details.take(kept), solids)
        kept = kept[stray <= np.minimum(np.maximum(depth[kept], _LEAST), _STEEP * reach)]
    patches = 1 + int(max(details.patch.max(initial=0), seen[1].max(initial=0)))
    cells = len(details.elements) * patches
    room = density * np.bincount(seen[0] * patches + seen[1], minlength=cells)
    cell = details.element * patches + details.patch
    held = np.bincount(cell[kept], minlength=cells) + np.bincount(cell[beneath], minlength=cells)
    held = np.where(held <= _CROWD * room, held, 0)
    have, most = (_by_element(counts, patches) for counts in (np.minimum(held, room), room))
    return kept[(held[cell] > 0)[kept] & (have >= _KNOWN * most)[details.element[kept]]]


def _beneath(details: Details, solids: Solids, depth: np.ndarray) -> np.ndarray:
    """(E,) bool: which lie more than half of the primitive's ``depth`` (E,) below their place, and so far below others of their patch
    that stand around them."""
    if not len(details):
        return np.zeros(0, dtype=bool)
    scale = details.diagonal[details.owner]
    frames = solids.frames(details.elements, details.element, details.patch, details.u, details.v)
    patch = details.element * (1 + int(details.patch.max())) + details.patch
    places = np.concatenate([frames.place / scale[:, None], _ELSEWHERE * patch[:, None]], axis=1)
    near = cKDTree(places).query(places, k=min(_AROUND, len(details)))[1].reshape(len(details), -1)
    height = details.offset[:, 0] / scale
    above = (patch[near] == patch[:, None]) & (height[near] > (height + _BELOW * depth)[:, None])
    return (height < -_BELOW * depth) & (above.mean(axis=1) >= _ABOVE)


def strayed(details: Details, solids: Solids) -> tuple[np.ndarray, np.ndarray]:
    """(E,) how far each offset lies off the median of those around it on the same element, and how far around these are, in diagonals."""
    if not len(details):
        return np.zeros(0), np.zeros(0)
    frames = solids.frames(details.elements, details.element, details.patch, details.u, details.v)
    scale = details.diagonal[details.owner][:, None]
    offset = frames.out_of(details.offset) / scale
    places = np.concatenate(
        [frames.place / scale, _TURN * frames.normal, _ELSEWHERE * details.element[:, None]], axis=1
    )
    apart, near = (x.reshape(len(details), -1) for x in cKDTree(places).query(places, k=min(_AROUND, len(details))))
    alike = details.element[near] == details.element[:, None]
    middle = np.median(offset[np.where(alike, near, near[:, :1])], axis=1)
    way = offset - middle
    return np.sqrt(dot(way, way)), np.where(alike, apart, 0.0).max(axis=1)


def _depth(details: Details, solids: Solids) -> np.ndarray:
    """(E,) how far it is from each place against the normal to the box of its primitive, in diagonals."""
    frames = solids.frames(details.elements, details.element, details.patch, details.u, details.v)
    low, high = (corner[details.element] for corner in solids.boxes(details.elements))
    room = np.where(frames.normal > 0.0, frames.place - low, high - frames.place)
    way = np.maximum(room, 0.0) / np.maximum(np.abs(frames.normal), 1e-9)
    return np.asarray(way.min(axis=1) / details.diagonal[details.owner])


def _by_element(cells: np.ndarray, patches: int) -> np.ndarray:
    """Sums (N,) of the patches (N * patches,) of each element."""
    return np.bincount(np.arange(len(cells)) // patches, cells, len(cells) // patches)
