"""Faces of convex pieces that many instances share: which instances they fit, and the sets of faces that instances need."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache

import numpy as np

from ..native import backend
from ..native import wrap as native
from ..records import dataclass
from . import wrap
from .runs import absent
from .vectors import extent

_CHUNK = 20_000  # faces that are looked at together, so that they stay in the cache
_BEND = 1e-8  # how far points are moved where faces hardly bend: less than what counts as flat
_FLAT = 1e-7  # how far, relative to the piece's extent, a vertex may stand out of the plane of a face
_NO_VOLUME = "has no volume: its points lie in one plane"


class NoHullError(ValueError):
    """Points that have no hull; the message says why."""


@dataclass(frozen=True, eq=False)
class Hull:
    """``used`` (P,) indexes the points that are corners; ``faces`` (F, 3) indexes ``used``."""

    used: np.ndarray
    faces: np.ndarray

    @cached_property
    def told(self) -> np.ndarray:
        """``faces`` as groups of pieces have them, one array for all."""
        return self.faces.astype(np.int32)

    @cached_property
    def across(self) -> np.ndarray:
        """(F, 3): the corner of the neighbouring face across each edge of a face, as an index into ``used``."""
        count = len(self.used)
        start, end = self.faces, np.roll(self.faces, -1, axis=1)
        opposite = np.roll(self.faces, -2, axis=1).ravel()
        forward, back = (start * count + end).ravel(), (end * count + start).ravel()
        order = np.argsort(forward)
        return opposite[order[np.searchsorted(forward[order], back)]].reshape(-1, 3)


@lru_cache(maxsize=4096)
def _shared(used: bytes, faces: bytes) -> Hull:
    """One hull for all pieces with the same corners and faces."""
    return Hull(np.frombuffer(used, dtype=np.int64), np.frombuffer(faces, dtype=np.int64).reshape(-1, 3))


@lru_cache(maxsize=4096)
def read_hull(used: tuple[int, ...], faces: tuple[int, ...], points: int) -> Hull:
    """The hull of data that anyone may have written, which many pieces share; ValueError where it is no closed surface over so many
    points."""
    chosen, corners = np.array(used, dtype=np.int64), np.array(faces, dtype=np.int64).reshape(-1, 3)
    count = len(chosen)
    if count < 4 or not ((chosen >= 0) & (chosen < points)).all() or (np.diff(chosen) <= 0).any():
        raise ValueError("the corners of a hull are some of the points, in their order")
    if not ((corners >= 0) & (corners < count)).all():
        raise ValueError("a face of a hull has three of its corners")
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    edges, back = np.sort(start * count + end), np.sort(end * count + start)
    if (np.diff(edges) == 0).any() or (edges != back).any() or len(corners) != 2 * count - 4:
        raise ValueError("the faces of a hull are closed, and those of one body")
    return _shared(chosen.tobytes(), corners.tobytes())


def hull_of(points: np.ndarray) -> Hull:
    """The hull of one instance (P, 3), triangulated, faces outwards. Raises NoHullError where there is none."""
    size = points.max(axis=0) - points.min(axis=0)
    if not np.isfinite(size).all():
        raise NoHullError("has points that are not finite numbers")
    if not _broad(size):
        raise NoHullError(_NO_VOLUME)
    try:
        for moved in (wrap.BEND, _BEND):
            found = _numbered(wrap.wrap_all([points], moved)[0])
            if fits(points[None], found).all():  # not where true faces bend less than the moved points make them
                return found
        return _numbered(wrap.wrap_plainly(points))
    except wrap.FlatError as error:
        raise NoHullError(_NO_VOLUME) from error


def _broad(size: np.ndarray) -> bool:
    """Whether an extent (3,) is one of a body."""
    return bool((size > 1e-12 * size.max()).all())


def _numbered(wrapped: wrap.Wrapped) -> Hull:
    used, faces = wrapped
    return _shared(used.astype(np.int64).tobytes(), faces.astype(np.int64).tobytes())


def distinct_hulls(points: np.ndarray) -> tuple[Hull, ...]:
    """Hulls such that each of the instances (k, P, 3) fits one of them. Raises NoHullError where one has none."""
    found: list[Hull] = []
    left = np.ones(len(points), dtype=bool)
    while left.any():
        first = int(np.argmax(left))
        found.append(hull_of(points[first]))
        left &= ~fits(points, found[-1])
        left[first] = False
    return tuple(found)


def distinct_together(sets: Sequence[np.ndarray]) -> list[tuple[Hull, ...] | None]:
    """What ``distinct_hulls`` finds for each set of instances (k, P, 3), k at least 1, all first hulls found at once; None for a set that has
    to be looked at alone, as it needs several hulls or has none."""
    found: list[tuple[Hull, ...] | None] = [None] * len(sets)
    chosen = [n for n, points in enumerate(sets) if _broad(points[0].max(axis=0) - points[0].min(axis=0))]
    try:
        wrapped = wrap.wrap_all([sets[n][0] for n in chosen])
    except wrap.FlatError:
        return found
    alike: dict[tuple[Hull, int], list[int]] = {}
    for n, own in zip(chosen, wrapped, strict=True):
        alike.setdefault((_numbered(own), sets[n].shape[1]), []).append(n)
    for (hull, _), numbers in alike.items():
        fitting = fits(np.concatenate([sets[n] for n in numbers]), hull)
        starts = np.cumsum([0, *(len(sets[n]) for n in numbers[:-1])])
        for n, all_fit in zip(numbers, np.logical_and.reduceat(fitting, starts).tolist(), strict=True):
            found[n] = (hull,) if all_fit else None
    return found


def fits(points: np.ndarray, hull: Hull) -> np.ndarray:
    """(k,) bool: for which instances (k, P, 3) the faces are convex and no other point lies in front of one.

    A closed surface of the kind of a sphere is convex as a whole when it is so along every edge.
    """
    faces, across = hull.used[hull.faces], hull.used[hull.across]
    others = absent(points.shape[1], hull.used)
    machine = backend.machine()
    if machine is not None:
        return native.fit_faces(machine, points, faces, across, others, _FLAT)
    low, high = extent(points)
    reach = np.maximum((high - low).max(axis=1), 1e-300)[:, None, None]
    scaled = np.ascontiguousarray(((points - low[:, None]) / reach).transpose(2, 0, 1))
    found = np.ones(len(points), dtype=bool)
    size = max(64, _CHUNK // len(faces))
    for part in range(0, len(points), size):
        chunk = scaled[:, part : part + size]
        a, b, c = ([axis[:, faces[:, n]] for axis in chunk] for n in range(3))
        e, f = [q - p for p, q in zip(a, b, strict=True)], [q - p for p, q in zip(a, c, strict=True)]
        normal = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]]
        length = np.sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2])
        reach = normal[0] * a[0] + normal[1] * a[1] + normal[2] * a[2] + _FLAT * length + 1e-18
        worst = np.full(reach.shape, -np.inf)
        for corner in (*across.T, *(np.full(len(faces), p) for p in others)):
            x, y, z = (axis[:, corner] for axis in chunk)
            np.maximum(worst, normal[0] * x + normal[1] * y + normal[2] * z, out=worst)
        found[part : part + size] = (worst <= reach).all(axis=1)
    return found


def which_fits(points: np.ndarray, known: tuple[Hull, ...]) -> np.ndarray:
    """(k,) the first of the hulls that fits each of the instances (k, P, 3), their number where none does."""
    found = np.full(len(points), len(known))
    for number, hull in enumerate(known):
        left = np.flatnonzero(found == len(known))
        if not len(left):
            break
        found[left[fits(points if len(left) == len(points) else points[left], hull)]] = number
    return found
