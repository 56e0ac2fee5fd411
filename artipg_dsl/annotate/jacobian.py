"""How links move with each joint that drives them, through all joints above them: the columns of the spatial Jacobian.

A joint *drives* if its value is free: it neither mimics another nor is determined by a closed loop. What follows it moves
with it, mimics at their multiple, joints of a loop as the loop has them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..records import dataclass
from ..runtime.loops import leaders_of
from ..runtime.motion import freedoms_of, joints_by_depth
from ..runtime.newton import solve_small
from .frames import rotate

if TYPE_CHECKING:
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True)
class Jacobian:
    """Velocities of links: ``driver`` (L, D) numbers of the joints (of their objects) that move a link, -1 for no more.

    A point p on the link moves with ``turn x p + shift``, (L, D, 3), per radian or metre of that joint, in the object's
    frame.
    """

    driver: np.ndarray
    turn: np.ndarray
    shift: np.ndarray

    def at(self, link: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Velocities (..., D, 3) of points (..., 3) on the rows ``link`` (...); 0 for no driver."""
        out = np.empty((*link.shape, self.driver.shape[1], 3))
        x, y, z = (points[..., i] for i in range(3))
        for d in range(self.driver.shape[1]):
            a, b, c = (np.ascontiguousarray(self.turn[:, d, i])[link] for i in range(3))
            for axis, value in enumerate((b * z - c * y, c * x - a * z, a * y - b * x)):
                out[..., d, axis] = value + np.ascontiguousarray(self.shift[:, d, axis])[link]
        return out


def find_jacobian(batch: Batch, states: np.ndarray | None = None) -> Jacobian:
    """The motion of each link by every joint that drives it, with the joints at ``states`` (J,), at rest by default."""
    links, joints = batch.links(), batch.joints()
    values = batch.settle(batch.rest() if states is None else np.asarray(states, dtype=np.float64))
    rotation, translation = batch.pose(values)
    first = np.searchsorted(links.owner, joints.owner)
    parent, child = first + joints.parent, first + joints.child
    axis, slide = (rotate(rotation[parent], way) for way in freedoms_of(joints))
    origin = rotate(rotation[parent], joints.origin) + translation[parent]
    drivers, rate, depends = find_rates(batch, values)
    slots = drivers.shape[1]
    moved = np.zeros((len(links.owner), slots), dtype=bool)
    turn, shift = np.zeros((len(links.owner), slots, 3)), np.zeros((len(links.owner), slots, 3))
    x, y, z = origin.T
    a, b, c = axis.T
    lever = np.stack([c * y - b * z, a * z - c * x, b * x - a * y], axis=-1) + slide  # slide - axis x origin
    for at in joints_by_depth(len(links.owner), parent, child):
        up, down = parent[at], child[at]
        moved[down] = moved[up] | depends[at]
        turn[down] = turn[up] + rate[at, :, None] * axis[at, None]
        shift[down] = shift[up] + rate[at, :, None] * lever[at, None]
    most = int(moved.sum(axis=1).max(initial=0))
    order = np.argsort(~moved, axis=1, kind="stable")[
        :, :most
    ]  # the drivers of each link, in the order of their numbers
    there = np.take_along_axis(moved, order, axis=1)
    row = np.take_along_axis(drivers[links.owner], order, axis=1) if slots else np.zeros_like(order)
    number = np.append(np.asarray(joints.number, dtype=np.int64), -1)
    along = order[..., None]
    return Jacobian(
        np.where(there, number[row], -1),
        np.where(there[..., None], np.take_along_axis(turn, along, axis=1), 0.0),
        np.where(there[..., None], np.take_along_axis(shift, along, axis=1), 0.0),
    )


def find_rates(batch: Batch, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The joints that drive each object, rows of the table (B, S), -1 for no more; how fast each joint moves per unit of
    each of them, (J, S), with the joints at ``values``; and by which of them it moves at all, (J, S) bool."""
    joints = batch.joints()
    count = len(joints.owner)
    leader, multiple = leaders_of(joints)
    for curve in joints.curves:
        multiple[curve.row] = curve.rate(values[curve.leader])
    loops = batch.loops
    turning, sliding = freedoms_of(joints)
    free = (leader == np.arange(count)) & ((turning != 0.0) | (sliding != 0.0)).any(axis=1)
    if loops is not None:
        free[loops.variable[loops.follows]] = False
    rows = np.flatnonzero(free)
    slot = np.full(count, -1, dtype=np.int64)
    slot[rows] = np.arange(len(rows)) - np.searchsorted(joints.owner[rows], joints.owner[rows])
    drivers = np.full((len(batch), int(slot.max(initial=-1)) + 1), -1, dtype=np.int64)
    drivers[joints.owner[rows], slot[rows]] = rows
    own = np.zeros((count, drivers.shape[1]))
    own[rows, slot[rows]] = 1.0
    depends = own != 0.0
    if loops is not None:
        _, slope = loops.slopes(values)
        lead = (loops.variable >= 0) & ~loops.follows
        answer = _answers(slope, loops.follows)
        for i in range(slope.shape[2]):
            for j in range(slope.shape[2]):
                owner = np.flatnonzero(loops.follows[:, i] & lead[:, j])
                follower, driver = loops.variable[owner, i], loops.variable[owner, j]
                own[follower, slot[driver]] = answer[owner, i, j]
                depends[follower, slot[driver]] = True
    return drivers, own[leader] * multiple[:, None], depends[leader]


def _answers(slope: np.ndarray, follows: np.ndarray) -> np.ndarray:
    """(B, V, V): how fast the joint that follows (first axis) moves with each other one, such that the gaps, whose
    derivatives are ``slope`` (B, M, V), stay what they are: least squares, as loops may state more than they need."""
    held = np.where(follows[:, None], slope, 0.0)
    size = slope.shape[2]
    matrix, right = np.zeros((size, size, len(slope))), np.zeros((size, size, len(slope)))
    for i in range(size):
        for j in range(size):
            for m in range(slope.shape[1]):
                matrix[i, j] += held[:, m, i] * held[:, m, j]
                right[j, i] -= held[:, m, i] * slope[:, m, j]
        matrix[i, i] += np.where(follows[:, i], 0.0, 1.0)
    return np.stack([solve_small(matrix, one).T for one in right], axis=-1)
