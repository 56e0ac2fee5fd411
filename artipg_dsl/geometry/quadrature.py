"""Volume, centre and inertia of the true solids, by Gauss and Legendre's quadrature over their surfaces.

A volume integral is one over the surface (Gauss's theorem): that of x y over the volume is that of x^2 y n_x / 2 over the
surface. Trigonometric patches are exact to about 1e-12 this way; meshes are not, they cut off what bulges. A patch whose
curvature has cusps, such as a bar along a superellipse, is asked at more places: as many as its test values show it to need.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from ..graph.primitive import Primitive
from ..native.backend import machine as compiled
from ..native.moments import add_moments
from ..shapes import fit
from . import facts
from .box import bounds
from .patches import find_existing, surfaces
from .split import Params, Split, rows_of
from .topology import orientation, turns
from .trial import draw_trial

_AT_ONCE = 400_000  # places, so that the terms stay in the caches
_STRAIGHT, _PER_RADIAN = 4, 4  # nodes
_STEADY = 1e-3  # of the volume and of the greatest moment: what twice the nodes of a patch may still change
_MOST = 8  # times as many nodes

_Moments = tuple[np.ndarray, np.ndarray, np.ndarray]


@lru_cache(maxsize=512)
def _nodes(turn: float, times: int) -> tuple[np.ndarray, np.ndarray]:
    """Places in 0 .. 1 and their weights for a direction that turns through an angle."""
    places, weights = np.polynomial.legendre.leggauss(times * (_STRAIGHT + math.ceil(_PER_RADIAN * min(turn, 13.0))))
    return (places + 1) / 2, weights / 2


@lru_cache(maxsize=1024)
def _split(primitive: Primitive, patch: int) -> Split:
    """Position and du x dv of a patch."""
    made = surfaces(primitive)[patch]
    return Split.kept(primitive, f"flux of {patch}", 6, lambda: (*made.position, *made.cross))


def _rule(primitive: Primitive, patch: int, times: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The fractions (n,) along u and v to ask a patch at, and their weights, signed outwards."""
    (u, by_u), (v, by_v) = map(_nodes, turns(primitive, patch), times)
    weight = float(orientation(primitive)[patch]) * by_u[:, None] * by_v[None]
    grid = np.broadcast_arrays(u[:, None], v[None])
    return grid[0].ravel(), grid[1].ravel(), weight.ravel()


@lru_cache(maxsize=1024)
def _rules(primitive: Primitive) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], ...]:
    """The places and weights of each patch, as many as it needs."""

    def read(held: Any) -> list[tuple[int, int]]:
        fit(held, list[list[int]])  # JSON has no pairs
        if len(held) != len(surfaces(primitive)) or not all(1 <= times <= _MOST for pair in held for times in pair):
            raise ValueError("a pair of small numbers for each patch")
        return [(u, v) for u, v in held]

    times = facts.recall_fact(primitive, "nodes", lambda: _find_times(primitive), list, read)
    return tuple(_rule(primitive, patch, pair) for patch, pair in enumerate(times))


def _find_times(primitive: Primitive) -> list[tuple[int, int]]:
    """How many times as many nodes each patch takes along u and v: twice as many, as long as that changes the moments of a solid."""
    params = draw_trial(primitive)
    low, high = bounds(primitive, params)
    there = find_existing(primitive, params)

    def share(patch: int, times: tuple[int, int]) -> np.ndarray:
        """(rows, 4): what a patch adds to the volume and to the squares along the axes."""
        found = np.zeros(len(low)), np.zeros((len(low), 3)), np.zeros((len(low), 3, 3))
        own = np.flatnonzero(there[:, patch])
        _add(_split(primitive, patch), _rule(primitive, patch, times), params, own, (low + high) / 2, found, True)
        return np.column_stack([found[0], *(found[2][:, axis, axis] for axis in range(3))])

    shares = [share(patch, (1, 1)) for patch in range(there.shape[1])]
    whole = np.abs(sum(shares))
    whole[:, 1:] = whole[:, 1:].max(axis=1, keepdims=True)
    out = []
    for patch, held in enumerate(shares):
        times = [1, 1]
        for axis, turn in enumerate(turns(primitive, patch)):
            while turn > 0 and times[axis] < _MOST:
                times[axis] *= 2
                finer = share(patch, (times[0], times[1]))
                if (np.abs(finer - held) <= _STEADY * whole).all():
                    times[axis] //= 2
                    break
                held = finer
        out.append((times[0], times[1]))
    return out


def volume_inertia(primitive: Primitive, params: Params, inertia: bool = True) -> _Moments:
    """Volume (k,) m3, centre (k, 3) m, inertia about the centre per unit density (k, 3, 3) m5; noughts unless it is asked for."""
    count = rows_of(params)
    low, high = bounds(primitive, params)
    middle = (low + high) / 2  # the moments are taken about it, so that little cancels
    volume, first, second = np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3, 3))
    there = find_existing(primitive, params)
    for patch, rule in enumerate(_rules(primitive)):
        own = np.flatnonzero(there[:, patch])
        _add(_split(primitive, patch), rule, params, own, middle, (volume, first, second), inertia)
    second = (second + second.transpose(0, 2, 1)) / 2  # two ways to the same mixed moment
    centre, about = first / volume[:, None], np.zeros((count, 3, 3))
    for i in range(3) if inertia else ():
        for j in range(3):
            second[:, i, j] -= volume * centre[:, i] * centre[:, j]
            about[:, i, j] = -second[:, i, j]
    for i in range(3) if inertia else ():
        about[:, i, i] = second[:, (i + 1) % 3, (i + 1) % 3] + second[:, (i + 2) % 3, (i + 2) % 3]
    return volume, centre + middle, about


def _add(
    split: Split,
    rule: tuple[np.ndarray, np.ndarray, np.ndarray],
    params: Params,
    rows: np.ndarray,
    middle: np.ndarray,
    moments: _Moments,
    inertia: bool,
) -> None:
    """Add what a patch gives on the instances ``rows`` (k,) to their volume (K,), first (K, 3) and second moments (K, 3, 3)."""
    u, v, weight = rule
    volume, first, second = moments
    machine = compiled()
    at_once = max(1, _AT_ONCE // len(u))
    for start in range(0, len(rows), at_once):
        own = rows[start : start + at_once]
        values = split.points([r[:, None] for r in split.rows({n: c[own] for n, c in params.items()})], u, v)
        if machine is not None:
            add_moments(machine, values, weight, own, middle, moments, inertia)
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


def _total(values: np.ndarray) -> np.ndarray:
    """Row sums (k,); contiguous rows, so that the order of summation depends on their length alone."""
    return np.add.reduce(np.ascontiguousarray(values), axis=1)
