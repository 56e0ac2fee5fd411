"""Exactly n points per object, uniform by area over its visible surface, each bound to (site, row, patch, u, v).

Candidates are allocated to the patches of an object by one random offset and fall on them by addressed random
numbers; the hidden ones are dropped and the rest thinned evenly. Nothing that is drawn for an object depends on the
others in the batch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..graph import random
from .block import Block, Shelf, block, to_object
from .density import Placement
from .hidden import Cells, hidden, occluders, scales
from .patches import surfaces
from .sites import SiteTable
from .surface import Evaluator

_CANDIDATES = 120_000  # at a time: their arrays stay in the caches
_SPARE = 1.25  # candidates per point wanted
_ROUNDS = 40
_LEAST = 1 / 64  # share of visible candidates that later rounds reckon with at least
_OFFSET_LANE, _THIN_LANE = 0xFFFFFFFF, 0xFFFFFFFE


class PointsError(Exception):
    """Objects (their indices in the batch) that have no visible surface to put points on."""

    def __init__(self, objects: list[int]):
        super().__init__(f"no visible surface on objects {objects[:5]}")
        self.objects = objects


@dataclass(frozen=True, slots=True, eq=False)
class PointSet:
    """n points for each of B objects; metres, in the frames of the objects.

    The binding is (``site`` number, ``row`` of that site's table, ``patch`` number, fractions ``u``, ``v``).
    """

    site: np.ndarray  # (B, n) int32
    row: np.ndarray  # (B, n) int32
    patch: np.ndarray  # (B, n) int16
    u: np.ndarray  # (B, n)
    v: np.ndarray  # (B, n)
    position: np.ndarray  # (B, n, 3)
    normal: np.ndarray  # (B, n, 3)


def sample(sites: list[SiteTable], n_objects: int, n_points: int, key: random.Key, address: np.ndarray) -> PointSet:
    """Points of ``n_objects`` objects whose rows ``sites`` hold; ``address`` (n_objects,) uint64 names each to ``key``.

    Raises PointsError for objects without visible surface.
    """
    shape = (n_objects, n_points)
    out = PointSet(
        np.zeros(shape, np.int32), np.zeros(shape, np.int32), np.zeros(shape, np.int16), np.zeros(shape),
        np.zeros(shape), np.zeros((*shape, 3)), np.zeros((*shape, 3)),
    )  # fmt: skip
    if n_points:
        step = _objects_at_once(n_points)
        for first in range(0, n_objects, step):
            stop = min(first + step, n_objects)
            _Sampler(block(sites, first, stop), key, address[first:stop], first).fill(out, n_points)
    return out


def _objects_at_once(n: int) -> int:
    return min(max(1, _CANDIDATES // _first_round(n)), 256)


def _first_round(n: int) -> int:
    """Candidates of the first round per object."""
    return int(np.ceil(_SPARE * n)) + 32


class _Sampler:
    """The candidates of one block of objects."""

    def __init__(self, rows: Block, key: random.Key, address: np.ndarray, first: int):
        self.rows, self.key, self.first = rows, key, first
        self.address = np.asarray(address, dtype=np.uint64)
        self.poses = (rows.rotation, rows.translation, rows.mirror)
        self.off = scales(rows)
        self._make_cells()
        self.near = occluders(rows, self.cells, self.off)

    def _make_cells(self) -> None:
        rows = self.rows
        self.placements: list[tuple[Shelf, Placement]] = []
        self.evaluators: list[Evaluator] = []
        row, patch, area, combo = (
            [np.empty(0, np.int64)],
            [np.empty(0, np.int64)],
            [np.empty(0)],
            [np.empty(0, np.int64)],
        )
        for shelf in rows.shelves:
            for number in range(len(surfaces(shelf.primitive))):
                made = Placement(shelf.primitive, number, shelf.params)
                there = np.flatnonzero(made.area > 0.0)
                row.append(shelf.start + there)
                patch.append(np.full(len(there), number))
                area.append(made.area[there])
                combo.append(np.full(len(there), len(self.placements)))
                self.placements.append((shelf, made))
                self.evaluators.append(Evaluator(shelf.primitive, number, shelf.params))
        every = [np.concatenate(c) for c in (row, patch, area, combo)]
        order = np.lexsort((every[1], rows.rank[every[0]]))
        cell_row, cell_patch, self.cell_area, self.cell_combo = (c[order] for c in every)
        self.cells = Cells(cell_row, cell_patch, rows.owner[cell_row])
        counts = np.bincount(self.cells.owner, minlength=rows.objects)
        self.cell_start = np.cumsum(counts) - counts
        self.cell_slot = np.arange(len(cell_row)) - self.cell_start[self.cells.owner]
        padded = np.zeros((rows.objects, max(1, int(counts.max(initial=1)))))
        padded[self.cells.owner, self.cell_slot] = self.cell_area
        running = np.cumsum(padded, axis=1)
        total = running[:, -1]
        share = running / np.where(total > 0.0, total, 1.0)[:, None]
        self.share = share[self.cells.owner, self.cell_slot]
        self.last = self.cell_slot == counts[self.cells.owner] - 1
        if (total <= 0.0).any():
            raise PointsError((self.first + np.flatnonzero(total <= 0.0)).tolist())
        self.by_combo = np.argsort(self.cell_combo, kind="stable")

    def fill(self, out: PointSet, n: int) -> None:
        """Rounds of candidates until every object has its points."""
        filled = np.zeros(self.rows.objects, dtype=np.int64)
        wanted = np.full(self.rows.objects, _first_round(n), dtype=np.int64)
        tried, seen = np.zeros_like(wanted), np.zeros_like(wanted)
        for attempt in range(_ROUNDS):
            survivors = self._round(out, n, filled, wanted, attempt)
            tried += wanted
            seen += survivors
            filled = np.minimum(filled + survivors, n)
            missing = n - filled
            if not missing.any():
                return
            share = np.maximum(seen / tried, _LEAST)
            wanted = np.where(missing > 0, np.ceil(_SPARE * missing / share).astype(np.int64) + 32, 0)
        raise PointsError((self.first + np.flatnonzero(filled < n)).tolist())

    def _round(self, out: PointSet, n: int, filled: np.ndarray, wanted: np.ndarray, attempt: int) -> np.ndarray:
        """One round of ``wanted`` (objects,) candidates; the survivors counted, and written as far as there is room."""
        cells, rows = self.cells, self.rows
        offset, thin = (random.uniform(self.key, self.address, lane, attempt) for lane in (_OFFSET_LANE, _THIN_LANE))
        most = wanted[cells.owner]
        upto = np.clip(np.ceil(most * self.share - offset[cells.owner]), 0, most).astype(np.int64)
        upto[self.last] = most[self.last]
        before = np.concatenate([[0], upto[:-1]])
        before[self.cell_slot == 0] = 0
        counts = np.maximum(upto - before, 0)
        order = self.by_combo
        cell = np.repeat(order, counts[order])
        starts = np.cumsum(counts[order]) - counts[order]
        lane = before[cell] + np.arange(len(cell)) - np.repeat(starts, counts[order])
        owner, row = cells.owner[cell], cells.row[cell]
        u, v = random.pair(self.key, self.address[owner], lane, attempt)
        place, normal = np.empty((3, len(cell))), np.empty((3, len(cell)))
        combo = self.cell_combo[cell]
        ends = np.searchsorted(combo, np.arange(len(self.placements) + 1))
        for number, (shelf, made) in enumerate(self.placements):
            part = slice(int(ends[number]), int(ends[number + 1]))
            if part.start == part.stop:
                continue
            local = row[part] - shelf.start
            u[part], v[part] = made.place(local, u[part], v[part])
            at, direction = self.evaluators[number].at(local, u[part], v[part])
            for axis in range(3):
                place[axis, part], normal[axis, part] = at[axis], direction[axis]
        position = to_object(self.poses, row, place, True)
        outward = to_object(self.poses, row, normal, False)
        seen = ~hidden(rows, self.near, cell, row, position, outward, self.off[owner])

        first = np.cumsum(wanted) - wanted
        slot = first[owner] + lane
        visible = np.zeros(int(wanted.sum()), dtype=bool)
        visible[slot] = seen
        running = np.concatenate([[0], np.cumsum(visible)])
        survivors = running[first + wanted] - running[first]
        room = np.minimum(n - filled, survivors)
        kept = np.flatnonzero(seen)
        who = owner[kept]
        rank = running[slot[kept]] - running[first[who]]
        total, take = np.maximum(survivors, 1)[who], room[who]
        start = np.minimum((thin * survivors).astype(np.int64), np.maximum(survivors - 1, 0))[who]
        index, following = (rank * take + start) // total, ((rank + 1) * take + start) // total
        chosen = following > index
        kept, who, index = kept[chosen], who[chosen], index[chosen] + filled[who[chosen]]
        target = (self.first + who) * n + index
        from_row, from_cell = row[kept], cell[kept]
        out.site.reshape(-1)[target] = rows.site[from_row]
        out.row.reshape(-1)[target] = rows.row[from_row]
        out.patch.reshape(-1)[target] = cells.patch[from_cell]
        out.u.reshape(-1)[target], out.v.reshape(-1)[target] = u[kept], v[kept]
        for axis in range(3):
            out.position.reshape(-1, 3)[target, axis] = position[axis][kept]
            out.normal.reshape(-1, 3)[target, axis] = outward[axis][kept]
        return survivors


def evaluate(sites: list[SiteTable], binding: PointSet) -> tuple[np.ndarray, np.ndarray]:
    """Positions and normals (B, n, 3) of bound points on the present rows of ``sites``.

    On the rows they were sampled from, the very bits of the sampled positions and normals.
    """
    position, normal = np.empty(binding.position.shape), np.empty(binding.normal.shape)
    count = binding.u.shape[1]
    step = _objects_at_once(count)
    for first in range(0, len(binding.u), step):
        stop = min(first + step, len(binding.u))
        part = slice(first, stop)
        rows = block(sites, first, stop)
        poses = (rows.rotation, rows.translation, rows.mirror)
        row = _rows(sites, rows, binding.site[part].ravel(), binding.row[part].ravel())
        patch = binding.patch[part].ravel()
        u, v = binding.u[part].ravel(), binding.v[part].ravel()
        place, direction = np.empty((3, len(row))), np.empty((3, len(row)))
        for shelf in rows.shelves:
            for number in range(len(surfaces(shelf.primitive))):
                at = np.flatnonzero((row >= shelf.start) & (row < shelf.stop) & (patch == number))
                if len(at):
                    made = Evaluator(shelf.primitive, number, shelf.params).at(row[at] - shelf.start, u[at], v[at])
                    for axis in range(3):
                        place[axis, at], direction[axis, at] = made[0][axis], made[1][axis]
        position[part] = np.stack(to_object(poses, row, place, True), axis=-1).reshape(-1, count, 3)
        normal[part] = np.stack(to_object(poses, row, direction, False), axis=-1).reshape(-1, count, 3)
    return position, normal


def _rows(sites: list[SiteTable], rows: Block, number: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Rows of a block for pairs (site number, row of that site's table); ValueError when there is no such row."""
    longest = max((len(s) for s in sites), default=0) + 1
    have, asked = rows.site * longest + rows.row, number.astype(np.int64) * longest + row
    order = np.argsort(have)
    found = order[np.minimum(np.searchsorted(have[order], asked), len(order) - 1)]
    if (have[found] != asked).any():
        raise ValueError("points are bound to rows that their objects do not have")
    return found
