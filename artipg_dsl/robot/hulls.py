"""The convex hulls that stand for several pieces of an object: which pieces, and their corners and faces."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from functools import cache, cached_property

import numpy as np

from ..geometry.collide import inset
from ..geometry.merge import Cluster, cluster_units, cut, gather_clusters, halves
from ..geometry.runs import changes, runs
from ..geometry.stock import Stock
from ..geometry.vectors import extent
from ..geometry.wrap import wrap_all
from ..records import dataclass
from . import solids

_BUDGET = 60  # colliders of an object
STEPS = (0.002, 0.004, 0.008, 0.016, 0.03)  # of the diagonal of the object's box
Item = solids.Item[solids.ShapedPieces]


class Gathered:
    """The convex pieces of a batch by their numbers: in the order of objects, sites, rows and pieces within a row; those of object
    ``i`` from ``first[i]`` on. ``materials`` by site: what each row is made of."""

    def __init__(self, groups: list[solids.ShapedPieces], n_objects: int, materials: dict[int, np.ndarray]):
        self._groups = groups
        self._which, self._k, self._row, self.owner = solids.order_by_object(groups)
        self.first = np.searchsorted(self.owner, np.arange(n_objects + 1)).tolist()
        self._materials = materials

    def item(self, number: int) -> Item:
        """Where a piece is from."""
        return solids.Item(self._groups[self._which[number]], int(self._k[number]), int(self._row[number]))

    def _of_rows(self, columns: Sequence[np.ndarray]) -> np.ndarray:
        """What the rows of each group say, for all pieces."""
        start = np.cumsum([0, *map(len, columns)])
        return np.concatenate(columns)[start[self._which] + self._k]

    @cached_property
    def link(self) -> np.ndarray:
        """(n,) the number of the link of each piece."""
        return self._of_rows([group.table.link[group.rows] for group in self._groups])

    @cached_property
    def site(self) -> np.ndarray:
        """(n,) the number of the site of each piece."""
        return self._of_rows([group.table.site[group.rows] for group in self._groups])

    @cached_property
    def likeness(self) -> np.ndarray:
        """(n,) equal numbers for pieces of one site, link and material."""
        material = self._of_rows([self._materials[group.table.number][group.rows] for group in self._groups])
        return (self.site * (self.link.max() + 1) + self.link) * (material.max() + 1) + material

    @cached_property
    def stock(self) -> Stock:
        """All of them."""
        groups = self._groups
        planes = [group.planes for group in groups]
        triangles = [np.broadcast_to(group.faces, (len(group.rows), *group.faces.shape)) for group in groups]
        (points,), point_start = self._in_order([group.vertices for group in groups])
        (triangle, normal, offset), face_start = self._in_order(
            triangles, [normals for normals, _ in planes], [offsets for _, offsets in planes]
        )
        new = changes(self.site) | changes(self._row)
        name, index = (self._of_rows([getattr(g, of) for g in groups]) for of in ("name", "index"))
        return Stock(points, point_start, triangle, normal, offset, face_start, np.cumsum(new), name, index)

    def _in_order(self, *columns: Sequence[np.ndarray]) -> tuple[list[np.ndarray], np.ndarray]:
        """Columns of groups (k, m, ...), one after the other (m of all pieces, ...), and where those of each piece begin."""
        each = np.array([values.shape[1] for values in columns[0]])
        base = np.cumsum([0, *(values.shape[0] * values.shape[1] for values in columns[0])])
        count = each[self._which]
        at = runs(base[self._which] + self._k * count, count)
        flat = [np.concatenate([part.reshape(-1, *part.shape[2:]) for part in parts]) for parts in columns]
        return [values.take(at, axis=0) for values in flat], np.concatenate([[0], np.cumsum(count)])


@dataclass(slots=True, eq=False)
class Hull:
    """One collider: its first piece, the numbers of all its pieces, and where these are several, corners (P, 3) in the object's
    frame and faces, which ``wrap`` finds.

    ``cut``: what would fill a hollow is cut off, and with it some of the pieces. ``inner`` (P, 3): its corners moved inwards, so that
    what touches does not meet; ``shrink`` finds them.
    """

    item: Item
    pieces: Cluster
    corners: np.ndarray | None = None
    triangles: np.ndarray | None = None
    cut: bool = False
    inner: np.ndarray | None = None

    @property
    def vertices(self) -> np.ndarray:
        """Corners (P, 3) in the object's frame."""
        return self.item.group.vertices[self.item.k] if self.corners is None else self.corners

    @property
    def faces(self) -> np.ndarray:
        """Outward triangles (F, 3)."""
        return self.item.group.faces if self.triangles is None else self.triangles


