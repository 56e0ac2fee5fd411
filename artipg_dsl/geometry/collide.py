"""Do convex bodies overlap? Many pairs at once, by the Gilbert-Johnson-Keerthi iteration on their supports.

The question is only whether a plane separates two bodies (E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for
computing the distance between complex objects in three-dimensional space", 1988): a pair leaves the iteration as soon
as its search direction is a separating axis, or the simplex holds the origin of the difference body. A body is known
by its support alone, so that one that is turned or swept needs no vertices of its own.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..native import backend, narrow
from .vectors import cross, dot

MOST_STEPS = 40
DEPTH = 1e-6  # metres: what overlaps by less touches
_PAIRS = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
_TRIPLES = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]


class Bodies(Protocol):
    """k convex bodies."""

    def __len__(self) -> int: ...

    def center(self) -> np.ndarray:
        """(k, 3): a point of, or near, each body."""
        ...

    def support(self, rows: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """The points (m, 3) of the bodies ``rows`` (m,) that lie farthest along ``direction`` (m, 3)."""
        ...

    def side(self) -> narrow.Side:
        """The same bodies for the compiled backend."""
        ...


class Corners:
    """Bodies given by their corners (k, P, 3)."""

    def __init__(self, vertices: np.ndarray):
        self.vertices = vertices

    def __len__(self) -> int:
        return len(self.vertices)

    def center(self) -> np.ndarray:
        return (self.vertices.min(axis=1) + self.vertices.max(axis=1)) / 2

    def support(self, rows: np.ndarray, direction: np.ndarray) -> np.ndarray:
        points = self.vertices[rows]
        return points[np.arange(len(rows)), np.argmax(dot(points, direction[:, None]), axis=1)]

    def side(self) -> narrow.Side:
        every = np.arange(len(self))
        return narrow.Side([self.vertices], np.zeros_like(every), every)


def inset(points: np.ndarray, first: np.ndarray, faces: np.ndarray, margin: float = DEPTH / 2) -> np.ndarray:
    """Corners (N, 3) of pieces with the planes of their faces moved inwards by ``margin``: what touches meets no more.

    The pieces follow one another, ``first`` (k,) tells where each begins; ``faces`` (F, 3) are numbers of ``points``, and no piece
    is without any.
    """
    machine = backend.machine()
    if machine is not None:
        return narrow.inset(machine, points, first, faces, margin)
    corners = points[faces]
    normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.sqrt(dot(normal, normal))
    normal = np.where(length[:, None] > 0, normal / np.where(length > 0, length, 1.0)[:, None], 0.0)
    middle = (np.minimum.reduceat(points, first) + np.maximum.reduceat(points, first)) / 2
    piece = np.searchsorted(first, faces[:, 0], side="right") - 1
    outwards = np.bincount(piece, dot(normal, corners[:, 0] - middle[piece]), minlength=len(first))
    turned = outwards[piece] < 0.0  # mirrored: the faces run the other way
    normal[turned] = -normal[turned]
    n, corner = np.repeat(normal, 3, axis=0).T, faces.ravel()

    def gathered(values: np.ndarray) -> np.ndarray:
        return np.bincount(corner, values, minlength=len(points))

    ridge = 1e-6
    # N'N of the normals N at each corner
    a, b, c = (gathered(n[i] * n[i]) + ridge for i in range(3))
    d, e, f = (gathered(n[i] * n[j]) for i, j in ((1, 2), (2, 0), (0, 1)))
    # the symmetric system [[a, f, e], [f, b, d], [e, d, c]] m = push, by its adjugate
    aa, bb, cc = b * c - d * d, a * c - e * e, a * b - f * f
    dd, ee, ff = e * f - a * d, f * d - b * e, d * e - c * f
    det = a * aa + f * ff + e * ee
    x, y, z = (-gathered(n[i]) for i in range(3))
    move = np.stack([aa * x + ff * y + ee * z, ff * x + bb * y + dd * z, ee * x + dd * y + cc * z], axis=-1)
    move /= np.where(det > 0, det, 1.0)[:, None]
    reach = np.sqrt(dot(move, move))
    move *= np.minimum(1.0, 20.0 / np.maximum(reach, 1e-300))[:, None]  # needles: not farther than makes sense
    return points + margin * move


def overlap(first: Bodies, second: Bodies) -> np.ndarray:
    """Whether the bodies penetrate one another; (k,) bool. Bodies that touch are best inset before."""
    return separate(first, second, near=0.0)[0]


def separate(first: Bodies, second: Bodies, near: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """Which pairs overlap (k,), and for the others a direction (k, 3) along which ``first`` lies beyond ``second``.

    The two are apart along it by at least ``near`` times their distance. Where it cannot be told within the steps, the
    pair counts as not overlapping and its direction separates nothing.
    """
    count = len(first)
    result = np.zeros(count, dtype=bool)
    active = np.arange(count)
    nearest = first.center() - second.center()
    nearest[dot(nearest, nearest) < 1e-24] = (1.0, 0.0, 0.0)
    machine = backend.machine()
    if machine is not None and count:
        return narrow.separate(machine, first.side(), second.side(), near, MOST_STEPS, nearest)
    start = first.support(active, -nearest) - second.support(active, nearest)
    size = np.sqrt(dot(start, start)) + np.sqrt(dot(nearest, nearest))
    simplex = np.repeat(start[:, None], 4, axis=1)
    weight = np.zeros((count, 4))
    weight[:, 0] = 1.0
    nearest = start.copy()
    apart = np.zeros(count, dtype=bool)
    for _ in range(MOST_STEPS):
        v = nearest[active]
        point = first.support(active, -v) - second.support(active, v)
        away, length = dot(v, point), dot(v, v)
        apart[active] |= away > 1e-12 * size[active] * np.sqrt(length)
        separated = apart[active] & (away >= near * length)
        stuck = length - away <= 1e-10 * length  # no nearer point: the distance itself is found
        going = ~(separated | stuck)
        active, point = active[going], point[going]
        if not len(active):
            break
        slot = np.argmin(weight[active], axis=1)
        simplex[active, slot] = point
        value, shares = _closest(simplex[active])
        nearest[active], weight[active] = value, shares
        inside = dot(value, value) <= 1e-22 * np.maximum(size[active] ** 2, 1e-12)
        inside |= (shares > 0.0).all(axis=1)
        result[active[inside]] = True
        active = active[~inside]
        if not len(active):
            break
    return result & ~apart, nearest


def common_point(first: Bodies, second: Bodies) -> np.ndarray:
    """A point (k, 3) that both bodies of each pair hold; of two that do not meet, midway between where they are nearest."""
    count = len(first)
    rows, nearest = np.arange(count), first.center() - second.center()
    nearest[dot(nearest, nearest) < 1e-24] = (1.0, 0.0, 0.0)
    ends = np.stack([first.support(rows, -nearest), second.support(rows, nearest)], axis=1)
    simplex = np.repeat(ends[:, :, None], 4, axis=2)  # (k, 2, 4, 3): corners of either
    weight = np.zeros((count, 4))
    weight[:, 0] = 1.0
    nearest = ends[:, 0] - ends[:, 1]
    for _ in range(MOST_STEPS):
        ends = np.stack([first.support(rows, -nearest), second.support(rows, nearest)], axis=1)
        length = dot(nearest, nearest)
        going = (length > 1e-22) & (length - dot(nearest, ends[:, 0] - ends[:, 1]) > 1e-10 * length)
        going &= ~(weight > 0.0).all(axis=1)
        at = np.flatnonzero(going)
        if not len(at):
            break
        slot = np.argmin(weight[at], axis=1)
        simplex[at, :, slot] = ends[at]
        nearest[at], weight[at] = _closest(simplex[at, 0] - simplex[at, 1])
    return (_mixed(weight, simplex[:, 0]) + _mixed(weight, simplex[:, 1])) / 2


def find_near(first: Bodies, second: Bodies, distance: np.ndarray, near: float = 0.99) -> np.ndarray:
    """Which pairs overlap or are nearer than ``distance`` (k,); those between ``near`` of it and all of it may be left out."""
    if not len(distance):
        return np.zeros(0, dtype=bool)
    hit, away = separate(first, second, near)
    return hit | (dot(away, away) < distance * distance)


def _closest(simplex: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The point of tetrahedra (k, 4, 3) nearest the origin, and its weights (k, 4); all positive: the origin lies within."""
    machine = backend.machine()
    if machine is not None:
        return narrow.closest(machine, simplex)
    best = np.full(len(simplex), np.inf)
    weights = np.zeros((len(simplex), 4))
    corners = [np.ascontiguousarray(simplex[:, k]) for k in range(4)]

    def offer(which: tuple[int, ...], shares: tuple[np.ndarray, ...], valid: np.ndarray) -> None:
        point = shares[0][:, None] * corners[which[0]]
        for k, share in zip(which[1:], shares[1:], strict=True):
            point += share[:, None] * corners[k]
        square = np.where(valid, dot(point, point), np.inf)
        better = np.flatnonzero(square < best * (1.0 - 1e-12))
        best[better] = square[better]
        weights[better] = 0.0
        for k, share in zip(which, shares, strict=True):
            weights[better, k] = share[better]

    whole, every = np.ones(len(simplex)), np.ones(len(simplex), dtype=bool)
    for i in range(4):
        offer((i,), (whole,), every)
    for i, j in _PAIRS:
        edge = corners[j] - corners[i]
        square = dot(edge, edge)
        t = -dot(corners[i], edge) / np.where(square > 0, square, 1.0)
        offer((i, j), (1.0 - t, t), (square > 1e-30) & (t > 0) & (t < 1))
    for i, j, k in _TRIPLES:
        a, b = corners[j] - corners[i], corners[k] - corners[i]
        aa, ab, bb = dot(a, a), dot(a, b), dot(b, b)
        pa, pb = -dot(corners[i], a), -dot(corners[i], b)
        det = aa * bb - ab * ab
        safe = np.where(det > 0, det, 1.0)
        s, t = (bb * pa - ab * pb) / safe, (aa * pb - ab * pa) / safe
        offer((i, j, k), (1.0 - s - t, s, t), (det > 1e-14 * aa * bb) & (s > 0) & (t > 0) & (s + t < 1))
    inside, shares = _tetrahedron(simplex)
    best[inside], weights[inside] = 0.0, shares[inside]
    return _mixed(weights, simplex), weights


def _tetrahedron(simplex: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which tetrahedra hold the origin, and its barycentric coordinates."""
    a, b, c = (simplex[:, k] - simplex[:, 0] for k in (1, 2, 3))
    origin = -simplex[:, 0]
    volume = dot(a, cross(b, c))
    scale = np.sqrt(dot(a, a) * dot(b, b) * dot(c, c))
    solid = np.abs(volume) > 1e-12 * scale
    safe = np.where(solid, volume, 1.0)
    u = dot(origin, cross(b, c)) / safe
    v = dot(a, cross(origin, c)) / safe
    w = dot(a, cross(b, origin)) / safe
    shares = np.stack([1.0 - u - v - w, u, v, w], axis=1)
    return solid & (shares > 0).all(axis=1), shares


def _mixed(shares: np.ndarray, simplex: np.ndarray) -> np.ndarray:
    """The points (k, 3) of tetrahedra (k, 4, 3) with the weights (k, 4), added up corner by corner."""
    found = shares[:, 0, None] * simplex[:, 0]
    for i in range(1, 4):
        found += shares[:, i, None] * simplex[:, i]
    return found
