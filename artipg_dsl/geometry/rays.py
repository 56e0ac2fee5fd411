"""Which triangle a camera sees at each pixel: with embree where it is installed, else with NumPy alone.

Both look along the same rays and only name the triangle; where the ray meets it is computed here in double precision,
so that the two agree to the last digits wherever they name the same one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Protocol

import numpy as np

from ..native import backend, covers
from ..records import dataclass
from .vectors import cross, dot

BLOCK = 1_500_000  # candidates (triangle, pixel) looked at together
NEAR = 1e-6  # metres before the eye within which nothing is seen


@dataclass(frozen=True, slots=True)
class Grid:
    """Rays of a pinhole camera (x right, y down, z forward; lengths of the picture in pixels) on a regular grid.

    Column i runs through x = ``left + step * i``, row j through y = ``top + step * j``; the centre of the first pixel
    is (0.5, 0.5).
    """

    focal: tuple[float, float]
    centre: tuple[float, float]
    left: float
    top: float
    step: float
    columns: int
    rows: int

    def slopes(self) -> tuple[np.ndarray, np.ndarray]:
        """x / z (columns,) and y / z (rows,) of the rays."""
        x = self.left + self.step * np.arange(self.columns)
        y = self.top + self.step * np.arange(self.rows)
        return (x - self.centre[0]) / self.focal[0], (y - self.centre[1]) / self.focal[1]

    def directions(self) -> np.ndarray:
        """(rows * columns, 3) with z = 1, row by row."""
        x, y = self.slopes()
        out = np.ones((self.rows, self.columns, 3))
        out[..., 0], out[..., 1] = x, y[:, None]
        return out.reshape(-1, 3)


class Caster(Protocol):
    """Finds the first of some triangles (T, 3, 3)."""

    def first(self, turn: np.ndarray, eye: np.ndarray, grid: Grid) -> np.ndarray:
        """The triangle that each ray meets first (rows * columns,), -1 for none; ``turn`` carries into the camera."""
        ...


class Embree:
    """Rays by embree. Raises ImportError where embreex is missing."""

    def __init__(self, triangles: np.ndarray):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = EmbreeScene()
        self._mesh = TriangleMesh(self._scene, np.ascontiguousarray(triangles, dtype=np.float32))

    def first(self, turn: np.ndarray, eye: np.ndarray, grid: Grid) -> np.ndarray:
        rays = np.ascontiguousarray(rotate_vectors(turn.T, grid.directions()), dtype=np.float32)
        origins = np.broadcast_to(eye.astype(np.float32), rays.shape).copy()
        return self._scene.run(origins, rays).astype(np.int64)


class Raster:
    """Rays by a z-buffer."""

    def __init__(self, triangles: np.ndarray):
        self.triangles = triangles

    def first(self, turn: np.ndarray, eye: np.ndarray, grid: Grid) -> np.ndarray:
        local = rotate_vectors(turn, self.triangles - eye)
        seen = np.flatnonzero(_amid(self.triangles, eye) | _towards(local))[::-1]  # of coincident ones the first wins
        local = local[seen]
        low, high = _reach(local, grid)
        found, _ = cover(_perspective(local, grid), low, high, grid.columns, grid.rows)
        return np.append(seen, -1)[found].ravel()


def _towards(local: np.ndarray) -> np.ndarray:
    """Triangles that turn their outer side to the eye at the origin."""
    return dot(_normals(local), local[:, 0]) < 0


def _amid(triangles: np.ndarray, eye: np.ndarray) -> bool:
    """Whether the eye may be within a solid, so that inner sides are seen too."""
    corners = triangles.reshape(-1, 3)
    return bool(len(corners)) and bool(((eye >= corners.min(axis=0)) & (eye <= corners.max(axis=0))).all())


ENGINES: dict[str, Callable[[np.ndarray], Caster]] = {"embree": Embree, "numpy": Raster}


@lru_cache(maxsize=1)
def best_engine() -> str:
    """``embree`` where it is installed, else ``numpy``."""
    try:
        import embreex.rtcore_scene  # noqa: F401
    except ImportError:
        return "numpy"
    return "embree"


def rotate_vectors(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) times one matrix (3, 3), written out."""
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.stack([row[0] * x + row[1] * y + row[2] * z for row in matrix], axis=-1)


def _normals(triangles: np.ndarray) -> np.ndarray:
    """Normals (n, 3) of triangles (n, 3, 3), twice the area long."""
    return cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])


