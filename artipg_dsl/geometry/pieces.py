"""Convex pieces of many instances at once: the declared ones, or the hull of a mesh of few corners.

The faces of a hull are found at the test values when the primitive is compiled; an instance takes the first set of
faces that is convex for it, and only one that fits none gets a hull of its own. Whoever needs the points alone asks for
clouds, whose faces are looked for when they are wanted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from hashlib import blake2b
from typing import Any

import numpy as np

from ..graph.expr import Expr
from ..graph.primitive import Primitive
from ..records import dataclass
from . import facts, mesh
from .errors import PrimitiveError
from .patches import evaluate_rows
from .runs import absent
from .split import Params, keep_formula, rows_of
from .topology import topology
from .trial import draw_trial, variants
from .vectors import cross, dot, extent
from .weld import plan_weld, step_counts

_STEPS = (24, 16, 12, 8)  # per full turn: a hull takes the finest of these that has few corners
_FEW = 200  # what collision checks and simulators take well; a ball of 16 steps lies within 2 % of its radius
_MOST = 1000  # times a piece is there in an instance
_CHUNK = 20_000  # faces that are looked at together, so that they stay in the cache
_OWN = 64  # hulls of single instances that are kept of a primitive
_FLAT = 1e-7  # how far, relative to the piece's extent, a vertex may stand out of the plane of a face


@dataclass(frozen=True, slots=True, eq=False)
class PieceGroup:
    """One convex piece per instance of ``rows`` (k',): ``vertices`` (k', P, 3) and common outward ``faces`` (F, 3)."""

    name: str
    rows: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray


@dataclass(frozen=True, eq=False)
class _Hull:
    """``used`` (P,) indexes the points that are corners; ``faces`` (F, 3) indexes ``used``."""

    used: np.ndarray
    faces: np.ndarray

    @cached_property
    def told(self) -> np.ndarray:
        """``faces`` as groups have them, one array for all."""
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
def _shared(used: bytes, faces: bytes) -> _Hull:
    """One hull for all pieces with the same corners and faces."""
    return _Hull(np.frombuffer(used, dtype=np.int64), np.frombuffer(faces, dtype=np.int64).reshape(-1, 3))


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Points (k, P, 3) of convex pieces of instances ``rows`` (k,), before their faces are looked for.

    A declared piece is there so many times, with an ``index`` (k,) for each; ``number`` is its own, -1: the hull of a mesh.
    """

    primitive: Primitive
    number: int
    variant: tuple[bool, ...]
    rows: np.ndarray
    index: np.ndarray
    points: np.ndarray

    def known(self, index: int) -> tuple[_Hull, ...]:
        """The hulls that may fit."""
        if self.number < 0:
            return _mesh_hulls(self.primitive, self.variant)
        return _known(self.primitive, self.number, index)

    def name(self, index: int) -> str:
        if self.number < 0:
            return "hull"
        piece = self.primitive.pieces[self.number]
        return piece.name if piece.count is None else f"{piece.name}[{index}]"

    def at(self, chosen: np.ndarray, first: int = 0) -> Cloud:
        """Some of the pieces, in their order, of instances counted from ``first`` on."""
        return replace(self, rows=self.rows[chosen] - first, index=self.index[chosen], points=self.points[chosen])

    def ranges(self) -> list[tuple[int, int, int]]:
        """(index, where its rows begin, where they end): rows are sorted by index."""
        edges = np.flatnonzero(np.diff(self.index, prepend=-1)).tolist()
        ends = [*edges[1:], len(self.index)] if edges else []  # a piece under a condition may be in no row
        return [(int(self.index[a]), a, b) for a, b in zip(edges, ends, strict=True)]

    def settled(self) -> np.ndarray:
        """(k,) of which pieces all points are corners, as far as is known before their faces are."""
        count, found = self.points.shape[1], np.ones(len(self.rows), dtype=bool)
        for index, start, stop in self.ranges():
            found[start:stop] = _all_corners(self.known(index), count)
        return found

    def fitted(self, chosen: np.ndarray) -> list[tuple[np.ndarray, _Hull]]:
        """The hulls of some of the pieces: (positions in ``chosen``, their hull)."""
        alike: dict[tuple[_Hull, ...], list[np.ndarray]] = {}
        order = np.argsort(self.index[chosen], kind="stable")
        for own in np.split(order, np.flatnonzero(np.diff(self.index[chosen[order]])) + 1) if len(order) else ():
            alike.setdefault(self.known(int(self.index[chosen[own[0]]])), []).append(own)
        found: list[tuple[np.ndarray, _Hull]] = []
        for known, parts in alike.items():
            at = np.concatenate(parts)
            fitting = _fitting(self.points[chosen[at]], known)
            found += [(at[fitting == n], hull) for n, hull in enumerate(known) if (fitting == n).any()]
            for own in at[fitting == len(known)].tolist():
                row = chosen[own]
                hull = _own(self.primitive, self.name(int(self.index[row])), self.points[row])
                found.append((np.array([own]), hull))
        return found

    def groups(self) -> list[PieceGroup]:
        """The pieces with their faces, index by index."""
        found: dict[int, list[PieceGroup]] = {}
        alike: dict[tuple[_Hull, ...], list[tuple[int, int, int]]] = {}
        for index, start, stop in self.ranges():
            alike.setdefault(self.known(index), []).append((index, start, stop))
        for known, ranges in alike.items():
            fitting = _fitting(np.concatenate([self.points[start:stop] for _, start, stop in ranges]), known)
            begin = 0
            for index, start, stop in ranges:
                fits = fitting[begin : begin + stop - start]
                begin += stop - start
                own = slice(start, stop)
                name = self.name(index)
                found[index] = _grouped(self.primitive, name, self.rows[own], self.points[own], known, fits)
        return [group for index in sorted(found) for group in found[index]]


