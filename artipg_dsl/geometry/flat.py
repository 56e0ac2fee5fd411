"""Which patches are flat, told when the primitive is compiled: most of what is sampled needs no formula per point.

A flat patch is the quad ``origin + u a + v b + u v c`` in one plane; where ``c`` is nought it is a parallelogram.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal

import numpy as np

from ..graph.derive import derive
from ..graph.expr import ONE, ZERO, Expr
from ..graph.formula import Formula
from ..graph.primitive import Primitive
from ..graph.substitution import substitute
from ..shapes import fit
from . import facts
from .patches import U, V, find_existing, grid, inside_split, position_split, surfaces
from .split import Params, keep_formula, rows_of
from .topology import shown_rows
from .trial import draw_trial

PARALLEL, PLANAR, BENT = 0, 1, 2  # a parallelogram, another flat quad, anything else
_TOLERANCE = 1e-9
_ENDS = np.array([0.0, 0.5, 1.0])
_INNER = np.array([0.02, 0.3, 0.7, 0.98])
_PAIRS = 512  # pairs of surface points whose middles are asked, per test value


@lru_cache(maxsize=512)
def shapes(primitive: Primitive) -> np.ndarray:
    """(patches,) int8: PARALLEL, PLANAR or BENT."""
    count = len(surfaces(primitive))

    def read(held: Any) -> np.ndarray:
        fit(held, list[Literal[0, 1, 2]])
        if len(held) != count:
            raise ValueError("a shape for each patch")
        return np.array(held, dtype=np.int8)

    find = lambda: np.array([_shape(primitive, patch) for patch in range(count)], dtype=np.int8)  # noqa: E731
    return facts.recall_fact(primitive, "flat", find, np.ndarray.tolist, read)


def _shape(primitive: Primitive, patch: int) -> int:
    surface = surfaces(primitive)[patch]
    du, dv = surface.tangents
    if any(derive(e, "u") is not ZERO for e in du) or any(derive(e, "v") is not ZERO for e in dv):
        return BENT
    places = grid(
        position_split(primitive, patch), shown_rows(primitive, patch), *np.meshgrid(_ENDS, _ENDS, indexing="ij")
    )
    corners = [places[:, i, j] for i in (0, -1) for j in (0, -1)]  # at (0, 0), (0, 1), (1, 0), (1, 1)
    a, b = corners[2] - corners[0], corners[1] - corners[0]
    c = corners[3] - corners[2] - corners[1] + corners[0]
    size = np.abs(places - places[:, :1, :1]).max(axis=(1, 2, 3))
    # the twist of a patch that is bilinear lies in its one mixed term: no part of it may leave the plane of the rest
    twist = (np.cross(a, b) * c).sum(axis=1)
    at_middle = places[:, 1, 1] - (corners[0] + a / 2 + b / 2 + c / 4)
    if (np.abs(twist) > _TOLERANCE * size**3).any() or (np.abs(at_middle).max(axis=1) > _TOLERANCE * size).any():
        return BENT
    return PARALLEL if all(derive(e, "v") is ZERO for e in du) else PLANAR


@lru_cache(maxsize=512)
def _corners(primitive: Primitive) -> tuple[tuple[int, ...], Formula]:
    """The flat patches, and the coordinates of their corners (0, 0), (1, 0), (0, 1), (1, 1)."""
    flat = tuple(int(p) for p in np.flatnonzero(shapes(primitive) != BENT))
    ends = [{U: u, V: v} for v in (ZERO, ONE) for u in (ZERO, ONE)]

    def formulas() -> list[Expr]:
        every = surfaces(primitive)
        return [substitute(every[p].position[axis], end) for end in ends for axis in range(3) for p in flat]

    return flat, keep_formula(primitive, "corners of quads", 12 * len(flat), formulas)


def quads(primitive: Primitive, params: Params) -> tuple[tuple[int, ...], np.ndarray]:
    """The flat patches, and (4, 3, k, flat patches): origin, a, b and c in the own frames of the instances."""
    flat, corners = _corners(primitive)
    corner = np.empty((4, 3, rows_of(params), len(flat)))
    if not flat:
        return flat, corner
    values = corners(*(params[n] for n in primitive.parameters))
    for number, value in enumerate(values):
        vector, patch = divmod(number, len(flat))
        corner[vector // 3, vector % 3, :, patch] = value
    corner[3] -= corner[2]
    corner[1:3] -= corner[0]
    corner[3] -= corner[1]
    corner[3][..., shapes(primitive)[list(flat)] == PARALLEL] = 0.0
    return flat, corner


@lru_cache(maxsize=512)
def convex(primitive: Primitive) -> bool:
    """Whether the solid is convex: it declares no pieces, and points between its surface points never lie outside."""
    if primitive.pieces:
        return False

    def read(held: Any) -> bool:
        fit(held, bool)
        return bool(held)

    return facts.recall_fact(primitive, "convex", lambda: _found_convex(primitive), bool, read)


def _found_convex(primitive: Primitive) -> bool:
    params = draw_trial(primitive)
    there = find_existing(primitive, params)
    u, v = (a.ravel() for a in np.meshgrid(_INNER, _INNER, indexing="ij"))
    every = [grid(position_split(primitive, patch), params, u, v) for patch in range(there.shape[1])]
    split = inside_split(primitive)
    rows = split.rows(params)
    for row in range(len(there)):
        points = np.concatenate([every[patch][row] for patch in np.flatnonzero(there[row])])
        size = (points.max(axis=0) - points.min(axis=0)).max()
        first = np.arange(_PAIRS) * 7919 % len(points)
        second = np.arange(_PAIRS) * 104729 // 7 % len(points)
        middle = (points[first] + points[second]) / 2
        value = split.points([r[row] for r in rows], *middle.T)[0]
        if (value > _TOLERANCE * size).any():
            return False
    return True