def intersect(triangles: np.ndarray, found: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Where rays (n, 3) from the origin meet ``triangles[found]``, of (T, 3, 3): barycentric weights (n, 3) of the corners.

    A ray that passes a triangle by a rounding error meets its border. What depends on the triangle alone is computed
    once for each; rows of ``found`` gather it column by column.
    """
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = _normals(triangles)
    square = dot(normal, normal)
    square = np.where(square == 0.0, 1.0, square)[:, None]
    across, along = cross(c - a, normal) / square, cross(normal, b - a) / square  # of places in the plane

    def gathered(vectors: np.ndarray) -> list[np.ndarray]:
        return [np.ascontiguousarray(vectors[:, k])[found] for k in range(3)]

    def product(one: list[np.ndarray], two: list[np.ndarray]) -> np.ndarray:
        return one[0] * two[0] + one[1] * two[1] + one[2] * two[2]

    way, start, up = [np.ascontiguousarray(directions[:, k]) for k in range(3)], gathered(a), gathered(normal)
    slope = product(up, way)
    distance = dot(normal, a)[found] / np.where(slope == 0.0, 1.0, slope)
    offset = [w * distance - s for w, s in zip(way, start, strict=True)]
    second = np.clip(product(offset, gathered(across)), 0.0, 1.0)
    third = np.clip(product(offset, gathered(along)), 0.0, 1.0)
    over = np.maximum(second + third, 1.0)
    out = np.empty((len(found), 3))
    out[:, 1], out[:, 2] = second / over, third / over
    out[:, 0] = 1.0 - out[:, 1] - out[:, 2]
    return out


def _reach(local: np.ndarray, grid: Grid) -> tuple[np.ndarray, np.ndarray]:
    """The columns and rows [low, high) (T, 2) within which triangles in the camera's frame lie."""
    size = np.array([grid.columns, grid.rows])
    z = local[..., 2]
    safe = np.maximum(z, NEAR)
    ends = []
    for axis, start in enumerate((grid.left, grid.top)):
        place = local[..., axis] / safe * grid.focal[axis] + grid.centre[axis]
        ends.append((place - start) / grid.step)
    place = np.stack(ends, axis=-1)
    low = np.clip(np.ceil(place.min(axis=1) - 1e-6), 0, size).astype(np.int64)
    high = np.clip(np.floor(place.max(axis=1) + 1e-6) + 1, 0, size).astype(np.int64)
    crossing = (z.min(axis=1) <= NEAR) & (z.max(axis=1) > NEAR)  # its picture has no corners: look everywhere
    low[crossing], high[crossing] = 0, size
    high[z.max(axis=1) <= NEAR] = 0
    return low, high


def _perspective(local: np.ndarray, grid: Grid) -> np.ndarray:
    """Coefficients (T, 4, 3) of column, row, 1 on a grid: three edges, inside where all are >= 0, and 1 / z.

    The edges are planes through the eye, so a triangle that reaches behind the camera needs no clipping.
    """
    a, b, c = local[:, 0], local[:, 1], local[:, 2]
    normal = _normals(local)
    side = dot(normal, a)
    flat = np.abs(side) < 1e-300
    planes = [*(cross(p, q) * np.sign(side)[:, None] for p, q in ((b, c), (c, a), (a, b)))]
    planes.append(normal / np.where(flat, 1.0, side)[:, None])
    fx, fy = grid.focal
    x0, y0 = (grid.left - grid.centre[0]) / fx, (grid.top - grid.centre[1]) / fy
    out = np.empty((len(local), 4, 3))
    for i, plane in enumerate(planes):
        x, y, z = plane.T
        out[:, i, 0], out[:, i, 1] = x * (grid.step / fx), y * (grid.step / fy)
        out[:, i, 2] = x * x0 + y * y0 + z
    out[flat, :3] = (0.0, 0.0, -1.0)  # a triangle seen from its edge covers nothing
    return out


def cover(
    planes: np.ndarray, low: np.ndarray, high: np.ndarray, columns: int, rows: int
) -> tuple[np.ndarray, np.ndarray]:
    """Nearest triangle at each place of a picture (rows, columns): its number (-1: none) and its nearness.

    ``planes`` (T, 4, 3): coefficients of column, row, 1: three edges (inside where all are >= 0) and a nearness > 0.
    ``low``, ``high`` (T, 2): the columns and rows [low, high) to look at. The winner of a place is found by a maximum
    over keys of nearness and number.
    """
    machine = backend.machine()
    if machine is not None:
        keys = covers.cover(machine, planes, low, high, columns, rows)
    else:
        keys = _cover(planes, low, high, columns, rows)
    found = (keys & np.uint64(0xFFFFFFFF)).astype(np.int64) - 1
    near = (keys >> np.uint64(32)).astype(np.uint32).view(np.float32).astype(np.float64)
    return found.reshape(rows, columns), near.reshape(rows, columns)


def _cover(planes: np.ndarray, low: np.ndarray, high: np.ndarray, columns: int, rows: int) -> np.ndarray:
    """The keys (rows * columns,): all places of all triangles are tried at once, in bounded blocks."""
    keys = np.zeros(rows * columns, dtype=np.uint64)
    band = max(1, BLOCK // max(columns, 1))
    for top in range(0, rows, band):
        first, last = np.maximum(low[:, 1], top), np.minimum(high[:, 1], top + band)
        width = np.maximum(high[:, 0] - low[:, 0], 0)
        count = width * np.maximum(last - first, 0)
        ends = np.cumsum(count)
        start = 0
        while start < len(planes):
            before = int(ends[start] - count[start])
            stop = max(start + 1, int(np.searchsorted(ends, before + BLOCK, side="right")))
            number = np.repeat(np.arange(start, stop), count[start:stop])
            within = np.arange(len(number)) - (ends - count)[number] + before
            wide = width[number]
            x, y = low[number, 0] + within % wide, first[number] + within // wide
            keep = np.arange(len(number))
            for side in range(3):  # each edge looks only at what the ones before have left
                p, i, j = planes[number[keep], side], x[keep], y[keep]
                keep = keep[p[:, 0] * i + p[:, 1] * j + p[:, 2] >= 0]
            p, i, j, number = planes[number[keep], 3], x[keep], y[keep], number[keep]
            value = p[:, 0] * i + p[:, 1] * j + p[:, 2]
            near = np.maximum(value, 1e-9).astype(np.float32).view(np.uint32)
            key = (near.astype(np.uint64) << np.uint64(32)) | (number + 1).astype(np.uint64)
            np.maximum.at(keys, j * columns + i, key)
            start = stop
    return keys
