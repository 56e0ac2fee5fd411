"""The solids of a batch: meshes and convex pieces of every primitive, in the object's frame at zero pose.

Instances of one site that share a topology stay together in one array, so everything is computed for all objects at
once; ``Solid`` picks out one instance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from ..annotate.frames import place
from ..geometry import mesh
from ..geometry.resolution import FINEST, STANDARD, Resolution, measure_bends, within_budget
from ..geometry.topology import topology
from ..geometry.vectors import cross, dot
from .shading import Shading, shade

if TYPE_CHECKING:
    from ..geometry.pieces import PieceGroup
    from ..geometry.sites import SiteTable


@dataclass(frozen=True)
class SolidGroup:
    """Instances ``rows`` of one site with common ``faces`` (F, 3), outward, and vertices (k, V, 3).

    ``face_uv`` (F, 3, 2): fractions of the corners on the patch ``face_patch`` (F,).
    """

    table: SiteTable
    rows: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    face_patch: np.ndarray
    face_uv: np.ndarray

    @cached_property
    def shading(self) -> Shading:
        """Vertices split where an edge is to look sharp, with normals (k, V', 3)."""
        return shade(self.vertices, self.faces, self.face_patch)


@dataclass(frozen=True)
class ShapedPieces:
    """Convex pieces of ``rows`` of one site. Where ``is_box``, the piece is a box of ``size`` about ``center`` in the
    directions of the site's rotation; otherwise the hull of vertices (k, P, 3). All in the object's frame.

    ``name`` numbers the declared piece, ``index`` its steps; ``round`` (k, 3): radius, length along z and whether that
    ends in half spheres, of what is round about the site's z, else noughts.
    """

    table: SiteTable
    name: int
    index: int
    rows: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    is_box: np.ndarray
    size: np.ndarray
    center: np.ndarray
    round: np.ndarray

    @cached_property
    def planes(self) -> tuple[np.ndarray, np.ndarray]:
        """Outward normals (k, F, 3) and offsets (k, F) of the faces."""
        return planes_of(self.vertices, self.faces)


def planes_of(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Outward unit normals (k, F, 3) of the faces of convex pieces (k, P, 3), and their offsets (k, F)."""
    corners = vertices[:, faces]
    normal = cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    normal = normal / np.maximum(np.sqrt(dot(normal, normal)), 1e-300)[..., None]
    return normal, dot(normal, corners[:, :, 0])


Group = TypeVar("Group", SolidGroup, ShapedPieces)


@dataclass(frozen=True, slots=True)
class Item(Generic[Group]):
    """Row ``k`` of ``group``, which is row ``row`` of the group's site table."""

    group: Group
    k: int
    row: int


def build_meshes(
    tables: list[SiteTable], resolution: Resolution = STANDARD, edge: np.ndarray | None = None
) -> list[SolidGroup]:
    """Meshes of all instances of all sites; ``edge`` (objects,): no step of those of an object is longer, metres."""
    groups: list[SolidGroup] = []
    tables = [table for table in tables if len(table.owner)]
    for table, steps in zip(tables, _steps_of(tables, resolution), strict=True):
        for part in mesh.build(table.primitive, table.params, steps, None if edge is None else edge[table.owner]):
            rows = np.asarray(part.rows)
            vertices = _place_points(table, rows, part.vertices)
            for sign in (1.0, -1.0):
                chosen = np.flatnonzero(table.mirror[rows] == sign)
                if len(chosen):
                    order = slice(None, None, int(sign))  # a mirror turns faces inside out
                    faces, face_uv = part.faces[:, order], part.face_uv[:, order]
                    mine = vertices if len(chosen) == len(rows) else vertices[chosen]
                    groups.append(SolidGroup(table, rows[chosen], mine, faces, part.face_patch, face_uv))
    return groups


def _steps_of(tables: list[SiteTable], resolution: Resolution) -> Sequence[int | np.ndarray]:
    """What ``mesh.build`` takes for each table: steps per full turn, or the tolerance (k,) of each instance, metres."""
    if not resolution.by_error:
        return [resolution.steps] * len(tables)
    wanted = resolution.tolerance or FINEST
    if resolution.triangles is None:
        return [np.full(len(table.owner), wanted) for table in tables]
    objects = max((int(table.owner.max()) + 1 for table in tables), default=0)
    parts = [
        (
            measure_bends(table.primitive, topology(table.primitive, variant), mesh.take(table.params, rows)),
            table.owner[rows],
        )
        for table in tables
        for variant, rows in mesh.group_rows(table.primitive, table.params)
    ]
    own = within_budget(parts, objects, resolution.triangles, wanted)
    return [own[table.owner] for table in tables]


def build_pieces(tables: list[SiteTable]) -> list[ShapedPieces]:
    """Convex pieces of all instances of all sites, boxes told from other hulls."""
    groups: list[ShapedPieces] = []
    for table in tables:
        names: dict[str, int] = {}
        for part, placed, center, (is_box, size, bulge) in _placed(table) if len(table.owner) else ():
            rows = np.asarray(part.rows)
            name, _, index = part.name.partition("[")
            number = names.setdefault(name, len(names))
            for sign in (1.0, -1.0):
                c = np.flatnonzero(table.mirror[rows] == sign)
                if len(c):
                    faces = part.faces if sign > 0 else part.faces[:, ::-1]
                    step = int(index[:-1] or 0)
                    groups.append(
                        ShapedPieces(
                            table, number, step, rows[c], placed[c], faces, is_box[c], size[c], center[c], bulge[c]
                        )
                    )
    return groups


def _placed(table: SiteTable) -> Iterator[tuple[PieceGroup, np.ndarray, np.ndarray, list[np.ndarray]]]:
    """The pieces of a table with their corners and centres in the object's frame, whether they are boxes, of which size, and whether
    they are round: those of as many corners all at once, for a wall has hundreds of steps of a few pieces each."""
    alike: dict[int, list[int]] = {}
    for number, part in enumerate(table.pieces):
        alike.setdefault(part.vertices.shape[1], []).append(number)
    found: dict[int, tuple[np.ndarray, ...]] = {}
    for numbers in alike.values():
        parts = [table.pieces[number] for number in numbers]
        vertices, rows = (
            np.concatenate([np.asarray(getattr(p, name)) for p in parts]) for name in ("vertices", "rows")
        )
        is_box, size, center = match_box(vertices)
        center = _place_points(table, rows, center[:, None])[:, 0]
        columns = _place_points(table, rows, vertices), center, is_box, size, match_round(vertices)
        ends = np.cumsum([len(part.rows) for part in parts])[:-1]
        found |= dict(zip(numbers, zip(*(np.split(column, ends) for column in columns), strict=True), strict=True))
    for number, part in enumerate(table.pieces):
        placed, center, *shape = found[number]
        yield part, placed, center, shape


def _place_points(table: SiteTable, rows: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Local points (k, n, 3) of ``rows`` in the object's frame."""
    return place(table.rotation[rows], table.translation[rows], points, table.mirror[rows])


def match_box(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Whether the points (k, P, 3) are the eight corners of a box along the axes; its size and centre (k, 3)."""
    low, high = vertices.min(axis=1), vertices.max(axis=1)
    size, center = high - low, (high + low) / 2
    if vertices.shape[1] != 8:
        return np.zeros(len(vertices), dtype=bool), size, center
    upper = vertices > center[:, None]
    corner = np.where(upper, high[:, None], low[:, None])
    exact = (np.abs(vertices - corner) <= 1e-9).all(axis=(1, 2))
    code = np.sort(upper[..., 0] + 2 * upper[..., 1] + 4 * upper[..., 2], axis=1)
    return exact & (code == np.arange(8)).all(axis=1) & (size > 0).all(axis=1), size, center


def match_round(vertices: np.ndarray) -> np.ndarray:
    """Radius, length and whether it ends in half spheres, (k, 3), of the points (k, P, 3) of cylinders, balls and capsules.

    The corners of a cylinder lie on two equal circles about z, or in the middle of these, those of a ball or a capsule
    at one distance from a stretch of z; else there are noughts. The length of a capsule is that between its ends' middles.
    """
    found = np.zeros((len(vertices), 3))
    if vertices.shape[1] < 12:
        return found
    low, high = vertices.min(axis=1), vertices.max(axis=1)
    middle, half = (low + high) / 2, (high - low) / 2
    local = vertices - middle[:, None]
    radius, near = half[:, 0], 1e-6 * half.max(axis=1)
    across = np.sqrt(local[..., 0] ** 2 + local[..., 1] ** 2)
    even = (np.abs(half[:, 0] - half[:, 1]) <= near) & (radius > 0)
    flat = np.abs(np.abs(local[..., 2]) - half[:, 2, None]) <= near[:, None]
    rim = np.abs(across - radius[:, None]) <= near[:, None]
    cylinder = even & (flat & (rim | (across <= near[:, None]))).all(axis=1) & (rim.sum(axis=1) >= 12)
    straight = half[:, 2] - radius
    beyond = np.maximum(np.abs(local[..., 2]) - straight[:, None], 0.0)
    apart = np.abs(np.sqrt(across**2 + beyond**2) - radius[:, None])
    capsule = even & (straight >= -near) & (apart <= near[:, None]).all(axis=1) & ~cylinder
    found[:, 0] = np.where(cylinder | capsule, radius, 0.0)
    found[:, 1] = np.where(
        cylinder, 2 * half[:, 2], np.where(capsule, np.where(straight > near, 2 * straight, 0.0), 0.0)
    )
    found[:, 2] = capsule
    return found


def group_by_object(groups: list[Group], n_objects: int) -> list[list[Item[Group]]]:
    """Items of each object, in the order of groups (of sites, then pieces) and within them of rows."""
    items: list[list[Item[Group]]] = [[] for _ in range(n_objects)]
    for group in groups:
        for k, (row, owner) in enumerate(zip(group.rows.tolist(), group.table.owner[group.rows].tolist(), strict=True)):
            items[owner].append(Item(group, k, row))
    for one in items:  # groups of one site (two topologies, mirrored rows) lie together: order them by row
        one.sort(key=lambda item: (item.group.table.number, item.row))
    return items
