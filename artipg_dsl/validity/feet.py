"""What objects stand on: the corners of convex pieces that touch the floor at rest.

The floor is as low as the lowest point of any primitive. Pieces may end above the lowest point of theirs, those of a round
one by as much as a hundredth of its radius, and by no fault of what an author wrote: what misses the floor by that is moved
down by that much.
"""

from __future__ import annotations

import numpy as np

from ..geometry.box import bounds
from ..geometry.lowest import find_lowest
from ..geometry.mesh import take
from ..geometry.sites import SiteTable
from ..geometry.vectors import dot
from ..records import dataclass
from ..runtime.motion import apply, multiply
from .bodies import Pieces
from .tree import Tree

FLOOR = 1e-3  # metres: what is higher does not stand on it


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """The height of the floor (B,), and corners that touch it: the piece (n,) and the place (n, 3) of each, metres."""

    floor: np.ndarray
    piece: np.ndarray
    point: np.ndarray


def find_feet(tree: Tree, body: Pieces) -> Feet:
    """The feet of all objects at rest, piece by piece; no corners of an object without pieces, whose floor is infinite."""
    drop = _drops(tree, body)[body.solid]
    low, floor = body.low[:, 2] - drop, np.full(len(tree.batch), np.inf)
    np.minimum.at(floor, body.owner, low)
    near = np.flatnonzero(low <= floor[body.owner] + FLOOR)
    pieces, points = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 3))]
    for at, corners in body.classes(near):
        piece = near[at]
        corners[..., 2] -= drop[piece][:, None]
        touching = corners[..., 2] <= (floor[body.owner[piece]] + FLOOR)[:, None]
        pieces.append(np.broadcast_to(piece[:, None], touching.shape)[touching])
        points.append(corners[touching])
    piece = np.concatenate(pieces)
    order = np.argsort(piece, kind="stable")
    return Feet(floor, piece[order], np.concatenate(points)[order])


def _drops(tree: Tree, body: Pieces) -> np.ndarray:
    """How far (S,) the pieces of each row of the tables of sites, one table after the other, end above their primitive; 0 where they
    touch the floor as they are, as most feet do, and for what is nowhere near it."""
    tables = tree.batch.sites()
    count = sum(len(table) for table in tables)
    low, drop = np.full(count, np.inf), np.zeros(count)
    np.minimum.at(low, body.solid, body.low[:, 2])
    floor = np.full(len(tree.batch), np.inf)
    np.minimum.at(floor, body.owner, body.low[:, 2])
    begin = 0
    for table in tables:
        own = slice(begin, begin + len(table))
        begin += len(table)
        up, shift = _upright(tree, table)
        least = _box_lows(table, up) + shift
        reach = floor[table.owner] + FLOOR
        rows = np.flatnonzero((least <= reach) & (low[own] > reach) & np.isfinite(low[own]))
        if len(rows):
            true = find_lowest(table.primitive, take(table.params, rows), up[rows]) + shift[rows]
            drop[own][rows] = low[own][rows] - true
    return drop


def _upright(tree: Tree, table: SiteTable) -> tuple[np.ndarray, np.ndarray]:
    """The vertical (k, 3) in the frames of the rows, unmirrored, and the heights (k,) of their origins, at rest."""
    link = tree.first[table.owner] + table.link
    up = multiply(tree.turn[link], table.rotation)[:, 2]
    up[:, 1] *= table.mirror
    return up, (apply(tree.turn[link], table.translation) + tree.shift[link])[:, 2]


def _box_lows(table: SiteTable, up: np.ndarray) -> np.ndarray:
    """The least height (k,) of the stated boxes over the origins of their frames."""
    low, high = bounds(table.primitive, table.params)
    return dot(up, (low + high) / 2) - dot(np.abs(up), (high - low) / 2)
