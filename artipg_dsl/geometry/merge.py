"""Fewer convex pieces: the hulls of neighbours in place of the pieces, where hardly more than the pieces fill them.

How much a hull adds is told by how far points of it lie from the nearest piece: points half way between corners that
reach far in some direction. So the walls of a vessel become staves of few sides, while a hole stays a hole. What a hull
adds to the side of the hollow can be cut off along the face of a piece there. Pieces are numbers of a stock, which
knows where they stand: which primitive they belong to, which step around or along it, which of its names.
"""

from __future__ import annotations

from bisect import bisect_left
from functools import lru_cache
from itertools import pairwise

import numpy as np

from ..native import backend, gaps
from .runs import changes
from .stock import Stock

_LEFT = 0.05  # of the depth of a piece: one that keeps less when it is cut is lost
_LOST = 3  # one piece in so many at most: four staves of a thin ring lose a third, and stand all round it
_SECTORS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 48, 60)
_WAYS = np.array(
    [(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)], float
)
_MANY, _FIRST = 64, 4  # pieces from which on points are asked about by and by, and how many at first
_TURNED = _WAYS + np.array([0.011, 0.007, 0.003])  # so that no two corners of a box tie

Cluster = np.ndarray  # numbers (n,) of pieces


def gap(stock: Stock, pieces: Cluster) -> float:
    """How far the hull of pieces reaches from them, at the points looked at; metres."""
    return 0.0 if len(pieces) == 1 else _asked(stock, pieces)[0]


def _hollow(stock: Stock, pieces: Cluster) -> tuple[np.ndarray, float]:
    """The plane (normal (3,), offset) of the face beyond which the hull of several pieces reaches farthest from them."""
    _, face = _asked(stock, pieces)
    at = stock.faces(pieces)[face]
    return stock.normals[at], float(stock.offsets[at])


def _asked(stock: Stock, pieces: Cluster) -> tuple[float, int]:
    """``_deepest``, by compiled code where there is some; what was asked is kept."""
    key = pieces.tobytes()
    if key not in stock.known:
        machine = backend.machine()
        stock.known[key] = (
            _deepest(stock, pieces) if machine is None else gaps.deepest(machine, stock.places, pieces, _TURNED)
        )
    return stock.known[key]


def _deepest(stock: Stock, pieces: Cluster) -> tuple[float, int]:
    """How far the hull reaches from its pieces where it does most, and the nearest face there, counted over all pieces.

    Of many pieces, the one with the nearest middle tells how far a point lies at most: all are asked about the farthest alone.
    """
    points = _extreme(stock.corners(pieces))
    i, j = _pairs(len(points))
    middles = (points[i] + points[j]) / 2
    faces = stock.faces(pieces)
    normals, offsets = stock.normals[faces], stock.offsets[faces]
    start = np.cumsum([0, *(stock.face_start[pieces + 1] - stock.face_start[pieces])])
    numbers = np.arange(len(middles))
    at_most, block = None, len(middles)
    if len(pieces) > _MANY:
        at_most = _from_nearest(stock, pieces, middles)
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


def _from_nearest(stock: Stock, pieces: Cluster, points: np.ndarray) -> np.ndarray:
    """How far points (n, 3) lie from the piece whose middle is nearest."""
    counts = stock.sizes(pieces)
    middles = np.add.reduceat(stock.corners(pieces), np.cumsum(counts) - counts, axis=0)
    x, y, z = (points[:, n, None] - middles[:, n] / counts for n in range(3))
    nearest = (x * x + y * y + z * z).argmin(axis=1)
    found = np.zeros(len(points))
    for k in set(nearest.tolist()):
        mine, faces = nearest == k, stock.faces(pieces[k : k + 1])
        found[mine] = _beyond(stock.normals[faces], stock.offsets[faces], points[mine]).max(axis=0)
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


def cluster_units(stock: Stock, pieces: Cluster, tolerance: float) -> np.ndarray:
    """Which cluster (n,) each piece is of, where those of each primitive are put together by ``clusters``; in order of primitive,
    name and index."""
    machine, unit = backend.machine(), stock.unit[pieces]
    if machine is not None:
        name = stock.name[pieces]
        return gaps.cluster(machine, stock.places, pieces, unit, name, np.array(_SECTORS), _TURNED, tolerance)
    found = [
        cluster
        for own in np.split(pieces, np.flatnonzero(changes(unit))[1:])
        for cluster in clusters(stock, own, tolerance)
    ]
    of = np.repeat(np.arange(len(found)), [len(cluster) for cluster in found])
    return of[np.argsort(np.concatenate(found))]


def clusters(stock: Stock, pieces: Cluster, tolerance: float) -> list[Cluster]:
    """The pieces of one primitive, in order of name and index, put together where hulls add less than ``tolerance``."""
    name = stock.name[pieces]
    start = np.flatnonzero(changes(name))
    steps = np.diff(start, append=len(pieces))
    found: list[Cluster] = []
    single = steps == 1  # names of one step and names of several do not mix
    runs = [*np.flatnonzero(changes(single)).tolist(), len(steps)]
    for first, last in pairwise(runs):
        begin = start[first:last]
        if single[first]:
            found += _joined(pieces, *_chained(stock, pieces, begin, begin + 1, tolerance))
        else:
            found += _grid(stock, pieces, begin, steps[first:last], tolerance)
    return found