@lru_cache(maxsize=8192)
def _all_corners(hulls: tuple[_Hull, ...], count: int) -> bool:
    """Whether so many points are the corners of each of some hulls."""
    return all(len(hull.used) == count for hull in hulls)


def clouds(primitive: Primitive, params: Params) -> list[Cloud]:
    """The points of all convex pieces of k instances; metres, own frame."""
    if not primitive.pieces:
        found = []
        for variant, rows in mesh.group_rows(primitive, params):
            (made,) = mesh.build(primitive, mesh.take(params, rows), _hull_steps(primitive, variant))
            found.append(Cloud(primitive, -1, variant, rows, np.zeros(len(rows), dtype=np.int64), made.vertices))
        return found
    declared = [cloud for numbers in _alike(primitive) for cloud in _declared(primitive, numbers, params)]
    return sorted(declared, key=lambda cloud: cloud.number)


def join_clouds(some: Sequence[Sequence[Cloud]], starts: Sequence[int]) -> list[Cloud]:
    """The clouds of several sets of instances of one primitive as those of all, the rows of each set counted from its start on."""
    alike: dict[tuple[int, tuple[bool, ...]], list[Cloud]] = {}
    for clouds, start in zip(some, starts, strict=True):
        for cloud in clouds:
            alike.setdefault((cloud.number, cloud.variant), []).append(replace(cloud, rows=cloud.rows + start))
    found = []
    for key in sorted(alike):
        rows, index, points = (
            np.concatenate([getattr(cloud, name) for cloud in alike[key]]) for name in ("rows", "index", "points")
        )
        order = np.argsort(index, kind="stable")
        found.append(replace(alike[key][0], rows=rows[order], index=index[order], points=points[order]))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Pieces with one ``hull``: by the number ``cloud`` (k,) of a cloud and ``index`` (k,), of instances ``rows`` (k,); corners (k, P, 3)."""

    hull: _Hull
    cloud: np.ndarray
    index: np.ndarray
    rows: np.ndarray
    corners: np.ndarray


def fit_all(clouds: Sequence[Cloud]) -> list[Fitted]:
    """The hulls of the pieces of several clouds; those that may have the same are looked at together."""
    alike: dict[tuple[tuple[_Hull, ...], int], list[tuple[int, int, int]]] = {}
    for number, cloud in enumerate(clouds):
        for step, start, stop in cloud.ranges():
            alike.setdefault((cloud.known(step), cloud.points.shape[1]), []).append((number, start, stop))
    found = []
    for (known, _), ranges in alike.items():
        of = np.repeat([number for number, _, _ in ranges], [stop - start for _, start, stop in ranges])
        index, rows, points = (
            np.concatenate([getattr(clouds[number], name)[start:stop] for number, start, stop in ranges])
            for name in ("index", "rows", "points")
        )
        fitting = _fitting(points, known)
        hulls = [(np.flatnonzero(fitting == number), hull) for number, hull in enumerate(known)]
        for k in np.flatnonzero(fitting == len(known)).tolist():
            cloud = clouds[of[k]]
            hulls.append((np.array([k]), _own(cloud.primitive, cloud.name(int(index[k])), points[k])))
        found += [
            Fitted(hull, of[at], index[at], rows[at], points[at[:, None], hull.used]) for at, hull in hulls if len(at)
        ]
    return found


def build(primitive: Primitive, params: Params) -> list[PieceGroup]:
    """Convex pieces of k instances, one group per piece (its index too) and per set of faces; metres, own frame."""
    return [group for cloud in clouds(primitive, params) for group in cloud.groups()]


def amounts(primitive: Primitive, params: Params) -> np.ndarray:
    """(k,) how many convex pieces ``build`` makes of each instance."""
    if not primitive.pieces:
        return np.ones(rows_of(params), dtype=np.int64)
    counted = [len(numbers) * _counts(primitive, numbers[0], params) for numbers in _alike(primitive)]
    return np.sum(counted, axis=0)


@lru_cache(maxsize=512)
def _alike(primitive: Primitive) -> tuple[tuple[int, ...], ...]:
    """The numbers of the declared pieces; those that are there as many times as one another, by the same formulas, together."""
    found: dict[tuple[Expr | None, Expr | None], list[int]] = {}
    for number, piece in enumerate(primitive.pieces):
        found.setdefault((piece.count, piece.guard), []).append(number)
    return tuple(map(tuple, found.values()))


def _declared(primitive: Primitive, numbers: tuple[int, ...], params: Params) -> list[Cloud]:
    """Declared pieces that are alike; all indices of one together."""
    counts = _counts(primitive, numbers[0], params)
    rows = [np.flatnonzero(counts > index) for index in range(int(counts.max(initial=0)))]
    index = np.repeat(np.arange(len(rows)), [len(own) for own in rows])
    chosen = np.concatenate([np.zeros(0, dtype=np.int64), *rows])
    points = _points(primitive, numbers, index, mesh.take(params, chosen))
    return [Cloud(primitive, n, (), chosen, index, own) for n, own in zip(numbers, points, strict=True)]


def _counts(primitive: Primitive, number: int, params: Params) -> np.ndarray:
    """(k,) how many of a declared piece each instance has; the guard makes it 0."""
    piece = primitive.pieces[number]
    count = np.ones(rows_of(params))
    if piece.count is not None:
        count = np.floor(evaluate_rows(primitive, (piece.count,), params)[0] + 0.5)
    if piece.guard is not None:
        count = np.where(evaluate_rows(primitive, (piece.guard,), params, bool)[0], count, 0.0)
    if not (count <= _MOST).all():
        raise PrimitiveError(primitive, None, f"piece {piece.name} is there {count.max():.0f} times, more than {_MOST}")
    return count.astype(np.int64)


@lru_cache(maxsize=2048)
def _corners(primitive: Primitive, numbers: tuple[int, ...]) -> Callable[..., tuple[Any, ...]]:
    """The declared points of some pieces as a function of the parameters' columns and of their index."""
    points = [point for number in numbers for point in primitive.pieces[number].points]
    name = f"corners of {' '.join(map(str, numbers))}"
    return keep_formula(primitive, name, 3 * len(points), lambda: [e for point in points for e in point], ("i",))


