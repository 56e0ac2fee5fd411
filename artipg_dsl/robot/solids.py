"""The solids of a batch: meshes and convex pieces of every primitive, in the object's frame at zero pose.

Instances of one site that share a topology stay together in one array, so everything is computed for all objects at
once; ``Solid`` picks out one instance.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from ..annotate.frames import place
from ..geometry import mesh
from ..geometry.patches import inside_split
from ..geometry.pieces import fit_all
from ..geometry.resolution import FINEST, STANDARD, Resolution, measure_bends, within_budget
from ..geometry.topology import topology
from ..geometry.vectors import cross, dot, extent
from ..records import dataclass
from ..validity.bodies import enumerate_ranges
from .shading import Shading, shade

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable

_SIDE = 2 * np.pi / 12 + 1e-6  # radians: what has longer sides than a bar of 12 steps is a prism
_FINE = 2 * np.pi / STANDARD.steps + 1e-6  # radians: sides that lie no further off a circle than those of its mesh


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

    @property
    def places(self) -> np.ndarray:
        """(k,) what tells things of one row apart: there is one mesh."""
        return np.zeros(len(self.rows), dtype=np.int64)

    @cached_property
    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the most (k, 3) of the vertices along each axis."""
        return extent(self.vertices)

    @cached_property
    def shading(self) -> Shading:
        """Vertices split where an edge is to look sharp, with normals (k, V', 3)."""
        return shade(self.vertices, self.faces, self.face_patch)


@dataclass(frozen=True)
class ShapedPieces:
    """Convex pieces of ``rows`` of one site. Where ``is_box``, the piece is a box of ``size`` about ``center`` in the
    directions of the site's rotation; otherwise the hull of vertices (k, P, 3). All in the object's frame.

    ``name`` (k,) numbers the declared piece, ``index`` (k,) its steps; ``round`` (k, 3): radius, length along z and whether that
    ends in half spheres, of what is round about the site's z, else noughts.
    """

    table: SiteTable
    name: np.ndarray
    index: np.ndarray
    rows: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray
    is_box: np.ndarray
    size: np.ndarray
    center: np.ndarray
    round: np.ndarray

    @property
    def places(self) -> np.ndarray:
        """(k,) what orders the pieces of one row."""
        return (self.name << 32) + self.index

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
    tables: list[SiteTable], resolution: Resolution = STANDARD, edges: Sequence[np.ndarray] | None = None
) -> list[SolidGroup]:
    """Meshes of all instances of all sites; ``edges`` (k,) of each table: no step of an instance is longer, metres."""
    groups: list[SolidGroup] = []
    there = [number for number, table in enumerate(tables) if len(table.owner)]
    for number, steps in zip(there, _steps_of([tables[number] for number in there], resolution), strict=True):
        table, edge = tables[number], None if edges is None else edges[number]
        for part in mesh.build(table.primitive, table.params, steps, edge):
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
        for fit in fit_all(table.clouds):
            is_box, size, center = match_box(fit.corners)
            center = _place_points(table, fit.rows, center[:, None])[:, 0]
            bars = match_round(fit.corners)
            bars[_find_prisms(table, fit.rows, fit.corners, bars[:, 0])] = 0.0
            columns = _place_points(table, fit.rows, fit.corners), is_box, size, center, bars
            for sign in (1.0, -1.0):
                c = np.flatnonzero(table.mirror[fit.rows] == sign)
                if len(c):
                    faces = fit.hull.told if sign > 0 else fit.hull.told[:, ::-1]
                    placed, *shape = (column[c] for column in columns)
                    groups.append(ShapedPieces(table, fit.cloud[c], fit.index[c], fit.rows[c], placed, faces, *shape))
    return groups


