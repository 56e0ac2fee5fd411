"""How low primitives reach, by the formulas of their patches.

Convex pieces have corners on a round surface and faces within it: the pieces of a tyre end above the point on which it stands.
"""

from __future__ import annotations

import math

import numpy as np

from ..graph.primitive import Primitive
from .mesh import take
from .patches import find_existing, position_split
from .split import Params, rows_of
from .topology import turns
from .vectors import dot

_STEP = math.radians(15.0)  # by which lines turn between places that are looked at first
_LEAST = 4  # steps along a line that turns at all: it may do so in one place alone
_HALVINGS = 6  # of the steps about the lowest: a ball is then known to a millionth of its radius
_NEAR = np.stack(np.meshgrid([-1.0, -0.5, 0.0, 0.5, 1.0], [-1.0, -0.5, 0.0, 0.5, 1.0], indexing="ij")).reshape(2, -1)
_POINTS = 1_000_000  # at a time


def find_lowest(primitive: Primitive, params: Params, up: np.ndarray) -> np.ndarray:
    """The least coordinate (k,) of each of k instances along unit vectors ``up`` (k, 3); metres, own frame, unmirrored.

    The patches are looked at step by step, and about the lowest place of each step halved until that hardly changes.
    """
    there, found = find_existing(primitive, params), np.full(rows_of(params), np.inf)
    for patch in range(there.shape[1]):
        own = np.flatnonzero(there[:, patch])
        steps = [max(math.ceil(turn / _STEP), _LEAST) if turn > 1e-6 else 1 for turn in turns(primitive, patch)]
        at_once = max(1, _POINTS // (steps[0] * steps[1]))
        for rows in np.split(own, range(at_once, len(own), at_once)):
            found[rows] = np.minimum(found[rows], _lowest(primitive, patch, take(params, rows), up[rows], steps))
    return found


def _lowest(primitive: Primitive, patch: int, params: Params, up: np.ndarray, steps: list[int]) -> np.ndarray:
    split = position_split(primitive, patch)
    columns = [column[:, None] for column in split.rows(params)]
    rows = np.arange(len(up))

    def height(u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """(k, places) of places (k, places)."""
        place = np.empty((*u.shape, 3))
        for axis, value in enumerate(split.points(columns, u, v)):
            place[..., axis] = value
        return dot(place, up[:, None])

    # the middles of steps: on a surface that closes, the nearest of them to the lowest lies on its side of the seam
    u, v = (
        np.broadcast_to(at.ravel(), (len(up), at.size)).copy()
        for at in np.meshgrid(*((np.arange(count) + 0.5) / count for count in steps), indexing="ij")
    )
    for halving in range(1 + _HALVINGS):
        heights = height(u, v)
        best = np.argmin(heights, axis=1)
        wide = 0.5**halving
        u, v = (
            np.clip(at[rows, best][:, None] + wide / count * near, 0.0, 1.0)
            for at, near, count in zip((u, v), _NEAR, steps, strict=True)
        )
    found: np.ndarray = heights[rows, best]
    return found
