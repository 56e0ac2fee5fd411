"""Shading in NumPy for renderers without a graphics library: find what each sample shows, then light all at once, a light at a time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np
from scipy.ndimage import gaussian_filter

from ..geometry.vectors import unit
from ..records import dataclass
from .camera import Camera, Lights
from .scene import Scene

_SAMPLES = 2  # supersampling per axis
_NEAR, _FAR = 0.006, 0.025  # how far shadows on the ground run into what is around them, in widths of the picture
_OPEN = (0.1, 0.7)  # shares of the light from which on, and where wholly, they do so over the larger of these
_GROUND_REACH = 1.3  # how far from the object its shadow is looked for, in its own sizes


@dataclass(frozen=True, slots=True)
class RayHits:
    """For each ray (n,): the face it meets, -1 for none, its barycentric ``u``, ``v`` and the ``distance``."""

    face: np.ndarray
    u: np.ndarray
    v: np.ndarray
    distance: np.ndarray


class Engine(Protocol):
    """What differs between the renderers: which face a ray meets first, and which points (n, 3) see a light, 0 .. 1."""

    def begin(self, scene: Scene, opaque: np.ndarray, camera: Camera, lights: Lights, floor: float) -> None:
        """Take a scene, and the faces that cast shadows."""

    def first(self, faces: np.ndarray, rays: Rays) -> RayHits: ...

    def visible(self, points: np.ndarray, light: int) -> np.ndarray: ...


@dataclass(frozen=True, slots=True)
class Rays:
    """One ray per sample of the picture, ``edge`` samples on a side: unit directions (n, 3) from ``eye``."""

    eye: np.ndarray
    direction: np.ndarray
    edge: int


@dataclass(frozen=True, slots=True)
class _SeenSurface:
    """What is seen at some samples: position, unit normal (n, 3) towards the viewer, tint (n, 4), finish (n,) each."""

    position: np.ndarray
    normal: np.ndarray
    tint: np.ndarray
    metalness: np.ndarray
    gloss: np.ndarray


def camera_rays(camera: Camera, edge: int) -> Rays:
    """Rays through a picture of ``edge`` samples on a side."""
    steps = ((np.arange(edge) + 0.5) / edge * 2 - 1) / camera.scale
    right, up, back = camera.axes
    direction = unit(steps[None, :, None] * right - steps[:, None, None] * up - back)
    return Rays(camera.eye, direction.reshape(-1, 3), edge)


def shade_picture(
    engine: Engine, size: int, backdrop: np.ndarray, scene: Scene, camera: Camera, lights: Lights, floor: float
) -> np.ndarray:
    """Linear light (size, size, 3) of a scene that stands on the plane z = ``floor``."""
    opaque, clear = scene.split()
    engine.begin(scene, opaque, camera, lights, floor)
    rays = camera_rays(camera, size * _SAMPLES)
    image = np.broadcast_to(backdrop, rays.direction.shape).copy()
    solid = engine.first(opaque, rays)
    extent = float((scene.vertices.max(axis=0) - scene.vertices.min(axis=0)).max())

    ground = _ground_samples(scene, rays, solid, floor, extent)
    y, x = np.divmod(ground, rays.edge)
    pixels, own = np.unique(y // _SAMPLES * size + x // _SAMPLES, return_inverse=True)
    image[ground] = backdrop * _shadow(engine, lights, camera_rays(camera, size), pixels, floor)[own]
    at = np.flatnonzero(solid.face >= 0)
    image[at] = _light_up(engine, lights, _surface(scene, rays, at, solid), rays, at, backdrop, extent)[0]
    if len(clear):
        pane = engine.first(clear, rays)
        nearer = np.where(solid.face >= 0, solid.distance, np.inf)
        at = np.flatnonzero((pane.face >= 0) & (pane.distance < nearer))
        shown, alpha = _light_up(engine, lights, _surface(scene, rays, at, pane), rays, at, backdrop, extent)
        image[at] = shown * alpha[:, None] + image[at] * (1 - alpha[:, None])
    grid = image.reshape(size, _SAMPLES, size, _SAMPLES, 3)
    return np.clip(grid.mean(axis=(1, 3)), 0.0, 1.0)


def _shares(lights: Lights, edge: int, at: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Which of the samples ``at`` (indices into them) look at which lights (m,), and the irradiance (m, 3) that stands for all lights.

    Neighbours, two by two, share out all lights, so that their mean has seen every one.
    """
    count = _SAMPLES * _SAMPLES
    y, x = np.divmod(at, edge)
    share = (y % _SAMPLES) * _SAMPLES + x % _SAMPLES
    for k in range(count):
        yield np.flatnonzero(share == k), np.arange(k, len(lights.direction), count), lights.power[k::count] * count


