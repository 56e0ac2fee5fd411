"""Shading in NumPy for renderers without a graphics library: find what each sample shows, then light all at once, a light at a time.

Single precision, and a row for each axis: what a picture waits for is how often its samples are read.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Protocol

import numpy as np

from ..records import dataclass
from .camera import SKY, SUN, Camera, Lights
from .scene import Scene
from .softness import smooth, soften_ground, spread_over_surface

_SAMPLES = 2  # supersampling per axis
_QUARTERS = _SAMPLES * _SAMPLES  # the samples of a pixel, and the parts into which they share out all lights
_GROUND_REACH = 1.3  # how far from the object its shadow is looked for, in its own sizes


@dataclass(frozen=True, slots=True)
class RayHits:
    """For each ray (n,): the face it meets, -1 for none, its barycentric ``u``, ``v`` and the ``distance``."""

    face: np.ndarray
    u: np.ndarray
    v: np.ndarray
    distance: np.ndarray

    def part(self, of: Callable[[np.ndarray], np.ndarray]) -> RayHits:
        """What ``of`` takes from each of these arrays."""
        return RayHits(of(self.face), of(self.u), of(self.v), of(self.distance))


@dataclass(frozen=True, slots=True)
class Rays:
    """One ray per sample of the picture, ``edge`` samples on a side: unit directions (n, 3) from ``eye``, row by row."""

    eye: np.ndarray
    direction: np.ndarray
    edge: int


class Engine(Protocol):
    """What differs between the renderers: which face a ray meets first, and which points (n, 3) see a light, 0 .. 1.

    Of four ``kinds`` (n,) of points, each may look for the light at a place of its own around it.
    """

    def begin(self, scene: Scene, opaque: np.ndarray, camera: Camera, lights: Lights, floor: float) -> None:
        """Take a scene, and the faces that cast shadows."""

    def first(self, faces: np.ndarray, rays: Rays) -> RayHits: ...

    def visible(self, points: np.ndarray, light: int, kinds: np.ndarray) -> np.ndarray: ...


@dataclass(frozen=True, slots=True)
class _Seen:
    """What some samples show, one in each pixel ``at`` (n,): ``position``, unit ``normal``, direction ``towards`` the viewer (3, n);
    ``distance`` (n,) from there; ``colour`` (4, n); finish (n,) each.
    """

    at: np.ndarray
    position: np.ndarray
    normal: np.ndarray
    towards: np.ndarray
    distance: np.ndarray
    colour: np.ndarray
    metalness: np.ndarray
    gloss: np.ndarray


def camera_rays(camera: Camera, edge: int) -> Rays:
    """Rays through a picture of ``edge`` samples on a side."""
    steps = ((np.arange(edge) + 0.5) / edge * 2 - 1) / camera.scale
    right, up, back = camera.axes
    shorter = 1 / np.sqrt(steps * steps + (steps * steps + 1)[:, None])
    direction = np.empty((edge, edge, 3), dtype=np.float32)
    for axis in range(3):
        direction[..., axis] = (right[axis] * steps - (up[axis] * steps + back[axis])[:, None]) * shorter
    return Rays(camera.eye.astype(np.float32), direction.reshape(-1, 3), edge)


def shade_picture(
    engine: Engine, size: int, backdrop: np.ndarray, scene: Scene, camera: Camera, lights: Lights, floor: float
) -> np.ndarray:
    """Linear light (size, size, 3) of a scene that stands on the plane z = ``floor``."""
    opaque, clear = scene.split()
    engine.begin(scene, opaque, camera, lights, floor)
    rays = camera_rays(camera, size * _SAMPLES)
    solid, pane = engine.first(opaque, rays), engine.first(clear, rays) if len(clear) else None
    extent = float((scene.vertices.max(axis=0) - scene.vertices.min(axis=0)).max())
    behind = backdrop.astype(np.float32)[:, None]
    parts = [partial(_quarter, rays.edge, k) for k in range(_QUARTERS)]

    ground = np.empty((3, size * size), dtype=np.float32)
    ground[:] = behind
    bare = np.flatnonzero(np.any([part(solid.face) < 0 for part in parts], axis=0))
    bare, point = _ground_points(scene, camera_rays(camera, size), bare, floor, extent)
    ground[:, bare] *= _shadow(engine, lights, bare, point, size)
    image = np.zeros_like(ground)
    look = _Look(scene)
    for quarter, part in enumerate(parts):
        shown, way, hits = ground.copy(), part(rays.direction), solid.part(part)
        at = np.flatnonzero(hits.face >= 0)
        shown[:, at] = _light_up(engine, lights, quarter, look.seen(rays.eye, way, at, hits), behind, extent, size)[0]
        if pane is not None:
            nearer, hits = np.where(hits.face >= 0, hits.distance, np.inf), pane.part(part)
            at = np.flatnonzero((hits.face >= 0) & (hits.distance < nearer))
            seen = look.seen(rays.eye, way, at, hits)
            colour, cover = _light_up(engine, lights, quarter, seen, behind, extent, size)
            shown[:, at] = colour * cover + shown[:, at] * (1 - cover)
        image += shown
    return np.clip(image.T.reshape(size, size, 3) / _QUARTERS, 0.0, 1.0)


def _quarter(edge: int, quarter: int, samples: np.ndarray) -> np.ndarray:
    """Of what all samples (edge * edge, ...) have, every second row and column, from one of the four places where these can begin.

    Neighbours, two by two, share out all lights, so that their mean has seen every one: a quarter looks at ``_lights_of`` it.
    """
    down, right = divmod(quarter, _SAMPLES)
    shape = samples.shape[1:]
    return samples.reshape(edge, edge, *shape)[down::_SAMPLES, right::_SAMPLES].reshape(-1, *shape)


def _kinds(row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """Which of the four places in a square of two by two each is, 0 .. 3."""
    return row % 2 * 2 + column % 2


def _lights_of(lights: Lights, quarter: int) -> range:
    """The numbers of those lights at which a quarter of the samples looks."""
    return range(quarter, len(lights.direction), _QUARTERS)


def _dot(rows: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Scalar products (n,) of (3, n) with (3, n) or (3,)."""
    found = rows[0] * other[0]
    found += rows[1] * other[1]
    found += rows[2] * other[2]
    return found


