"""What is known of points that rays have met: place, exact normal, classes and labels, part coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..geometry.block import to_local
from ..geometry.bound import normals_at
from ..geometry.patches import inside_split
from ..records import dataclass
from .frames import rotate, rotate_rows, unrotate
from .points import Labels, label_points
from .poses import centers_of, diagonal

if TYPE_CHECKING:
    from ..runtime.batch import Batch
    from .soup import Soup


@dataclass(frozen=True, slots=True)
class SoupHits:
    """n points on triangles of a soup: ``triangle`` (n,), barycentric ``weights`` (n, 3) of its corners."""

    triangle: np.ndarray
    weights: np.ndarray

    def blend(self, values: np.ndarray) -> np.ndarray:
        """(n, c): the weighted sums of values (T, 3, c) at the corners of all triangles."""
        out = np.empty((len(self.triangle), values.shape[2]))
        weights = [np.ascontiguousarray(self.weights[:, k]) for k in range(3)]
        for axis in range(values.shape[2]):
            a, b, c = (np.ascontiguousarray(values[:, k, axis])[self.triangle] for k in range(3))
            out[:, axis] = a * weights[0] + b * weights[1] + c * weights[2]
        return out

    def take(self, at: np.ndarray) -> SoupHits:
        return SoupHits(self.triangle[at], self.weights[at])


@dataclass(frozen=True, slots=True)
class BoundHits:
    """The points of hits as ``label_points`` wants them: bound to the rows of the site tables, at joint values 0."""

    site: np.ndarray
    row: np.ndarray
    patch: np.ndarray
    u: np.ndarray
    v: np.ndarray
    position: np.ndarray
    normal: np.ndarray

    def take(self, at: np.ndarray) -> BoundHits:
        return BoundHits(*(getattr(self, name)[at] for name in self.__slots__))


def bind_hits(soup: Soup, hits: SoupHits) -> BoundHits:
    """Place on the triangle, normal of the surface that it stands for."""
    row, patch = soup.row[hits.triangle], soup.patch[hits.triangle]
    uv = np.clip(hits.blend(soup.uv), 0.0, 1.0)
    normal = normals_at(soup.rows, row, patch, uv[:, 0], uv[:, 1])
    position = hits.blend(soup.corner)
    return BoundHits(soup.rows.site[row], soup.rows.row[row], patch, uv[:, 0], uv[:, 1], position, normal)


def part_coordinates(batch: Batch, part: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Normalised part coordinates (n, 3) of points at joint values 0, each of a row ``part`` (n,) of the batch's."""
    parts = batch.parts()
    scale = diagonal(parts.high - parts.low)
    scale = np.where(scale > 0, scale, 1.0)
    back = np.swapaxes(parts.rotation, -1, -2)
    return rotate_rows(back, part, points - centers_of(parts).take(part, axis=0)) / scale.take(part)[:, None]


def read_classes(batch: Batch, points: BoundHits) -> np.ndarray:
    """Semantic classes (n,)."""
    wanted = [label for label in batch.program.labels if label.vocabulary == "semantic"]
    return label_points(batch, batch.sites(), points, wanted).semantic


def read_labels(batch: Batch, points: BoundHits) -> Labels:
    """All labels (n,)."""
    return label_points(batch, batch.sites(), points)


def is_amid_solids(
    made: Soup, index: int, rotation: np.ndarray, translation: np.ndarray, places: np.ndarray
) -> np.ndarray:
    """(V,) bool: which ``places`` (V, 3) lie within a solid of the object ``index`` of a soup, its links carried by
    ``rotation`` and ``translation``."""
    return np.asarray(links_around(made, index, rotation, translation, places).any(axis=0))


def links_around(
    made: Soup, index: int, rotation: np.ndarray, translation: np.ndarray, places: np.ndarray
) -> np.ndarray:
    """(L, V) bool: within a solid of which link of the batch each place lies, as of ``is_amid_solids``."""
    rows = made.rows
    link = np.zeros(len(rows.owner), dtype=np.int64)
    link[made.row] = made.link
    out = np.zeros((len(rotation), len(places)), dtype=bool)
    for shelf in rows.shelves:
        row = np.repeat(shelf.start + np.flatnonzero(rows.owner[shelf.start : shelf.stop] == index), len(places))
        which = np.tile(np.arange(len(places)), len(row) // max(len(places), 1))
        back = unrotate(rotation[link[row]], places[which] - translation[link[row]])
        local = to_local((rows.rotation, rows.translation, rows.mirror), row, back.T)
        split = inside_split(shelf.primitive)
        depth = split.points([r[row - shelf.start] for r in split.rows(shelf.params)], *local)[0]
        inside = np.broadcast_to(depth, row.shape) < 0.0
        out[link[row[inside]], which[inside]] = True
    return out


def carry_vectors(
    rotation: np.ndarray, translation: np.ndarray | None, link: np.ndarray, vectors: np.ndarray
) -> np.ndarray:
    """Vectors (n, ..., 3) moved with the links (n,); directions without a translation."""
    if vectors.ndim == 2:
        return rotate_rows(rotation, link, vectors, translation)
    spread = link.reshape(link.shape + (1,) * (vectors.ndim - 2))
    out = rotate(rotation[spread], vectors)
    return out if translation is None else out + translation[spread]
