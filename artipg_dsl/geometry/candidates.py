"""Candidates for points of pools: random fractions of cells, where these lie, and which of them are kept.

Most cells are flat: what falls on them is told by the quad of the cell, and hidden by quads in the frames of rows. The
others, and flat ones so small that hardly a point falls on them, are looked at by themselves.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .. import random
from ..native import backend
from ..native import points as native
from ..records import dataclass
from .block import Coordinates, to_object
from .density import AreaPlacement, solve_linear
from .flat import BENT, PLANAR
from .hidden import Occlusion
from .pointset import PointSet
from .runs import runs
from .surface import PatchEvaluator

if TYPE_CHECKING:
    from .cells import Cells

_CHUNK = 16_000  # points on one bent patch at a time: their arrays stay in the caches


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """One round: ``stream`` (pools,) of random numbers, ``wanted`` (pools,) candidates, ``count`` (C,) of them on each
    cell, ``before`` (C,) lanes first."""

    stream: np.ndarray
    wanted: np.ndarray
    count: np.ndarray
    before: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Thinning:
    """Of pools (p,) the candidates ``wanted``, how many are ``seen`` and how many there is ``room`` for: they are taken evenly, from
    a ``shift`` on, and go to ``target`` and the places after it."""

    wanted: np.ndarray
    seen: np.ndarray
    room: np.ndarray
    shift: np.ndarray
    target: np.ndarray


class Loose(NamedTuple):
    """Some of the ``LoosePoints``: which candidates of a group they are (k,), and what is known of them."""

    at: np.ndarray
    u: np.ndarray
    v: np.ndarray
    hidden: np.ndarray
    position: np.ndarray  # (3, k)
    normal: np.ndarray  # (3, k)


def draw(stream: np.ndarray, lane: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two numbers in (0, 1) for each lane: of streams (n,) ``count`` (n,) from ``lane`` (n,) on."""
    machine = backend.machine()
    if machine is not None:
        return native.coarse(machine, stream, lane, count)
    return random.coarse(np.repeat(stream, count), runs(lane, count))


def slant(cells: Cells, cell: np.ndarray, at: np.ndarray | slice, u: np.ndarray, v: np.ndarray) -> None:
    """Make the fractions ``u[at]``, ``v[at]`` uniform by area on flat cells whose element grows along u or v."""
    base, along_u, along_v = (e[cell] for e in cells.element)
    middle = base + along_v / 2
    u[at] = solve_linear(u[at], middle, middle + along_u)
    left = base + along_u * u[at]
    v[at] = solve_linear(v[at], left, left + along_v)


class LoosePoints:
    """The candidates of one round, of all pools of a block, on the cells that are not prepared: the bent ones, and flat
    ones so small that hardly a point falls on them. Sorted by cell and lane.

    ``nth`` counts them within their cell; ``u``, ``v``, ``hidden`` (m,), ``position`` and ``normal`` (3, m).
    """

    def __init__(self, cells: Cells, occlusion: Occlusion, drawn: Drawn):
        small = np.flatnonzero((cells.shape != BENT) & ~occlusion.prepared & (drawn.count > 0))
        every = np.concatenate([*(bent.cell for bent in cells.bent), small])
        count = drawn.count[every]
        cell = np.repeat(every, count)
        nth = runs(np.zeros_like(count), count)
        u, v = draw(drawn.stream[cells.pool[every]], drawn.before[every], count)
        position, normal = np.empty((3, len(cell))), np.empty((3, len(cell)))
        begin = 0
        done = np.cumsum(np.concatenate([[0], count]))
        for bent in cells.bent:
            stop = begin + len(bent.cell)
            part = slice(int(done[begin]), int(done[stop]))
            begin = stop
            if part.start == part.stop:
                continue
            row, local, params = cells.rows_asked(bent, cell[part])
            placement = AreaPlacement(bent.shelf.primitive, bent.patch, params)
            surface = PatchEvaluator(bent.shelf.primitive, bent.patch, params)
            for low in range(0, part.stop - part.start, _CHUNK):
                some, mine = (
                    slice(part.start + low, min(part.start + low + _CHUNK, part.stop)),
                    slice(low, low + _CHUNK),
                )
                u[some], v[some] = placement.place(local[mine], u[some], v[some])
                at, outward = surface.at(local[mine], u[some], v[some])
                at, outward = to_object(cells.poses, row[mine], at, outward)
                for axis in range(3):
                    position[axis, some], normal[axis, some] = at[axis], outward[axis]
        part = slice(int(done[begin]), len(cell))
        slanting = np.flatnonzero(cells.shape[cell[part]] == PLANAR)
        slant(cells, cell[part][slanting], slanting, u[part], v[part])
        at = cells.flat_position(cell[part], u[part], v[part])
        for axis in range(3):
            position[axis, part], normal[axis, part] = at[axis], cells.normal[axis][cell[part]]
        turn = np.argsort(every)
        order = runs(done[turn], count[turn])  # the points of a cell stand together
        self.cell, self.nth, self.u, self.v = (column.take(order) for column in (cell, nth, u, v))
        self.position, self.normal = position.take(order, axis=1), normal.take(order, axis=1)
        self.hidden = occlusion.loose_hidden(self.cell, self.position, self.normal)

    def part(self, begin: int, end: int, start: np.ndarray) -> Loose:
        """Those on the cells from ``begin`` to ``end``, whose candidates begin at ``start`` (end - begin,)."""
        mine = slice(*np.searchsorted(self.cell, (begin, end)).tolist())
        at = start[self.cell[mine] - begin] + self.nth[mine]
        return Loose(at, self.u[mine], self.v[mine], self.hidden[mine], self.position[:, mine], self.normal[:, mine])


