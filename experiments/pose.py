"""Poses of parts from normalised coordinates, and how far they are off, as GAPartNet and ANCSH compute it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ROUNDS, PICKED = 100, 5  # of RANSAC
NEAR = 0.05  # of the part's diagonal: a point agrees with a pose
GRID = 50  # cells to a side by which boxes are compared


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Canonical coordinates ``u`` lie at ``scale * rotation @ u + shift``; ``half`` (3,): half the edges of the box about 0, canonical."""

    rotation: np.ndarray
    shift: np.ndarray
    scale: float
    half: np.ndarray


def umeyama(source: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rotations (B, 3, 3), scales (B,) and shifts (B, 3) that bring ``source`` (B, n, 3) nearest to ``target`` (Umeyama, TPAMI 1991)."""
    a, b = source.mean(axis=1, keepdims=True), target.mean(axis=1, keepdims=True)
    x, y = source - a, target - b
    u, s, v = np.linalg.svd(np.swapaxes(y, 1, 2) @ x / source.shape[1])
    sign = np.ones_like(s)
    sign[:, 2] = np.where(np.linalg.det(u) * np.linalg.det(v) < 0, -1.0, 1.0)
    rotation = (u * sign[:, None]) @ v
    scale = (s * sign).sum(axis=1) / np.maximum((x**2).sum(axis=-1).mean(axis=1), 1e-12)
    shift = b[:, 0] - scale[:, None] * np.einsum("bij,bj->bi", rotation, a[:, 0])
    return rotation, scale, shift


def fit_pose(npcs: np.ndarray, points: np.ndarray, draws: np.random.Generator) -> Pose:
    """The pose of a part from its points (n, 3) and what a network says of their canonical places: RANSAC, then a fit to those that agree."""
    at = draws.integers(0, len(points), (ROUNDS, PICKED))
    rotation, scale, shift = umeyama(npcs[at], points[at])
    made = scale[:, None, None] * np.einsum("bij,nj->bni", rotation, npcs) + shift[:, None]
    agrees = np.sqrt(((made - points) ** 2).sum(axis=-1)) < NEAR * np.maximum(scale, 1e-9)[:, None]
    kept = agrees[int(agrees.sum(axis=1).argmax())]
    if kept.sum() < PICKED:
        kept = np.ones(len(points), dtype=bool)
    r, s, t = (found[0] for found in umeyama(npcs[kept][None], points[kept][None]))
    return Pose(r, t, float(s), np.abs(npcs[kept]).max(axis=0))


def rotation_error(one: np.ndarray, other: np.ndarray) -> float:
    """Degrees between two rotations."""
    return float(np.degrees(np.arccos(np.clip((np.trace(one @ other.T) - 1) / 2, -1.0, 1.0))))


def line_error(one: np.ndarray, other: np.ndarray) -> float:
    """Degrees between two lines along unit vectors, 0 to 90."""
    return float(np.degrees(np.arccos(np.clip(abs(one @ other), 0.0, 1.0))))


def distance_of_lines(point: np.ndarray, along: np.ndarray, other: np.ndarray, other_along: np.ndarray) -> float:
    """The least distance of two lines through points along unit vectors."""
    across = np.cross(along, other_along)
    length = float(np.sqrt((across**2).sum()))
    away = point - other
    if length < 1e-6:
        return float(np.sqrt(((away - (away @ along) * along) ** 2).sum()))
    return float(abs(away @ across) / length)


def box_iou(one: Pose, other: Pose) -> float:
    """Intersection over union of two boxes, counted on GRID cubed points of the box of both along the axes."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    every = np.concatenate([p.scale * (corners * p.half) @ p.rotation.T + p.shift for p in (one, other)])
    low, high = every.min(axis=0), every.max(axis=0)
    steps = (np.arange(GRID) + 0.5) / GRID
    grid = low + np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3) * (high - low)
    a, b = (_inside(p, grid) for p in (one, other))
    either = int((a | b).sum())
    return float((a & b).sum() / either) if either else 0.0


def _inside(pose: Pose, points: np.ndarray) -> np.ndarray:
    own = (points - pose.shift) @ pose.rotation / max(pose.scale, 1e-9)
    return (np.abs(own) <= pose.half).all(axis=1)
