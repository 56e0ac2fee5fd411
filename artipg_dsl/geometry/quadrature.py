"""Volume, centre and inertia of the true solids, by Gauss and Legendre's quadrature over their surfaces.

A volume integral is one over the surface (Gauss's theorem): that of x y over the volume is that of x^2 y n_x / 2 over the
surface. Trigonometric patches are exact to about 1e-12 this way; meshes are not, they cut off what bulges.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..graph.primitive import Primitive
from ..native.backend import machine as compiled
from ..native.moments import add_moments
from .box import bounds
from .patches import Params, Split, find_existing, rows_of, surfaces
from .topology import orientation, turns

_AT_ONCE = 400_000  # places, so that the terms stay in the caches
_STRAIGHT, _PER_RADIAN = 4, 4  # nodes


@lru_cache(maxsize=512)
def _nodes(turn: float) -> tuple[np.ndarray, np.ndarray]:
    """Places in 0 .. 1 and their weights for a direction that turns through an angle."""
    places, weights = np.polynomial.legendre.leggauss(_STRAIGHT + math.ceil(_PER_RADIAN * min(turn, 13.0)))
    return (places + 1) / 2, weights / 2


@lru_cache(maxsize=1024)
def _rule(primitive: Primitive, patch: int) -> tuple[Split, np.ndarray, np.ndarray, np.ndarray]:
    """Position and du x dv of a patch, the fractions (n,) to ask at, and their weights, signed outwards."""
    along_u, along_v = turns(primitive, patch)
    (u, by_u), (v, by_v) = _nodes(along_u), _nodes(along_v)
    made = surfaces(primitive)[patch]
    weight = float(orientation(primitive)[patch]) * by_u[:, None] * by_v[None]
    grid = np.broadcast_arrays(u[:, None], v[None])
    return Split(primitive, (*made.position, *made.cross)), grid[0].ravel(), grid[1].ravel(), weight.ravel()


def volume_inertia(
    primitive: Primitive, params: Params, inertia: bool = True
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Volume (k,) m3, centre (k, 3) m, inertia about the centre per unit density (k, 3, 3) m5; noughts unless it is asked for."""
    count = rows_of(params)
    low, high = bounds(primitive, params)
    middle = (low + high) / 2  # the moments are taken about it, so that little cancels
    volume, first, second = np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3, 3))
    there, machine = find_existing(primitive, params), compiled()
    for patch in range(there.shape[1]):
        split, u, v, weight = _rule(primitive, patch)
        rows = np.flatnonzero(there[:, patch])
        at_once = max(1, _AT_ONCE // len(u))
        for start in range(0, len(rows), at_once):
            own = rows[start : start + at_once]
            values = split.points([r[:, None] for r in split.rows({n: c[own] for n, c in params.items()})], u, v)
            if machine is not None:
                add_moments(machine, values, weight, own, middle, (volume, first, second), inertia)
                continue
            terms = [np.broadcast_to(value, (len(own), len(u))) for value in values]
            x = [terms[axis] - middle[own, axis, None] for axis in range(3)]
            flow = [terms[3 + axis] * weight for axis in range(3)]
            volume[own] += _total(x[0] * flow[0] + x[1] * flow[1] + x[2] * flow[2]) / 3
            for i in range(3):
                square = x[i] * x[i] * flow[i]
                first[own, i] += _total(square) / 2
                for j in range(3) if inertia else ():
                    second[own, i, j] += _total(square * x[j]) / (3 if i == j else 2)
    second = (second + second.transpose(0, 2, 1)) / 2  # two ways to the same mixed moment
    centre, about = first / volume[:, None], np.zeros((count, 3, 3))
    for i in range(3) if inertia else ():
        for j in range(3):
            second[:, i, j] -= volume * centre[:, i] * centre[:, j]
            about[:, i, j] = -second[:, i, j]
    for i in range(3) if inertia else ():
        about[:, i, i] = second[:, (i + 1) % 3, (i + 1) % 3] + second[:, (i + 2) % 3, (i + 2) % 3]
    return volume, centre + middle, about


def _total(values: np.ndarray) -> np.ndarray:
    """Row sums (k,); contiguous rows, so that the order of summation depends on their length alone."""
    return np.add.reduce(np.ascontiguousarray(values), axis=1)
