"""Area, placing and exact normals on the surfaces of many instances."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..graph.expr import ZERO, Expr, const
from ..graph.primitive import Primitive
from .density import AreaPlacement, norm, patch_area
from .patches import surfaces
from .split import Params, Split, rows_of
from .topology import orientation

_NUDGE = 1e-6  # fraction by which a normal at a collapsed edge is taken further in
_COLLAPSED = 1e-6  # of the square of the area element there: an edge with less has none but for rounding
_ASTRAY = 1e-8  # 1 less the cosine to the normal there: a normal that is farther from it is rounding, too

Coordinates = tuple[np.ndarray, np.ndarray, np.ndarray]


def areas(primitive: Primitive, params: Params) -> np.ndarray:
    """(k, patches) areas in square metres, 0 where a patch does not exist."""
    out = np.empty((rows_of(params), len(surfaces(primitive))))
    for patch in range(out.shape[1]):
        out[:, patch] = patch_area(primitive, patch, params)
    return out


def place(
    primitive: Primitive, patch: int, params: Params, row: np.ndarray, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Fractions (u, v), uniform by area, for pairs of numbers in (0, 1) on instances ``row`` (m,)."""
    return AreaPlacement(primitive, patch, params).place(row, first, second)


@lru_cache(maxsize=4096)
def _split(primitive: Primitive, patch: int) -> Split:
    """Position, outward unit normal, and the square of the area element."""

    def formulas() -> tuple[Expr, ...]:
        surface = surfaces(primitive)[patch]
        sign = const(float(orientation(primitive)[patch]))
        x, y, z = surface.cross
        length = norm(surface.cross)
        normal = (ZERO if c is ZERO else sign * c / length for c in surface.cross)
        return (*surface.position, *normal, x * x + y * y + z * z)

    return Split.kept(primitive, f"surface of {patch}", 7, formulas)


class PatchEvaluator:
    """Positions and normals of one patch on k instances."""

    def __init__(self, primitive: Primitive, patch: int, params: Params):
        self._split = _split(primitive, patch)
        self._rows = self._split.rows(params)

    def at(self, row: np.ndarray, u: np.ndarray, v: np.ndarray) -> tuple[Coordinates, Coordinates]:
        """Position (metres) and outward unit normal, as three arrays (m,) each, at fractions u, v of instances ``row``.

        At a collapsed edge rounding may leave no normal, or any; then it is that of a point slightly further in.
        """
        gathered = self._rows.take(row, axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            found = self._split.points(gathered, u, v)
        out = _columns(found, u.shape)
        edge = np.flatnonzero((np.abs(u - 0.5) > 0.5 - _NUDGE) | (np.abs(v - 0.5) > 0.5 - _NUDGE))
        if len(edge):
            inner = [np.clip(f[edge], _NUDGE, 1.0 - _NUDGE) for f in (u, v)]
            with np.errstate(divide="ignore", invalid="ignore"):
                fixed = self._split.points(gathered.take(edge, axis=1), *inner)
            moved = _columns(fixed, edge.shape)
            agreed = sum(out[axis][edge] * moved[axis] for axis in range(3, 6))
            bad = np.flatnonzero(~(out[6][edge] > _COLLAPSED * moved[6]) & ~(agreed > 1.0 - _ASTRAY))
            for axis in range(3, 6) if len(bad) else ():
                out[axis] = np.array(out[axis])
                out[axis][edge[bad]] = moved[axis][bad]
        return (out[0], out[1], out[2]), (out[3], out[4], out[5])


def _columns(values: Sequence[Any], shape: tuple[int, ...]) -> list[np.ndarray]:
    """Values at points as arrays of the shape of these: most are, and broadcasting takes long to find that out."""
    arrays = [np.asarray(value, dtype=np.float64) for value in values]
    return [array if array.shape == shape else np.broadcast_to(array, shape) for array in arrays]


def evaluate(
    primitive: Primitive, patch: int, params: Params, row: np.ndarray, u: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Position (m, 3) in metres and outward unit normal (m, 3) at fractions (u, v) of instances ``row`` (m,)."""
    position, normal = PatchEvaluator(primitive, patch, params).at(row, u, v)
    return np.stack(position, axis=-1), np.stack(normal, axis=-1)
