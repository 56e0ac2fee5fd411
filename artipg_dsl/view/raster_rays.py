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

    def begin(self, scene: Scene, opaque: np.ndarray, camera: Camera, lights: Lights, floor: float) -> None:
        self.scene, self.lights = scene, lights
        self.opaque, self.casters = opaque, self._build(opaque)
        self.place = camera.picture(scene.vertices)[0]

    def _build(self, faces: np.ndarray) -> Any:
        triangles = self.scene.vertices[self.scene.faces[faces]].astype(np.float32)
        built = self._scene()
        if len(triangles):
            self._mesh(built, np.ascontiguousarray(triangles))
        return built

    def first(self, faces: np.ndarray, rays: Rays) -> RayHits:
        """The nearest of ``faces`` that each ray meets."""
        count = len(rays.direction)
        hits = RayHits(np.full(count, -1), np.zeros(count), np.zeros(count), np.full(count, np.inf))
        at = self._window(faces, rays.edge)
        if len(at):
            origins = np.broadcast_to(rays.eye.astype(np.float32), (len(at), 3)).copy()
            built = self.casters if faces is self.opaque else self._build(faces)
            found = built.run(origins, rays.direction[at].astype(np.float32), output=True)
            met = np.flatnonzero(found["primID"] >= 0)
            hits.face[at[met]] = faces[found["primID"][met]]
            for values, name in ((hits.u, "u"), (hits.v, "v"), (hits.distance, "tfar")):
                values[at[met]] = found[name][met]
        return hits

    def _window(self, faces: np.ndarray, edge: int) -> np.ndarray:
        """The samples in the rectangle of the picture that holds the faces."""
        if not len(faces):
            return np.empty(0, dtype=np.int64)
        place = (self.place[:, self.scene.faces[faces].ravel()] + 1) * (edge / 2)
        low = np.clip(np.floor(place.min(axis=1)), 0, edge).astype(np.int64)
        high = np.clip(np.ceil(place.max(axis=1)), 0, edge).astype(np.int64)
        return (np.arange(low[1], high[1])[:, None] * edge + np.arange(low[0], high[0])).ravel()

    def visible(self, points: np.ndarray, light: int) -> np.ndarray:
        """Which of the points (n, 3) see a light, 0 or 1."""
        if not points.size or not len(self.opaque):
            return np.ones(len(points))
        towards = np.broadcast_to(self.lights.direction[light].astype(np.float32), points.shape)
        origins = points.astype(np.float32)
        return (self.casters.run(origins, np.ascontiguousarray(towards), query="OCCLUDED") != 0).astype(float)
