"""The rows of all sites of some objects, arranged by primitive: one call then serves all instances of a primitive."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..graph.primitive import Primitive
from ..records import dataclass
from .box import bounds
from .sites import SiteTable
from .split import Params


@dataclass(frozen=True, slots=True, eq=False)
class Shelf:
    """The rows ``start .. stop`` of a block, which are instances of one primitive."""

    primitive: Primitive
    params: Params
    start: int
    stop: int


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Rows of ``objects`` consecutive objects, sorted by primitive, then as they come in the site tables.

    ``rank`` orders the rows of an object by site number and rank within the site: of two coincident surfaces the
    lower one keeps its points. ``low``, ``high`` (R, 3) bound the rows in their object's frame.
    """

    objects: int
    shelves: tuple[Shelf, ...]
    owner: np.ndarray  # (R,) object within the block
    site: np.ndarray  # (R,) site number
    row: np.ndarray  # (R,) row of that site's table
    rank: np.ndarray  # (R,) position among all rows of the block, by (owner, site number, rank)
    rotation: np.ndarray  # (9, R) row by row
    translation: np.ndarray  # (3, R)
    mirror: np.ndarray  # (R,)
    low: np.ndarray  # (R, 3)
    high: np.ndarray  # (R, 3)
    diagonal: np.ndarray  # (R,) of the box in the row's own frame, metres

    def only(self, chosen: np.ndarray) -> Block:
        """Some of the rows, those ``chosen`` (R,) bool."""
        shelves, start = [], 0
        for shelf in self.shelves:
            own = chosen[shelf.start : shelf.stop]
            stop = start + int(np.count_nonzero(own))
            if stop > start:
                params = {name: column.compress(own) for name, column in shelf.params.items()}
                shelves.append(Shelf(shelf.primitive, params, start, stop))
            start = stop
        # compress leaves an array in the order of C, which compiled code reads
        owner, site, row, rank = (column.compress(chosen) for column in (self.owner, self.site, self.row, self.rank))
        poses = (
            self.rotation.compress(chosen, axis=1),
            self.translation.compress(chosen, axis=1),
            self.mirror.compress(chosen),
        )
        boxes = (*(end.compress(chosen, axis=0) for end in (self.low, self.high)), self.diagonal.compress(chosen))
        return Block(self.objects, tuple(shelves), owner, site, row, rank, *poses, *boxes)


def block_of(sites: list[SiteTable], first: int, stop: int) -> Block:
    """The rows of the objects ``first .. stop - 1``."""
    by_primitive: dict[int, list[tuple[SiteTable, slice]]] = {}
    for site in sites:
        span = slice(*np.searchsorted(site.owner, (first, stop)).tolist())
        if span.stop > span.start:
            by_primitive.setdefault(id(site.primitive), []).append((site, span))
    shelves, low, high = [], [np.empty((0, 3))], [np.empty((0, 3))]
    chosen: list[tuple[SiteTable, slice]] = []
    start = 0
    for parts in by_primitive.values():
        primitive = parts[0][0].primitive
        stop_row = start + sum(s.stop - s.start for _, s in parts)
        params = {n: np.concatenate([t.params[n][s] for t, s in parts]) for n in primitive.parameters}
        params[""] = np.zeros(stop_row - start)
        shelves.append(Shelf(primitive, params, start, stop_row))
        corners = bounds(primitive, params)
        low.append(corners[0])
        high.append(corners[1])
        chosen.extend(parts)
        start = stop_row

    def column(pick: Callable[[SiteTable, slice], np.ndarray], kind: type = np.int64) -> np.ndarray:
        return np.concatenate([np.empty(0, kind), *(pick(t, s) for t, s in chosen)])

    owner = column(lambda t, s: t.owner[s]) - first
    number = column(lambda t, s: np.full(s.stop - s.start, t.number))
    order = np.lexsort((column(lambda t, s: t.rank[s]), number, owner))
    rank = np.empty(start, dtype=np.int64)
    rank[order] = np.arange(start)
    rotation = np.concatenate([np.empty((0, 3, 3)), *(t.rotation[s] for t, s in chosen)]).reshape(-1, 9)
    translation = np.concatenate([np.empty((0, 3)), *(t.translation[s] for t, s in chosen)])
    mirror = column(lambda t, s: t.mirror[s], np.float64)
    own_low, own_high = np.concatenate(low), np.concatenate(high)
    extent = own_high - own_low
    diagonal = np.sqrt(extent[:, 0] * extent[:, 0] + extent[:, 1] * extent[:, 1] + extent[:, 2] * extent[:, 2])
    poses = (np.ascontiguousarray(rotation.T), np.ascontiguousarray(translation.T), mirror)
    rows = column(lambda t, s: np.arange(s.start, s.stop))
    where = _placed_bounds(poses, np.arange(start), own_low, own_high)
    return Block(stop - first, tuple(shelves), owner, number, rows, rank, *poses, *where, diagonal)