def _dot(rows: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return rows[:, 0] * vector[..., 0] + rows[:, 1] * vector[..., 1] + rows[:, 2] * vector[..., 2]


def _surface(scene: Scene, rays: Rays, at: np.ndarray, hits: RayHits) -> _SeenSurface:
    """What the samples ``at`` show, interpolated over the faces they hit."""
    corners = scene.faces[hits.face[at]]
    u, v = hits.u[at][:, None], hits.v[at][:, None]
    share = (1 - u - v, u, v)
    normal = _unit_or_up(sum(w * scene.normals[corners[:, i]] for i, w in enumerate(share)))
    towards = -rays.direction[at]
    normal = np.where(_dot(normal, towards)[:, None] < 0, -normal, normal)
    position = rays.eye - towards * hits.distance[at][:, None]
    first = corners[:, 0]
    return _SeenSurface(position, normal, scene.colour[first], scene.metalness[first], scene.gloss[first])


def _unit_or_up(vectors: np.ndarray) -> np.ndarray:
    length = np.sqrt(_dot(vectors, vectors))[:, None]
    return np.where(length > 1e-12, vectors / np.maximum(length, 1e-12), [0.0, 0.0, 1.0])


def _light_up(
    engine: Engine, lights: Lights, seen: _SeenSurface, rays: Rays, at: np.ndarray, backdrop: np.ndarray, extent: float
) -> tuple[np.ndarray, np.ndarray]:
    """Linear light (n, 3) that leaves the surface towards the eye, and how much it covers (n,)."""
    normal, towards = seen.normal, -rays.direction[at]
    cosine = _dot(normal, towards)
    light, shine = np.empty_like(normal), np.empty_like(normal)
    # single precision and a row per axis: the loop over lights is what a picture waits for
    facing, to_eye = (np.ascontiguousarray(rows.T, dtype=np.float32) for rows in (normal, towards))
    points = (seen.position + normal * (0.004 * extent)).astype(np.float32)
    aslant, sharp = cosine.astype(np.float32), np.exp2(2.0 + 7.0 * seen.gloss).astype(np.float32)
    for mine, chosen, power in _shares(lights, rays.edge, at):
        diffuse, mirror = np.zeros((2, 3, len(mine)), dtype=np.float32)
        own, eye, start = facing.take(mine, axis=1), to_eye.take(mine, axis=1), points.take(mine, axis=0)
        tilt, narrow = aslant[mine], sharp[mine]
        for k, strength in zip(chosen.tolist(), power.astype(np.float32)[:, :, None], strict=True):
            to_light = lights.direction[k].astype(np.float32)
            cast = _dot(own.T, to_light)
            lit = np.flatnonzero(cast > 0.0)
            shown = np.zeros(len(mine), dtype=np.float32)
            shown[lit] = engine.visible(start.take(lit, axis=0), k)
            diffuse += shown * cast * strength
            if lights.sun[k]:
                middle = (cast + tilt) / np.sqrt(2 + 2 * _dot(eye.T, to_light))
                mirror += shown * np.exp2(narrow * np.log2(np.maximum(middle, 1e-6))) * strength  # faster than a power
        light[mine], shine[mine] = diffuse.T, mirror.T
    light += 0.13 + 0.10 * backdrop * (0.5 - 0.5 * normal[:, 2:])
    edge = (1 - np.maximum(cosine, 0.0)) ** 5
    metal, gloss = seen.metalness[:, None], seen.gloss[:, None]
    base = 0.04 * (1 - metal) + seen.tint[:, :3] * metal
    mirrored = _surroundings(2 * cosine[:, None] * normal - towards, lights.direction[0], 1 - seen.gloss)
    mirrored = mirrored * np.clip(np.sqrt(_dot(light, light))[:, None], 0.25, 1.1)
    fresnel = base + (1 - base) * edge[:, None] * gloss
    body = seen.tint[:, :3] * light * (1 - metal)
    colour = body + fresnel * mirrored * (0.5 * gloss * (1 - metal) + metal) + shine * base * (1 + 7 * gloss) * 1.6
    alpha = seen.tint[:, 3]
    glassy = np.clip(alpha + 0.6 * edge + np.sqrt(_dot(shine, shine)) * seen.gloss, 0.0, 1.0)
    return colour, np.where(alpha < 0.999, glassy, 1.0)


def _surroundings(direction: np.ndarray, sun: np.ndarray, rough: np.ndarray) -> np.ndarray:
    """What a mirror (n,) sees (n, 1), as in a studio: a wide light overhead, one at either side, a dim room, a bright table.

    Edges blur as the surface is ``rough`` (n,).
    """
    blur = 0.03 + 0.6 * rough
    across = np.array([-sun[1], sun[0], 0.0]) / np.hypot(sun[0], sun[1])
    up, aside = direction[:, 2], np.abs(_dot(direction, across))

    def beyond(border: float, values: np.ndarray) -> np.ndarray:
        return _smooth(border - blur, border + blur, values)

    lamp = 0.86 * beyond(0.42, up) + 0.60 * beyond(0.80, aside) * (1 - beyond(0.55, np.abs(up)))
    table = 0.30 * beyond(0.22, -up)
    glow = 0.25 * _smooth(0.55, 0.95, _dot(direction, sun))
    return (0.22 + lamp + table + glow)[:, None]


def _smooth(low: float | np.ndarray, high: float | np.ndarray, values: np.ndarray) -> np.ndarray:
    t = np.clip((values - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def _distance_to_floor(rays: Rays, at: np.ndarray, floor: float) -> np.ndarray:
    return (floor - rays.eye[2]) / np.minimum(rays.direction[at, 2], -1e-9)


def _ground_samples(scene: Scene, rays: Rays, solid: RayHits, floor: float, extent: float) -> np.ndarray:
    """Samples that show ground near enough to the object to lie in its shadow."""
    at = np.flatnonzero((solid.face < 0) & (rays.direction[:, 2] < -1e-6))
    points = rays.eye[:2] + rays.direction[at, :2] * _distance_to_floor(rays, at, floor)[:, None]
    low, high = scene.vertices.min(axis=0)[:2], scene.vertices.max(axis=0)[:2]
    away = np.maximum(np.maximum(low - points, points - high), 0.0).max(axis=1)
    return at[away < _GROUND_REACH * extent]


def _shadow(engine: Engine, lights: Lights, rays: Rays, at: np.ndarray, floor: float) -> np.ndarray:
    """How much of the open sky's light (n, 3) reaches the ground in the pixels ``at``; 1 towards the border of the picture.

    A shadow is soft, so one ray per pixel tells enough, a quarter of the lights each.
    """
    points = rays.eye + rays.direction[at] * _distance_to_floor(rays, at, floor)[:, None] + [0.0, 0.0, 1e-5]
    share, edge = np.empty_like(points), rays.edge
    for mine, chosen, power in _shares(lights, edge, at):
        up = np.maximum(lights.direction[chosen, 2:], 0.0) * power
        got, own = np.zeros((3, len(mine))), points[mine]
        for k, strength in zip(chosen.tolist(), (up / up.sum(axis=0))[:, :, None], strict=True):
            got += engine.visible(own, k) * strength
        share[mine] = got.T
    share = _soften(share, at, edge)
    y, x = np.divmod(at, edge)
    border = np.minimum(np.minimum(x, edge - 1 - x), np.minimum(y, edge - 1 - y)) / edge
    kept = _smooth(0.0, 0.12, border)[:, None]
    return 1 - kept + kept * share**0.85


def _soften(share: np.ndarray, at: np.ndarray, edge: int) -> np.ndarray:
    """Light (n, 3) of the pixels ``at`` of which what few lights miss runs into what is around it: the shadows of single lights are
    streaks where an open sky gives none. What most lights miss keeps its edge, since there the object is near."""
    known = np.zeros((edge * edge, 4))
    known[at] = np.column_stack([share, np.ones(len(share))])
    picture = known.reshape(edge, edge, 4)

    def around(width: float) -> np.ndarray:
        spread = gaussian_filter(picture, max(width * edge, _SAMPLES / 2), truncate=2.5, axes=(0, 1)).reshape(-1, 4)[at]
        return spread[:, :3] / spread[:, 3:]

    near, far = around(_NEAR), around(_FAR)
    open_to_sky = _smooth(*_OPEN, near.mean(axis=1))[:, None]
    return near + (far - near) * open_to_sky
