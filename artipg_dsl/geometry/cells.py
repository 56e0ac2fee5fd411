"""Cells: the patches of all rows of a block, placed in the frames of their objects.

A cell stands for one patch of one row, whether it exists or not (its area is then 0). Cells are sorted by object, pool,
rank of the row and patch, so that the points on them are the points of a pool in order.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..records import dataclass
from .block import Block, Coordinates, Shelf, to_object
from .density import patch_area
from .flat import BENT, PLANAR, quads, shapes
from .patches import find_existing, surfaces
from .split import Params
from .surface import PatchEvaluator
from .topology import orientation

_CHUNK = 8192  # cells at a time: their arrays stay in the cache


@dataclass(frozen=True, slots=True, eq=False)
class Bent:
    """The cells of one patch that is not flat: those of all rows of a shelf."""

    shelf: Shelf
    patch: int
    cell: np.ndarray  # (k,)


class Cells:
    """The cells of a block. Vectors are three arrays (C,) in the frames of the objects.

    ``origin``, ``a``, ``b``, ``c`` give the quad of a flat cell; ``shape`` tells which are flat. ``pool`` (R,) of the
    ``pools`` that the rows belong to, ascending with their objects; without it each object is one.
    """

    def __init__(self, rows: Block, pool: np.ndarray | None = None, pools: int = 0):
        self.rows = rows
        self.poses = (rows.rotation, rows.translation, rows.mirror)
        patches = np.concatenate(
            [np.empty(0, np.int64), *(np.full(s.stop - s.start, len(surfaces(s.primitive))) for s in rows.shelves)]
        )
        pool, pools = (rows.owner, rows.objects) if pool is None else (pool, pools)
        order = np.lexsort((rows.rank, pool))
        counts = patches[order]
        first = np.cumsum(counts) - counts
        self.first = np.empty_like(first)  # (R,) the first cell of each row
        self.first[order] = first
        self.row = np.repeat(order, counts)
        self.patch = np.arange(len(self.row)) - np.repeat(first, counts)
        self.owner = rows.owner[self.row]
        self.pool = pool[self.row]
        self.start = np.searchsorted(self.pool, np.arange(pools + 1))  # of the cells of each pool
        size = len(self.row)
        self.shape = np.full(size, BENT, dtype=np.int8)
        self.origin, self.a, self.b, self.c, self.normal = (np.zeros((3, size)) for _ in range(5))
        self.element = np.zeros((3, size))  # of a flat cell at (0, 0), and its growth along u and along v
        self.area = np.empty(size)
        self.exists = np.ones(size, dtype=bool)
        for shelf in rows.shelves:
            self._place_flat(shelf)
        for start in range(0, size, _CHUNK):
            self._complete_flat(slice(start, start + _CHUNK))
        self.bent = [b for shelf in rows.shelves for b in self._bent(shelf)]

    def _place_flat(self, shelf: Shelf) -> None:
        """Quads of one shelf, turned into the frames of the objects."""
        numbers, own = quads(shelf.primitive, shelf.params)
        flat = np.array(numbers, dtype=np.int64)
        kinds, sign = shapes(shelf.primitive)[flat], orientation(shelf.primitive)[flat]
        step = max(1, _CHUNK // (4 * max(1, len(flat))))
        for start in range(shelf.start, shelf.stop, step):
            part = slice(start, min(start + step, shelf.stop))
            mine = own[:, :, start - shelf.start : part.stop - shelf.start]
            cell = (self.first[part, None] + flat).ravel()
            self.shape[cell] = np.tile(kinds, part.stop - start)
            rotation, translation, mirror = (p[..., part, None] for p in self.poses)
            y = mine[:, 1] * mirror
            for axis in range(3):
                p, q, r = rotation[3 * axis], rotation[3 * axis + 1], rotation[3 * axis + 2]
                placed = p * mine[:, 0] + q * y + r * mine[:, 2]
                self.origin[axis][cell] = (placed[0] + translation[axis]).ravel()
                for k, into in ((1, self.a), (2, self.b), (3, self.c)):
                    into[axis][cell] = placed[k].ravel()
            self.normal[0][cell] = (mirror * sign).ravel()
        part = slice(shelf.start, shelf.stop)
        if any(s.guard is not None for s in surfaces(shelf.primitive)):
            here = self.first[part, None] + np.arange(len(surfaces(shelf.primitive)))
            self.exists[here] = find_existing(shelf.primitive, shelf.params)

    def _complete_flat(self, part: slice) -> None:
        """Normals and areas of some cells, as far as they are flat, from their quads."""
        a, b, sign = self.a[:, part], self.b[:, part], self.normal[0, part].copy()
        element = self.element[:, part]
        planar = np.flatnonzero(self.shape[part] == PLANAR)
        middle = _cross(a, b)
        bend = self.c[:, part].take(planar, axis=1)
        along_u, along_v = _cross(a.take(planar, axis=1), bend), _cross(bend, b.take(planar, axis=1))
        for axis in range(3):
            middle[axis][planar] += along_u[axis] / 2 + along_v[axis] / 2
        length = np.sqrt(middle[0] * middle[0] + middle[1] * middle[1] + middle[2] * middle[2])
        unit = 1.0 / np.where(length > 0.0, length, 1.0)
        normal = [m * unit for m in middle]
        element[0] = length
        for k, growth in ((1, along_u), (2, along_v)):
            element[k, planar] = sum(g * n[planar] for g, n in zip(growth, normal, strict=True))
        element[0, planar] -= element[1, planar] / 2 + element[2, planar] / 2
        self.area[part] = np.where(self.exists[part], length, 0.0)
        for axis in range(3):
            self.normal[axis, part] = normal[axis] * sign

    def _bent(self, shelf: Shelf) -> list[Bent]:
        chosen = np.flatnonzero(shapes(shelf.primitive) == BENT).tolist()
        return [Bent(shelf, patch, self.first[shelf.start : shelf.stop] + patch) for patch in chosen]

    def measure_bent(self, asked: np.ndarray | None = None) -> None:
        """Enter the areas of the bent cells; where not all pools are ``asked`` (pools,) bool, the cells of others have none."""
        mine = np.ones(len(self.area), dtype=bool) if asked is None else asked[self.pool]
        self.area[~mine] = 0.0
        for bent in self.bent:
            at = np.flatnonzero(mine[bent.cell])
            if len(at):
                params = {name: value[at] for name, value in bent.shelf.params.items()}
                self.area[bent.cell[at]] = patch_area(bent.shelf.primitive, bent.patch, params)

    def flat_position(self, cell: np.ndarray, u: np.ndarray, v: np.ndarray) -> Coordinates:
        """Positions on flat cells at fractions; what it gives on bent ones is void."""
        out = [self.origin[k][cell] + u * self.a[k][cell] + v * self.b[k][cell] for k in range(3)]
        planar = np.flatnonzero(self.shape[cell] == PLANAR)
        if len(planar):
            both, where = u[planar] * v[planar], cell[planar]
            for k in range(3):
                out[k][planar] += both * self.c[k][where]
        return out[0], out[1], out[2]

    def bent_position(
        self, bent: Bent, cell: np.ndarray, u: np.ndarray, v: np.ndarray
    ) -> tuple[Coordinates, Coordinates]:
        """Positions and outward normals at fractions of cells that all belong to ``bent``."""
        row, local, params = self.rows_asked(bent, cell)
        at, normal = PatchEvaluator(bent.shelf.primitive, bent.patch, params).at(local, u, v)
        return to_object(self.poses, row, at, normal)

    def by_bent(self, cell: np.ndarray) -> Iterator[tuple[Bent, np.ndarray]]:
        """Those of some cells that are bent, patch by patch: the places among these (m,), ascending."""
        number = np.full(len(self.shape), -1)
        for k, bent in enumerate(self.bent):
            number[bent.cell] = k
        own = number[cell]
        at = np.flatnonzero(own >= 0)
        at = at[np.argsort(own[at], kind="stable")]
        begin = np.searchsorted(own[at], np.arange(len(self.bent) + 1))
        for bent, first, last in zip(self.bent, begin.tolist(), begin[1:].tolist(), strict=False):
            if last > first:
                yield bent, at[first:last]

    def rows_asked(self, bent: Bent, cell: np.ndarray) -> tuple[np.ndarray, np.ndarray, Params]:
        """Rows of cells of ``bent``; the same among the rows that are named at all, and the parameters of those."""
        row = self.row[cell]
        asked = np.zeros(len(bent.cell), dtype=bool)
        asked[row - bent.shelf.start] = True
        local = (np.cumsum(asked) - 1)[row - bent.shelf.start]
        return row, local, {name: value[asked] for name, value in bent.shelf.params.items()}

    def bounds(self, cell: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(3, m) boxes of flat cells in the frames of their objects."""
        low, high = np.empty((3, len(cell))), np.empty((3, len(cell)))
        for axis in range(3):
            origin, a, b = self.origin[axis][cell], self.a[axis][cell], self.b[axis][cell]
            far = a + b + self.c[axis][cell]
            low[axis] = origin + np.minimum(np.minimum(a, b), np.minimum(far, 0.0))
            high[axis] = origin + np.maximum(np.maximum(a, b), np.maximum(far, 0.0))
        return low, high


def _cross(a: np.ndarray, b: np.ndarray) -> list[np.ndarray]:
    return [a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3] for k in range(3)]