def _grid(stock: Stock, pieces: Cluster, start: np.ndarray, steps: np.ndarray, tolerance: float) -> list[Cluster]:
    """Names with several ``steps`` each from ``start`` on: as few sectors of steps as do, then names in a row put together in all
    sectors alike."""
    most = int(steps.max())
    counts = [c for c in _SECTORS if c < most]

    def sectors(count: int, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where sectors begin and end (names, len(which))."""
        begin, end = (-(-steps[:, None] * k // count) + start[:, None] for k in (which, which + 1))
        return begin, end

    def fits(count: int) -> bool:
        looked_at = np.arange(count) if len(steps) == 1 else np.array([0, count // 4])  # steps around an axis are alike
        parts = zip(*(ends.ravel().tolist() for ends in sectors(count, looked_at)), strict=True)
        return all(b - a < 2 or gap(stock, pieces[a:b]) <= tolerance for a, b in parts)

    count = [*counts, most][bisect_left(counts, True, key=fits)]  # with more sectors gaps are less
    begin, end = sectors(count, np.arange(count))
    together = np.zeros(1, dtype=np.int64)
    if len(steps) > 1:
        *_, together = _chained(stock, pieces, begin[:, 0], end[:, 0], tolerance)
    found = []
    for k in range(count):
        found += _joined(pieces, begin[:, k], end[:, k], together)
    return [cluster for cluster in found if len(cluster)]


def _chained(
    stock: Stock, pieces: Cluster, begin: np.ndarray, end: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Parts of ``pieces`` one after the other, put together as long as the hull of all adds less than ``tolerance``: where they
    begin and end, and which cluster each is of."""
    machine = backend.machine()
    if machine is not None:
        return begin, end, gaps.chain(machine, stock.places, pieces, begin, end, _TURNED, tolerance)
    found, last = [0], pieces[begin[0] : end[0]]
    for a, b in zip(begin[1:].tolist(), end[1:].tolist(), strict=True):
        more = np.concatenate([last, pieces[a:b]])
        fit = gap(stock, more) <= tolerance
        last = more if fit else pieces[a:b]
        found.append(found[-1] + (not fit))
    return begin, end, np.array(found)


def _joined(pieces: Cluster, begin: np.ndarray, end: np.ndarray, cluster: np.ndarray) -> list[Cluster]:
    """The clusters of parts of ``pieces``, told by where they begin and end and which one each is of, ascending."""
    start = [*np.flatnonzero(changes(cluster)).tolist(), len(cluster)]
    parts = [pieces[a:b] for a, b in zip(begin.tolist(), end.tolist(), strict=True)]
    return [parts[a] if b == a + 1 else np.concatenate(parts[a:b]) for a, b in pairwise(start)]


def gather_clusters(stock: Stock, pieces: Cluster, start: np.ndarray, tolerance: float) -> np.ndarray:
    """Where clusters of several primitives in a row begin, such as the keys of a keyboard, from where those of the primitives do,
    ``start`` (k,): rows first, then rows of rows."""
    while True:
        _, _, cluster = _chained(stock, pieces, start, np.append(start[1:], len(pieces)), tolerance)
        fewer = start[changes(cluster)]
        if len(fewer) == len(start):
            return start
        start = fewer


def cut(stock: Stock, pieces: Cluster, tolerance: float, small: float) -> tuple[np.ndarray, float] | None:
    """The plane (normal, offset) along which the hull of pieces of one primitive can be cut off, to clear what they surround.

    It is that of their face that the hull reaches farthest beyond: a stave of a ring so cut touches the bore. None where
    a piece would fall short by more than ``tolerance``, or, unless all are within a box of ``small``, one would be lost;
    of those, where more than one in _LOST would be.
    """
    unit = stock.unit[pieces]
    if (unit != unit[0]).any():
        return None
    normal, offset = _hollow(stock, pieces)
    points = stock.corners(pieces)
    beyond = points[:, 0] * normal[0] + points[:, 1] * normal[1] + points[:, 2] * normal[2] - offset
    count = stock.sizes(pieces)
    start = np.cumsum(count) - count
    high, low = np.maximum.reduceat(beyond, start), np.minimum.reduceat(beyond, start)
    if high.max() > tolerance or low.min() > -_LEFT * (high.max() - low.min()):
        return None
    lost = low > -_LEFT * (high - low)
    most = len(pieces) // _LOST if np.ptp(points, axis=0).max() <= small else 0
    return None if lost.sum() > most else (normal, offset)


def halves(stock: Stock, cluster: Cluster) -> tuple[Cluster, Cluster]:
    """A cluster of several pieces in two: of primitives, else of steps, or of names where that fills clearly less."""
    ways = []
    for key in (stock.unit, stock.index, stock.name):
        values = key[cluster]
        each = np.unique(values)
        if len(each) > 1:
            lower = values < each[len(each) // 2]
            halved = cluster[lower], cluster[~lower]
            if key is stock.unit:
                return halved
            ways.append(halved)
    if not ways:
        raise ValueError("a single piece")
    first, last = (max(gap(stock, one), gap(stock, other)) for one, other in (ways[0], ways[-1]))
    return ways[-1] if last < 0.9 * first else ways[0]
