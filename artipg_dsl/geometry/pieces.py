"""Convex pieces of many instances at once: the declared ones, or the hull of a mesh of few corners.

The faces of a hull are found at the test values when the primitive is compiled; an instance takes the first set of
faces that is convex for it, and only one that fits none gets a hull of its own. Whoever needs the points alone asks for
clouds, whose faces are looked for when they are wanted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from hashlib import blake2b
from typing import Any

import numpy as np

from ..graph.expr import Expr
from ..graph.primitive import Primitive
from ..records import dataclass
from . import facts, mesh
from .errors import PrimitiveError
from .hulls import Hull, NoHullError, distinct_hulls, distinct_together, fits, read_hull, which_fits
from .patches import evaluate_rows
from .split import Params, keep_formula, rows_of
from .topology import topology
from .trial import draw_trial, variants
from .weld import plan_weld, step_counts

_STEPS = (24, 16, 12, 8)  # per full turn: a hull takes the finest of these that has few corners
_FEW = 200  # what collision checks and simulators take well; a ball of 16 steps lies within 2 % of its radius
_MOST = 1000  # times a piece is there in an instance
_OWN = 64  # hulls of single instances that are kept of a primitive


@dataclass(frozen=True, slots=True, eq=False)
class PieceGroup:
    """One convex piece per instance of ``rows`` (k',): ``vertices`` (k', P, 3) and common outward ``faces`` (F, 3)."""

    name: str
    rows: np.ndarray
    vertices: np.ndarray
    faces: np.ndarray


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

    def known(self, index: int) -> tuple[Hull, ...]:
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

    def fitted(self, chosen: np.ndarray) -> list[tuple[np.ndarray, Hull]]:
        """The hulls of some of the pieces: (positions in ``chosen``, their hull)."""
        alike: dict[tuple[Hull, ...], list[np.ndarray]] = {}
        order = np.argsort(self.index[chosen], kind="stable")
        for own in np.split(order, np.flatnonzero(np.diff(self.index[chosen[order]])) + 1) if len(order) else ():
            alike.setdefault(self.known(int(self.index[chosen[own[0]]])), []).append(own)
        found: list[tuple[np.ndarray, Hull]] = []
        for known, parts in alike.items():
            at = np.concatenate(parts)
            fitting = which_fits(self.points[chosen[at]], known)
            found += [(at[fitting == n], hull) for n, hull in enumerate(known) if (fitting == n).any()]
            for own in at[fitting == len(known)].tolist():
                row = chosen[own]
                hull = _own(self.primitive, self.name(int(self.index[row])), self.points[row])
                found.append((np.array([own]), hull))
        return found

    def groups(self) -> list[PieceGroup]:
        """The pieces with their faces, index by index."""
        found: dict[int, list[PieceGroup]] = {}
        alike: dict[tuple[Hull, ...], list[tuple[int, int, int]]] = {}
        for index, start, stop in self.ranges():
            alike.setdefault(self.known(index), []).append((index, start, stop))
        for known, ranges in alike.items():
            fitting = which_fits(np.concatenate([self.points[start:stop] for _, start, stop in ranges]), known)
            begin = 0
            for index, start, stop in ranges:
                fits = fitting[begin : begin + stop - start]
                begin += stop - start
                own = slice(start, stop)
                name = self.name(index)
                found[index] = _grouped(self.primitive, name, self.rows[own], self.points[own], known, fits)
        return [group for index in sorted(found) for group in found[index]]


@lru_cache(maxsize=8192)
def _all_corners(hulls: tuple[Hull, ...], count: int) -> bool:
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

    hull: Hull
    cloud: np.ndarray
    index: np.ndarray
    rows: np.ndarray
    corners: np.ndarray


def fit_all(clouds: Sequence[Cloud]) -> list[Fitted]:
    """The hulls of the pieces of several clouds; those that may have the same are looked at together."""
    alike: dict[tuple[tuple[Hull, ...], int], list[tuple[int, int, int]]] = {}
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
        fitting = which_fits(points, known)
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
def _known(primitive: Primitive, number: int, index: int) -> tuple[Hull, ...]:
    """The sets of faces that the test values show for a declared piece, or for the last step that they have, as steps are alike."""
    piece = primitive.pieces[number]

    def find() -> tuple[Hull, ...]:
        numbers = next(numbers for numbers in _alike(primitive) if number in numbers)
        steps, together = _tested(primitive, numbers)[numbers.index(number)]
        if not steps:
            return ()
        if index >= len(steps):
            return _known(primitive, number, len(steps) - 1)
        return together[index] or _distinct(primitive, piece.name, steps[index])

    return _kept(primitive, f"hulls {number} {index}", find, len(piece.points))


@lru_cache(maxsize=64)
def _tested(
    primitive: Primitive, numbers: tuple[int, ...]
) -> list[tuple[list[np.ndarray], list[tuple[Hull, ...] | None]]]:
    """Declared pieces that are alike, at the test values: the points of each step, and its hulls where they are found together. All steps
    of all of these pieces are one call of their formulas."""
    steps = [
        [cloud.points[start:stop] for _, start, stop in cloud.ranges()]
        for cloud in _declared(primitive, numbers, draw_trial(primitive))
    ]
    found = iter(distinct_together([points for own in steps for points in own]))
    return [(own, [next(found) for _ in own]) for own in steps]


def _distinct(primitive: Primitive, name: str, points: np.ndarray) -> tuple[Hull, ...]:
    """Hulls such that each of the instances (k, P, 3) of a piece fits one of them."""
    try:
        return distinct_hulls(points)
    except NoHullError as error:
        raise PrimitiveError(primitive, None, f"piece {name} {error}") from error


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
def _mesh_hulls(primitive: Primitive, variant: tuple[bool, ...]) -> tuple[Hull, ...]:
    """The mesh itself, where it may be convex, and the hulls of the test values for which it is not."""
    found = topology(primitive, variant)
    corners = plan_weld(found, tuple(step_counts(found, _hull_steps(primitive, variant)).tolist())).count
    return _kept(primitive, f"hulls of meshes {_word(variant)}", lambda: _found_hulls(primitive, variant), corners)


def _found_hulls(primitive: Primitive, variant: tuple[bool, ...]) -> tuple[Hull, ...]:
    found: list[Hull] = []
    params = mesh.take(draw_trial(primitive), variants(primitive)[variant])
    (made,) = mesh.build(primitive, params, _hull_steps(primitive, variant))
    points, corners = made.vertices, made.vertices.shape[1]
    if 2 * corners - len(made.faces) == 4:  # V - E + F = 2: one body without holes
        found.append(Hull(np.arange(corners), made.faces.astype(np.int64)))
        points = points[~fits(points, found[-1])]
    return (*found, *_distinct(primitive, "hull", points))


def _kept(
    primitive: Primitive, name: str, find: Callable[[], tuple[Hull, ...]], points: int, most: int | None = None
) -> tuple[Hull, ...]:
    """Hulls of so many ``points`` as facts that are kept between runs."""
    return facts.recall_fact(
        primitive,
        name,
        find,
        lambda hulls: [[hull.used.tolist(), hull.faces.ravel().tolist()] for hull in hulls],
        lambda data: tuple(read_hull(tuple(used), tuple(faces), points) for used, faces in data),
        most,
    )


def _own(primitive: Primitive, name: str, points: np.ndarray) -> Hull:
    """The hull of one instance (P, 3); the first of a primitive are kept, so that the first objects are there at once."""
    seen = blake2b(np.ascontiguousarray(points).tobytes(), digest_size=12).hexdigest()
    find = lambda: _distinct(primitive, name, points[None])  # noqa: E731
    (found,) = _kept(primitive, f"own hull {seen}", find, len(points), _OWN)
    return found


def _grouped(
    primitive: Primitive, name: str, rows: np.ndarray, points: np.ndarray, known: tuple[Hull, ...], fitting: np.ndarray
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