Poses = tuple[np.ndarray, np.ndarray, np.ndarray]
Coordinates = tuple[np.ndarray, np.ndarray, np.ndarray]


def _placed_bounds(poses: Poses, row: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Boxes (m, 3) in the own frames of rows, bounded by boxes in the object's frame."""
    rotation, translation, mirror = poses[0].take(row, axis=1), poses[1].take(row, axis=1), poses[2].take(row)
    middle, half = (low + high) / 2, (high - low) / 2
    out_low, out_high = np.empty_like(middle), np.empty_like(middle)
    y = middle[:, 1] * mirror
    for axis in range(3):
        a, b, c = rotation[3 * axis], rotation[3 * axis + 1], rotation[3 * axis + 2]
        centre = a * middle[:, 0] + b * y + c * middle[:, 2] + translation[axis]
        reach = np.abs(a) * half[:, 0] + np.abs(b) * half[:, 1] + np.abs(c) * half[:, 2]
        out_low[:, axis], out_high[:, axis] = centre - reach, centre + reach
    return out_low, out_high


def to_object(
    poses: Poses, row: np.ndarray, place: Coordinates, direction: Coordinates
) -> tuple[Coordinates, Coordinates]:
    """Places and directions (three arrays (m,) each) in the own frames of rows, in the object's frame."""
    rotation, translation, mirror = poses[0].take(row, axis=1), poses[1].take(row, axis=1), poses[2].take(row)
    locals_ = [(p[0], p[1] * mirror, p[2]) for p in (place, direction)]
    places, directions = [], []
    for axis in range(3):
        a, b, c = rotation[3 * axis : 3 * axis + 3]
        one, two = (a * x + b * y + c * z for x, y, z in locals_)
        one += translation[axis]
        places.append(one)
        directions.append(two)
    return (places[0], places[1], places[2]), (directions[0], directions[1], directions[2])


def placed_points(poses: Poses, row: np.ndarray, place: Sequence[np.ndarray] | np.ndarray) -> list[np.ndarray]:
    """Places (three arrays (m,) each) in the own frames of rows, in the object's frame."""
    x, y, z = place[0], place[1] * poses[2][row], place[2]
    cells = ((poses[0][3 * axis + k][row] for k in range(3)) for axis in range(3))
    return [a * x + b * y + c * z + poses[1][axis][row] for axis, (a, b, c) in enumerate(cells)]


def to_local(
    poses: Poses, row: np.ndarray, point: Sequence[np.ndarray] | np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Coordinates of points of the object (three arrays (m,)) in the own frames of rows."""
    offset = [point[axis] - poses[1][axis][row] for axis in range(3)]
    out = []
    for axis in range(3):
        a, b, c = (poses[0][3 * k + axis][row] for k in range(3))
        out.append(a * offset[0] + b * offset[1] + c * offset[2])
    return out[0], out[1] * poses[2][row], out[2]
