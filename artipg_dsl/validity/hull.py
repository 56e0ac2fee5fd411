"""Convex hulls of many sets of points in the plane at once, and how far inside them other points lie."""

from __future__ import annotations

import numpy as np

NEAR = 1e-9  # metres: points nearer than this are one; radians: edges that turn by less are one line
_WELL = 1e-6  # metres
_WAYS = tuple((np.cos(k * np.pi / 4), np.sin(k * np.pi / 4)) for k in range(8))


def hulls(points: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Corners (M, H, 2) of the hulls of points (M, K, 2) where ``valid`` (M, K), counter-clockwise, the last repeated.

    By wrapping (R. Jarvis, 1973): from each corner, the next is the point towards which the outline turns least. Sets
    without points give nan.
    """
    points, valid = _outer(points, valid)
    count = len(points)
    rows = np.arange(count)
    some = valid.any(axis=1)
    masked = np.where(valid[:, :, None], points, np.nan)
    low = np.where(valid, points[..., 0], np.inf)
    # of points on one upright line but for rounding, the lowest: another is no corner, and the outline would not come back to it
    low = np.where(low <= low.min(axis=1, initial=np.inf)[:, None] + NEAR, points[..., 1], np.inf)
    start = np.argmin(np.where(valid, low, np.inf), axis=1)
    first = masked[rows, start]
    corners, at, way = [first], first, np.tile((0.0, -1.0), (count, 1))
    going = some.copy()
    for _ in range(points.shape[1]):
        step = masked - at[:, None]
        length = np.sqrt(step[..., 0] ** 2 + step[..., 1] ** 2)
        ahead = step[..., 0] * way[:, None, 0] + step[..., 1] * way[:, None, 1]
        aside = way[:, None, 0] * step[..., 1] - way[:, None, 1] * step[..., 0]
        turn = np.arctan2(aside, ahead) + NEAR
        turn = np.where(turn < 0.0, turn + 2 * np.pi, turn)
        far = valid & (length > NEAR)
        turn = np.where(far, turn, np.inf)
        least = turn.min(axis=1, initial=np.inf)
        best = np.argmax(np.where(far & (turn <= least[:, None] + NEAR), length, -1.0), axis=1)
        going &= far.any(axis=1)
        chosen = np.where(going[:, None], masked[rows, best], at)
        back = chosen - first
        going &= back[:, 0] ** 2 + back[:, 1] ** 2 > NEAR**2
        if not going.any():
            break
        chosen = np.where(going[:, None], chosen, first)
        moved = np.where(going, length[rows, best], 1.0)
        way = np.where(going[:, None], step[rows, best] / moved[:, None], way)
        at = chosen
        corners.append(chosen)
    return np.stack(corners, axis=1)


def _outer(points: np.ndarray, valid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Without what lies well inside the polygon of the outermost points in eight directions: no corner of a hull, nor near one."""
    if points.shape[1] <= len(_WAYS):
        return points, valid
    rows = np.arange(len(points))
    far = [np.argmax(np.where(valid, points[..., 0] * x + points[..., 1] * y, -np.inf), axis=1) for x, y in _WAYS]
    corners = np.stack([points[rows, at] for at in far], axis=1)
    inside = valid.copy()
    for one, two in zip(corners.swapaxes(0, 1), np.roll(corners, -1, axis=1).swapaxes(0, 1), strict=True):
        edge = two - one
        length = np.sqrt(edge[:, 0] ** 2 + edge[:, 1] ** 2)
        off = points - one[:, None]
        inward = edge[:, None, 0] * off[..., 1] - edge[:, None, 1] * off[..., 0]
        inside &= inward > _WELL * length[:, None]
    left = valid & ~inside
    order = np.argsort(~left, axis=1, kind="stable")[:, : int(left.sum(axis=1).max(initial=1))]
    return points[rows[:, None], order], left[rows[:, None], order]


def depth(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far (M,) points (M, 2) lie inside hulls (M, H, 2), negative outside; -inf for hulls without corners or edges."""
    edge = np.roll(corners, -1, axis=1) - corners
    length = np.sqrt(edge[..., 0] ** 2 + edge[..., 1] ** 2)
    off = points[:, None] - corners
    inward = edge[..., 0] * off[..., 1] - edge[..., 1] * off[..., 0]
    real = length > NEAR
    found = np.where(real, inward / np.where(real, length, 1.0), np.inf).min(axis=1)
    return np.where(real.any(axis=1), found, -np.inf)
