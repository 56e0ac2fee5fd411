"""Pictures by ray casting (embreex): soft shadows and ambient occlusion from rays towards many lights."""

from __future__ import annotations

from typing import Any

import numpy as np

from .camera import Camera, Lights
from .deferred import RayHits, Rays, shade_picture
from .scene import Scene


class Renderer:
    """Draws scenes in tiles of ``size`` pixels. Raises ImportError where embreex is missing."""

    name = "embreex"
    light_counts = (8, 24)  # sun, sky

    def __init__(self, size: int, backdrop: np.ndarray):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene, self._mesh = EmbreeScene, TriangleMesh
        self.size, self.backdrop = size, backdrop

    def render(self, scene: Scene, camera: Camera, lights: Lights, floor: float) -> np.ndarray:
        """Linear light (size, size, 3) of a scene that stands on the plane z = ``floor``."""
        return shade_picture(self, self.size, self.backdrop, scene, camera, lights, floor)

    def begin(self, scene: Scene, opaque: np.ndarray, camera: Camera, lights: Lights, floor: float) -> None:
        self.scene, self.opaque = scene, opaque
        self.casters = self._build(opaque)
        self.place = camera.picture(scene.vertices)[0]
        self.towards = lights.around().astype(np.float32)

    def _build(self, faces: np.ndarray) -> Any:
        built = self._scene()
        if len(faces):
            self._mesh(built, self.scene.vertices.astype(np.float32), self.scene.faces[faces].astype(np.int32))
        return built

    def first(self, faces: np.ndarray, rays: Rays) -> RayHits:
        """The nearest of ``faces`` that each ray meets."""
        edge = rays.edge
        face = np.full((edge, edge), -1)
        u, v, distance = (np.full((edge, edge), value, dtype=np.float32) for value in (0, 0, np.inf))
        window = self._window(faces, edge)
        way = np.ascontiguousarray(rays.direction.reshape(edge, edge, 3)[window])
        if way.size:
            origins = np.empty_like(way)
            origins[:] = rays.eye
            built = self.casters if faces is self.opaque else self._build(faces)
            found = built.run(origins.reshape(-1, 3), way.reshape(-1, 3), output=True)
            shape, number = way.shape[:2], found["primID"]
            face[window] = np.where(number >= 0, faces.take(number, mode="clip"), -1).reshape(shape)
            u[window], v[window] = found["u"].reshape(shape), found["v"].reshape(shape)
            distance[window] = found["tfar"].reshape(shape)
        return RayHits(face.ravel(), u.ravel(), v.ravel(), distance.ravel())

    def _window(self, faces: np.ndarray, edge: int) -> tuple[slice, slice]:
        """The rows and columns of the picture that hold the faces."""
        if not len(faces):
            return slice(0), slice(0)
        place = (self.place[:, self.scene.faces[faces].ravel()] + 1) * (edge / 2)
        low = np.clip(np.floor(place.min(axis=1)), 0, edge).astype(np.int64)
        high = np.clip(np.ceil(place.max(axis=1)), 0, edge).astype(np.int64)
        return slice(low[1], high[1]), slice(low[0], high[0])

    def visible(self, points: np.ndarray, light: int, kinds: np.ndarray) -> np.ndarray:
        """Which of the points (n, 3) see a light, each kind a quarter of it."""
        if not points.size or not len(self.opaque):
            return np.ones(len(points), dtype=bool)
        seen: np.ndarray = self.casters.run(points, self.towards[light].take(kinds, axis=0), query="OCCLUDED") != 0
        return seen
