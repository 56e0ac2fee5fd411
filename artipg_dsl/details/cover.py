"""What the primitives of an object cover of one another: details move nothing out from beneath what lies over it.

A primitive that is flat where its donor was thick has others a hair's breadth before it: the pane of a screen before the plate that bears
it. So no place may be moved out of another primitive that it lies in, nor through one that lies before it, nor up to its surface: the
steps of a mesh that wears nothing are longer, and the finer one would show between them.
"""

from __future__ import annotations

import numpy as np

from ..geometry.patches import inside_split
from ..geometry.runs import runs
from ..geometry.vectors import dot
from .elements import Elements, Solids

SUNK = 1.5e-3  # diagonals: so deep beneath the surface of what covers it a place stays
_STEPS = 8  # of a way, at which it is asked
_DEEP = 2e-4  # diagonals: what lies no deeper in another primitive touches it
_PAIRS = 1 << 16  # places and primitives that are asked together


def find_covered(
    place: np.ndarray,
    normal: np.ndarray,
    way: np.ndarray,
    element: np.ndarray,
    elements: Elements,
    solids: Solids,
    scale: np.ndarray,
) -> np.ndarray:
    """The numbers (k,) of the places (m, 3) of elements, with their outward ``normal`` (m, 3), that their ways (m, 3) would take out of
    another primitive of their object. ``scale`` (m,): the diagonals of the objects, metres."""
    moved = np.flatnonzero(dot(way, way) > (_DEEP * scale) ** 2)
    moved = moved[np.argsort(element[moved], kind="stable")]
    if not len(moved):
        return moved
    low, high = _boxes(elements, solids)
    ends = place[moved], place[moved] + way[moved]
    least, most = np.minimum(*ends), np.maximum(*ends)
    own, first, count = np.unique(element[moved], return_index=True, return_counts=True)
    reach = [f.reduceat(corner, first) for f, corner in ((np.minimum, least), (np.maximum, most))]
    begin, end = (np.searchsorted(elements.owner, elements.owner[own], side=side) for side in ("left", "right"))
    which, other = np.repeat(np.arange(len(own)), end - begin), runs(begin, end - begin)
    meet = (other != own[which]) & _meets(reach[0][which], reach[1][which], low[other], high[other])
    which, other = which[meet], other[meet]
    many = count[which]
    kind, out = solids.kind(elements.site), np.zeros(len(moved), dtype=bool)
    for part in np.split(np.arange(len(which)), np.flatnonzero(np.diff(np.cumsum(many) // _PAIRS)) + 1):
        at, over = runs(first[which[part]], many[part]), np.repeat(other[part], many[part])
        near = _meets(least[at], most[at], low[over], high[over])
        at, over = at[near], over[near]
        for number in np.unique(kind[over]).tolist():
            some = np.flatnonzero(kind[over] == number)
            here, mine = moved[at[some]], over[some]
            start = elements.local(mine, place[here] - elements.translation[mine])
            along, outward = elements.local(mine, way[here]), elements.local(mine, normal[here])
            out[at[some[_covers(solids, elements, number, mine, start, along, outward, scale[here])]]] = True
    return np.sort(moved[out])


def _covers(
    solids: Solids,
    elements: Elements,
    number: int,
    element: np.ndarray,
    start: np.ndarray,
    way: np.ndarray,
    outward: np.ndarray,
    scale: np.ndarray,
) -> np.ndarray:
    """(k,) whether elements of one primitive cover places at ``start`` (k, 3) that go these ways (k, 3), all in the frames of these."""
    split = inside_split(solids.primitives[number])
    used, row = np.unique(element, return_inverse=True)
    rows = list(split.rows(dict(solids.params(elements, number, used))).take(row, axis=1))

    def depth(point: np.ndarray) -> np.ndarray:
        """Negative within."""
        columns = (np.ascontiguousarray(point[:, k]) for k in range(3))
        return np.broadcast_to(split.points(rows, *columns)[0], len(element))

    before = [depth(start + step / _STEPS * way) for step in range(_STEPS)]
    end, above = depth(start + way), depth(start + way + SUNK * scale[:, None] * outward)
    deep, rises = -_DEEP * scale, dot(way, outward) > 0.0
    near = (before[0] < deep) & (end < 0.0) & (above > 0.0)
    emerges = (np.minimum.reduce(before) < deep) & (end >= 0.0) & rises  # what sinks may leave it at its back
    return np.asarray(near | emerges)


def _boxes(elements: Elements, solids: Solids) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners (N, 3) of elements in the frames of their objects."""
    low, high = solids.boxes(elements)
    middle = elements.placed(np.arange(len(elements)), (low + high) / 2)
    half = (np.abs(elements.rotation) * ((high - low) / 2)[:, None]).sum(axis=2)
    return middle - half, middle + half


def _meets(low: np.ndarray, high: np.ndarray, least: np.ndarray, most: np.ndarray) -> np.ndarray:
    return np.asarray(((low <= most) & (high >= least)).all(axis=1))
