"""Clouds that look different with the same labels: turns, scales, noise, and local warps as of PointWOLF (Kim et al., ICCV 2021)."""

from __future__ import annotations

import numpy as np

ANCHORS = 4


def turn(points: np.ndarray, draws: np.random.Generator, most: float = np.pi) -> np.ndarray:
    """Clouds (B, n, 3), each turned about z by up to ``most`` radians either way."""
    return _turned(points, draws.uniform(-most, most, len(points)))


def tilt_and_scale(points: np.ndarray, draws: np.random.Generator) -> np.ndarray:
    """Clouds (B, n, 3), their axes scaled by 0.8 to 1.25, each tilted and turned a little, with noise of 0.5 % of its radius: normal
    angles about each axis, of 0.06 radians and cut at 0.18, as PointNet++ has them for shapes that stand alike."""
    a, b, c = np.clip(draws.normal(0.0, 0.06, (3, len(points))), -0.18, 0.18)
    turned = _about(2, a) @ _about(1, b) @ _about(0, c)
    scaled = points * np.exp(draws.uniform(-0.22, 0.22, (len(points), 1, 3)))
    return np.einsum("bij,bnj->bni", turned, scaled) + draws.normal(0.0, 0.005, points.shape)


def _turned(points: np.ndarray, angle: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack([c * x - s * y, s * x + c * y, z], axis=-1)


def turn_and_scale(points: np.ndarray, draws: np.random.Generator) -> np.ndarray:
    """Clouds (B, n, 3), each turned about z, its axes scaled by 0.8 to 1.25, with noise of 0.5 % of its radius."""
    angle, scale = draws.uniform(0, 2 * np.pi, len(points)), np.exp(draws.uniform(-0.22, 0.22, (len(points), 1, 3)))
    turned = _turned(points * scale, angle)
    return turned + draws.normal(0.0, 0.005, turned.shape)


def warp_locally(points: np.ndarray, draws: np.random.Generator) -> np.ndarray:
    """Clouds (B, n, 3), each a blend of what ANCHORS of its points do to their surroundings: a turn by up to 15 degrees about each axis,
    a scale of 0.5 to 2 and a shift, weighted by a Gaussian about the anchor of width 0.5 along random axes."""
    count, n, _ = points.shape
    anchor = np.take_along_axis(points, draws.integers(0, n, (count, ANCHORS))[..., None], axis=1)
    rays = points[:, None] - anchor[:, :, None]  # (B, M, n, 3)
    kept = draws.integers(0, 2, (count, ANCHORS, 1, 3)).astype(np.float64)
    kept[(kept == 0).all(axis=-1)] = 1.0
    weight = np.exp(-((rays * kept) ** 2).sum(axis=-1) / (2 * 0.5**2))
    a, b, c = np.moveaxis(draws.uniform(-np.pi / 12, np.pi / 12, (count, ANCHORS, 3)), -1, 0)
    turn = _about(2, a) @ _about(1, b) @ _about(0, c)
    scale = np.exp(draws.uniform(-np.log(2), np.log(2), (count, ANCHORS, 1, 3)))
    shift = draws.uniform(-0.2, 0.2, (count, ANCHORS, 1, 3))
    moved = np.einsum("bmij,bmnj->bmni", turn, rays * scale) + anchor[:, :, None] + shift
    blend = (weight[..., None] * moved).sum(axis=1) / np.maximum(weight.sum(axis=1), 1e-12)[..., None]
    return blend - blend.mean(axis=1, keepdims=True)


def _about(axis: int, angle: np.ndarray) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    found = np.zeros((*angle.shape, 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    found[..., axis, axis] = 1.0
    found[..., i, i], found[..., j, j], found[..., i, j], found[..., j, i] = c, c, -s, s
    return found