def _points(primitive: Primitive, numbers: tuple[int, ...], index: np.ndarray, params: Params) -> list[np.ndarray]:
    """(k, points, 3) of each of some pieces: its declared points at each instance's ``index`` (k,)."""
    count = rows_of(params)
    values = iter(_corners(primitive, numbers)(*(params[n] for n in primitive.parameters), index.astype(np.float64)))
    found = []
    for number in numbers:
        points = len(primitive.pieces[number].points)
        out = np.empty((count, 3 * points))
        for column, value in zip(range(3 * points), values, strict=False):
            out[:, column] = value
        found.append(out.reshape(count, points, 3))
    return found


@lru_cache(maxsize=8192)
def _known(primitive: Primitive, number: int, index: int) -> tuple[_Hull, ...]:
    """The sets of faces that the test values show for a declared piece, or for the last step that they have, as steps are alike."""
    piece = primitive.pieces[number]

    def find() -> tuple[_Hull, ...]:
        tested = _tested(primitive, number)
        rows = np.flatnonzero(tested.index == index)
        last = tested.index.max(initial=-1)
        if 0 <= last < index:
            return _known(primitive, number, int(last))
        return _distinct(primitive, piece.name, tested.points[rows])

    return _kept(primitive, f"hulls {number} {index}", find, len(piece.points))


