"""What the primitives of an object cover of one another: in details, too, what lies over another stays over it.

A primitive that is flat where its donor was thick has others a hair's breadth before it: the pane of a screen before the plate that bears
it. So no place may be moved out of another primitive that it lies in, nor through one that lies before it, nor up to its surface, which
has been moved itself. And none may sink into what it lies over: the cap of a bottle stays over the nozzle, however narrow the neck of the
original. Either keeps a distance: the steps of a mesh that wears nothing are longer, and the finer one would show between them.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..geometry.nearest import Nearest
from ..geometry.patches import inside_split
from ..geometry.runs import runs
from ..geometry.vectors import dot
from .elements import Elements, Solids
from .skin import tie_breakers

SUNK = 1.5e-3  # diagonals: so deep beneath the surface of what covers it a place stays, and so far over what it covers
_STEPS = 8  # of a way, at which it is asked
_DEEP = 2e-4  # diagonals: what lies no deeper in another primitive touches it
_BESIDE = 0.03  # diagonals: so near to a place its cover has one of its own
_APART = 10.0  # diagonals between elements
_PAIRS = 1 << 16  # places and primitives that are asked together


def hold(
    place: np.ndarray,
    normal: np.ndarray,
    way: np.ndarray,
    element: np.ndarray,
    elements: Elements,
    solids: Solids,
    scale: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Which of the places (m, 3) of elements, with their outward ``normal`` (m, 3), cannot go their ways (m, 3) for the other primitives of
    their object, and the ways (k, 3) that these go instead. ``scale`` (m,): the diagonals of the objects, metres."""
    meetings = _Meetings(place, normal, element, elements, solids, scale)
    gone = way * meetings.shares(way)[:, None]
    covered, over = meetings.covered(gone)
    gone[covered] = over - SUNK * scale[covered, None] * normal[covered]
    at = np.flatnonzero((gone != way).any(axis=1))
    return at, gone[at]


