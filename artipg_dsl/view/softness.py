"""Light that few rays have found, spread over the pixels around: shadows of single lights are streaks where an open sky gives none."""

from __future__ import annotations

import numpy as np

_NEAR, _FAR = 0.006, 0.025  # how far shadows on the ground run into what is around them, in widths of the picture
_OPEN = (0.1, 0.7)  # shares of the light from which on, and where wholly, they do so over the larger of these
_LEAST = 1.0  # pixels, which a shadow on the ground runs at least
_BENT, _APART = 0.9, 0.03  # neighbours show one surface if the product of normals is above, distances differ by less


def soften_ground(got: np.ndarray, at: np.ndarray, edge: int, power: np.ndarray) -> np.ndarray:
    """Light (3, n) of the pixels ``at`` that see some of the sky's light and of the sun's, ``got`` (2, n), whose ``power`` is (3, 2).

    What few lights miss runs into what is around it. What most lights miss keeps its edge, since there the object is near.
    """
    known = np.zeros((3, edge * edge), dtype=np.float32)
    known[:2, at], known[2, at] = got, 1
    power = (power / power.sum(axis=1, keepdims=True)).astype(np.float32)

    def around(width: float) -> np.ndarray:
        spread = blur(known.reshape(3, edge, edge), max(width * edge, _LEAST)).reshape(3, -1).take(at, axis=1)
        spread[:2] /= spread[2]
        return power[:, :1] * spread[0] + power[:, 1:] * spread[1]

    near, far = around(_NEAR), around(_FAR)
    return near + (far - near) * smooth(*_OPEN, near.mean(axis=0))


def spread_over_surface(
    light: np.ndarray, at: np.ndarray, edge: int, normal: np.ndarray, distance: np.ndarray
) -> np.ndarray:
    """Light (k, n) in the pixels ``at`` of a picture, by (1, 2, 1) / 4 along rows and columns: neighbours two by two weigh alike.

    It stays on the surface: neighbours count whose unit ``normal`` (3, n) is nearly the same, and whose ``distance`` (n,) from the eye is,
    in sizes of the object.
    """
    facing, far, picture = (np.zeros((k, edge, edge), dtype=np.float32) for k in (3, 1, len(light)))
    for grid, values in ((facing, normal), (far, distance), (picture, light)):
        grid.reshape(len(grid), -1)[:, at] = values
    for before, after in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:, :, :-1], np.s_[:, :, 1:])):
        product = (facing[before] * facing[after]).sum(axis=0, keepdims=True)  # 0 where nothing is shown
        same = product > _BENT
        same &= np.abs(far[before] - far[after]) < _APART
        total, spread = np.full_like(far, 2), picture * 2
        for here, there in ((before, after), (after, before)):
            total[here] += same
            spread[here] += picture[there] * same
        picture = spread / total
    return picture.reshape(len(light), -1).take(at, axis=1)


def smooth(low: float | np.ndarray, high: float | np.ndarray, values: np.ndarray) -> np.ndarray:
    t = np.clip((values - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def blur(picture: np.ndarray, sigma: float) -> np.ndarray:
    """Pictures (k, n, n) through a Gaussian filter, black beyond their borders. SciPy's takes longer to import than a picture to draw."""
    weight = np.exp(-0.5 * (np.arange(int(2.5 * sigma + 0.5) + 1) / sigma) ** 2)
    weight = (weight / (2 * weight.sum() - weight[0])).astype(np.float32)
    for _ in range(2):  # along rows, then along columns
        spread, some = picture * weight[0], np.empty_like(picture)
        for k, share in enumerate(weight[1:].tolist(), 1):
            np.multiply(picture, share, out=some)
            spread[:, :, k:] += some[:, :, :-k]
            spread[:, :, :-k] += some[:, :, k:]
        picture = np.ascontiguousarray(spread.transpose(0, 2, 1))
    return picture