class Body:
    """The pieces of one object, by their numbers, and the hulls in place of them."""

    def __init__(self, gathered: Gathered, first: int, last: int):
        self._gathered = gathered
        pieces = np.arange(first, last)
        self.merged = len(pieces) > _BUDGET
        if not self.merged:
            self.hulls = [self._hull(pieces[k : k + 1]) for k in range(len(pieces))]
            return
        stock = gathered.stock
        tolerances = _tolerances(stock.points[stock.point_start[first] : stock.point_start[last]])

        @cache
        def merged(tolerance: float) -> np.ndarray:
            found = cluster_units(stock, pieces, tolerance)
            return found if found.max() < _BUDGET else _rows(gathered, pieces, found, tolerance)

        least = bisect_left(tolerances[:-1], True, key=lambda tolerance: merged(tolerance).max() < _BUDGET)
        self.tolerance, self.small = tolerances[least], tolerances[-1]
        found = merged(self.tolerance)
        order = np.argsort(found, kind="stable")
        self.hulls = [self._hull(some) for some in np.split(pieces[order], np.cumsum(np.bincount(found))[:-1])]

    def _hull(self, pieces: Cluster) -> Hull:
        return Hull(self._gathered.item(int(pieces[0])), pieces)

    def reduce(self, hulls: set[Hull]) -> set[Hull]:
        """Put less in place of hulls of several pieces: cut off what fills a hollow, else halve them; returns the new ones."""
        stock = self._gathered.stock
        kept: list[Hull] = []
        new: set[Hull] = set()
        for hull in self.hulls:
            if hull not in hulls:
                kept.append(hull)
                continue
            plane = None if hull.cut else cut(stock, hull.pieces, self.tolerance, self.small)
            less = [_without(hull, *plane)] if plane else [self._hull(half) for half in halves(stock, hull.pieces)]
            kept += less
            new.update(less)
        self.hulls = kept
        return new

    def in_order(self) -> list[Hull]:
        """The colliders, in the order of their first pieces."""
        return sorted(self.hulls, key=lambda hull: int(hull.pieces[0]))


def _rows(gathered: Gathered, pieces: Cluster, cluster: np.ndarray, tolerance: float) -> np.ndarray:
    """Which cluster (n,) each piece is of, where primitives of one site, link and material that are a hull each are put together
    where they stand close; from what they are of before, ascending with the primitives."""
    new = changes(gathered.stock.unit[pieces])
    unit, first = np.cumsum(new) - 1, np.flatnonzero(new)
    single = np.minimum.reduceat(cluster, first) == np.maximum.reduceat(cluster, first)
    _, kind, many = np.unique(
        np.where(single, gathered.likeness[pieces[first]], -1), return_inverse=True, return_counts=True
    )
    found = cluster.copy()
    for k in np.flatnonzero(many > 1).tolist():
        mine = np.flatnonzero((single & (kind == k))[unit])
        if len(mine):
            own = pieces[mine]
            start = gather_clusters(gathered.stock, own, np.flatnonzero(changes(unit[mine])), tolerance)
            found[mine] = found[mine[start]].repeat(np.append(start[1:], len(own)) - start)
    _, found = np.unique(found, return_inverse=True)
    return found


def _tolerances(points: np.ndarray) -> list[float]:
    """How far hulls may reach from the pieces of an object: more and more, metres."""
    low, high = extent(points)
    size = high - low
    diagonal = float(np.sqrt(size[0] ** 2 + size[1] ** 2 + size[2] ** 2))
    return [step * diagonal for step in STEPS]


def wrap(stock: Stock, hulls: Iterable[Hull]) -> None:
    """Find the corners and the outward faces of those hulls of several pieces that have none yet."""
    several = [hull for hull in hulls if len(hull.pieces) > 1 and hull.triangles is None]
    points = [stock.corners(hull.pieces) if hull.corners is None else hull.corners for hull in several]
    for hull, own, (used, faces) in zip(several, points, wrap_all(points), strict=True):
        hull.corners, hull.triangles = own[used], faces


def shrink(hulls: Iterable[Hull]) -> None:
    """Move the corners of those hulls of several pieces inwards that have none so yet."""
    left = [hull for hull in dict.fromkeys(hulls) if hull.inner is None and len(hull.pieces) > 1]
    if not left:
        return
    points, faces = [hull.vertices for hull in left], [hull.faces for hull in left]
    first = np.cumsum([0, *map(len, points)])
    triangles = np.concatenate(faces) + np.repeat(first[:-1], [len(own) for own in faces])[:, None]
    moved = inset(np.concatenate(points), first[:-1], triangles)
    for hull, start, stop in zip(left, first[:-1].tolist(), first[1:].tolist(), strict=True):
        hull.inner = moved[start:stop]


def _without(hull: Hull, normal: np.ndarray, offset: float) -> Hull:
    """A hull without what lies beyond a plane: what is left of its corners, and where its edges cross the plane."""
    points = hull.vertices
    beyond = points[:, 0] * normal[0] + points[:, 1] * normal[1] + points[:, 2] * normal[2] - offset
    start, end = hull.faces.ravel(), np.roll(hull.faces, -1, axis=1).ravel()
    crossing = (beyond[start] <= 0) & (beyond[end] > 0)  # of the two ways along an edge the one that leads beyond
    start, end = start[crossing], end[crossing]
    share = beyond[start] / (beyond[start] - beyond[end])
    edge = points[start] + share[:, None] * (points[end] - points[start])
    return Hull(hull.item, hull.pieces, np.concatenate([points[beyond <= 0], edge]), cut=True)
