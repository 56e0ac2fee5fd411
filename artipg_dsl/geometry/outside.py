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


class Outlook:
    """The solids of a block as triangles, ``corner`` (3 corners, 3 axes, T), sorted by object; ``cell`` (T,) that each is of."""

    def __init__(self, cells: Cells, off: np.ndarray, buried: np.ndarray):
        self.cells, self.off = cells, off
        rows = cells.rows
        corners, owners, sources = [np.empty((3, 3, 0))], [np.empty(0, np.int64)], [np.empty(0, np.int64)]
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
                corner = np.stack([placed[:, :, made.faces[:, c]] for c in range(3)])  # (corner, axis, row, face)
                inside_out = np.flatnonzero(rows.mirror[own] < 0)
                corner[:, :, inside_out] = corner[::-1, :, inside_out]
                source = cells.first[own, None] + made.face_patch
                shown = ~buried[source]
                corners.append(corner[:, :, shown])
                sources.append(source[shown])
                owners.append(np.broadcast_to(rows.owner[own, None], shown.shape)[shown])
        owner = np.concatenate(owners)
        order = np.argsort(owner, kind="stable")
        self.owner, self.cell = owner[order], np.concatenate(sources)[order]
        self.corner = np.concatenate(corners, axis=2)[:, :, order]
        a, b, c = self.corner
        e, f = b - a, c - a
        self.normal = np.stack([e[(k + 1) % 3] * f[(k + 2) % 3] - e[(k + 2) % 3] * f[(k + 1) % 3] for k in range(3)])
        ends = np.searchsorted(self.owner, np.arange(rows.objects + 1))
        filled = np.flatnonzero(np.diff(ends))
        self.low, self.high = np.zeros((3, rows.objects)), np.ones((3, rows.objects))
        if len(filled):
            self.low[:, filled] = np.minimum.reduceat(self.corner.min(axis=0), ends[filled], axis=1)
            self.high[:, filled] = np.maximum.reduceat(self.corner.max(axis=0), ends[filled], axis=1)

        extent = self.high - self.low
        square = extent[0] * extent[0] + extent[1] * extent[1] + extent[2] * extent[2]
        across = self.normal[0] ** 2 + self.normal[1] ** 2 + self.normal[2] ** 2
        large = across > (2.0 * _LARGE * square[self.owner]) ** 2
        self.asked = np.flatnonzero(large), np.flatnonzero(~large)

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
                for triangles in self.asked:  # the large ones stop most rays that are stopped at all
                    asked = asked[self._free(way, owner[asked], [s[asked] for s in start], triangles)]
                seen[asked] = True
                low = low[seen[low]]
                for triangles in self.asked:
                    free = self._free(way, owner[low], [s[low] for s in start], triangles, cell[low])
                    seen[low[~free]], low = False, low[free]
                left = left[~seen[left]]
        return seen

    def _free(
        self,
        way: np.ndarray,
        owner: np.ndarray,
        start: list[np.ndarray],
        triangles: np.ndarray,
        own: np.ndarray | None = None,
    ) -> np.ndarray:
        """(m,) bool: whether rays along ``way`` from points of objects ``owner`` enter none of the triangles; with ``own``, the cells
        of the points, whether they leave none from behind but those of their own cell."""
        out = np.ones(len(owner), dtype=bool)
        if not len(owner):
            return out
        frame = _frame(tuple(way.tolist()))
        objects = np.zeros(self.low.shape[1], dtype=bool)
        objects[owner] = True
        facing = triangles[objects[self.owner[triangles]]]
        side = 1.0 if own is None else -1.0
        slope = way[0] * self.normal[0][facing] + way[1] * self.normal[1][facing] + way[2] * self.normal[2][facing]
        facing = facing[side * slope < 0.0]
        whose = self.owner[facing]
        turning = self.corner if own is None else self.corner[::-1]
        flat = [[f[0] * c[0] + f[1] * c[1] + f[2] * c[2] for f in frame[:2]] for c in turning[:, :, facing]]
        point = [f[0] * start[0] + f[1] * start[1] + f[2] * start[2] for f in frame]
        # the grid: each object's picture has its own, _BINS by _BINS
        middle, reach = (self.low + self.high) / 2, (self.high - self.low) / 2
        scale, origin = [], []
        for f in frame[:2]:
            half = np.abs(f[0]) * reach[0] + np.abs(f[1]) * reach[1] + np.abs(f[2]) * reach[2]
            half = np.maximum(half * 1.001, 1e-12)
            origin.append(f[0] * middle[0] + f[1] * middle[1] + f[2] * middle[2] - half)
            scale.append(_BINS / (2.0 * half))
        across, up = (
            np.clip((point[k] - origin[k][owner]) * scale[k][owner], 0, _BINS - 1).astype(np.int64) for k in (0, 1)
        )
        place = (owner * _BINS + up) * _BINS + across
        order = np.argsort(place, kind="stable")
        count = np.bincount(place, minlength=self.low.shape[1] * _BINS * _BINS)
        begin = np.cumsum(count) - count
        ends = []
        for k in (0, 1):
            low = np.minimum(np.minimum(flat[0][k], flat[1][k]), flat[2][k])
            high = np.maximum(np.maximum(flat[0][k], flat[1][k]), flat[2][k])
            for value in (low, high):
                ends.append(np.clip((value - origin[k][whose]) * scale[k][whose], 0, _BINS - 1).astype(np.int64))
        left, right, bottom, top = ends
        wide = right - left + 1
        lines = runs(bottom, top - bottom + 1)  # one for each triangle and row of bins that it touches
        of = np.repeat(np.arange(len(facing)), top - bottom + 1)
        head = (whose[of] * _BINS + lines) * _BINS + left[of]
        # the points of neighbouring bins of a row stand together
        first = begin[head]
        many = begin[head + wide[of] - 1] + count[head + wide[of] - 1] - first
        some = np.flatnonzero(many)
        of, first, many = of[some], first[some], many[some]
        # most triangles have no point near them, once few are left
        near = np.zeros(len(facing), dtype=bool)
        near[of] = True
        of = (np.cumsum(near) - 1)[of]
        facing, whose = facing[near], whose[near]
        f = frame[2]
        depth = [f[0] * c[0] + f[1] * c[1] + f[2] * c[2] for c in turning[:, :, facing]]
        corner = [[x[near], y[near], z] for (x, y), z in zip(flat, depth, strict=True)]
        edge = [_edges(corner, k) for k in range(3)]
        normal = side * self.normal[:, facing]
        turned = [f[0] * normal[0] + f[1] * normal[1] + f[2] * normal[2] for f in frame]
        size = _EDGE / (scale[0] * scale[1])[whose]
        total = np.cumsum(many)
        cuts = np.searchsorted(total, np.arange(_PAIRS, int(total[-1]) if len(total) else 0, _PAIRS))
        for part in np.split(np.arange(len(of)), cuts):
            if not len(part):
                continue
            ray = order[runs(first[part], many[part])]
            with_ = np.repeat(of[part], many[part])
            for a, b, c in edge:
                kept = a[with_] * point[0][ray] + b[with_] * point[1][ray] + c[with_] <= size[with_]
                ray, with_ = ray[kept], with_[kept]
            # what faces the ray lies before it where the start is on the outer side of its plane
            gap = sum(turned[k][with_] * (corner[0][k][with_] - point[k][ray]) for k in range(3))
            ahead = gap < 0.0
            if own is not None:
                ahead &= self.cell[facing[with_]] != own[ray]
            out[ray[ahead]] = False
        return out


def _edges(corner: list[list[np.ndarray]], k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coefficients of x, y, 1 that are not above 0 within edge k of triangles that face the rays."""
    (x, y, _), (p, q, _) = corner[k], corner[(k + 1) % 3]
    return y - q, p - x, x * q - p * y


@cache
def _frame(towards: tuple[float, float, float]) -> list[np.ndarray]:
    """Two axes across a direction, and the direction."""
    way = np.array(towards)
    other = np.eye(3)[int(np.argmin(np.abs(way)))]
    first = np.cross(way, other)
    first = first / np.sqrt((first * first).sum())
    return [first, np.cross(way, first), way]