class _Look:
    """What faces show at their corners, a row for each component."""

    def __init__(self, scene: Scene):
        self.corner = np.ascontiguousarray(scene.faces.T)
        self.normal, self.colour = (np.ascontiguousarray(a.T, dtype=np.float32) for a in (scene.normals, scene.colour))
        self.metalness, self.gloss = (a.astype(np.float32) for a in (scene.metalness, scene.gloss))

    def seen(self, eye: np.ndarray, direction: np.ndarray, at: np.ndarray, hits: RayHits) -> _Seen:
        """What those rays ``at`` show, of ``direction`` (n, 3) from ``eye``, which hit faces, interpolated over these."""
        u, v = hits.u.take(at), hits.v.take(at)
        corners = self.corner.take(hits.face.take(at), axis=1)
        normal = self.normal.take(corners[0], axis=1) * (1 - u - v)
        normal += self.normal.take(corners[1], axis=1) * u
        normal += self.normal.take(corners[2], axis=1) * v
        way = np.ascontiguousarray(direction.take(at, axis=0).T)
        long = np.sqrt(_dot(normal, normal))
        lost = long < 1e-12
        normal[:, lost], long[lost] = [[0], [0], [1]], 1
        normal /= np.where(_dot(normal, way) > 0, -long, long)  # towards the viewer
        first = corners[0]
        colour, finish = self.colour.take(first, axis=1), (self.metalness.take(first), self.gloss.take(first))
        distance = hits.distance.take(at)
        return _Seen(at, eye[:, None] + way * distance, normal, -way, distance, colour, *finish)


def _light_up(
    engine: Engine, lights: Lights, quarter: int, seen: _Seen, backdrop: np.ndarray, extent: float, size: int
) -> tuple[np.ndarray, np.ndarray]:
    """Linear light (3, n) that leaves the surface towards the eye, and how much it covers (n,); by a quarter of the lights."""
    normal, metal, gloss = seen.normal, seen.metalness, seen.gloss
    tilt = _dot(normal, seen.towards)
    start = np.ascontiguousarray((seen.position + normal * (0.004 * extent)).T)
    narrow, kinds = np.exp2(2 + 7 * gloss), _kinds(*np.divmod(seen.at, size))
    light, glint = np.zeros((2, len(tilt)), dtype=np.float32), np.zeros(len(tilt), dtype=np.float32)
    direction, strength = lights.direction.astype(np.float32), (lights.strength * _QUARTERS).astype(np.float32)
    for k in _lights_of(lights, quarter):
        to_light = direction[k]
        cast = _dot(normal, to_light)
        lit = np.flatnonzero(cast > 0)
        shown = np.zeros_like(cast)
        shown[lit] = engine.visible(start.take(lit, axis=0), k, kinds.take(lit)) * strength[k]
        if lights.sun[k]:
            middle = (cast + tilt) / np.sqrt(2 + 2 * _dot(seen.towards, to_light))
            glint += shown * np.exp2(narrow * np.log2(np.maximum(middle, 1e-6)))  # faster than a power
        light[int(lights.sun[k])] += shown * cast
    sky, sun = spread_over_surface(light, seen.at, size, normal, seen.distance / extent)
    light = SUN[:, None] * sun + SKY[:, None] * sky + 0.13 + 0.10 * backdrop * (0.5 - 0.5 * normal[2])
    shine = SUN[:, None] * glint
    edge = (1 - np.maximum(tilt, 0)) ** 5
    base = 0.04 * (1 - metal) + seen.colour[:3] * metal
    mirrored = _surroundings(2 * tilt * normal - seen.towards, lights.direction[0], 1 - gloss)
    mirrored *= np.clip(np.sqrt(_dot(light, light)), 0.25, 1.1)
    fresnel = base + (1 - base) * (edge * gloss)
    body = seen.colour[:3] * light * (1 - metal)
    colour = body + fresnel * (mirrored * (0.5 * gloss * (1 - metal) + metal)) + shine * base * (1.6 * (1 + 7 * gloss))
    alpha = seen.colour[3]
    glassy = np.clip(alpha + 0.6 * edge + np.sqrt(_dot(shine, shine)) * gloss, 0, 1)
    return colour, np.where(alpha < 0.999, glassy, np.float32(1))


