"""Which points on the cells of a block are hidden in, or pressed against, another primitive of the same object.

Where points fall on flat cells in large numbers, boxes narrow the question further than for single places (`cover`):
cells against rows, then the part of a flat cell, as a rectangle of fractions, that the box of the other row can reach.
Points on flat cells are asked in the frame of the row that may hide them, where the cell is a quad too: no point is
turned from frame to frame. Flat cells so small that hardly a point falls on them are not prepared for that: their points
are asked as those on bent cells are.
"""

from __future__ import annotations

import numpy as np

from ..native import backend, points
from ..records import dataclass
from .cells import Cells
from .cover import ABOUT, PAIRS, REACH, Cover, Places
from .enclosure import bound_inside
from .flat import BENT, PLANAR, convex
from .runs import distinct, runs

_LOOSE = 1e-9  # rectangles are wider, cells smaller by this fraction
_SIGNS = np.uint32(0x80008000)
_CHUNK = 4096  # pairs of cells and rows at a time: their arrays stay in the cache


def pack_fractions(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(m,) uint32: two fractions rounded down to 15 bits each, a nought above either.

    With ``x - low`` and ``high - x`` of packed numbers a bit of ``_SIGNS`` tells that one of the two is out of bounds.
    """
    return ((u * 32767.0).astype(np.uint32) << np.uint32(16)) | (v * 32767.0).astype(np.uint32)


@dataclass(frozen=True, slots=True, eq=False)
class _Pairs:
    """Flat cells and rows that may hide points on them, by group of pools and then by shelf of the row.

    ``quad`` (4, 3, P) holds the points asked on the cell, in the row's own frame: origin, a, b, c; ``step`` (3, P) is
    the way from them through the surface to as far behind it. ``within`` (4, P) bounds the fractions u and v that the
    row's box can reach. ``edges[g * shelves + s]`` is where the pairs of group g with shelf s begin.
    """

    cell: np.ndarray
    other: np.ndarray
    quad: np.ndarray
    step: np.ndarray
    within: np.ndarray
    least: np.ndarray  # (P,) uint32: the low ends of ``within``, packed
    most: np.ndarray  # (P,) the high ends
    planar: np.ndarray  # (P,) bool: c is not nought
    lower: np.ndarray  # (P,) bool: coincident surfaces belong to the row, not to the cell
    edges: np.ndarray


class Occlusion:
    """What may hide what in a block, and which flat cells are hidden altogether: ``buried`` (C,) bool.

    ``prepared`` (C,) bool: the flat cells for which ``flat_hidden`` may be asked, those of at least a share of
    ``least`` (of each pool, or of all) of the surface of their pool; for others ``loose_hidden`` has to be.
    ``meeting``: the rows on which points are asked, and those that may hide them, as of ``meeting_rows``.
    """

    def __init__(
        self,
        cells: Cells,
        off: np.ndarray,
        group: np.ndarray,
        least: float | np.ndarray,
        meeting: tuple[np.ndarray, np.ndarray],
    ):
        self.cells, self.rows, self.off = cells, cells.rows, off
        self.cover = Cover(cells.rows, off, meeting)
        total = np.bincount(cells.pool, cells.area, minlength=len(cells.start) - 1)
        self.prepared = (cells.shape != BENT) & (cells.area > (least * total)[cells.pool])
        self.pairs = self._flat_pairs(*self._near(*meeting), group)
        self.buried = self._buried()

    def _near(self, near: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Pairs of a flat cell and a row whose boxes meet, from pairs of rows."""
        rows, cells = self.rows, self.cells
        chosen = np.flatnonzero(self.prepared)
        patches = np.bincount(cells.row[chosen], minlength=len(rows.owner))
        first = np.searchsorted(chosen, cells.first)  # of the chosen ones of each row, which stand together
        low, high = cells.bounds(chosen)
        row_low, row_high = self.cover.ends
        found = [(np.empty(0, np.int64), np.empty(0, np.int64))]
        for start in range(0, len(near), _CHUNK // 2):
            part = slice(start, start + _CHUNK // 2)
            count = patches[near[part]]
            cell, beside = runs(first[near[part]], count), np.repeat(other[part], count)
            kept = np.ones(len(cell), dtype=bool)
            for axis in range(3):
                kept &= low[axis][cell] <= row_high[axis][beside]
                kept &= high[axis][cell] >= row_low[axis][beside]
            found.append((chosen[cell.compress(kept)], beside.compress(kept)))
        return np.concatenate([c for c, _ in found]), np.concatenate([o for _, o in found])

    def _flat_pairs(self, cell: np.ndarray, other: np.ndarray, group: np.ndarray) -> _Pairs:
        rows, cells = self.rows, self.cells
        place = group[cells.pool[cell]] * len(rows.shelves) + self.cover.shelf[other]
        order = np.argsort(place.astype(np.int16 if place.max(initial=0) < 32000 else np.int64), kind="stable")
        total = (int(group.max(initial=0)) + 1) * len(rows.shelves)
        edges = np.searchsorted(place[order], np.arange(total + 1))
        cell, other = cell[order], other[order]
        count = len(cell)
        pairs = _Pairs(
            cell,
            other,
            np.empty((4, 3, count)),
            np.empty((3, count)),
            np.empty((4, count)),
            np.empty(count, np.uint32),
            np.empty(count, np.uint32),
            cells.shape[cell] == PLANAR,
            rows.rank[other] < rows.rank[cells.row[cell]],
            edges,
        )
        for start in range(0, count, _CHUNK):
            self._carry_over(pairs, slice(start, start + _CHUNK))
        return pairs

    def _carry_over(self, pairs: _Pairs, part: slice) -> None:
        """Some of the pairs: their quads in the frames of the rows, and what of them the boxes can reach."""
        rows, cells = self.rows, self.cells
        cell, other = pairs.cell[part], pairs.other[part]
        off = self.off[cells.owner[cell]]
        poses = [[rows.rotation[3 * j + axis][other] for j in range(3)] for axis in range(3)]
        mirror = rows.mirror[other]
        normal = [x[cell] for x in cells.normal]
        origin = [cells.origin[k][cell] + off * normal[k] - rows.translation[k][other] for k in range(3)]
        vectors = (origin, [x[cell] for x in cells.a], [x[cell] for x in cells.b])
        quad, step, within = pairs.quad[:, :, part], pairs.step[:, part], pairs.within[:, part]
        quad[3] = 0.0
        some = np.flatnonzero(pairs.planar[part])
        bend = [x[cell[some]] for x in cells.c]
        within[0] = within[2] = 0.0
        within[1] = within[3] = 1.0
        reach = REACH * off
        for axis in range(3):
            p, q, r = poses[axis]
            for k, vector in enumerate(vectors):
                quad[k, axis] = p * vector[0] + q * vector[1] + r * vector[2]
            quad[3, axis, some] = p[some] * bend[0] + q[some] * bend[1] + r[some] * bend[2]
            step[axis] = (p * normal[0] + q * normal[1] + r * normal[2]) * (-2.0 * off)
            if axis == 1:
                quad[:, axis] *= mirror
                step[axis] *= mirror
            self._narrow(
                quad[:, axis], self.cover.low[axis][other] - reach, self.cover.high[axis][other] + reach, within
            )
        np.minimum(within[0::2], 2.0, out=within[0::2])
        np.maximum(within[1::2], -1.0, out=within[1::2])
        low, high = np.clip(within[0::2], 0.0, 1.0), np.clip(within[1::2], 0.0, 1.0)
        pairs.least[part], pairs.most[part] = pack_fractions(low[0], low[1]), pack_fractions(high[0], high[1])

    @staticmethod
    def _narrow(quad: np.ndarray, low: np.ndarray, high: np.ndarray, within: np.ndarray) -> None:
        """Narrow ``within`` to the fractions at which quads (4, P) may lie in ``low .. high`` along one axis."""
        origin, a, b, c = quad
        low, high = low - origin - np.maximum(c, 0.0), high - origin - np.minimum(c, 0.0)
        rest = (np.minimum(a, 0.0), np.maximum(a, 0.0)), (np.minimum(b, 0.0), np.maximum(b, 0.0))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            for start, along, (down, up) in ((0, a, rest[1]), (2, b, rest[0])):
                one, two = (low - up) / along, (high - down) / along
                # fmin and fmax pass over nan: nought by nought bounds nothing
                np.fmax(within[start], np.fmin(one, two) - _LOOSE, out=within[start])
                np.fmin(within[start + 1], np.fmax(one, two) + _LOOSE, out=within[start + 1])

    def _buried(self) -> np.ndarray:
        """Flat cells that lie within one row: nothing of them can be seen.

        All corners lie in a convex row, or the inside function is below nought all over the box of the cell. Edges that
        are flush with one of the row's do not count: cells are taken smaller by a billionth.
        """
        pairs, out = self.pairs, np.zeros(len(self.cells.row), dtype=bool)
        solid = np.zeros(len(self.rows.owner), dtype=bool)
        for shelf in self.rows.shelves:
            solid[shelf.start : shelf.stop] = convex(shelf.primitive)
        low, high = np.maximum(pairs.within[0], pairs.within[2]), np.minimum(pairs.within[1], pairs.within[3])
        whole = np.flatnonzero((low <= 0.0) & (high >= 1.0))
        chosen = whole[solid[pairs.other[whole]]]
        corners = [(u, v) for u in (_LOOSE, 1.0 - _LOOSE) for v in (_LOOSE, 1.0 - _LOOSE)]
        for u, v in corners:
            chosen = chosen[self._at(chosen, u, v) < 0.0]
        out[pairs.cell[chosen]] = True
        whole = whole[~solid[pairs.other[whole]]]
        shelf_of = self.cover.shelf[pairs.other[whole]]
        for number in distinct(shelf_of).tolist():
            shelf, mine = self.rows.shelves[number], whole[shelf_of == number]
            origin, a, b, c = pairs.quad.take(mine, axis=2)
            ends = np.stack([origin + u * a + v * b + (u * v) * c for u, v in corners])
            row = pairs.other[mine] - shelf.start
            params = {name: value[row] for name, value in shelf.params.items()}
            found = bound_inside(shelf.primitive, params, list(ends.min(axis=0)), list(ends.max(axis=0)))
            out[pairs.cell[mine[found < 0.0]]] = True
        return out

    def visible(self) -> np.ndarray:
        """(C,) about which share of each cell can be seen: judged by the middle of what each row can reach of it."""
        within = self.pairs.within
        u, v = (within[0] + within[1]) / 2, (within[2] + within[3]) / 2
        share = np.maximum(within[1] - within[0], 0.0) * np.maximum(within[3] - within[2], 0.0)
        share = np.where(self._at(slice(None), u, v) < 0.0, share, 0.0)
        out = np.zeros(len(self.cells.row))
        np.maximum.at(out, self.pairs.cell, share)
        out[self.buried] = 1.0
        return 1.0 - np.minimum(out, 1.0)

    def _at(self, chosen: np.ndarray | slice, u: np.ndarray | float, v: np.ndarray | float) -> np.ndarray:
        """(m,) depths in their rows of one place asked on the cell of each chosen pair."""
        quad = self.pairs.quad
        origin, a, b, c = quad if isinstance(chosen, slice) else quad.take(chosen, axis=2)
        return self.cover.depths(self.pairs.other[chosen], origin + u * a + v * b + (u * v) * c)

    def flat_hidden(
        self, group: int, first: int, start: np.ndarray, count: np.ndarray, u: np.ndarray, v: np.ndarray
    ) -> np.ndarray:
        """(m,) bool: which points on the flat cells of one group of pools are hidden.

        Points are sorted by cell: cell ``first + i`` has ``count[i]`` of them from ``start[i]`` on.
        """
        pairs, shelves = self.pairs, len(self.rows.shelves)
        out, spots = np.zeros(len(u), dtype=bool), pack_fractions(u, v)
        begin, end = int(pairs.edges[group * shelves]), int(pairs.edges[(group + 1) * shelves])
        at = pairs.cell[begin:end] - first
        asked = begin + np.flatnonzero(count[at])
        ends = np.cumsum(count[pairs.cell[asked] - first])
        cuts = np.searchsorted(ends, np.arange(PAIRS, int(ends[-1]) if len(ends) else 0, PAIRS))
        for part in np.split(asked, cuts):
            if len(part):
                at = pairs.cell[part] - first
                self._ask(group, part, start[at], count[at], u, v, spots, out)
        return out

    def _ask(
        self,
        group: int,
        asked: np.ndarray,
        start: np.ndarray,
        count: np.ndarray,
        u: np.ndarray,
        v: np.ndarray,
        spots: np.ndarray,
        out: np.ndarray,
    ) -> None:
        """Enter into ``out`` the points that pairs ``asked`` (ascending) hide; each has a run of points."""
        pairs, shelves = self.pairs, len(self.rows.shelves)
        pair, point, local = self._within_reach(asked, start, count, u, v, spots)
        if not len(pair):
            return
        other = pairs.other[pair]
        edges = pairs.edges[group * shelves : (group + 1) * shelves + 1]
        depth = self._by_shelf(edges, pair, other, local)
        out[point.compress(depth < 0.0)] = True
        about = ABOUT * self.off[self.rows.owner[other]]
        close = np.flatnonzero((depth >= 0.0) & (depth <= about) & pairs.lower[pair])
        if len(close):
            pair, point, other = pair[close], point[close], other[close]
            behind = [local[k][close] + pairs.step[k][pair] for k in range(3)]
            out[point.compress(self._by_shelf(edges, pair, other, behind) < 0.0)] = True

    def _within_reach(
        self, asked: np.ndarray, start: np.ndarray, count: np.ndarray, u: np.ndarray, v: np.ndarray, spots: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, Places]:
        """Pairs and points (k,), those of runs that the row of the pair can reach, and where in its frame (3, k)."""
        pairs, machine = self.pairs, backend.machine()
        if machine is not None:
            ends = pairs.least, pairs.most
            return points.near_flat(machine, asked, start, count, (u, v, spots), pairs.quad, ends, pairs.planar)
        point = runs(start, count)
        spot = spots[point]
        beyond = (spot - np.repeat(pairs.least[asked], count)) | (np.repeat(pairs.most[asked], count) - spot)
        found = np.flatnonzero((beyond & _SIGNS) == 0)
        pair, point = np.repeat(asked, count)[found], point[found]
        across, along = u[point], v[point]
        origin, a, b, c = pairs.quad
        local = [origin[k][pair] + across * a[k][pair] + along * b[k][pair] for k in range(3)]
        planar = np.flatnonzero(pairs.planar[pair])
        if len(planar):
            both, where = across[planar] * along[planar], pair[planar]
            for k in range(3):
                local[k][planar] += both * c[k][where]
        return pair, point, local

    def _by_shelf(self, edges: np.ndarray, pair: np.ndarray, other: np.ndarray, local: Places) -> np.ndarray:
        """Depths of points in the rows of pairs, which are sorted by shelf."""
        depth = np.empty(len(pair))
        cuts = np.searchsorted(pair, edges)
        for shelf in range(len(edges) - 1):
            part = slice(int(cuts[shelf]), int(cuts[shelf + 1]))
            if part.start < part.stop:
                depth[part] = self.cover.depth(shelf, other[part], [x[part] for x in local])
        return depth

    def loose_hidden(self, cell: np.ndarray, position: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """(m,) bool: which points on any cells are hidden; positions and normals (3, m) in the frames of their objects."""
        return self.cover.hidden(self.cells.row[cell], position, normal)
