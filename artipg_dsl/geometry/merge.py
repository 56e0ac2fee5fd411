"""Fewer convex pieces: the hulls of neighbours in place of the pieces, where hardly more than the pieces fill them.

How much a hull adds is told by how far points of it lie from the nearest piece: points half way between corners that
reach far in some direction. So the walls of a vessel become staves of few sides, while a hole stays a hole. What a hull
adds to the side of the hollow can be cut off along the face of a piece there. Pieces know where they stand: which
primitive they belong to, which step around or along it (``index``), which of its names.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from ..native import backend, gaps
from ..records import dataclass

_LEFT = 0.05  # of the depth of a piece: one that keeps less when it is cut is lost
_LOST = 3  # one piece in so many at most: four staves of a thin ring lose a third, and stand all round it
_SECTORS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 60)
_WAYS = np.array(
    [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)], float
)
_MANY, _FIRST = 64, 4  # pieces from which on points are asked about by and by, and how many at first
_TURNED = _WAYS + np.array([0.011, 0.007, 0.003])  # so that no two corners of a box tie


@dataclass(frozen=True, slots=True, eq=False)
class Convex:
    """A convex piece: corners (P, 3), planes of its faces (outward normals (F, 3), offsets (F,)).

    ``unit`` numbers its primitive within the body, ``name`` the piece within the primitive, ``index`` the step.
    ``source`` is what a caller knows it by. ``stock`` holds it for compiled code, as its ``number``.
    """

    points: np.ndarray
    normals: np.ndarray
    offsets: np.ndarray
    unit: int
    name: int
    index: int
    source: Any = None
    stock: gaps.Stock | None = None
    number: int = 0


Cluster = tuple[Convex, ...]


def gap(pieces: Sequence[Convex]) -> float:
    """How far the hull of pieces reaches from them, at the points looked at; metres."""
    return 0.0 if len(pieces) == 1 else _asked(tuple(pieces))[0]


def _within(pieces: Sequence[Convex], tolerance: float) -> bool:
    """Whether the hull of pieces reaches from them by no more than a tolerance, which is less than what is enough for their stock."""
    if len(pieces) == 1:
        return True
    stock, machine = pieces[0].stock, backend.machine()
    if stock is None or machine is None:
        return gap(pieces) <= tolerance
    numbers = tuple([piece.number for piece in pieces])
    found = stock.bounded.get(numbers)
    if found is None:
        found, _ = gaps.deepest(machine, stock, numbers, _TURNED, stock.enough)
        stock.bounded[numbers] = found
    return found <= tolerance


def _hollow(pieces: Sequence[Convex]) -> tuple[np.ndarray, float]:
    """The plane (normal (3,), offset) of the face beyond which the hull of several pieces reaches farthest from them."""
    _, face = _asked(tuple(pieces))
    for piece in pieces:
        if face < len(piece.offsets):
            return piece.normals[face], float(piece.offsets[face])
        face -= len(piece.offsets)
    raise ValueError("no pieces")


def _asked(pieces: Cluster) -> tuple[float, int]:
    """``_deepest``, by compiled code where there is some; a stock keeps what several tolerances ask for."""
    stock, machine = pieces[0].stock, backend.machine()
    if stock is None:
        return _deepest(pieces)
    numbers = tuple([piece.number for piece in pieces])
    if numbers not in stock.known:
        found = _deepest(pieces) if machine is None else gaps.deepest(machine, stock, numbers, _TURNED)
        stock.known[numbers] = found
    return stock.known[numbers]


def _deepest(pieces: Cluster) -> tuple[float, int]:
    """How far the hull reaches from its pieces where it does most, and the nearest face there, counted over all pieces.

    Of many pieces, the one with the nearest middle tells how far a point lies at most: all are asked about the farthest alone.
    """
    points = _extreme(np.concatenate([piece.points for piece in pieces]))
    i, j = _pairs(len(points))
    middles = (points[i] + points[j]) / 2
    normals = np.concatenate([piece.normals for piece in pieces])
    offsets = np.concatenate([piece.offsets for piece in pieces])
    start = np.cumsum([0, *(len(piece.offsets) for piece in pieces)])
    numbers = np.arange(len(middles))
    at_most, block = None, len(middles)
    if len(pieces) > _MANY:
        at_most = _from_nearest(pieces, middles)
        numbers, block = np.argsort(-at_most, kind="stable"), _FIRST
    depth, first, face = -np.inf, 0, 0
    while len(numbers):
        now, numbers = numbers[:block], numbers[block:]
        away = _beyond(normals, offsets, middles[now])
        apart = np.maximum.reduceat(away, start[:-1], axis=0)
        found = apart.min(axis=0)
        k = int(found.argmax()) if at_most is None else min(np.flatnonzero(found == found.max()), key=now.item)
        if found[k] > depth or found[k] == depth and now[k] < first:  # of equals the first
            nearest = int(apart[:, k].argmin())
            depth, first = float(found[k]), int(now[k])
            face = int(start[nearest] + away[start[nearest] : start[nearest + 1], k].argmax())
        if at_most is not None:
            numbers = numbers[at_most[numbers] >= depth]
        block *= 2
    return depth, face


def _from_nearest(pieces: Cluster, points: np.ndarray) -> np.ndarray:
    """How far points (n, 3) lie from the piece whose middle is nearest."""
    counts = np.array([len(piece.points) for piece in pieces])
    middles = np.add.reduceat(np.concatenate([piece.points for piece in pieces]), np.cumsum(counts) - counts, axis=0)
    x, y, z = (points[:, n, None] - middles[:, n] / counts for n in range(3))
    nearest = (x * x + y * y + z * z).argmin(axis=1)
    found = np.zeros(len(points))
    for k in set(nearest.tolist()):
        mine = nearest == k
        found[mine] = _beyond(pieces[k].normals, pieces[k].offsets, points[mine]).max(axis=0)
    return found


def _beyond(normals: np.ndarray, offsets: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far points (n, 3) lie beyond planes (F,): (F, n)."""
    x, y, z = points.T
    return normals[:, 0, None] * x + normals[:, 1, None] * y + normals[:, 2, None] * z - offsets[:, None]


