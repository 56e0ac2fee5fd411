"""Places spread over every patch of some rows, and which of them can be seen.

They are evenly spread over the fractions of a patch, not over its area: they tell what there is on a surface, whatever its size.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..records import dataclass
from .block import block_of, to_object
from .cover import Cover, meeting_rows, scales
from .patches import find_existing, surfaces
from .pointset import PointSet
from .sites import SiteTable
from .surface import PatchEvaluator

_GOLDEN = (5.0**0.5 - 1.0) / 2.0


@lru_cache(maxsize=64)
def _fractions(many: int) -> tuple[np.ndarray, np.ndarray]:
    """A lattice of places in the unit square, no two of which are on one line along an axis: narrow strips have theirs."""
    step = np.arange(many)
    return (step + 0.5) / many, (0.5 + _GOLDEN * step) % 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Spread:
    """``points`` (m, 1) on rows of a block (m,), which is what hides some of them."""

    points: PointSet
    _cover: Cover
    _row: np.ndarray

    def seen(self, which: np.ndarray) -> np.ndarray:
        """(k,) bool: whether the places ``which`` (k,) are on the boundary of the union of the primitives."""
        position, normal = (getattr(self.points, name)[which, 0].T for name in ("position", "normal"))
        return ~self._cover.hidden(self._row[which], position, normal)


def spread(sites: list[SiteTable], chosen: list[np.ndarray], first: int, stop: int, most: int) -> Spread:
    """Places on the rows ``chosen`` (k,) bool of the site tables, of the objects ``first .. stop - 1``: as many on each
    patch, ``most`` on a row at most, as far as that is one for each patch.

    Patches that do not exist, or have no area at a place, have none there.
    """
    rows = block_of(sites, first, stop)
    asked = np.zeros(len(rows.owner), dtype=bool)
    for site, own in zip(sites, chosen, strict=True):
        mine = rows.site == site.number
        asked[mine] = own[rows.row[mine]]
    off = scales(rows)
    cover = Cover(rows, off, meeting_rows(rows, off, asked))
    columns: list[tuple[np.ndarray, ...]] = []
    for shelf in rows.shelves:
        part = slice(shelf.start, shelf.stop)
        there = find_existing(shelf.primitive, shelf.params) & asked[part, None]
        u, v = _fractions(max(1, most // len(surfaces(shelf.primitive))))
        for patch in range(there.shape[1]):
            own = np.flatnonzero(there[:, patch])
            if not len(own):
                continue
            params = {name: value[own] for name, value in shelf.params.items()}
            local, many = np.repeat(np.arange(len(own)), len(u)), len(own)
            surface = PatchEvaluator(shelf.primitive, patch, params)
            at, normal = surface.at(local, np.tile(u, many), np.tile(v, many))
            row = shelf.start + own[local]
            at, normal = to_object(cover.poses, row, at, normal)
            whole = np.flatnonzero(np.isfinite(normal[0] + normal[1] + normal[2]))
            where = (np.tile(u, many), np.tile(v, many), *at, *normal)
            columns.append((row[whole], np.full(len(whole), patch), *(column[whole] for column in where)))
    if not columns:
        return Spread(PointSet.empty(0, 1), cover, np.zeros(0, dtype=np.int64))
    row, on, across, along, *ends = (np.concatenate(column) for column in zip(*columns, strict=True))
    bound = (rows.site[row].astype(np.int32), rows.row[row].astype(np.int32), on.astype(np.int16), across, along)
    vectors = (np.stack(ends[:3], axis=-1), np.stack(ends[3:], axis=-1))
    return Spread(PointSet(*(column[:, None] for column in (*bound, *vectors))), cover, row)
