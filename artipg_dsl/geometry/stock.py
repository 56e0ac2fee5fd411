"""Convex pieces of many objects, one after the other in arrays; a piece is told by its number."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..native.calls import address
from ..records import dataclass
from .collide import inset
from .runs import runs


@dataclass(frozen=True, eq=False)
class Stock:
    """Pieces (n,): corners (P, 3), those of piece ``k`` from ``point_start[k]`` to ``point_start[k + 1]``, and likewise faces: outward
    ``triangles`` (F, 3) of its corners, counted within the piece, normals (F, 3), offsets (F,).

    ``unit`` numbers its primitive, ascending, ``name`` the piece within the primitive, ``index`` the step around or along it.
    """

    points: np.ndarray
    point_start: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    offsets: np.ndarray
    face_start: np.ndarray
    unit: np.ndarray
    name: np.ndarray
    index: np.ndarray

    @cached_property
    def places(self) -> tuple[int, int, int, int, int]:
        """Addresses of corners, normals, offsets and of where they begin, as compiled code takes them."""
        arrays = self.points, self.point_start, self.normals, self.offsets, self.face_start
        assert all(a.flags.c_contiguous and a.itemsize == 8 for a in arrays)
        one, two, three, four, five = (address(a) for a in arrays)
        return one, two, three, four, five

    def sizes(self, pieces: np.ndarray) -> np.ndarray:
        """How many corners (k,) some pieces have."""
        counts: np.ndarray = self.point_start[pieces + 1] - self.point_start[pieces]
        return counts

    def corners(self, pieces: np.ndarray) -> np.ndarray:
        """The corners (P, 3) of some pieces, in their order."""
        return self.points.take(_within(self.point_start, pieces), axis=0)

    def faces(self, pieces: np.ndarray) -> np.ndarray:
        """The numbers (F,) of the faces of some pieces, in their order."""
        return _within(self.face_start, pieces)

    @cached_property
    def known(self) -> dict[bytes, tuple[float, int]]:
        """How far hulls reach, and beyond which face, of what was asked."""
        return {}

    @cached_property
    def _inner(self) -> tuple[np.ndarray, np.ndarray]:
        return np.empty_like(self.points), np.zeros(len(self.unit), dtype=bool)

    def inner(self, pieces: np.ndarray) -> np.ndarray:
        """The corners (P, 3) of some pieces, moved inwards so that what touches does not meet."""
        inner, known = self._inner
        new = np.unique(pieces[~known[pieces]])
        if len(new):
            at, faces = _within(self.point_start, new), _within(self.face_start, new)
            counts = self.sizes(new)
            first = np.cumsum(counts) - counts
            shift = np.repeat(first, self.face_start[new + 1] - self.face_start[new])
            inner[at] = inset(self.points.take(at, axis=0), first, self.triangles.take(faces, axis=0) + shift[:, None])
            known[new] = True
        return inner.take(_within(self.point_start, pieces), axis=0)


def _within(start: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """The numbers from ``start[k]`` to before ``start[k + 1]`` of each of the ``chosen`` k, one after the other."""
    first = start[chosen]
    return runs(first, start[chosen + 1] - first)
