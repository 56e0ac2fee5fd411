"""What collides: the convex pieces that validity was proved on, or hulls of neighbours where there are too many.

An object of up to ``BUDGET`` pieces keeps them as they are. Of one with more, neighbours are put together with the
least tolerance of ``STEPS`` that brings it there. Then the hulls are examined as samples are, at rest and over the range of
every joint: hulls that meet another link are halved until none does, in the end into the pieces that were proved.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.merge import Cluster, Convex, clusters, gathered, halves
from ..runtime.bodies import Alike, packed, turned
from ..runtime.tree import Tree
from ..runtime.validate import collisions
from . import solids

if TYPE_CHECKING:
    from ..runtime.batch import Batch

BUDGET = 60  # colliders of an object
STEPS = (0.002, 0.004, 0.008, 0.016, 0.03)  # of the diagonal of the object's box
Item = solids.Item[solids.PieceGroup]


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """One collider: its first piece, and where it has several, these, its corners (P, 3) in the object's frame and faces."""

    item: Item
    pieces: Cluster = ()
    vertices: np.ndarray | None = None
    faces: np.ndarray | None = None


def colliders(batch: Batch, groups: list[solids.PieceGroup], materials: dict[int, np.ndarray]) -> list[list[Hull]]:
    """The colliders of each object, in the order of the pieces; ``materials`` by site: what each row is made of."""
    objects = [_Object(items, materials) for items in solids.by_object(groups, len(batch))]
    _prove(batch, objects)
    return [[hull for hull, _ in one.hulls()] for one in objects]


class _Object:
    """The pieces of one object and how they are put together."""

    def __init__(self, items: list[Item], materials: dict[int, np.ndarray]):
        self.items = items
        self.parts: list[Cluster] = []
        self.made: dict[Cluster, Hull] = {}
        self.merged = len(items) > BUDGET
        if self.merged:
            self._merge(list(_pieces(items)), materials)

    def _merge(self, pieces: list[Convex], materials: dict[int, np.ndarray]) -> None:
        points = np.concatenate([piece.points for piece in pieces])
        extent = points.max(axis=0) - points.min(axis=0)
        diagonal = float(np.sqrt(extent[0] ** 2 + extent[1] ** 2 + extent[2] ** 2))
        units: dict[int, list[Convex]] = {}
        for piece in pieces:
            units.setdefault(piece.unit, []).append(piece)
        for step in STEPS:
            tolerance = step * diagonal
            found = [clusters(unit, tolerance) for unit in units.values()]
            if sum(map(len, found)) > BUDGET:
                found = self._rows(found, tolerance, materials)
            if sum(map(len, found)) <= BUDGET:
                break
        self.parts = [cluster for unit in found for cluster in unit]

    def _rows(
        self, found: list[list[Cluster]], tolerance: float, materials: dict[int, np.ndarray]
    ) -> list[list[Cluster]]:
        """Primitives of one site, link and material that are a hull each, put together where they stand close."""
        single: dict[tuple[int, int, int], list[Cluster]] = {}
        others = []
        for parts in found:
            item = self.items[parts[0][0].unit]
            table = item.group.table
            key = (table.number, int(table.link[item.row]), int(materials[table.number][item.row]))
            if len(parts) == 1:
                single.setdefault(key, []).append(parts[0])
            else:
                others.append(parts)
        return [*(gathered(parts, tolerance) for parts in single.values()), *others]

    def hulls(self) -> Iterator[tuple[Hull, Cluster | None]]:
        """The colliders, in the order of their first pieces."""
        if not self.merged:
            yield from ((Hull(item), None) for item in self.items)
            return
        at = {id(item): k for k, item in enumerate(self.items)}
        for cluster in self.parts:
            if cluster not in self.made:
                self.made[cluster] = _hull(cluster)
        yield from sorted(((self.made[c], c) for c in self.parts), key=lambda pair: at[id(pair[0].item)])


def _pieces(items: list[Item]) -> Iterator[Convex]:
    first, unit = (-1, -1), -1
    for k, item in enumerate(items):
        group = item.group
        if (group.table.number, item.row) != first:
            first, unit = (group.table.number, item.row), k  # a primitive is named after its first piece
        normals, offsets = group.planes
        yield Convex(group.vertices[item.k], normals[item.k], offsets[item.k], unit, group.name, group.index, item)


def _hull(cluster: Cluster) -> Hull:
    """The hull of a cluster; faces turn outwards."""
    if len(cluster) == 1:
        return Hull(cluster[0].source, cluster)
    from scipy.spatial import ConvexHull  # late: importing the package must not load SciPy

    points = np.concatenate([piece.points for piece in cluster])
    low = points.min(axis=0)
    scaled = (points - low) / (points.max(axis=0) - low)
    found = ConvexHull(scaled)
    used, faces = np.unique(found.simplices, return_inverse=True)
    faces = faces.reshape(-1, 3)
    a, b, c = (scaled[used][faces[:, n]] for n in range(3))
    inward = (np.cross(b - a, c - a) * found.equations[:, :3]).sum(axis=1) < 0
    faces[inward] = faces[inward][:, ::-1]
    return Hull(cluster[0].source, cluster, points[used], faces.astype(np.int32))


def _prove(batch: Batch, objects: list[_Object]) -> None:
    """Halve the hulls that meet another link, at rest or while a joint moves, until none does."""
    open_ones = [i for i, one in enumerate(objects) if one.merged]
    tree = Tree(batch) if open_ones else None
    while open_ones and tree is not None:
        groups, where = [], []
        for i in open_ones:
            for hull, cluster in objects[i].hulls():
                table, row = hull.item.group.table, hull.item.row
                link = int(tree.first[i]) + int(table.link[row])
                vertices = hull.item.group.vertices[hull.item.k] if hull.vertices is None else hull.vertices
                faces = hull.item.group.faces if hull.faces is None else hull.faces
                at_rest = turned(tree.turn[[link]], vertices[None]) + tree.shift[[link]][:, None]
                groups.append(Alike(at_rest, faces, np.array([i]), np.array([link])))
                where.append((i, cluster))
        body = packed(groups)
        collisions(batch, tree, body)
        met = {where[k] for k in body.source[body.met].tolist() if len(where[k][1] or ()) > 1}
        open_ones = sorted({i for i, _ in met})
        for i in open_ones:
            one = objects[i]
            one.parts = [half for c in one.parts for half in (halves(c) if (i, c) in met else (c,))]