def _tested(primitive: Primitive, number: int) -> Cloud:
    """A declared piece at the test values."""
    numbers = next(numbers for numbers in _alike(primitive) if number in numbers)
    return _tested_together(primitive, numbers)[numbers.index(number)]


@lru_cache(maxsize=8)
def _tested_together(primitive: Primitive, numbers: tuple[int, ...]) -> list[Cloud]:
    """Declared pieces that are alike at the test values: all steps of all of them are one call of their formulas."""
    return _declared(primitive, numbers, draw_trial(primitive))


@lru_cache(maxsize=512)
def _hull_steps(primitive: Primitive, variant: tuple[bool, ...]) -> int:
    """The steps per full turn of the mesh whose hull is the piece."""

    def find() -> int:
        found = topology(primitive, variant)
        few = (s for s in _STEPS if plan_weld(found, tuple(step_counts(found, s).tolist())).count <= _FEW)
        return next(few, _STEPS[-1])

    def read(held: Any) -> int:
        return _STEPS[_STEPS.index(held)]  # a ValueError for any other number

    return facts.recall_fact(primitive, f"hull steps {_word(variant)}", find, int, read)


def _word(variant: tuple[bool, ...]) -> str:
    """Which patches there are, as facts are named."""
    return "".join(str(int(there)) for there in variant)


@lru_cache(maxsize=512)
def _mesh_hulls(primitive: Primitive, variant: tuple[bool, ...]) -> tuple[_Hull, ...]:
    """The mesh itself, where it may be convex, and the hulls of the test values for which it is not."""
    found = topology(primitive, variant)
    corners = plan_weld(found, tuple(step_counts(found, _hull_steps(primitive, variant)).tolist())).count
    return _kept(primitive, f"hulls of meshes {_word(variant)}", lambda: _found_hulls(primitive, variant), corners)


def _found_hulls(primitive: Primitive, variant: tuple[bool, ...]) -> tuple[_Hull, ...]:
    found: list[_Hull] = []
    params = mesh.take(draw_trial(primitive), variants(primitive)[variant])
    (made,) = mesh.build(primitive, params, _hull_steps(primitive, variant))
    points, corners = made.vertices, made.vertices.shape[1]
    if 2 * corners - len(made.faces) == 4:  # V - E + F = 2: one body without holes
        found.append(_Hull(np.arange(corners), made.faces.astype(np.int64)))
        points = points[~_fits(points, found[-1])]
    return (*found, *_distinct(primitive, "hull", points))


def _kept(
    primitive: Primitive, name: str, find: Callable[[], tuple[_Hull, ...]], points: int, most: int | None = None
) -> tuple[_Hull, ...]:
    """Hulls of so many ``points`` as facts that are kept between runs."""
    return facts.recall_fact(
        primitive,
        name,
        find,
        lambda hulls: [[hull.used.tolist(), hull.faces.ravel().tolist()] for hull in hulls],
        lambda data: tuple(_read(tuple(used), tuple(faces), points) for used, faces in data),
        most,
    )


def _own(primitive: Primitive, name: str, points: np.ndarray) -> _Hull:
    """The hull of one instance (P, 3); the first of a primitive are kept, so that the first objects are there at once."""
    seen = blake2b(np.ascontiguousarray(points).tobytes(), digest_size=12).hexdigest()
    find = lambda: (_hull(primitive, name, points),)  # noqa: E731
    (found,) = _kept(primitive, f"own hull {seen}", find, len(points), _OWN)
    return found


