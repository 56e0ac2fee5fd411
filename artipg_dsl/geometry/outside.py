"""What of the boundary of an object can be seen from without, as against the walls of a cavity behind a closed door.

A point counts as seen when one of ``_DIRECTIONS`` rays from it, the same evenly spread ones for all points and objects,
leaves the object without entering a solid: a camera far away in that direction sees it. So what shows itself only
through a slit or hole narrower than the spacing of the rays, about 17 degrees, counts as not seen. Solids are
represented by their meshes. On a hollow surface the chords of the mesh lie before the point: a ray from there begins within the
mesh, and must leave it by that surface; one that leaves by another has gone through the wall of a lid, and does not count. The rays of one
direction are parallel: which triangles they may meet is looked up on a grid in the plane across, for all objects at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from ..native import backend, leaving
from ..records import dataclass
from . import mesh
from .cells import Cells
from .flat import BENT
from .runs import runs

_DIRECTIONS = 144
_STEPS = 24  # of the meshes, per full turn
_GRAZING = 0.02  # sine of the angle to the surface below which a ray is not asked
_LOW = 0.5  # that sine below which a ray from a hollow surface may pass between it and its chords
_BINS = 24  # of the grid, along either axis
_LARGE = 0.004  # area of a triangle that is asked first, relative to the square of the object's diagonal
_EDGE = 1e-9  # a ray this far beyond an edge, relative to the picture, still meets the triangle
_STRIDE = 65  # through the directions, so that the first of them are spread evenly too
_PAIRS = 500_000  # of a ray and a triangle at a time


def spread_directions(count: int = _DIRECTIONS) -> np.ndarray:
    """(count, 3) unit vectors spread evenly: a Fibonacci lattice on the sphere, in an order whose beginnings are even too."""
    number = np.arange(count) * _STRIDE % count
    z = 1.0 - (2.0 * number + 1.0) / count
    around = number * (np.pi * (3.0 - np.sqrt(5.0)))
    level = np.sqrt(1.0 - z * z)
    return np.stack([level * np.cos(around), level * np.sin(around), z], axis=-1)


@dataclass(frozen=True, slots=True, eq=False)
class _Triangles:
    """Of a block, sorted by object: ``face`` (3, T), the numbers of their vertices, ``normal`` (3, T), ``owner`` (T,), ``cell`` (T,);
    ``ends`` (objects + 1,), where those of each object begin, and the last end."""

    face: np.ndarray
    normal: np.ndarray
    owner: np.ndarray
    cell: np.ndarray
    ends: np.ndarray

    def only(self, chosen: np.ndarray) -> _Triangles:
        face, normal = (np.take(array, chosen, axis=1) for array in (self.face, self.normal))
        owner = self.owner[chosen]
        return _Triangles(face, normal, owner, self.cell[chosen], _ends(owner, len(self.ends) - 1))


class Outlook:
    """The solids of a block as triangles over ``vertex`` (3, V), the vertices sorted by object, ``many`` of each; the large triangles
    apart from the others."""

    def __init__(self, cells: Cells, off: np.ndarray, buried: np.ndarray):
        self.cells, self.off = cells, off
        rows = cells.rows
        vertices, faces, sources, owners = [np.empty((3, 0))], [np.empty((3, 0), np.int64)], [np.empty(0, np.int64)], []
        owners.append(np.empty(0, np.int64))
        count = 0
        for shelf in rows.shelves:
            for made in mesh.build(shelf.primitive, shelf.params, _STEPS):
                own = shelf.start + made.rows
                rotation, translation, mirror = (p[..., own, None] for p in cells.poses)
                x, y, z = (made.vertices[..., axis] for axis in range(3))
                y = y * mirror
                placed = np.stack(
                    [
                        rotation[3 * k] * x + rotation[3 * k + 1] * y + rotation[3 * k + 2] * z + translation[k]
                        for k in range(3)
                    ]
                )  # (3, rows, vertices)
                first = count + x.shape[1] * np.arange(len(own))
                count += x.size
                face = first[:, None] + made.faces.T[:, None]  # (3, rows, faces)
                inside_out = np.flatnonzero(rows.mirror[own] < 0)
                face[:, inside_out] = face[::-1, inside_out]
                source = cells.first[own, None] + made.face_patch
                shown = ~buried[source]
                vertices.append(placed.reshape(3, -1))
                owners.append(np.repeat(rows.owner[own], x.shape[1]))
                faces.append(face[:, shown])
                sources.append(source[shown])
        owner, face, cell = np.concatenate(owners), np.concatenate(faces, axis=1), np.concatenate(sources)
        order = np.argsort(owner[face[0]], kind="stable")
        face, cell = face[:, order], cell[order]
        order = np.argsort(owner, kind="stable")
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        self.vertex, owner, face = np.take(np.concatenate(vertices, axis=1), order, axis=1), owner[order], place[face]
        self.many = np.bincount(owner, minlength=rows.objects)
        owner, corner = owner[face[0]], self.vertex[:, face]  # (axis, corner, T)
        a, b, c = (corner[:, k] for k in range(3))
        e, f = b - a, c - a
        normal = np.stack([e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3] for k in range(3)])
        ends = _ends(owner, rows.objects)
        filled = np.flatnonzero(np.diff(ends))
        self.low, self.high = np.zeros((3, rows.objects)), np.ones((3, rows.objects))
        if len(filled):
            self.low[:, filled] = np.minimum.reduceat(corner.min(axis=1), ends[filled], axis=1)
            self.high[:, filled] = np.maximum.reduceat(corner.max(axis=1), ends[filled], axis=1)

        extent = self.high - self.low
        square = extent[0] * extent[0] + extent[1] * extent[1] + extent[2] * extent[2]
        across = normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2
        large = across > (2.0 * _LARGE * square[owner]) ** 2
        every = _Triangles(face, normal, owner, cell, ends)
        self.asked = every.only(np.flatnonzero(large)), every.only(np.flatnonzero(~large))

    def sees(self, cell: np.ndarray, position: Sequence[np.ndarray], normal: Sequence[np.ndarray]) -> np.ndarray:
        """(m,) bool: which of the points on cells ``cell`` can be seen from without."""
        owner = self.cells.owner[cell]
        start = [p + self.off[owner] * n for p, n in zip(position, normal, strict=True)]
        seen = np.zeros(len(cell), dtype=bool)
        left, bent = np.arange(len(cell)), self.cells.shape[cell] == BENT
        for way in spread_directions():
            slope = way[0] * normal[0][left] + way[1] * normal[1][left] + way[2] * normal[2][left]
            asked, low = left[slope > _GRAZING], left[(slope > _GRAZING) & (slope < _LOW) & bent[left]]
            if len(asked):
                picture = _Picture(self, way, owner[asked])
                for triangles in self.asked:  # the large ones stop most rays that are stopped at all
                    asked = asked[picture.free(owner[asked], [s[asked] for s in start], triangles)]
                seen[asked] = True
                low = low[seen[low]]
                for triangles in self.asked:
                    free = picture.free(owner[low], [s[low] for s in start], triangles, cell[low])
                    seen[low[~free]], low = False, low[free]
                left = left[~seen[left]]
        return seen


class _Picture:
    """Objects looked at along rays ``way``: of each vertex its place ``flat`` (2, V) across, and the bin of the grid ``bins`` (2, V), of
    those that belong to the objects ``owner`` alone."""

    def __init__(self, outlook: Outlook, way: np.ndarray, owner: np.ndarray):
        self.way, self.vertex, self.frame = way, outlook.vertex, _frame(tuple(way.tolist()))
        # each object's picture has a grid of its own, _BINS by _BINS
        middle, reach = (outlook.low + outlook.high) / 2, (outlook.high - outlook.low) / 2
        scales, origins = [], []
        for f in self.frame[:2]:
            half = np.abs(f[0]) * reach[0] + np.abs(f[1]) * reach[1] + np.abs(f[2]) * reach[2]
            half = np.maximum(half * 1.001, 1e-12)
            origins.append(f[0] * middle[0] + f[1] * middle[1] + f[2] * middle[2] - half)
            scales.append(_BINS / (2.0 * half))
        self.scale, self.origin = np.stack(scales), np.stack(origins)
        self.objects = self.scale.shape[1]
        there = self.among(owner)
        self.flat, self.bins = np.empty(outlook.vertex[:2].shape), np.empty(outlook.vertex[:2].shape, dtype=np.int16)
        if (machine := backend.machine()) is not None:
            told = self.frame[:2], self.origin, self.scale, _BINS
            leaving.lay_flat(machine, outlook.vertex, outlook.many, there, *told, self.flat, self.bins)
            return
        first = np.cumsum(outlook.many) - outlook.many
        chosen = slice(None) if there.all() else runs(first[there], outlook.many[there])
        x, y, z = outlook.vertex[:, chosen]
        many = outlook.many * there
        for k, f in enumerate(self.frame[:2]):
            flat = f[0] * x
            flat += f[1] * y
            flat += f[2] * z
            origin, scale = (np.repeat(each, many) for each in (self.origin[k], self.scale[k]))
            self.flat[k, chosen], self.bins[k, chosen] = flat, _bin(flat, origin, scale)

    def among(self, owner: np.ndarray) -> np.ndarray:
        """(objects,) bool: which of the objects are among ``owner``."""
        found = np.zeros(self.objects, dtype=bool)
        found[owner] = True
        return found

    def free(
        self, owner: np.ndarray, start: list[np.ndarray], triangles: _Triangles, own: np.ndarray | None = None
    ) -> np.ndarray:
        """(m,) bool: whether the rays from points of objects ``owner`` enter none of the triangles; with ``own``, the cells of the points,
        whether they leave none from behind but those of their own cell."""
        out = np.ones(len(owner), dtype=bool)
        if not len(owner):
            return out
        way, there = self.way, self.among(owner)
        point = [f[0] * start[0] + f[1] * start[1] + f[2] * start[2] for f in self.frame]
        across, up = (_bin(point[k], self.origin[k][owner], self.scale[k][owner]) for k in (0, 1))
        place = (owner * _BINS + up) * _BINS + across
        if (machine := backend.machine()) is not None:
            many = triangles.face, triangles.cell, triangles.ends, triangles.normal
            seen = self.vertex, self.flat, self.bins, self.frame, self.scale
            return leaving.free(machine, many, seen, _BINS, (np.stack(point), place, own), there, _EDGE)
        some: slice | np.ndarray = slice(None)
        if not there.all():
            some = runs(triangles.ends[:-1][there], np.diff(triangles.ends)[there])
        slope = way[0] * triangles.normal[0][some]
        slope += way[1] * triangles.normal[1][some]
        slope += way[2] * triangles.normal[2][some]
        facing = np.flatnonzero(slope < 0.0 if own is None else slope > 0.0)
        facing = facing if isinstance(some, slice) else some[facing]
        face, whose = triangles.face[:, facing], triangles.owner[facing]
        edges = []
        for bins in self.bins:
            a, b, c = bins[face]
            edges += [np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)]
        order = np.argsort(place, kind="stable")
        count = np.bincount(place, minlength=self.objects * _BINS * _BINS)
        near = _filled(count.reshape(-1, _BINS, _BINS), whose, *edges)
        if not len(near):
            return out
        face, whose, triangles = face[:, near], whose[near], triangles.only(facing[near])
        left, right, bottom, top = (edge[near].astype(np.int64) for edge in edges)
        begin = np.cumsum(count) - count
        wide = right - left + 1
        row = runs(bottom, top - bottom + 1)  # one for each triangle and row of bins that it touches
        of = np.repeat(np.arange(len(near)), top - bottom + 1)
        head = (whose[of] * _BINS + row) * _BINS + left[of]
        # the points of neighbouring bins of a row stand together
        first = begin[head]
        many = begin[head + wide[of] - 1] + count[head + wide[of] - 1] - first
        met = np.flatnonzero(many)
        of, first, many = of[met], first[met], many[met]
        side, face = (1.0, face) if own is None else (-1.0, face[::-1])
        f = self.frame[2]
        x, y, z = (axis[face] for axis in self.vertex)
        corner = list(zip(self.flat[0][face], self.flat[1][face], f[0] * x + f[1] * y + f[2] * z, strict=True))
        lines = [_edges(corner, k) for k in range(3)]
        normal = side * triangles.normal
        turned = [f[0] * normal[0] + f[1] * normal[1] + f[2] * normal[2] for f in self.frame]
        size = _EDGE / (self.scale[0] * self.scale[1])[whose]
        total = np.cumsum(many)
        cuts = np.searchsorted(total, np.arange(_PAIRS, int(total[-1]) if len(total) else 0, _PAIRS))
        for part in np.split(np.arange(len(of)), cuts):
            if not len(part):
                continue
            ray = order[runs(first[part], many[part])]
            with_ = np.repeat(of[part], many[part])
            for a, b, c in lines:
                kept = a[with_] * point[0][ray] + b[with_] * point[1][ray] + c[with_] <= size[with_]
                ray, with_ = ray[kept], with_[kept]
            # what faces the ray lies before it where the start is on the outer side of its plane
            gap = sum(turned[k][with_] * (corner[0][k][with_] - point[k][ray]) for k in range(3))
            ahead = gap < 0.0
            if own is not None:
                ahead &= triangles.cell[with_] != own[ray]
            out[ray[ahead]] = False
        return out


def _ends(owner: np.ndarray, objects: int) -> np.ndarray:
    """(objects + 1,) int64: where what is sorted by ``owner`` begins for each object, and the last end."""
    return np.searchsorted(owner, np.arange(objects + 1))


def _bin(flat: np.ndarray, origin: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """The bins, along one axis, of places (m,) in pictures that begin at ``origin`` (m,), with ``scale`` (m,) bins a metre."""
    found = flat - origin
    found *= scale
    return np.minimum(np.maximum(found, 0.0, out=found), _BINS - 1.0, out=found).astype(np.int16)


def _filled(
    count: np.ndarray, owner: np.ndarray, left: np.ndarray, right: np.ndarray, bottom: np.ndarray, top: np.ndarray
) -> np.ndarray:
    """Which rectangles of bins, of the grids of objects ``owner``, have points in them, by ``count`` (objects, _BINS, _BINS)."""
    wide = _BINS + 1
    table = np.zeros(
        (len(count), wide, wide), dtype=np.int64
    )  # how many are below and to the left of each corner of the grid
    np.cumsum(count.cumsum(axis=1), axis=2, out=table[:, 1:, 1:])
    flat, low, high = table.ravel(), (owner * wide + bottom) * wide, (owner * wide + top + 1) * wide
    inside = flat[high + right + 1] - flat[low + right + 1] - flat[high + left] + flat[low + left]
    return np.flatnonzero(inside)


def _edges(corner: Sequence[Sequence[np.ndarray]], k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coefficients of x, y, 1 that are not above 0 within edge k of triangles that face the rays."""
    (x, y, _), (p, q, _) = corner[k], corner[(k + 1) % 3]
    return y - q, p - x, x * q - p * y


@cache
def _frame(towards: tuple[float, float, float]) -> np.ndarray:
    """(3, 3): two axes across a direction, and the direction."""
    way = np.array(towards)
    other = np.eye(3)[int(np.argmin(np.abs(way)))]
    first = np.cross(way, other)
    first = first / np.sqrt((first * first).sum())
    return np.stack([first, np.cross(way, first), way])