@lru_cache(maxsize=64)
def _pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of numbers below ``count``."""
    first, second = np.triu_indices(count, 1)
    return first, second


def _extreme(points: np.ndarray) -> np.ndarray:
    """The points (n, 3) that reach farthest in some direction, by the extents of all of them."""
    low = points.min(axis=0)
    scaled = (points - low) / np.maximum(points.max(axis=0) - low, 1e-12)
    x, y, z = scaled.T
    reach = _TURNED[:, 0, None] * x + _TURNED[:, 1, None] * y + _TURNED[:, 2, None] * z
    return points[sorted(set(reach.argmax(axis=1).tolist()))]


def clusters(pieces: Sequence[Convex], tolerance: float) -> list[Cluster]:
    """The pieces of one primitive, in order of name and index, put together where hulls add less than ``tolerance``."""
    names: dict[int, list[Convex]] = {}
    for piece in pieces:
        names.setdefault(piece.name, []).append(piece)
    found: list[Cluster] = []
    runs: list[list[list[Convex]]] = []
    for steps in names.values():  # names of one step and names of several do not mix
        if runs and (len(runs[-1][0]) > 1) == (len(steps) > 1):
            runs[-1].append(steps)
        else:
            runs.append([steps])
    for run in runs:
        found += _chained([tuple(steps) for steps in run], tolerance) if len(run[0]) == 1 else _grid(run, tolerance)
    return found


def _grid(run: list[list[Convex]], tolerance: float) -> list[Cluster]:
    """Names with several steps each: as few sectors of steps as do, then names in a row put together in all sectors alike."""
    most = max(len(steps) for steps in run)
    counts = [c for c in _SECTORS if c < most]

    def fits(count: int) -> bool:
        looked_at = range(count) if len(run) == 1 else (0, count // 4)  # steps around an axis are alike
        sectors = (_sector(steps, count, k) for steps in run for k in looked_at)
        return all(_within(part, tolerance) for part in sectors if part)

    count = [*counts, most][bisect_left(counts, True, key=fits)]  # with more sectors gaps are less
    sectors = [_sectors(steps, count) for steps in run]
    if len(run) == 1:
        return [part for part in sectors[0] if part]
    first = _chained([parts[0] for parts in sectors], tolerance)
    lengths, at, found = [], 0, []
    for merged in first:
        stop = at
        while at < len(run) and {p.name for p in sectors[at][0]} <= {p.name for p in merged}:
            at += 1
        lengths.append((stop, at))
    for k in range(count):
        found += [sum((parts[k] for parts in sectors[a:b]), ()) for a, b in lengths]
    return [cluster for cluster in found if cluster]


def _sectors(steps: list[Convex], count: int) -> list[Cluster]:
    return [_sector(steps, count, k) for k in range(count)]


def _sector(steps: list[Convex], count: int, k: int) -> Cluster:
    return tuple(steps[-(-len(steps) * k // count) : -(-len(steps) * (k + 1) // count)])


def _chained(parts: list[Cluster], tolerance: float) -> list[Cluster]:
    """Clusters one after the other, put together as long as the hull of all adds less than ``tolerance``."""
    found: list[Cluster] = []
    for part in parts:
        if found and _within(found[-1] + part, tolerance):
            found[-1] = found[-1] + part
        else:
            found.append(part)
    return found


def gather_clusters(parts: list[Cluster], tolerance: float) -> list[Cluster]:
    """Clusters of several primitives in a row, such as the keys of a keyboard: rows first, then rows of rows."""
    while True:
        fewer = _chained(parts, tolerance)
        if len(fewer) == len(parts):
            return parts
        parts = fewer


def cut(pieces: Cluster, tolerance: float, small: float) -> tuple[np.ndarray, float] | None:
    """The plane (normal, offset) along which the hull of pieces of one primitive can be cut off, to clear what they surround.

    It is that of their face that the hull reaches farthest beyond: a stave of a ring so cut touches the bore. None where
    a piece would fall short by more than ``tolerance``, or, unless all are within a box of ``small``, one would be lost;
    of those, where more than one in _LOST would be.
    """
    if len({piece.unit for piece in pieces}) > 1:
        return None
    normal, offset = _hollow(pieces)
    points = np.concatenate([piece.points for piece in pieces])
    beyond = points[:, 0] * normal[0] + points[:, 1] * normal[1] + points[:, 2] * normal[2] - offset
    start = np.cumsum([0, *(len(piece.points) for piece in pieces[:-1])])
    high, low = np.maximum.reduceat(beyond, start), np.minimum.reduceat(beyond, start)
    if high.max() > tolerance or low.min() > -_LEFT * (high.max() - low.min()):
        return None
    lost = low > -_LEFT * (high - low)
    most = len(pieces) // _LOST if np.ptp(points, axis=0).max() <= small else 0
    return None if lost.sum() > most else (normal, offset)


def halves(cluster: Cluster) -> tuple[Cluster, Cluster]:
    """A cluster of several pieces in two: of primitives, else of steps, or of names where that fills clearly less."""
    ways = []
    for key in ("unit", "index", "name"):
        values = sorted({getattr(piece, key) for piece in cluster})
        if len(values) > 1:
            middle = values[len(values) // 2]
            one = tuple(p for p in cluster if getattr(p, key) < middle)
            other = tuple(p for p in cluster if getattr(p, key) >= middle)
            if key == "unit":
                return one, other
            ways.append((one, other))
    if not ways:
        raise ValueError("a single piece")
    first, last = (max(gap(one), gap(other)) for one, other in (ways[0], ways[-1]))
    return ways[-1] if last < 0.9 * first else ways[0]
