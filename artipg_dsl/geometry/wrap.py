"""The convex hulls of many sets of points at once: their corners and outward triangles.

The corners of a wall that is told by rings lie in planes, on lines and twice in one place, but for rounding. So that there is
one answer, points that coincide are one, and all are moved outwards by a little that grows with the square of how far out they lie: what lay
in one plane becomes triangles, and what lay on a line or within a face is no corner. Faces are told where each corner
across an edge, and each point that is no corner, lies behind them beyond doubt; then it does not matter who found them. Where there is
doubt, Qhull looks at the points as they are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..native import backend, wrap
from .runs import changes
from .vectors import cross, dot

_GRID = 1 << 20  # places along the extent of a set; what rounds to the same place coincides
_AT = 0.3718  # of a place: no number that has a short name lies between two
BEND = 1e-5  # how far points are moved, by the extent of the set, at a distance of that
_DOUBT = 1e-13  # some hundred times what rounding makes of a distance
_ALONG = np.array([[1.0, 0.37, 0.19], [0.37, 1.21, 0.43], [0.19, 0.43, 0.87]])  # nothing in a shape is even along these
Wrapped = tuple[np.ndarray, np.ndarray]  # numbers (P,) of the points that are corners, and faces (F, 3) of these


class FlatError(ValueError):
    """Points that lie in one plane have no hull."""


def wrap_all(sets: Sequence[np.ndarray], bend: float = BEND) -> list[Wrapped]:
    """The hulls of sets of points (n, 3), moved outwards by ``bend``. Raises FlatError for one that is flat."""
    if not sets:
        return []
    points = np.concatenate(sets) + 0.0
    of = np.repeat(np.arange(len(sets)), [len(own) for own in sets])
    first = np.searchsorted(of, np.arange(len(sets)))
    low, high = np.minimum.reduceat(points, first), np.maximum.reduceat(points, first)
    with np.errstate(divide="ignore", invalid="ignore"):  # what is flat is left to Qhull, which says so
        scaled = (points - low[of]) / (high - low)[of]
        once = _first_of_each(scaled, of, np.append(first, len(of)))
    scaled, of = scaled[once], of[once]
    start = np.searchsorted(of, np.arange(len(sets) + 1))
    bent = _bent(scaled, of, start, bend)
    machine = backend.machine()
    told = [None] * len(sets) if machine is None else wrap.wrap(machine, bent, start, _DOUBT)
    found = []
    for faces, begin, end, before in zip(told, start[:-1].tolist(), start[1:].tolist(), first.tolist(), strict=True):
        if faces is None:
            faces = _beyond_doubt(bent[begin:end])
        if faces is None:
            faces = _hull(scaled[begin:end])
        found.append(_numbered(once[begin:end] - before, faces))
    return found


def wrap_plainly(points: np.ndarray) -> Wrapped:
    """The hull of points (n, 3) as they are, by Qhull. Raises FlatError where they are flat."""
    low, high = points.min(axis=0), points.max(axis=0)
    return _numbered(np.arange(len(points)), _hull((points - low) / (high - low)))


def _first_of_each(scaled: np.ndarray, of: np.ndarray, start: np.ndarray) -> np.ndarray:
    """The numbers of points (N, 3) that no point before them of their set coincides with; each is ``of`` (N,) one, which begins at
    ``start``."""
    place = (np.nan_to_num(scaled) * _GRID + _AT).astype(np.int64)
    key = (place[:, 0] << 42) + (place[:, 1] << 21) + place[:, 2]
    machine = backend.machine()
    if machine is not None:
        return np.flatnonzero(wrap.first_of_each(machine, key, start))
    order = np.lexsort((key, of))
    new = changes(key[order]) | changes(of[order])
    return np.sort(order[new])


def _bent(scaled: np.ndarray, of: np.ndarray, start: np.ndarray, bend: float) -> np.ndarray:
    """Points (N, 3) of sets, each in a box of 1, from the middles of the sets, moved outwards."""
    middle = np.add.reduceat(scaled, start[:-1]) / np.diff(start)[:, None]
    away = scaled - middle[of]
    x, y, z = away.T
    (a, b, c), (_, d, e), (_, _, f) = _ALONG
    out: np.ndarray = (
        away * (1.0 + bend * (a * x * x + d * y * y + f * z * z + 2 * (b * x * y + c * x * z + e * y * z)))[:, None]
    )
    return np.ascontiguousarray(out)


def _beyond_doubt(points: np.ndarray) -> np.ndarray | None:
    """The faces (F, 3) of the hull of points (n, 3), if each corner across an edge and all that are no corners lie behind."""
    if not np.isfinite(points).all() or len(points) < 4:
        return None
    faces = _hull(points)
    count = len(points)
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    forward, back = start * count + end, end * count + start
    order = np.argsort(forward)
    at = np.minimum(np.searchsorted(forward[order], back), len(order) - 1)
    corners = np.bincount(start, minlength=count) > 0
    if (forward[order[at]] != back).any() or len(faces) != 2 * corners.sum() - 4:
        return None
    across = np.roll(faces, -2, axis=1).ravel()[order[at]].reshape(-1, 3)
    a, b, c = (points[faces[:, n]] for n in range(3))
    e, f = b - a, c - a
    normal = cross(e, f)
    length, longest = np.sqrt(dot(normal, normal)), np.maximum(dot(e, e), dot(f, f))
    for others in (points[across.T], points[~corners][:, None]):  # (m, F or 1, 3)
        w = [others[..., n] - a[:, n] for n in range(3)]
        size = np.abs(w[0]) + np.abs(w[1]) + np.abs(w[2])
        depth = -(normal[:, 0] * w[0] + normal[:, 1] * w[1] + normal[:, 2] * w[2])
        if not (depth > _DOUBT * (length + longest * size)).all():
            return None
    return faces


def _hull(points: np.ndarray) -> np.ndarray:
    """The faces (F, 3) of the hull of points (n, 3) as Qhull finds them: outwards, in order, each from its least number on."""
    from scipy.spatial import ConvexHull, QhullError  # late: importing the package must not load SciPy

    try:
        found = ConvexHull(points)
    except QhullError as error:
        raise FlatError(str(error)) from error
    faces = found.simplices.astype(np.int64)
    a, b, c = (points[faces[:, n]] for n in range(3))
    inward = dot(cross(b - a, c - a), found.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    faces = np.take_along_axis(faces, (np.argmin(faces, axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    return faces[np.lexsort(faces.T[::-1])]


def _numbered(own: np.ndarray, faces: np.ndarray) -> Wrapped:
    """Faces (F, 3) of points that the set numbers ``own`` (n,), by their corners alone."""
    used = np.bincount(faces.ravel(), minlength=len(own)) > 0
    return own[used], (np.cumsum(used) - 1)[faces].astype(np.int32)
