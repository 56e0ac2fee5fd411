"""Do convex pieces overlap? Many pairs at once, by the Gilbert-Johnson-Keerthi iteration on their vertices.

The question is only whether a plane separates two pieces (E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for
computing the distance between complex objects in three-dimensional space", 1988): a pair leaves the iteration as soon
as its search direction is a separating axis, or the simplex holds the origin of the difference body.
"""

from __future__ import annotations

import numpy as np

MOST_STEPS = 40
_PAIRS = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
_TRIPLES = [(0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)]
_BLOCK = 20_000  # pairs at a time


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def shrunk(vertices: np.ndarray, margin: float) -> np.ndarray:
    """Pieces (k, P, 3) drawn in towards their centres by about ``margin``: what touches no longer meets."""
    low, high = vertices.min(axis=1), vertices.max(axis=1)
    center = (low + high) / 2
    half = np.maximum((high - low) / 2, 1e-12)
    scale = np.maximum(1.0 - margin / half, 0.0)
    return center[:, None] + (vertices - center[:, None]) * scale[:, None]


def overlap(first: np.ndarray, second: np.ndarray, margin: float = 1e-6) -> np.ndarray:
    """Whether pieces (k, P, 3) and (k, Q, 3) penetrate one another by more than about twice ``margin``; (k,) bool."""
    found = np.zeros(len(first), dtype=bool)
    for start in range(0, len(first), _BLOCK):
        part = slice(start, start + _BLOCK)
        found[part] = _overlap(shrunk(first[part], margin), shrunk(second[part], margin))
    return found


def _overlap(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    result = np.zeros(len(first), dtype=bool)
    active = np.arange(len(first))
    direction = first.mean(axis=1) - second.mean(axis=1)
    size = np.maximum(np.abs(first).max(axis=(1, 2)), np.abs(second).max(axis=(1, 2)))
    direction[dot(direction, direction) < 1e-24] = (1.0, 0.0, 0.0)
    start = support(first, second, direction)
    simplex = np.repeat(start[:, None], 4, axis=1)
    weight = np.zeros((len(first), 4))
    weight[:, 0] = 1.0
    nearest = start.copy()
    for _ in range(MOST_STEPS):
        a, b, v = first[active], second[active], nearest[active]
        point = support(a, b, v)
        away = dot(v, point)
        length = dot(v, v)
        separated = away > 1e-12 * size[active] * np.sqrt(length)
        stuck = length - away <= 1e-10 * length  # no nearer point: the distance itself is found
        going = ~(separated | stuck)
        active, point = active[going], point[going]
        if not len(active):
            break
        slot = np.argmin(weight[active], axis=1)
        simplex[active, slot] = point
        value, shares = closest(simplex[active])
        nearest[active], weight[active] = value, shares
        inside = dot(value, value) <= 1e-22 * np.maximum(size[active] ** 2, 1e-12)
        inside |= (shares > 0.0).all(axis=1)
        result[active[inside]] = True
        active = active[~inside]
        if not len(active):
            break
    return result


def support(first: np.ndarray, second: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """The point of the difference body first - second that lies farthest against ``direction``; (k, 3)."""
    rows = np.arange(len(first))
    a = first[rows, np.argmin(dot(first, direction[:, None]), axis=1)]
    b = second[rows, np.argmax(dot(second, direction[:, None]), axis=1)]
    return a - b


def closest(simplex: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The point of tetrahedra (k, 4, 3) nearest the origin, and its weights (k, 4); all positive: the origin lies within."""
    best = np.full(len(simplex), np.inf)
    weights = np.zeros((len(simplex), 4))

    def offer(shares: np.ndarray, valid: np.ndarray) -> None:
        point = (shares[:, :, None] * simplex).sum(axis=1)
        square = np.where(valid, dot(point, point), np.inf)
        better = square < best * (1.0 - 1e-12)
        best[better] = square[better]
        weights[better] = shares[better]

    for i in range(4):
        shares = np.zeros((len(simplex), 4))
        shares[:, i] = 1.0
        offer(shares, np.ones(len(simplex), dtype=bool))
    for i, j in _PAIRS:
        edge = simplex[:, j] - simplex[:, i]
        square = dot(edge, edge)
        t = -dot(simplex[:, i], edge) / np.where(square > 0, square, 1.0)
        shares = np.zeros((len(simplex), 4))
        shares[:, i], shares[:, j] = 1.0 - t, t
        offer(shares, (square > 1e-30) & (t > 0) & (t < 1))
    for i, j, k in _TRIPLES:
        a, b = simplex[:, j] - simplex[:, i], simplex[:, k] - simplex[:, i]
        aa, ab, bb = dot(a, a), dot(a, b), dot(b, b)
        pa, pb = -dot(simplex[:, i], a), -dot(simplex[:, i], b)
        det = aa * bb - ab * ab
        safe = np.where(det > 0, det, 1.0)
        s, t = (bb * pa - ab * pb) / safe, (aa * pb - ab * pa) / safe
        shares = np.zeros((len(simplex), 4))
        shares[:, i], shares[:, j], shares[:, k] = 1.0 - s - t, s, t
        offer(shares, (det > 1e-14 * aa * bb) & (s > 0) & (t > 0) & (s + t < 1))
    inside, shares = _tetrahedron(simplex)
    best[inside], weights[inside] = 0.0, shares[inside]
    return (weights[:, :, None] * simplex).sum(axis=1), weights


def _tetrahedron(simplex: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which tetrahedra hold the origin, and its barycentric coordinates."""
    a, b, c = (simplex[:, k] - simplex[:, 0] for k in (1, 2, 3))
    origin = -simplex[:, 0]
    volume = dot(a, np.cross(b, c))
    scale = np.sqrt(dot(a, a) * dot(b, b) * dot(c, c))
    solid = np.abs(volume) > 1e-12 * scale
    safe = np.where(solid, volume, 1.0)
    u = dot(origin, np.cross(b, c)) / safe
    v = dot(a, np.cross(origin, c)) / safe
    w = dot(a, np.cross(b, origin)) / safe
    shares = np.stack([1.0 - u - v - w, u, v, w], axis=1)
    return solid & (shares > 0).all(axis=1), shares