class _Meetings:
    """Places (m, 3) of elements and the other primitives of their objects that they may meet on their ways."""

    def __init__(
        self,
        place: np.ndarray,
        normal: np.ndarray,
        element: np.ndarray,
        elements: Elements,
        solids: Solids,
        scale: np.ndarray,
    ):
        self._place, self._normal, self._element, self._scale = place, normal, element, scale
        self._elements, self._solids = elements, solids
        self._kind = solids.kind(elements.site)
        self._low, self._high = _boxes(elements, solids)

    def shares(self, way: np.ndarray) -> np.ndarray:
        """(m,) what share of its way each has before it sinks into what it lies over."""
        found, deep = np.ones(len(way)), -_DEEP * self._scale
        for at, over in self._pairs(way, np.zeros(len(self._elements))):
            inward = dot(way[at], self._normal[at]) < 0.0
            if not inward.any():
                continue
            at, over = at[inward], over[inward]
            depth = self._depths(at, over, way[at])
            sinks = (depth[0] >= deep[at]) & (np.minimum.reduce(depth) < deep[at])
            np.minimum.at(found, at[sinks], _share(depth[:, sinks], SUNK * self._scale[at[sinks]]))
        return found

    def covered(self, way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The numbers (k,) of places that would come out of what covers them, or up to its surface, and the way (k, 3) of that there."""
        found, over_way = np.zeros(len(way), dtype=bool), np.zeros_like(way)
        most = np.zeros(len(self._elements))
        np.maximum.at(most, self._element, np.sqrt(dot(way, way)))
        shape, mark = self._place / self._scale[:, None], tie_breakers(self._element)
        sides = Nearest(np.concatenate([shape, mark], axis=1), self._element, _APART)
        asked, none = np.concatenate([shape, 0.0 * mark], axis=1), np.zeros((1, 3))
        for at, over in self._pairs(way, most):
            theirs = np.concatenate([way, none])[sides.find(asked[at], over, _BESIDE)[1]]
            seen, outward, scale = way[at] - theirs, self._normal[at], self._scale[at]
            depth, deep, rises = self._depths(at, over, seen), -_DEEP * scale, dot(seen, outward) > 0.0
            above = self._depth(at, over, seen + SUNK * scale[:, None] * outward)
            close = (depth[0] < deep) & (depth[-1] < 0.0) & (above > 0.0)
            # what sinks may leave it at its back
            out = (np.minimum.reduce(depth[:-1]) < deep) & (depth[-1] >= 0.0) & rises
            hidden = np.flatnonzero(close | out)
            sunk = dot(theirs[hidden], outward[hidden])
            held = dot(over_way[at[hidden]], outward[hidden])
            deepest = np.argsort(-sunk, kind="stable")  # of several it goes beneath the lowest
            some = hidden[deepest][(~found[at[hidden]] | (sunk < held))[deepest]]
            over_way[at[some]], found[at[some]] = theirs[some], True
        covered = np.flatnonzero(found)
        return covered, over_way[covered]

    def _pairs(self, way: np.ndarray, most: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Places that move, and primitives whose boxes they meet on their ways, these being moved by as much as ``most`` (N,) themselves."""
        elements = self._elements
        low, high = self._low - most[:, None], self._high + most[:, None]
        moved = np.flatnonzero(dot(way, way) > (_DEEP * self._scale) ** 2)
        moved = moved[np.argsort(self._element[moved], kind="stable")]
        if not len(moved):
            return
        ends = self._place[moved], self._place[moved] + way[moved]
        least, last = np.minimum(*ends), np.maximum(*ends)
        own, first, count = np.unique(self._element[moved], return_index=True, return_counts=True)
        reach = [f.reduceat(corner, first) for f, corner in ((np.minimum, least), (np.maximum, last))]
        begin, end = (np.searchsorted(elements.owner, elements.owner[own], side=side) for side in ("left", "right"))
        which, other = np.repeat(np.arange(len(own)), end - begin), runs(begin, end - begin)
        meet = (other != own[which]) & _meets(reach[0][which], reach[1][which], low[other], high[other])
        which, other = which[meet], other[meet]
        many = count[which]
        for part in np.split(np.arange(len(which)), np.flatnonzero(np.diff(np.cumsum(many) // _PAIRS)) + 1):
            at, over = runs(first[which[part]], many[part]), np.repeat(other[part], many[part])
            near = _meets(least[at], last[at], low[over], high[over])
            at, over = moved[at[near]], over[near]
            for number in np.unique(self._kind[over]).tolist():
                some = self._kind[over] == number
                yield at[some], over[some]

    def _depths(self, at: np.ndarray, over: np.ndarray, way: np.ndarray) -> np.ndarray:
        """(steps + 1, k) how far places are outside of primitives on their ways, negative within."""
        return np.stack([self._depth(at, over, step / _STEPS * way) for step in range(_STEPS + 1)])

    def _depth(self, at: np.ndarray, over: np.ndarray, way: np.ndarray) -> np.ndarray:
        elements, solids = self._elements, self._solids
        number = int(self._kind[over[0]])
        split = inside_split(solids.primitives[number])
        used, row = np.unique(over, return_inverse=True)
        rows = list(split.rows(dict(solids.params(elements, number, used))).take(row, axis=1))
        local = elements.local(over, self._place[at] + way - elements.translation[over])
        columns = (np.ascontiguousarray(local[:, k]) for k in range(3))
        return np.broadcast_to(split.points(rows, *columns)[0], len(over))


def _share(depth: np.ndarray, least: np.ndarray) -> np.ndarray:
    """(k,) the share of a way at which depths (steps + 1, k) along it first fall below the ``least`` (k,)."""
    first = np.argmax(depth < least, axis=0)
    every, before = np.arange(depth.shape[1]), np.maximum(first - 1, 0)
    high, low = depth[before, every], depth[first, every]
    inside = (high - least) / np.maximum(high - low, 1e-12)
    return np.where(first > 0, (before + inside) / _STEPS, 0.0)


def _boxes(elements: Elements, solids: Solids) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners (N, 3) of elements in the frames of their objects."""
    low, high = solids.boxes(elements)
    middle = elements.placed(np.arange(len(elements)), (low + high) / 2)
    half = (np.abs(elements.rotation) * ((high - low) / 2)[:, None]).sum(axis=2)
    return middle - half, middle + half


def _meets(low: np.ndarray, high: np.ndarray, least: np.ndarray, most: np.ndarray) -> np.ndarray:
    return np.asarray(((low <= most) & (high >= least)).all(axis=1))
