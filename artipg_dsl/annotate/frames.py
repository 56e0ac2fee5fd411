"""Rigid placements of many points at once, written out so that every row gives the same bits in any batch."""

from __future__ import annotations

import numpy as np


def rotate(rotation: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) turned by matrices that broadcast with them ((..., 3, 3))."""
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    turned = [rotation[..., i, 0] * x + rotation[..., i, 1] * y + rotation[..., i, 2] * z for i in range(3)]
    return np.stack(turned, axis=-1)


def unrotate(rotation: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) turned by the inverses of rotations that broadcast with them."""
    return rotate(np.swapaxes(rotation, -1, -2), vectors)


def rotate_rows(
    rotation: np.ndarray, row: np.ndarray, vectors: np.ndarray, shift: np.ndarray | None = None
) -> np.ndarray:
    """Vectors (n, 3) turned by the matrices ``rotation[row]``, of (k, 3, 3), and moved by ``shift[row]``, of (k, 3).

    Column by column: no matrix is gathered for each vector. Most frames are not turned at all: their vectors are taken as they are,
    which gives the same bits (zeros are positive in the result).
    """
    row = np.asarray(row)
    out = np.array(vectors, dtype=float)
    turned = (rotation != np.eye(3)).any(axis=(1, 2))
    which = np.flatnonzero(turned[row]) if turned.any() else np.zeros(0, dtype=np.int64)
    if len(which):
        columns = np.ascontiguousarray(rotation.reshape(-1, 9).T)
        some = row[which]
        x, y, z = (np.ascontiguousarray(out[which, k]) for k in range(3))
        for i in range(3):
            a, b, c = (columns[3 * i + j][some] for j in range(3))
            out[which, i] = a * x + b * y + c * z
    if shift is None or not shift.any():
        out += 0.0
        return out
    for i in range(3):
        out[:, i] += np.ascontiguousarray(shift[:, i])[row]
    out += 0.0
    return out


def compose(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Products ``first @ second`` of matrices (..., 3, 3), without BLAS."""
    columns = [rotate(first, second[..., :, j]) for j in range(3)]
    return np.stack(columns, axis=-1)


def place(
    rotation: np.ndarray, translation: np.ndarray, points: np.ndarray, mirror: np.ndarray | None = None
) -> np.ndarray:
    """Points (k, n, 3) of k own frames, placed: rotation (k, 3, 3), translation (k, 3), mirror (k,) or None."""
    x, y, z = (np.ascontiguousarray(points[..., k]) for k in range(3))
    if mirror is not None:
        y = y * mirror[:, None]
    out = np.empty(np.broadcast_shapes(points.shape, (len(rotation), 1, 3)))
    for k in range(3):
        a, b, c = (rotation[:, k, j, None] for j in range(3))
        out[..., k] = a * x + b * y + c * z + translation[:, k, None]
    return out


def reflect(points: np.ndarray, mirror: np.ndarray) -> np.ndarray:
    """Points or vectors (k, ..., 3) taken at (x, mirror * y, z)."""
    sign = mirror.reshape(mirror.shape + (1,) * (points.ndim - 2))
    return np.stack([points[..., 0], points[..., 1] * sign, points[..., 2]], axis=-1)


def axis_angle(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotation matrices (..., 3, 3) by ``angle`` (radians) about unit ``axis`` (..., 3)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = axis[..., 0], axis[..., 1], axis[..., 2]
    t = 1.0 - c
    rows = [
        [c + x * x * t, x * y * t - z * s, x * z * t + y * s],
        [y * x * t + z * s, c + y * y * t, y * z * t - x * s],
        [z * x * t - y * s, z * y * t + x * s, c + z * z * t],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternion(rotation: np.ndarray) -> np.ndarray:
    """Unit quaternions (..., 4), order w x y z and w >= 0, of proper rotations (..., 3, 3)."""
    r = rotation
    # the squares of the four components (times 4); the largest one is the safe one to divide by
    squares = np.stack(
        [
            1.0 + r[..., 0, 0] + r[..., 1, 1] + r[..., 2, 2],
            1.0 + r[..., 0, 0] - r[..., 1, 1] - r[..., 2, 2],
            1.0 - r[..., 0, 0] + r[..., 1, 1] - r[..., 2, 2],
            1.0 - r[..., 0, 0] - r[..., 1, 1] + r[..., 2, 2],
        ],
        axis=-1,
    )
    wx, wy, wz = r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]
    xy, xz, yz = r[..., 0, 1] + r[..., 1, 0], r[..., 0, 2] + r[..., 2, 0], r[..., 1, 2] + r[..., 2, 1]
    products = np.stack(
        [
            np.stack([squares[..., 0], wx, wy, wz], axis=-1),
            np.stack([wx, squares[..., 1], xy, xz], axis=-1),
            np.stack([wy, xy, squares[..., 2], yz], axis=-1),
            np.stack([wz, xz, yz, squares[..., 3]], axis=-1),
        ],
        axis=-2,
    )
    # a tie is decided by rounded squares, so that the same rotation always gives the same branch
    best = np.argmax(np.round(squares, 9), axis=-1)
    q = np.take_along_axis(products, best[..., None, None], axis=-2)[..., 0, :]
    q = q / np.sqrt(q[..., :1] ** 2 + q[..., 1:2] ** 2 + q[..., 2:3] ** 2 + q[..., 3:] ** 2)
    return np.where(q[..., :1] < 0, -q, q) + 0.0


def euler(rotation: np.ndarray) -> np.ndarray:
    """Roll, pitch, yaw (..., 3) about the fixed axes x, y, z, as URDF has them: R = Rz(yaw) Ry(pitch) Rx(roll)."""
    sine = np.clip(-rotation[..., 2, 0], -1.0, 1.0)
    pitch = np.arcsin(sine)
    locked = np.abs(sine) > 1.0 - 1e-12
    roll = np.where(locked, 0.0, np.arctan2(rotation[..., 2, 1], rotation[..., 2, 2]))
    yaw = np.where(
        locked,
        np.arctan2(-rotation[..., 0, 1], rotation[..., 1, 1]),
        np.arctan2(rotation[..., 1, 0], rotation[..., 0, 0]),
    )
    return np.stack([roll, pitch, yaw], axis=-1) + 0.0
