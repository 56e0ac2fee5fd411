"""Meshes of many primitives as one list of vertices, of corners of patches, and of faces: what is moved by details."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from scipy.sparse import csr_matrix

from ..geometry.sites import SiteTable
from ..geometry.vectors import dot
from ..records import dataclass
from .elements import Elements

_TIE = 1e-4  # diagonals
_NEAR = 1e-6  # metres: what is nearer counts no more


class Grid(Protocol):
    """Closed meshes of instances ``rows`` (k,) of one site, with common ``faces`` (F, 3), outward, and vertices (k, V, 3) in the frames of
    their objects; ``face_uv`` (F, 3, 2): fractions of the corners on the patch ``face_patch`` (F,)."""

    @property
    def table(self) -> SiteTable: ...
    @property
    def rows(self) -> np.ndarray: ...
    @property
    def vertices(self) -> np.ndarray: ...
    @property
    def faces(self) -> np.ndarray: ...
    @property
    def face_patch(self) -> np.ndarray: ...
    @property
    def face_uv(self) -> np.ndarray: ...


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """V vertices at ``place`` (V, 3) of ``element`` (V,); C corners, each of one ``patch`` at one ``vertex`` with fractions ``u``, ``v``;
    ``faces`` (F, 3) by their vertices, and by their ``corners`` (F, 3)."""

    place: np.ndarray
    element: np.ndarray
    vertex: np.ndarray
    patch: np.ndarray
    u: np.ndarray
    v: np.ndarray
    faces: np.ndarray
    corners: np.ndarray

    def __len__(self) -> int:
        return len(self.place)


def gather(grids: Sequence[Grid], elements: Elements) -> Skin:
    """The meshes one after the other; where each begins depends on those before it alone."""
    columns: list[tuple[np.ndarray, ...]] = []
    vertices = corners = 0
    for grid in grids:
        table, rows = grid.table, grid.rows
        count, many = grid.vertices.shape[:2]
        site = np.full(count, table.number)
        element = elements.find(table.owner[rows], site, table.rank[rows])
        code = (grid.face_patch.astype(np.int64)[:, None] * many + grid.faces).ravel()
        keys, first, own = np.unique(code, return_index=True, return_inverse=True)
        patch, vertex = np.divmod(keys, many)
        u, v = grid.face_uv.reshape(-1, 2)[first].T
        which = np.arange(count)
        begin, start = vertices + many * which, corners + len(keys) * which
        columns.append(
            (
                grid.vertices.reshape(-1, 3),
                np.repeat(element, many),
                (vertex + begin[:, None]).ravel(),
                *(np.tile(values, count) for values in (patch, u, v)),
                (grid.faces + begin[:, None, None]).reshape(-1, 3),
                (own.reshape(-1, 3) + start[:, None, None]).reshape(-1, 3),
            )
        )
        vertices, corners = vertices + many * count, corners + len(keys) * count
    return Skin(*(np.concatenate(column) for column in zip(*columns, strict=True)))


def neighbours(faces: np.ndarray, place: np.ndarray) -> csr_matrix:
    """(m, m): the mean over what shares an edge of ``faces`` (F, 3) with each of m places (m, 3), by the inverse of how far it is: around
    the pole of a cap the next of a ring count more than the next ring."""
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    pairs, count = (np.concatenate([start, end]), np.concatenate([end, start])), len(place)
    found = csr_matrix((np.ones(len(pairs[0])), pairs), shape=(count, count))
    several = np.diff(found.indptr)
    row = np.repeat(np.arange(count), several)
    way = place[found.indices] - place[row]
    found.data[:] = 1.0 / np.maximum(np.sqrt(dot(way, way)), _NEAR)
    found.data /= np.bincount(row, found.data, count)[row]
    return found


def tie_breakers(mesh: np.ndarray) -> np.ndarray:
    """(m, 1) a small number for each of m places, other ones within a ``mesh`` (m,), the same whatever meshes are there beside it. As one
    more coordinate of what is searched it decides between places that are equally near, of which grids have many."""
    _, first, own = np.unique(mesh, return_index=True, return_inverse=True)
    rank = np.arange(len(mesh)) - first[own]
    return _TIE * ((rank[:, None] * 0.6180339887498949) % 1.0)


def total(of: np.ndarray, vectors: np.ndarray, count: int) -> np.ndarray:
    """(count, 3) sums of vectors (m, 3), each added to what it is ``of`` (m,)."""
    return np.stack([np.bincount(of, vectors[:, k], count) for k in range(3)], axis=-1)
