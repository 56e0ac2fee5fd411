"""Convex hulls of many sets of points in the plane at once, and how far inside them other points lie."""

from __future__ import annotations

import numpy as np

from ..native.backend import machine as compiled
from ..native.feet import outlines

NEAR = 1e-9  # metres: points nearer than this are one; radians: edges that turn by less are one line
_WELL = 1e-6  # metres
_FEW = 32  # points that are soon wrapped
_WAYS = np.array([(np.cos(k * np.pi / 8), np.sin(k * np.pi / 8)) for k in range(16)])


def hulls(points: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Corners (M, H, 2) of the hulls of points (M, K, 2) where ``valid`` (M, K), counter-clockwise, the first repeated.

    By wrapping (R. Jarvis, 1973): from each corner, the next is the point towards which the outline turns least. Sets
    without points give nan.
    """
    machine = compiled()
    if machine is not None:
        found, each = outlines(machine, points, valid, _FEW, _WAYS, NEAR, _WELL)
        rank = np.arange(int(each.max(initial=1)))
        return found[(np.cumsum(each) - each)[:, None] + np.where(rank < each[:, None], rank, 0)]
    if points.shape[1] > _FEW:
        points, valid = _outer(*_distinct(points, valid))
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


def _distinct(points: np.ndarray, valid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """One of all that are the same: neighbours share their corners, and rings stand above one another."""
    x, y = (np.where(valid, points[..., axis], np.inf) for axis in range(2))
    order = np.lexsort((y, x), axis=1)
    x, y = np.take_along_axis(x, order, axis=1), np.take_along_axis(y, order, axis=1)
    again = np.zeros(valid.shape, dtype=bool)
    again[:, 1:] = (x[:, 1:] == x[:, :-1]) & (y[:, 1:] == y[:, :-1])
    kept = valid.copy()
    np.put_along_axis(kept, order, np.take_along_axis(valid, order, axis=1) & ~again, axis=1)
    return _narrowed(points, kept)


def _outer(points: np.ndarray, valid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Without what lies well inside the polygon of the outermost points in some directions: no corner of a hull, nor near one."""
    rows = np.arange(len(points))
    far = [np.argmax(np.where(valid, points[..., 0] * x + points[..., 1] * y, -np.inf), axis=1) for x, y in _WAYS]
    corners = np.stack([points[rows, at] for at in far], axis=1)
    inside, edges = valid.copy(), np.zeros(len(points), dtype=bool)
    for one, two in zip(corners.swapaxes(0, 1), np.roll(corners, -1, axis=1).swapaxes(0, 1), strict=True):
        edge = two - one
        length = np.sqrt(edge[:, 0] ** 2 + edge[:, 1] ** 2)
        off = points - one[:, None]
        inward = edge[:, None, 0] * off[..., 1] - edge[:, None, 1] * off[..., 0]
        real = length > 0.0  # one point may be outermost in several directions
        inside &= (inward > _WELL * length[:, None]) | ~real[:, None]
        edges |= real
    return _narrowed(points, valid & ~(inside & edges[:, None]))


def _narrowed(points: np.ndarray, kept: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The points of each set that are ``kept``, before others, in as few columns as hold them."""
    order = np.argsort(~kept, axis=1, kind="stable")[:, : int(kept.sum(axis=1).max(initial=1))]
    return np.take_along_axis(points, order[:, :, None], axis=1), np.take_along_axis(kept, order, axis=1)


def depth(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far (M,) points (M, 2) lie inside hulls (M, H, 2), negative outside; -inf for hulls without corners or edges."""
    edge = np.roll(corners, -1, axis=1) - corners
    length = np.sqrt(edge[..., 0] ** 2 + edge[..., 1] ** 2)
    off = points[:, None] - corners
    inward = edge[..., 0] * off[..., 1] - edge[..., 1] * off[..., 0]
    real = length > NEAR
    found = np.where(real, inward / np.where(real, length, 1.0), np.inf).min(axis=1)
    return np.where(real.any(axis=1), found, -np.inf)
