"""Pictures with NumPy alone: a z-buffer over all triangles at once, shadow maps from the same rasteriser."""

from __future__ import annotations

import numpy as np

from ..geometry.rays import cover
from ..geometry.vectors import extent
from .camera import Camera, Lights
from .deferred import RayHits, Rays, shade_picture
from .raster_gl import light_matrices
from .scene import Scene

_MAP = 112  # pixels of one shadow map


class Renderer:
    """Draws scenes in tiles of ``size`` pixels."""

    name = "numpy"
    light_counts = (8, 20)  # sun, sky

    def __init__(self, size: int, backdrop: np.ndarray):
        self.size, self.backdrop = size, backdrop

    def render(self, scene: Scene, camera: Camera, lights: Lights, floor: float) -> np.ndarray:
        """Linear light (size, size, 3) of a scene that stands on the plane z = ``floor``."""
        return shade_picture(self, self.size, self.backdrop, scene, camera, lights, floor)

    def begin(self, scene: Scene, opaque: np.ndarray, camera: Camera, lights: Lights, floor: float) -> None:
        """Draw the shadow map of every light: the depth (K, MAP, MAP) along it of what is nearest."""
        self.scene, self.camera = scene, camera
        triangles = scene.vertices[scene.faces[opaque]]
        low, high = scene.vertices.min(axis=0), scene.vertices.max(axis=0)
        low[2] = min(low[2], floor)
        self.matrices = light_matrices(lights, low, high)
        self.maps = np.zeros((len(self.matrices), _MAP + 2, _MAP + 2), dtype=np.float32)
        for k in range(len(self.matrices)):
            local = self._to_light(triangles.reshape(-1, 3), k).T.reshape(-1, 3, 3)
            self.maps[k, 1:-1, 1:-1] = rasterise(local[..., :2] * _MAP, local[..., 2], _MAP)[1]

    def _to_light(self, points: np.ndarray, k: int) -> np.ndarray:
        """Points (n, 3) in the map of light ``k``, (3, n): x, y and nearness to the light, all 0 .. 1."""
        m = self.matrices[k] * [[0.5], [0.5], [-0.5], [1.0]]
        x, y, z = points.T
        return np.stack([m[i, 0] * x + m[i, 1] * y + m[i, 2] * z + (m[i, 3] + 0.5) for i in range(3)])

    def visible(self, points: np.ndarray, light: int, kinds: np.ndarray) -> np.ndarray:
        """How much of a light each of the points (n, 3) sees: the weighted mean of the four texels around it."""
        x, y, near = self._to_light(points.astype(np.float32), light)
        x, y, near = np.clip(x, 0, 1) * _MAP + 0.5, np.clip(y, 0, 1) * _MAP + 0.5, np.maximum(near, 0) + 0.008
        i, j = x.astype(np.int32), y.astype(np.int32)  # texels of a map with a free border of one
        fx, fy = x - i, y - j
        at, map_ = j * (_MAP + 2) + i, self.maps[light].ravel()
        below = (map_[at] < near) * (1 - fx) + (map_[at + 1] < near) * fx
        above = (map_[at + _MAP + 2] < near) * (1 - fx) + (map_[at + _MAP + 3] < near) * fx
        return below * (1 - fy) + above * fy

    def first(self, faces: np.ndarray, rays: Rays) -> RayHits:
        """The nearest of ``faces`` at each sample of the picture."""
        place, depth = self.camera.picture(self.scene.vertices)
        corners = self.scene.faces[faces]
        triangle = ((place.T + 1) * (rays.edge / 2))[corners]
        nearness = 1.0 / depth[corners]  # varies linearly over the picture
        found, near = rasterise(triangle, nearness, rays.edge)
        found, near = found.ravel(), near.ravel()
        met = np.flatnonzero(found >= 0)
        u, v, distance = (np.full(found.size, value, dtype=np.float32) for value in (0, 0, np.inf))
        y, x = np.divmod(met, rays.edge)
        weights = barycentric(triangle[found[met]], x + 0.5, y + 0.5) * nearness[found[met]]
        weights = weights / weights.sum(axis=1, keepdims=True)  # true over the triangle, not over its picture
        u[met], v[met] = weights[:, 1], weights[:, 2]
        back = (rays.direction[met] * -self.camera.axes[2]).sum(axis=1)
        distance[met] = 1.0 / (near[met] * back)
        face = np.full(found.size, -1)
        face[met] = faces[found[met]]
        return RayHits(face, u, v, distance)


def barycentric(triangle: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Weights (n, 3) of the corners of triangles (n, 3, 2) at points of the plane."""
    a, b, c = triangle[:, 0], triangle[:, 1], triangle[:, 2]
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    first = (b[:, 0] - x) * (c[:, 1] - y) - (b[:, 1] - y) * (c[:, 0] - x)
    second = (c[:, 0] - x) * (a[:, 1] - y) - (c[:, 1] - y) * (a[:, 0] - x)
    area = np.where(area == 0, 1.0, area)
    return np.stack([first / area, second / area, 1 - (first + second) / area], axis=1)


def rasterise(triangle: np.ndarray, nearness: np.ndarray, edge: int) -> tuple[np.ndarray, np.ndarray]:
    """Nearest triangle at each pixel of an ``edge`` x ``edge`` picture: its number (-1: none) and its nearness.

    ``triangle`` (T, 3, 2) in pixels, ``nearness`` (T, 3) > 0 and linear over the picture.
    """
    low, high = extent(triangle)
    low = np.clip(np.ceil(low - 0.5), 0, edge).astype(np.int64)
    high = np.clip(np.floor(high - 0.5) + 1, 0, edge).astype(np.int64)
    return cover(_planes(triangle, nearness), low, high, edge, edge)


def _planes(triangle: np.ndarray, nearness: np.ndarray) -> np.ndarray:
    """Coefficients (T, 4, 3) of x, y, 1 at pixel centres: three edges (inside where all are >= 0) and the nearness."""
    coefficients = np.zeros((4, 3, len(triangle)))
    (ax, ay), (bx, by), (cx, cy) = (np.ascontiguousarray(triangle[:, k].T) for k in range(3))
    area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    flat = np.abs(area) < 1e-12
    scale = 1.0 / np.where(flat, 1.0, area)
    for i, (px, py, qx, qy) in enumerate(((bx, by, cx, cy), (cx, cy, ax, ay), (ax, ay, bx, by))):
        dx, dy = (py - qy) * scale, (qx - px) * scale
        coefficients[i] = dx, dy, -(dx * (px - 0.5) + dy * (py - 0.5))
        coefficients[3] += coefficients[i] * nearness[:, i]
    coefficients[:3, :, flat] = -1.0  # a triangle seen from its edge covers nothing
    return coefficients.transpose(2, 0, 1)
