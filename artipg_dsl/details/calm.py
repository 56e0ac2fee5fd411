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

from ..geometry.frames import Frames
from ..geometry.vectors import cross, dot
from .elements import Solids
from .record import Details
from .wear import Wardrobe

_REACH = np.array(
    [1.0, 0.3, 0.15]
)  # of the sides of the primitive, the shortest first: offsets are no longer than the longest of these
_TURN = 0.15  # what two normals of opposite direction add to the distance of neighbours, half of it, in diagonals
_AROUND = 20  # neighbours, the point itself among them
_STIFF = 1e-5  # square diagonals
_STRAY = 0.02  # diagonals
_ROUNDS = 1
_ELSEWHERE = 10.0  # diagonals between elements
_SHEET = 0.25  # of its second side: what is thinner is a sheet,
_SUNK = 0.1  # and no more than this share of its points is moved inwards by more than its thickness: it would drown in what bears it
_TELLING = 4  # others of the same element around a point, from which its offset is foretold
_FORETOLD = 0.5  # of the offsets outwards: how far they lie off what is foretold at most, root mean square
_DOUBT = 0.002  # how much farther off the real normals a moved surface may face than the structure, 1 - cosine,
_CHANCE = 0.02  # and by how much more where few points tell of it,
_ASTRAY = 0.3  # and how far at most
_COVERED = 0.6  # of a patch
_GRID = 10  # places a side at which patches are asked


def calm(wardrobe: Wardrobe) -> Details:
    """The points whose offsets meshes can follow, with offsets that change little from each to the next."""
    solids = wardrobe.solids
    found = wardrobe.details.take(_within(wardrobe.details, solids))
    if not len(found):
        return found
    frames = solids.frames(found.elements, found.element, found.patch, found.u, found.v)
    scale = found.diagonal[found.owner][:, None]
    place, offset = frames.place / scale, frames.out_of(found.offset) / scale
    features = np.concatenate([place, _TURN * frames.normal, _ELSEWHERE * found.element[:, None]], axis=1)
    _, near = cKDTree(features).query(features, k=min(_AROUND, len(found)))
    near = near.reshape(len(found), -1)
    alike = (found.element[near] == found.element[:, None]).astype(np.float64)
    kept = np.flatnonzero(_is_surface(found, frames, place, offset, near, alike) & _is_covered(found, wardrobe))
    smooth, _ = _planes(place, offset, near, alike)
    return replace(found, offset=frames.into(smooth * scale)).take(kept)


def _within(details: Details, solids: Solids) -> np.ndarray:
    """The numbers of the points whose offsets are not too long for the size of their primitive, nor sink a whole sheet."""
    low, high = solids.boxes(details.elements)
    size, many = np.sort(high - low, axis=1), len(details.elements)
    reach = (size * _REACH).max(axis=1)
    sunk = np.bincount(details.element, details.offset[:, 0] < -size[details.element, 0], many)
    sheet = size[:, 0] < _SHEET * size[:, 1]
    drowned = sheet & (sunk > _SUNK * np.bincount(details.element, minlength=many))
    near = np.sqrt(dot(details.offset, details.offset)) <= reach[details.element]
    return np.flatnonzero(near & ~drowned[details.element])


def _is_surface(
    found: Details, frames: Frames, place: np.ndarray, offset: np.ndarray, near: np.ndarray, alike: np.ndarray
) -> np.ndarray:
    """(m,) which points are on elements whose offsets are those of one surface: each is foretold by those around it, and moved
    like that the surface faces as the real one does, or not worse than the structure. Others would ripple and fray."""
    others = np.where(near == np.arange(len(near))[:, None], 0.0, alike)
    enough = _sum(others) >= _TELLING
    foretold, slope = _planes(place, offset, near, np.where(enough[:, None], others, alike))
    moved = [way + np.stack([dot(way, s) for s in slope], axis=-1) for way in (frames.tangent, frames.second)]
    real, told, many = frames.out_of(found.facing), np.flatnonzero(enough), len(found.elements)
    missed, bare, after, before = (
        np.bincount(found.element[told], values[told], many)
        for values in (
            dot(offset - foretold, frames.normal) ** 2,
            dot(offset, frames.normal) ** 2,
            _turned(cross(*moved), real),
            _turned(frames.normal, real),
        )
    )
    count = np.bincount(found.element[told], minlength=many)
    turned = after <= before + _DOUBT * count + _CHANCE * np.sqrt(count)
    whole = (missed <= _FORETOLD**2 * bare) & turned & (after <= _ASTRAY * count)
    return whole[found.element]


def _is_covered(found: Details, wardrobe: Wardrobe) -> np.ndarray:
    """(m,) which points are on patches that are bound nearly all over, but for what lay behind others in the original. Details that end
    in the middle of a patch, as on an inner wall of which only the mouth has some, end in a ragged edge."""
    patches = 1 + int(found.patch.max())
    cells, own = np.unique(found.element * patches + found.patch, return_inverse=True)
    element, patch = (np.repeat(values, _GRID * _GRID) for values in np.divmod(cells, patches))
    step = (np.arange(_GRID) + 0.5) / _GRID
    u, v = np.tile(np.repeat(step, _GRID), len(cells)), np.tile(step, _GRID * len(cells))
    there = wardrobe.solids.frames(found.elements, element, patch, u, v)
    asked = there.place, there.normal, element
    bound, behind = wardrobe.has(*asked), wardrobe.before(*asked) >= 0
    share, open_ = (values.reshape(len(cells), -1).sum(axis=1) for values in (bound, bound | ~behind))
    return (share >= _COVERED * open_)[own]


def _turned(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """1 - the cosine between vectors (m, 3)."""
    return 1.0 - dot(one, other) / np.maximum(np.sqrt(dot(one, one) * dot(other, other)), 1e-12)


def _planes(
    place: np.ndarray, offset: np.ndarray, near: np.ndarray, weight: np.ndarray
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Offsets (m, 3) at places (m, 3) as linear functions of place say that fit those ``near`` (m, k) by ``weight`` (m, k) best; and the
    slopes (m, 3) of their three coordinates."""
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
    return mean + np.stack([dot(own, slope[k]) for k in range(3)], axis=-1), slope


def _sum(values: np.ndarray) -> np.ndarray:
    """Sums (m,) of rows (m, k), one column after the other: the same bits in any batch."""
    found = np.zeros(len(values))
    for column in values.T:
        found += column
    return found
