"""The convex hulls that stand for several pieces of an object: which pieces, and their corners and faces."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator
from functools import cache

import numpy as np

from ..geometry.collide import inset
from ..geometry.merge import Cluster, Convex, clusters, cut, gather_clusters, halves
from ..geometry.wrap import wrap_all
from ..native.gaps import Stock
from ..records import dataclass
from . import solids

BUDGET = 60  # colliders of an object
STEPS = (0.002, 0.004, 0.008, 0.016, 0.03)  # of the diagonal of the object's box
Item = solids.Item[solids.ShapedPieces]
Shape = tuple[np.ndarray, np.ndarray, np.ndarray, int, int]  # as ``ShapedPieces.shapes`` has it


@dataclass(slots=True, eq=False)
class Hull:
    """One collider: its first piece, and where it has several, these, its corners (P, 3) in the object's frame and faces,
    which ``wrap`` finds.

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
    def link(self) -> int:
        """The number of its link."""
        return int(self.item.group.table.link[self.item.row])

    @property
    def faces(self) -> np.ndarray:
        """Outward triangles (F, 3)."""
        return self.item.group.faces if self.triangles is None else self.triangles


class Body:
    """The pieces of one object and the hulls in place of them; ``materials`` by site: what each row is made of."""

    def __init__(self, items: list[Item], materials: dict[int, np.ndarray]):
        shapes = [item.group.shapes[item.k] for item in items]
        tolerances = _tolerances(shapes)
        stock = None
        if len(items) > BUDGET:
            corners, normals, offsets, _, _ = zip(*shapes, strict=True)
            stock = Stock(corners, normals, offsets, tolerances[-1])
        pieces = list(_pieces(items, shapes, stock))
        self._order = {id(piece): k for k, piece in enumerate(pieces)}
        if len(pieces) <= BUDGET:
            self.hulls = [Hull(piece.source, (piece,)) for piece in pieces]
            return
        units: dict[int, list[Convex]] = {}
        for piece in pieces:
            units.setdefault(piece.unit, []).append(piece)

        @cache
        def merged(tolerance: float) -> list[Cluster]:
            found = [clusters(unit, tolerance) for unit in units.values()]
            if sum(map(len, found)) > BUDGET:
                found = _rows(found, tolerance, materials)
            return [cluster for unit in found for cluster in unit]

        least = bisect_left(tolerances[:-1], True, key=lambda tolerance: len(merged(tolerance)) <= BUDGET)
        self.tolerance, self.small = tolerances[least], tolerances[-1]
        self.hulls = [Hull(cluster[0].source, cluster) for cluster in merged(self.tolerance)]

    def reduce(self, hulls: set[Hull]) -> set[Hull]:
        """Put less in place of hulls of several pieces: cut off what fills a hollow, else halve them; returns the new ones."""
        kept: list[Hull] = []
        new: set[Hull] = set()
        for hull in self.hulls:
            if hull not in hulls:
                kept.append(hull)
                continue
            plane = None if hull.cut else cut(hull.pieces, self.tolerance, self.small)
            less = [_without(hull, *plane)] if plane else [Hull(half[0].source, half) for half in halves(hull.pieces)]
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


def _tolerances(shapes: list[Shape]) -> list[float]:
    """How far hulls may reach from the pieces of an object: more and more, metres."""
    points = np.concatenate([corners for corners, *_ in shapes]) if shapes else np.zeros((1, 3))
    extent = points.max(axis=0) - points.min(axis=0)
    diagonal = float(np.sqrt(extent[0] ** 2 + extent[1] ** 2 + extent[2] ** 2))
    return [step * diagonal for step in STEPS]


def _pieces(items: list[Item], shapes: list[Shape], stock: Stock | None) -> Iterator[Convex]:
    first, unit = (-1, -1), -1
    for k, (item, (corners, normals, offsets, name, index)) in enumerate(zip(items, shapes, strict=True)):
        if (item.group.table.number, item.row) != first:
            first, unit = (item.group.table.number, item.row), k  # a primitive is named after its first piece
        yield Convex(corners, normals, offsets, unit, name, index, item, stock, k)


def wrap(hulls: Iterable[Hull]) -> None:
    """Find the corners and the outward faces of those hulls of several pieces that have none yet."""
    several = [hull for hull in hulls if len(hull.pieces) > 1 and hull.triangles is None]
    points = [
        np.concatenate([piece.points for piece in hull.pieces]) if hull.corners is None else hull.corners
        for hull in several
    ]
    for hull, own, (used, faces) in zip(several, points, wrap_all(points), strict=True):
        hull.corners, hull.triangles = own[used], faces


def shrink(hulls: Iterable[Hull]) -> None:
    """Move the corners of those hulls inwards that have none so yet."""
    left = [hull for hull in dict.fromkeys(hulls) if hull.inner is None]
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
