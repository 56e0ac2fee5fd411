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
    light_counts = (12, 32)  # sun, sky

    def __init__(self, size: int, backdrop: np.ndarray):
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene, self._mesh = EmbreeScene, TriangleMesh
        self.size, self.backdrop = size, backdrop

    def render(self, scene: Scene, camera: Camera, lights: Lights, floor: float) -> np.ndarray:
        """Linear light (size, size, 3) of a scene that stands on the plane z = ``floor``."""
        return shade_picture(self, self.size, self.backdrop, scene, camera, lights, floor)

    def begin(self, scene: Scene, camera: Camera, lights: Lights, floor: float) -> None:
        self.scene, self.lights = scene, lights
        opaque, _ = scene.split()
        self.casters = self._build(opaque)

    def _build(self, faces: np.ndarray) -> Any:
        triangles = self.scene.vertices[self.scene.faces[faces]].astype(np.float32)
        built = self._scene()
        if len(triangles):
            self._mesh(built, np.ascontiguousarray(triangles))
        return built

    def first(self, faces: np.ndarray, rays: Rays) -> RayHits:
        """The nearest of ``faces`` that each ray meets."""
        count = len(rays.direction)
        if not len(faces):
            return RayHits(np.full(count, -1), np.zeros(count), np.zeros(count), np.full(count, np.inf))
        origins = np.broadcast_to(rays.eye.astype(np.float32), (count, 3)).copy()
        found = self._build(faces).run(origins, rays.direction.astype(np.float32), output=True)
        met = found["primID"] >= 0
        face = np.where(met, faces[np.maximum(found["primID"], 0)], -1)
        return RayHits(face, found["u"].astype(float), found["v"].astype(float), found["tfar"].astype(float))

    def visible(self, points: np.ndarray, light: int) -> np.ndarray:
        """Which of the points (n, 3) see a light, 0 or 1."""
        if not points.size or not len(self.scene.split()[0]):
            return np.ones(len(points))
        towards = np.broadcast_to(self.lights.direction[light].astype(np.float32), points.shape)
        origins = points.astype(np.float32)
        return (self.casters.run(origins, np.ascontiguousarray(towards), query="OCCLUDED") != 0).astype(float)
