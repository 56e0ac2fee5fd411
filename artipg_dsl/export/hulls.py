"""The convex hulls that stand for several pieces of an object: which pieces, and their corners and faces."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..geometry.merge import Cluster, Convex, clusters, cut, gather_clusters, halves
from ..geometry.vectors import cross, dot
from ..native.gaps import Stock
from . import solids

BUDGET = 60  # colliders of an object
STEPS = (0.002, 0.004, 0.008, 0.016, 0.03)  # of the diagonal of the object's box
Item = solids.Item[solids.ShapedPieces]


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """One collider: its first piece, and where it has several, these, its corners (P, 3) in the object's frame and faces.

    ``cut``: what would fill a hollow is cut off, and with it some of the pieces.
    """

    item: Item
    pieces: Cluster
    corners: np.ndarray | None = None
    triangles: np.ndarray | None = None
    cut: bool = False

    @property
    def vertices(self) -> np.ndarray:
        """Corners (P, 3) in the object's frame."""
        return self.item.group.vertices[self.item.k] if self.corners is None else self.corners

    @property
    def faces(self) -> np.ndarray:
        """Outward triangles (F, 3)."""
        return self.item.group.faces if self.triangles is None else self.triangles


class Body:
    """The pieces of one object and the hulls in place of them; ``materials`` by site: what each row is made of."""

    def __init__(self, items: list[Item], materials: dict[int, np.ndarray]):
        pieces = list(_pieces(items))
        self._order = {id(piece): k for k, piece in enumerate(pieces)}
        if len(pieces) <= BUDGET:
            self.hulls = [_hull((piece,)) for piece in pieces]
            return
        points = np.concatenate([piece.points for piece in pieces])
        extent = points.max(axis=0) - points.min(axis=0)
        diagonal = float(np.sqrt(extent[0] ** 2 + extent[1] ** 2 + extent[2] ** 2))
        units: dict[int, list[Convex]] = {}
        for piece in pieces:
            units.setdefault(piece.unit, []).append(piece)
        tolerances = [step * diagonal for step in STEPS]

        @cache
        def merged(tolerance: float) -> list[Cluster]:
            found = [clusters(unit, tolerance) for unit in units.values()]
            if sum(map(len, found)) > BUDGET:
                found = _rows(found, tolerance, materials)
            return [cluster for unit in found for cluster in unit]

        least = bisect_left(tolerances[:-1], True, key=lambda tolerance: len(merged(tolerance)) <= BUDGET)
        self.tolerance, self.small = tolerances[least], tolerances[-1]
        self.hulls = [_hull(cluster) for cluster in merged(self.tolerance)]

    def reduce(self, hulls: set[Hull]) -> set[Hull]:
        """Put less in place of hulls of several pieces: cut off what fills a hollow, else halve them; returns the new ones."""
        kept: list[Hull] = []
        new: set[Hull] = set()
        for hull in self.hulls:
            if hull not in hulls:
                kept.append(hull)
                continue
            plane = None if hull.cut else cut(hull.pieces, self.tolerance, self.small)
            less = [_hull(half) for half in halves(hull.pieces)] if plane is None else [_without(hull, *plane)]
            kept += less
            new.update(less)
        self.hulls = kept
        return new

    def in_order(self) -> list[Hull]:
        """The colliders, in the order of their first pieces."""
        return sorted(self.hulls, key=lambda hull: self._order[id(hull.pieces[0])])


def _rows(found: list[list[Cluster]], tolerance: float, materials: dict[int, np.ndarray]) -> list[list[Cluster]]:
    """Primitives of one site, link and material that are a hull each, put together where they stand close."""
    single: dict[tuple[int, int, int], list[Cluster]] = {}
    others = []
    for parts in found:
        item = parts[0][0].source
        table = item.group.table
        key = (table.number, int(table.link[item.row]), int(materials[table.number][item.row]))
        if len(parts) == 1:
            single.setdefault(key, []).append(parts[0])
        else:
            others.append(parts)
    return [*(gather_clusters(parts, tolerance) for parts in single.values()), *others]


def _pieces(items: list[Item]) -> Iterator[Convex]:
    shapes = [(item.group.vertices[item.k], *(a[item.k] for a in item.group.planes)) for item in items]
    stock = Stock(*zip(*shapes, strict=True)) if len(items) > BUDGET else None
    first, unit = (-1, -1), -1
    for k, item in enumerate(items):
        group = item.group
        if (group.table.number, item.row) != first:
            first, unit = (group.table.number, item.row), k  # a primitive is named after its first piece
        corners, normals, offsets = shapes[k]
        yield Convex(corners, normals, offsets, unit, group.name, int(group.index[item.k]), item, stock, k)


def _hull(cluster: Cluster) -> Hull:
    """The hull of a cluster; faces turn outwards."""
    if len(cluster) == 1:
        return Hull(cluster[0].source, cluster)
    return Hull(cluster[0].source, cluster, *_wrapped(np.concatenate([piece.points for piece in cluster])))


def _without(hull: Hull, normal: np.ndarray, offset: float) -> Hull:
    """A hull without what lies beyond a plane."""
    points = hull.vertices
    beyond = points[:, 0] * normal[0] + points[:, 1] * normal[1] + points[:, 2] * normal[2] - offset
    kept, lost = points[beyond <= 0], points[beyond > 0]
    inner, outer = beyond[beyond <= 0][:, None], beyond[beyond > 0]
    share = (inner / (inner - outer))[..., None]
    edge = kept[:, None] + share * (lost - kept[:, None])
    return Hull(hull.item, hull.pieces, *_wrapped(np.concatenate([kept, edge.reshape(-1, 3)])), cut=True)


def _wrapped(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (P, 3) and outward faces (F, 3) of the hull of points."""
    from scipy.spatial import ConvexHull  # late: importing the package must not load SciPy

    # neighbours share corners, which would cost more than all else
    once = np.unique(np.ascontiguousarray(points).view(f"V{3 * points.itemsize}").ravel(), return_index=True)[1]
    points = points[np.sort(once)]
    low = points.min(axis=0)
    scaled = (points - low) / (points.max(axis=0) - low)
    found = ConvexHull(scaled)
    used = np.flatnonzero(np.bincount(found.simplices.ravel()))
    number = np.empty(len(points), dtype=np.int32)
    number[used] = np.arange(len(used))
    a, b, c = (scaled[found.simplices[:, n]] for n in range(3))
    inward = dot(cross(b - a, c - a), found.equations[:, :3]) < 0
    faces = number[found.simplices]
    faces[inward] = faces[inward][:, ::-1]
    return points[used], faces
