"""Joints in motion: where each link is for given joint values."""

from __future__ import annotations

import numpy as np

from .tables import JointTable, LinkTable


def rotation_about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotation matrices (k, 3, 3) about unit axes (k, 3) by angles (k,) (Rodrigues' formula)."""
    c, s = np.cos(angle), np.sin(angle)
    t = 1.0 - c
    x, y, z = axis[:, 0], axis[:, 1], axis[:, 2]
    cells = [
        x * x * t + c, x * y * t - z * s, x * z * t + y * s,
        x * y * t + z * s, y * y * t + c, y * z * t - x * s,
        x * z * t - y * s, y * z * t + x * s, z * z * t + c,
    ]  # fmt: skip
    return np.stack(cells, axis=-1).reshape(-1, 3, 3)


def apply(rotation: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Matrices (k, 3, 3) times vectors (k, 3), written out."""
    columns = [rotation[:, i, 0] * vector[:, 0] + rotation[:, i, 1] * vector[:, 1] + rotation[:, i, 2] * vector[:, 2] for i in range(3)]
    return np.stack(columns, axis=-1)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products (k, 3, 3) of matrices, written out."""
    return np.stack([apply(a, b[:, :, j]) for j in range(3)], axis=-1)


def follow(joints: JointTable, states: np.ndarray) -> np.ndarray:
    """Joint values in which those that mimic another take the value that follows from it."""
    values = np.array(states, dtype=np.float64)
    first = np.searchsorted(joints.owner, joints.owner)
    for _ in range(3):  # a mimic may follow a mimic
        leads = joints.mimic >= 0
        leader = first[leads] + joints.mimic[leads]
        values[leads] = joints.multiplier[leads] * values[leader] + joints.offset[leads]
    return values


def link_motion(links: LinkTable, joints: JointTable, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation (L, 3, 3) and translation (L, 3) that carry each link from joint values 0 to ``states`` (J,)."""
    count = len(links.owner)
    rotation = np.tile(np.eye(3), (count, 1, 1))
    translation = np.zeros((count, 3))
    if not len(joints.owner):
        return rotation, translation
    values = follow(joints, states)
    first = np.searchsorted(links.owner, np.arange(int(links.owner[-1]) + 1))
    parent, child = first[joints.owner] + joints.parent, first[joints.owner] + joints.child
    turning = np.array([kind in ("revolute", "continuous", "screw") for kind in joints.kind])
    sliding = np.array([kind == "prismatic" for kind in joints.kind])
    turn = rotation_about(joints.axis, np.where(turning, values, 0.0))
    shift = joints.origin - apply(turn, joints.origin) + joints.axis * np.where(sliding, values, 0.0)[:, None]
    depth = np.zeros(count, dtype=np.int64)
    for _ in range(count):
        deeper = depth[parent] + 1
        if (depth[child] == deeper).all():
            break
        depth[child] = deeper
    for level in range(1, int(depth.max()) + 1):
        at = np.flatnonzero(depth[child] == level)
        p, c = parent[at], child[at]
        rotation[c] = product(rotation[p], turn[at])
        translation[c] = apply(rotation[p], shift[at]) + translation[p]
    return rotation, translation