class Candidates:
    """The candidates of a group of pools (m,) in the order of their cells, which have ``count`` each from the cell ``begin`` on: fractions
    ``u`` and ``v``, and whether they are ``hidden``. What is known of the ``loose`` ones is entered."""

    def __init__(
        self,
        cells: Cells,
        begin: int,
        count: np.ndarray,
        u: np.ndarray,
        v: np.ndarray,
        hidden: np.ndarray,
        loose: Loose,
    ):
        u[loose.at], v[loose.at], hidden[loose.at] = loose.u, loose.v, loose.hidden
        self.cells, self.begin, self.count, self.loose = cells, begin, count, loose
        self.u, self.v, self.hidden = u, v, hidden

    @cached_property
    def cell(self) -> np.ndarray:
        """The cell (m,) of each."""
        return np.repeat(np.arange(self.begin, self.begin + len(self.count)), self.count)

    def places(self, kept: np.ndarray) -> tuple[Coordinates, Coordinates]:
        """Positions and normals of the candidates ``kept`` (ascending)."""
        cells = self.cells
        if not len(self.loose.at):
            cell = self.cell[kept]
            x, y, z = cells.normal
            return cells.flat_position(cell, self.u[kept], self.v[kept]), (x[cell], y[cell], z[cell])
        which = np.full(len(self.u), -1)  # of the loose points, if it is one
        which[self.loose.at] = np.arange(len(self.loose.at))
        which = which[kept]
        flat, other = np.flatnonzero(which < 0), np.flatnonzero(which >= 0)
        which, some = which[other], kept[flat]
        cell = self.cell[some]
        placed = cells.flat_position(cell, self.u[some], self.v[some])
        position, normal = np.empty((3, len(kept))), np.empty((3, len(kept)))
        for axis in range(3):
            position[axis, flat], normal[axis, flat] = placed[axis], cells.normal[axis][cell]
            position[axis, other], normal[axis, other] = (
                self.loose.position[axis][which],
                self.loose.normal[axis][which],
            )
        return (position[0], position[1], position[2]), (normal[0], normal[1], normal[2])

    def keep(self, out: PointSet, place: np.ndarray | None, thinning: Thinning, kept: np.ndarray) -> None:
        """Write those that are seen, the ``kept`` ones (k,), into the rows of ``out``, as far as there is room: one after the other, or where
        ``place`` has these places."""
        machine = backend.machine()
        if machine is not None:
            cells, of = self.cells, thinning
            quads = (cells.origin, cells.a, cells.b, cells.c, cells.normal)
            surfaces = (*quads, cells.shape, cells.row, cells.patch, cells.rows.site, cells.rows.row)
            pools = (of.wanted, of.seen, of.room, of.shift, of.target)
            loose = (self.loose.at, self.loose.position, self.loose.normal)
            into = [getattr(out, name) for name in PointSet.__slots__]
            given = (self.hidden, self.u, self.v)
            native.keep(machine, pools, given, self.begin, self.count, surfaces, PLANAR, loose, place, into)
            return
        seen, room = thinning.seen, thinning.room
        if (room < seen).any():
            rank = runs(np.zeros_like(seen), seen)
            total, take = np.repeat(seen, seen), np.repeat(room, seen)
            spread = rank * take + np.repeat(thinning.shift, seen)
            kept = kept[spread % total + take >= total]
        position, normal = self.places(kept)
        cell, target = self.cell[kept], runs(thinning.target, room)
        target = target if place is None else place[target]
        row = self.cells.row[cell]
        out.site.reshape(-1)[target] = self.cells.rows.site[row]
        out.row.reshape(-1)[target] = self.cells.rows.row[row]
        out.patch.reshape(-1)[target] = self.cells.patch[cell]
        out.u.reshape(-1)[target], out.v.reshape(-1)[target] = self.u[kept], self.v[kept]
        for axis in range(3):
            out.position.reshape(-1, 3)[target, axis] = position[axis]
            out.normal.reshape(-1, 3)[target, axis] = normal[axis]
