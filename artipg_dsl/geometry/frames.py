"""The frame of a surface at bound points: its outward normal and the patch's own tangent, in the primitive's own frame.

One normal leaves a rotation free. The second axis is the way in which ``u`` grows, as far as it lies across the normal.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..graph.primitive import Primitive
from ..records import dataclass
from .patches import surfaces, tangent_split
from .split import Params
from .surface import PatchEvaluator
from .vectors import cross, dot

_NUDGE = 1e-6  # of a fraction: so far in from a collapsed edge tangents are taken
_LEAST = 1e-12  # metres: shorter tangents say nothing


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """At m points of primitives, in their own frames: ``place`` (m, 3) metres; ``normal``, ``tangent`` and ``second`` (m, 3), a
    right-handed frame of unit vectors; ``speed`` (m, 2), metres per unit of u along the tangent and per unit of v along the second
    axis, below 0 where v grows the other way."""

    place: np.ndarray
    normal: np.ndarray
    tangent: np.ndarray
    second: np.ndarray
    speed: np.ndarray

    def out_of(self, parts: np.ndarray) -> np.ndarray:
        """Vectors (m, 3) given by their parts along normal, tangent and second axis."""
        return parts[:, :1] * self.normal + parts[:, 1:2] * self.tangent + parts[:, 2:] * self.second

    def into(self, vectors: np.ndarray) -> np.ndarray:
        """The parts (m, 3) of vectors."""
        return np.stack([dot(vectors, axis) for axis in (self.normal, self.tangent, self.second)], axis=-1)


def frames_at(
    stock: Sequence[tuple[Primitive, Params]],
    which: np.ndarray,
    row: np.ndarray,
    patch: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
) -> Frames:
    """The frames at m points: on ``row`` (m,) of the instances ``stock[which]``, patch numbers and fractions."""
    place, normal, tangent = (np.empty((len(row), 3)) for _ in range(3))
    speed = np.empty((len(row), 2))
    widest = max((len(surfaces(primitive)) for primitive, _ in stock), default=1)
    cell = which.astype(np.int64) * widest + patch
    order = np.argsort(cell, kind="stable")
    ordered = cell[order]
    starts = np.flatnonzero(np.append(True, ordered[1:] != ordered[:-1])) if len(cell) else np.empty(0, np.int64)
    parts = np.split(order, starts[1:]) if len(starts) else []
    for code, at in zip(ordered[starts].tolist(), parts, strict=True):
        primitive, params = stock[code // widest]
        mine = params if params else {"": np.zeros(int(row[at].max()) + 1)}
        found = _of_patch(primitive, code % widest, mine, row[at], u[at], v[at])
        for into, values in zip((place, normal, tangent, speed), found, strict=True):
            into[at] = values
    return Frames(place, normal, tangent, cross(normal, tangent), speed)


def _of_patch(
    primitive: Primitive, patch: int, params: Params, row: np.ndarray, u: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    place, normal = (np.stack(x, axis=-1) for x in PatchEvaluator(primitive, patch, params).at(row, u, v))
    split = tangent_split(primitive, patch)
    rows = [values[row] for values in split.rows(params)]
    values = split.points(rows, *(np.clip(x, _NUDGE, 1.0 - _NUDGE) for x in (u, v)))
    made = [np.broadcast_to(np.asarray(x, dtype=np.float64), u.shape) for x in values]
    along, aside = np.stack(made[:3], axis=-1), np.stack(made[3:], axis=-1)
    flat = along - dot(along, normal)[:, None] * normal
    length = np.sqrt(dot(flat, flat))
    tangent = flat / np.maximum(length, _LEAST)[:, None]
    untold = np.flatnonzero(length <= _LEAST)
    tangent[untold] = _across(normal[untold])
    across = dot(aside, cross(normal, tangent))
    across = np.where(np.abs(across) < _LEAST, _LEAST, across)
    return place, normal, tangent, np.stack([np.maximum(length, _LEAST), across], axis=-1)


def _across(normal: np.ndarray) -> np.ndarray:
    """Unit vectors across others (m, 3): where a patch tells none."""
    steep = np.abs(normal[:, 2]) > 0.9
    axis = np.where(steep[:, None], np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    found = cross(axis, normal)
    return found / np.sqrt(dot(found, found))[:, None]
