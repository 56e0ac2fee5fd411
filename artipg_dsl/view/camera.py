"""Where one looks from, and where the light comes from: shared by all renderers, so that their pictures agree."""

from __future__ import annotations

import numpy as np

from ..geometry.vectors import unit
from ..records import dataclass

_FIELD = np.radians(24.0)  # a long lens: little distortion
_MARGIN = 1.1  # of what is seen to what is to be seen
SUN, SKY = np.array([[1.0, 0.985, 0.95], [0.96, 0.985, 1.0]], dtype=np.float32)  # colours of light


@dataclass(frozen=True, slots=True)
class Camera:
    """``eye`` (3,), rows of ``axes`` (3, 3): right, up, backward; ``scale`` = 1 / tan(half the field of view)."""

    eye: np.ndarray
    axes: np.ndarray
    scale: float
    near: float
    far: float

    def local(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) in the camera's axes, (3, n): x right, y up, z backward."""
        return _along(self.axes, points - self.eye)

    def picture(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where points (n, 3) appear: places (2, n) right and down from the middle, -1 .. 1 within the picture, and depths (n,)."""
        x, y, z = self.local(points)
        return np.stack([x, -y]) * (self.scale / -z), -z

    def matrix(self) -> np.ndarray:
        """World to clip coordinates (4, 4), OpenGL's way."""
        view = np.eye(4)
        view[:3, :3] = self.axes
        view[:3, 3] = -self.axes @ self.eye
        n, f, s = self.near, self.far, self.scale
        lens = np.array([[s, 0, 0, 0], [0, s, 0, 0], [0, 0, (f + n) / (n - f), 2 * f * n / (n - f)], [0, 0, -1.0, 0]])
        return lens @ view


@dataclass(frozen=True, slots=True)
class Lights:
    """Directions towards the lights (K, 3); the ``strength`` (K,) of each, of ``SUN`` or ``SKY``, and which, ``sun`` (K,) bool.

    Each stands for all light from as far around it as ``spread`` (K,), a tangent.
    """

    direction: np.ndarray
    strength: np.ndarray
    sun: np.ndarray
    spread: np.ndarray

    def around(self) -> np.ndarray:
        """Unit directions (K, 4, 3) towards the middles of the quarters of each light."""
        aside = unit(np.cross(self.direction, [0.0, 0.0, 1.0]))
        turn = np.arange(len(aside))[:, None] + np.arange(4) * (np.pi / 2)  # no two lights alike
        way = (
            np.cos(turn)[..., None] * aside[:, None]
            + np.sin(turn)[..., None] * np.cross(self.direction, aside)[:, None]
        )
        return unit(self.direction[:, None] + self.spread[:, None, None] / 2 * way)

    def power(self) -> np.ndarray:
        """The irradiance (K, 3) that each gives what faces it."""
        return self.strength[:, None] * np.where(self.sun[:, None], SUN, SKY)


def look_at(points: np.ndarray, azimuth: float = 33.0, elevation: float = 24.0) -> Camera:
    """A camera ``azimuth`` degrees to the left of the front, ``elevation`` above, that sees all ``points`` (n, 3)."""
    a, e = np.radians(azimuth), np.radians(elevation)
    back = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    axes = np.stack([right, np.cross(back, right), back])
    scale = 1.0 / np.tan(_FIELD / 2)
    seen = _along(axes, points)
    middle = (seen.min(axis=1) + seen.max(axis=1)) / 2
    for _ in range(8):  # put the projected box into the middle: perspective makes near things larger
        across, behind = seen[:2] - middle[:2, None], seen[2] - middle[2]
        distance = (np.abs(across) * (scale * _MARGIN) + behind).max()
        projected = across / (distance - behind)
        middle[:2] += (projected.min(axis=1) + projected.max(axis=1)) / 2 * distance
    eye = axes.T @ middle + back * distance
    size = np.abs(seen - middle[:, None]).max() * 4
    return Camera(eye, axes, scale, max(distance - size, distance * 0.02), distance + 3 * size)


def _along(axes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Coordinates (3, n) of points (n, 3) along axes (3, 3), row by row: one reads them far faster than in threes."""
    x, y, z = points.T
    return np.stack([axis[0] * x + axis[1] * y + axis[2] * z for axis in axes])


def place_lights(camera: Camera, sun_count: int = 12, sky_count: int = 32) -> Lights:
    """A broad sun from above the viewer's left and a sky, as bundles of parallel lights that each cast a shadow.

    The counts are multiples of 4: the samples of a pixel share the lights out (``deferred._quarters``).
    """
    right, _, back = camera.axes
    main = unit(-0.75 * right + 0.55 * back + np.array([0.0, 0.0, 1.0]))
    a = unit(np.cross(main, [0.0, 0.0, 1.0]))
    b = np.cross(main, a)
    turn = np.pi * (3 - np.sqrt(5))
    i = np.arange(sun_count)
    radius = 0.16 * np.sqrt((i + 0.5) / sun_count)
    disc = radius[:, None] * (np.cos(turn * i)[:, None] * a + np.sin(turn * i)[:, None] * b)
    sun = unit(main + disc)
    j = np.arange(sky_count)
    z = 0.06 + 0.92 * (j + 0.5) / sky_count  # even over the upper half of the sphere
    flat = np.sqrt(1 - z * z)
    sky = np.stack([flat * np.cos(turn * j + 0.5), flat * np.sin(turn * j + 0.5), z], axis=-1)
    # a little more light from the viewer's side than from behind the object
    share = 1.0 + 0.55 * (sky * unit(back * [1.0, 1.0, 0.0])).sum(axis=-1)
    strength = np.concatenate([np.full(sun_count, 0.58 / sun_count), share * (0.94 / sky_count)])
    of_sun = np.arange(sun_count + sky_count) < sun_count
    spread = np.where(of_sun, 0.16 / np.sqrt(sun_count), np.sqrt(2 / sky_count))  # each a disc of its share
    return Lights(np.concatenate([sun, sky]), strength, of_sun, spread)