def _surroundings(direction: np.ndarray, sun: np.ndarray, rough: np.ndarray) -> np.ndarray:
    """What a mirror sees (n,) along directions (3, n), as in a studio: a wide light overhead, one at either side, a dim room, a bright table.

    Edges blur as the surface is ``rough`` (n,).
    """
    sun = sun.astype(np.float32)
    blur = 0.03 + 0.6 * rough
    up, aside = direction[2], np.abs(direction[1] * sun[0] - direction[0] * sun[1]) / np.hypot(sun[0], sun[1])

    def beyond(border: float, values: np.ndarray) -> np.ndarray:
        return smooth(border - blur, border + blur, values)

    lamp = 0.86 * beyond(0.42, up) + 0.60 * beyond(0.80, aside) * (1 - beyond(0.55, np.abs(up)))
    table = 0.30 * beyond(0.22, -up)
    return 0.22 + lamp + table + 0.25 * smooth(0.55, 0.95, _dot(direction, sun))


def _ground_points(
    scene: Scene, rays: Rays, bare: np.ndarray, floor: float, extent: float
) -> tuple[np.ndarray, np.ndarray]:
    """Those of the rays ``bare`` that meet ground near enough to the object to lie in its shadow, and where (n, 3)."""
    x, y, z = (np.ascontiguousarray(rays.direction[:, axis]).take(bare) for axis in range(3))
    far = (np.float32(floor) - rays.eye[2]) / np.minimum(z, -1e-9)
    point = np.stack([rays.eye[0] + x * far, rays.eye[1] + y * far, np.full_like(x, floor + 1e-5)], axis=1)
    near = z < -1e-6
    for axis in range(2):
        low, high = scene.vertices[:, axis].min(), scene.vertices[:, axis].max()
        near &= np.abs(point[:, axis] - (low + high) / 2) < (high - low) / 2 + _GROUND_REACH * extent
    return bare[near], point[near]


def _shadow(engine: Engine, lights: Lights, at: np.ndarray, point: np.ndarray, edge: int) -> np.ndarray:
    """How much of the open sky's light (3, n) reaches the ground in the pixels ``at``; 1 towards the border of the picture.

    A shadow is soft, so one ray per pixel tells enough, a quarter of the lights each.
    """
    y, x = np.divmod(at, edge)
    own, kinds = _kinds(y, x), _kinds(y // 2, x // 2)
    source = lights.sun.astype(int)  # the sky, the sun
    up = (np.maximum(lights.direction[:, 2], 0) * lights.strength).astype(np.float32)
    got = np.zeros((2, len(at)), dtype=np.float32)
    for quarter in range(_QUARTERS):
        mine, chosen = np.flatnonzero(own == quarter), _lights_of(lights, quarter)
        start, seen = point.take(mine, axis=0), np.zeros((2, len(mine)), dtype=np.float32)
        for k in chosen:
            seen[source[k]] += engine.visible(start, k, kinds.take(mine)) * up[k]
        got[:, mine] = seen / np.bincount(source[chosen], up[chosen])[:, None]
    share = soften_ground(got, at, edge, np.stack([SKY, SUN], axis=1) * np.bincount(source, up))
    border = np.minimum(np.minimum(x, edge - 1 - x), np.minimum(y, edge - 1 - y)).astype(np.float32) / edge
    kept = smooth(0.0, 0.12, border)
    return 1 - kept + kept * share ** np.float32(0.85)