def _place_points(table: SiteTable, rows: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Local points (k, n, 3) of ``rows`` in the object's frame."""
    return place(table.rotation[rows], table.translation[rows], points, table.mirror[rows])


def match_box(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Whether the points (k, P, 3) are the eight corners of a box along the axes; its size and centre (k, 3)."""
    low, high = extent(vertices)
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
    at one distance from a stretch of z, and all around it; else there are noughts, as for a prism of few sides. The length of a
    capsule is that between its ends' middles.
    """
    found = np.zeros((len(vertices), 3))
    if vertices.shape[1] < 12:
        return found
    low, high = extent(vertices)
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
    at = np.flatnonzero(cylinder | capsule)
    x, y, _ = np.moveaxis(local[at], -1, 0)
    angle = np.where(across[at] > near[at, None], np.arctan2(y, x), np.nan)
    angular = at[_widest_gap(angle)[0] > _SIDE]
    cylinder[angular] = capsule[angular] = False
    found[:, 0] = np.where(cylinder | capsule, radius, 0.0)
    found[:, 1] = np.where(
        cylinder, 2 * half[:, 2], np.where(capsule, np.where(straight > near, 2 * straight, 0.0), 0.0)
    )
    found[:, 2] = capsule
    return found


def _find_prisms(table: SiteTable, rows: np.ndarray, vertices: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Which of the points (k, P, 3) of round pieces (``radius`` (k,), else nought) are corners of flat sides.

    From 24 sides on, a prism is off a cylinder by no more than the mesh of one is, 0.9 % of the radius. Of fewer, the solid
    tells whether it is round: by the middle between side and circle where the sides are longest.
    """
    at = np.flatnonzero(radius > 0)
    low, high = extent(vertices[at])
    middle = (low + high) / 2
    local = vertices[at] - middle[:, None]
    across = np.sqrt(local[..., 0] ** 2 + local[..., 1] ** 2)
    angle = np.where(across > 1e-6 * radius[at, None], np.arctan2(local[..., 1], local[..., 0]), np.nan)
    gap, between = _widest_gap(angle)
    wide = np.flatnonzero(gap > _FINE)
    if not len(wide):
        return wide
    reach = radius[at[wide]] * (1 + np.cos(gap[wide] / 2)) / 2
    points = middle[wide] + np.stack([np.cos(between[wide]), np.sin(between[wide]), 0 * reach], axis=1) * reach[:, None]
    split = inside_split(table.primitive)
    known = [value[rows[at[wide]]] for value in split.rows(table.params)]
    return at[wide[np.broadcast_to(split.points(known, *points.T)[0], len(wide)) > 0]]


def _widest_gap(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The widest gap (k,) between neighbours among angles (k, P) of a full turn, and its middle (k,), radians; nan counts for none."""
    ordered = np.sort(angles, axis=1)
    last = np.nanmax(ordered, axis=1, initial=-np.pi)  # behind it are those that count for none
    ordered = np.concatenate([np.where(np.isnan(ordered), last[:, None], ordered), ordered[:, :1] + 2 * np.pi], axis=1)
    gaps = np.diff(ordered, axis=1)
    at = np.nanargmax(gaps, axis=1)[:, None] if len(gaps) else np.zeros((0, 1), dtype=np.int64)
    widest, first = (np.take_along_axis(found, at, axis=1)[:, 0] for found in (gaps, ordered))
    return widest, first + widest / 2


def group_by_object(groups: list[Group], n_objects: int) -> list[list[Item[Group]]]:
    """Items of each object, in the order of ``order_by_object``."""
    items: list[list[Item[Group]]] = [[] for _ in range(n_objects)]
    for g, *at, of in zip(*(column.tolist() for column in order_by_object(groups)), strict=True):
        items[of].append(Item(groups[g], *at))
    return items


def order_by_object(groups: Sequence[Group]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Group, row within it, row of the site and object (n,) of all that is in groups, in the order of objects, sites, rows, and
    what one row has several of."""
    if not groups:
        return (np.zeros(0, dtype=np.int64),) * 4
    which, k = enumerate_ranges(np.zeros(len(groups), dtype=np.int64), np.array([len(group.rows) for group in groups]))
    row, place = (np.concatenate(column) for column in zip(*((g.rows, g.places) for g in groups), strict=True))
    site, owner = (np.concatenate([getattr(g.table, name)[g.rows] for g in groups]) for name in ("site", "owner"))
    order = np.lexsort((place, row, site, owner))
    return which[order], k[order], row[order], owner[order]
