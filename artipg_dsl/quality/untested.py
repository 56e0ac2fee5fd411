"""Primitives at values that their `test` ranges leave out, where the stated box does not hold their surface or their convex pieces.

What a solid is made of is asked of its test values while it is lowered: which of several places is highest, say. At other values the
answer may be another one.
"""

from __future__ import annotations

import numpy as np

from ..geometry import mesh
from ..geometry.box import bounds
from ..geometry.sites import SiteTable, scatter
from ..records import dataclass
from ..runtime.batch import Batch

_STEPS = 24  # steps per turn of the mesh whose vertices are looked at
_BEYOND = 1e-6  # of the size
_PIECE = 1e-3  # of the size: a stated piece may be a little larger than what it stands for


@dataclass(frozen=True, slots=True)
class Untested:
    """A part of which something lies ``reach`` metres outside of its box; a parameter at a ``value`` outside of its test range."""

    part: str
    piece: bool  # of it lies outside, not its surface
    primitive: str
    parameter: str
    value: float
    test: tuple[float, float]
    reach: float


def find_untested(batch: Batch) -> list[Untested]:
    """One for each primitive that is wrong somewhere in the batch, at its worst."""
    tables: dict[str, list[SiteTable]] = {}
    for table in batch.sites():
        if len(table) and table.primitive.parameters:
            tables.setdefault(table.primitive.name, []).append(table)
    return [found for own in tables.values() if (found := _look_at(own)) is not None]


def _look_at(tables: list[SiteTable]) -> Untested | None:
    """The worst of the values of one primitive, in all of its places together."""
    primitive = tables[0].primitive
    every = [np.stack([table.params[name] for name in primitive.parameters], axis=1) for table in tables]
    values, first = np.unique(np.concatenate(every), axis=0, return_index=True)
    low, high = np.array(primitive.test).T
    share = np.maximum(low - values, values - high) / np.maximum(high - low, 1e-12)  # how far out of its range
    out = share.max(axis=1) > 1e-9
    values, share, first = values[out], share[out], first[out]
    if not len(values):
        return None
    asked = {name: values[:, k] for k, name in enumerate(primitive.parameters)}
    least, most = bounds(primitive, asked)
    surface, piece, size = np.zeros((3, len(values)))
    for group in mesh.build(primitive, asked, _STEPS):
        surface[group.rows] = _beyond(group.vertices, least[group.rows], most[group.rows])
        size[group.rows] = np.ptp(group.vertices, axis=1).max(axis=1)
    start = np.cumsum([0, *(len(own) for own in every)])
    looked = np.full(start[-1], -1)  # for each row of the tables, one after the other, its row of ``values``
    looked[first] = np.arange(len(values))
    scatter(tables)  # all that the check of the batch needs, too; without faces, which take long
    for table, begin in zip(tables, start.tolist(), strict=False):
        for cloud in table.clouds:
            rows = looked[cloud.rows + begin]
            at = np.flatnonzero(rows >= 0)
            rows = rows[at]
            np.maximum.at(piece, rows, _beyond(cloud.points[at], least[rows], most[rows]))
    reach = np.maximum(np.where(surface > _BEYOND * size, surface, 0), np.where(piece > _PIECE * size, piece, 0))
    row = int(np.argmax(reach))
    if reach[row] <= 0:
        return None
    own = int(np.argmax(share[row]))
    name, value = primitive.parameters[own], float(values[row, own])
    of_piece = bool(surface[row] < reach[row])
    part = tables[int(np.searchsorted(start, first[row], side="right")) - 1].path
    return Untested(part, of_piece, primitive.name, name, value, primitive.test[own], float(reach[row]))


def _beyond(vertices: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(rows,) how far vertices (rows, n, 3) lie outside of boxes (rows, 3), at most; negative within."""
    found: np.ndarray = np.maximum(low - vertices.min(axis=1), vertices.max(axis=1) - high).max(axis=1)
    return found
