"""Blue noise: of many points on a surface the n that keep their distance from one another.

Points are eliminated, the crowded ones first, until n are left. How crowded a point is follows Yuksel, "Sample
Elimination for Generating Poisson Disk Sample Sets" (2015): the sum of (1 - d / 2 r)^8 over the points within 2 r, r
being the largest radius that n discs on a plane of the same area could have. That takes them one by one; here all that
are more crowded than all their neighbours go at once. Points on surfaces that turn away from one another, the two sides
of a sheet, are no neighbours.
"""

from __future__ import annotations

import numpy as np

from .runs import runs

TIMES = 4  # points to choose from, per point wanted
_APART = -0.5  # cosine between normals of neighbours at least
_SHARE = 0.5  # of the crowding of the most crowded ones: what is less so stays for another round
_SCATTER = 2654435761  # an odd number: equally crowded points go in no order of place
_PAIRS = 4_000_000  # pairs of points looked at together, about
_FEW = 60  # pairs per point, about, that the grid proposes
_STEPS = [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (z, y, x) > (0, 0, 0)]


def thin(position: np.ndarray, normal: np.ndarray, area: np.ndarray, n: int) -> np.ndarray:
    """Indices (P, n), ascending, of the points kept of each pool's m: ``position``, ``normal`` (P, m, 3).

    ``area`` (P,): of the surface they lie on, in square metres. What is kept of a pool depends on its points alone.
    """
    pools, m = position.shape[:2]
    out = np.empty((pools, n), dtype=np.int64)
    if not n:
        return out
    step = max(1, _PAIRS // (_FEW * m))
    for first in range(0, pools, step):
        part = slice(first, min(first + step, pools))
        kept = _choose(position[part], normal[part], area[part], n)
        out[part] = np.nonzero(kept.reshape(-1, m))[1].reshape(-1, n)
    return out


def disc_radius(area: np.ndarray, n: int) -> np.ndarray:
    """The largest radius that n equal discs on a plane of this area could have: packed in a hexagon's way."""
    return np.sqrt(area / (2.0 * np.sqrt(3.0) * n))


def _choose(position: np.ndarray, normal: np.ndarray, area: np.ndarray, n: int) -> np.ndarray:
    """(P m,) bool: which points stay, n of each pool."""
    pools, m = position.shape[:2]
    owner = np.repeat(np.arange(pools), m)
    one, two, weight = _neighbours(position, normal, 2.0 * disc_radius(area, n))
    there = np.ones(pools * m, dtype=bool)
    excess = np.full(pools, m - n)
    while excess.any():
        crowd = np.bincount(one, weight, len(owner)) + np.bincount(two, weight, len(owner))
        lost = np.zeros(len(owner), dtype=bool)  # those with a more crowded neighbour; of equals the first goes
        first = crowd[one] >= crowd[two]
        lost[np.where(first, two, one)] = True
        most = crowd.reshape(pools, m).max(axis=1)
        going = np.flatnonzero(there & ~lost & (crowd >= _SHARE * most[owner]) & (excess[owner] > 0))
        # no more than what is too many, the most crowded ones
        order = np.lexsort((going % m * _SCATTER & 0xFFFFFFFF, -crowd[going], owner[going]))
        going = going[order]
        begin = np.searchsorted(owner[going], np.arange(pools))
        going = going[np.arange(len(going)) - begin[owner[going]] < excess[owner[going]]]
        there[going] = False
        excess = excess - np.bincount(owner[going], minlength=pools)
        kept = there[one] & there[two] & (excess[owner[one]] > 0)
        one, two, weight = one[kept], two[kept], weight[kept]
    return there


def _neighbours(
    position: np.ndarray, normal: np.ndarray, reach: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of points of one pool within its ``reach`` (P,), each once, and what one adds to the other's crowding."""
    pools, m = position.shape[:2]
    owner = np.repeat(np.arange(pools), m)
    wide = np.maximum(reach, 1e-300)[owner]
    low = position.min(axis=1)[owner]
    flat, facing = position.reshape(-1, 3), normal.reshape(-1, 3)
    bins = [((flat[:, k] - low[:, k]) / wide).astype(np.int64) + 1 for k in range(3)]
    size = [int(b.max(initial=0)) + 2 for b in bins]
    place = ((owner * size[0] + bins[0]) * size[1] + bins[1]) * size[2] + bins[2]
    order = np.argsort(place, kind="stable")
    found, begin, count = np.unique(place[order], return_index=True, return_counts=True)
    mine = np.repeat(np.arange(len(found)), count)  # of the points in this order: which bin
    later = np.arange(len(order)) + 1
    pairs = [(order, later, begin[mine] + count[mine] - later)]  # those of the own bin that come after
    for x, y, z in _STEPS:
        other = found + (x * size[1] + y) * size[2] + z
        at = np.minimum(np.searchsorted(found, other), len(found) - 1)
        many = np.where(found[at] == other, count[at], 0)
        pairs.append((order, begin[at][mine], many[mine]))
    made: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for point, start, many in pairs:
        one, two = np.repeat(point, many), order[runs(start, many)]
        square = np.zeros(len(one))
        for k in range(3):
            gap = flat[one, k] - flat[two, k]
            square += gap * gap
        kept = np.flatnonzero(square < (wide * wide)[one])
        one, two, square = one[kept], two[kept], square[kept]
        along = sum(facing[one, k] * facing[two, k] for k in range(3))
        kept = np.flatnonzero(along > _APART)
        one, two = one[kept], two[kept]
        near = 1.0 - np.sqrt(square[kept]) / wide[one]
        near = near * near
        near = near * near
        made.append((one, two, near * near))
    return (
        np.concatenate([a for a, _, _ in made]),
        np.concatenate([b for _, b, _ in made]),
        np.concatenate([c for _, _, c in made]),
    )