@lru_cache(maxsize=4096)
def _read(used: tuple[int, ...], faces: tuple[int, ...], points: int) -> _Hull:
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


def _distinct(primitive: Primitive, name: str, points: np.ndarray) -> tuple[_Hull, ...]:
    """Hulls such that each of the instances (k, P, 3) fits one of them."""
    found: list[_Hull] = []
    open_rows = np.ones(len(points), dtype=bool)
    while open_rows.any():
        hull = _hull(primitive, name, points[int(np.argmax(open_rows))])
        found.append(hull)
        fits = _fits(points, hull)
        fits[int(np.argmax(open_rows))] = True
        open_rows &= ~fits
    return tuple(found)


def _hull(primitive: Primitive, name: str, points: np.ndarray) -> _Hull:
    """The hull of one instance (P, 3), triangulated, faces outwards; PrimitiveError when the points are flat."""
    from scipy.spatial import ConvexHull, QhullError  # late: importing the package must not load SciPy

    low, size = points.min(axis=0), points.max(axis=0) - points.min(axis=0)
    if not np.isfinite(size).all():
        raise PrimitiveError(primitive, None, f"piece {name} has points that are not finite numbers")
    flat = PrimitiveError(primitive, None, f"piece {name} has no volume: its points lie in one plane")
    if (size <= 1e-12 * size.max()).any():
        raise flat
    scaled = (points - low) / size  # the faces of a hull do not change under scaling, their precision does
    try:
        found = ConvexHull(scaled)
    except QhullError as error:
        raise flat from error
    faces = found.simplices.astype(np.int64)
    a, b, c = (scaled[faces[:, n]] for n in range(3))
    turned = dot(cross(b - a, c - a), found.equations[:, :3]) < 0
    faces[turned] = faces[turned][:, ::-1]
    start = np.argmin(faces, axis=1)
    faces = np.take_along_axis(faces, (start[:, None] + np.arange(3)) % 3, axis=1)
    faces = faces[np.lexsort(faces.T[::-1])]
    used, number = np.unique(faces, return_inverse=True)
    return _shared(used.astype(np.int64).tobytes(), number.astype(np.int64).tobytes())


def _fits(points: np.ndarray, hull: _Hull) -> np.ndarray:
    """(k,) bool: for which instances (k, P, 3) the faces are convex and no other point lies in front of one.

    A closed surface of the kind of a sphere is convex as a whole when it is so along every edge.
    """
    low, high = extent(points)
    reach = np.maximum((high - low).max(axis=1), 1e-300)[:, None, None]
    scaled = np.ascontiguousarray(((points - low[:, None]) / reach).transpose(2, 0, 1))
    faces, across = hull.used[hull.faces], hull.used[hull.across]
    others = () if len(hull.used) == points.shape[1] else absent(points.shape[1], hull.used)
    fits = np.ones(len(points), dtype=bool)
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
        fits[part : part + size] = (worst <= reach).all(axis=1)
    return fits


def _fitting(points: np.ndarray, known: tuple[_Hull, ...]) -> np.ndarray:
    """(k,) the first of the hulls that fits each of the instances (k, P, 3), their number where none does."""
    found = np.full(len(points), len(known))
    for number, hull in enumerate(known):
        left = np.flatnonzero(found == len(known))
        if not len(left):
            break
        found[left[_fits(points[left], hull)]] = number
    return found


def _grouped(
    primitive: Primitive, name: str, rows: np.ndarray, points: np.ndarray, known: tuple[_Hull, ...], fitting: np.ndarray
) -> list[PieceGroup]:
    """Instances (k', P, 3) sorted by the hull that fits; those that fit none by a hull of their own."""
    groups = []
    for number, hull in enumerate(known):
        chosen = np.flatnonzero(fitting == number)
        if len(chosen):
            groups.append(PieceGroup(name, rows[chosen], points[chosen][:, hull.used], hull.told))
    for row in np.flatnonzero(fitting == len(known)).tolist():
        hull = _own(primitive, name, points[row])
        own = slice(row, row + 1)
        groups.append(PieceGroup(name, rows[own], points[own][:, hull.used], hull.told))
    return groups
