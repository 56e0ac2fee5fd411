"""Closed loops of joints: the values of some joints follow from the others, so that points stated by ``close`` stay together.

Of the joints on the loops of an object, those declared first drive and the others follow: as many, the last declared
first, as the loops can determine (a joint declared later yields, as parts do). They are solved for by Gauss-Newton steps
of all objects at once, led from rest to the values asked for, so that a loop does not jump to its other assembly.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .motion import Chains, apply, follow
from .newton import solved
from .tables import JointTable

if TYPE_CHECKING:
    from .batch import Batch

APART = 1e-6  # metres: farther than this, two points are not together
CLOSED = 1e-13  # and nearer than this, no step brings them closer
STAGES = 6  # on the way from rest
ROUNDS = 8  # steps for each
INDEPENDENT = 1e-6  # of a column that the columns before do not make up


@dataclass(frozen=True, slots=True, eq=False)
class Loops:
    """The closures of a batch: C pairs of points, sorted by object, on the rows ``link`` (2, C) of the table of links.

    ``joint`` (E,) moves the point ``side`` of closure ``at``, ``rate`` times as fast as the joint ``leads`` that it follows.
    ``slot`` numbers the leading joints of an object; ``follows`` (B, V) tells which of them the loops determine.
    """

    batch: Batch
    chains: Chains
    owner: np.ndarray
    link: np.ndarray
    point: np.ndarray  # (2, C, 3), at joint values 0
    at: np.ndarray
    side: np.ndarray
    joint: np.ndarray
    rate: np.ndarray
    slot: np.ndarray
    variable: np.ndarray  # (B, V): the leading joint of each slot, -1 for none
    follows: np.ndarray

    def apart(self, turn: np.ndarray, shift: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The links (rows of the table) of loops that do not close with the links posed by ``turn`` and ``shift``."""
        first, second = (
            apply(turn[link], point) + shift[link] for link, point in zip(self.link, self.point, strict=True)
        )
        wide = np.abs(first - second).max(axis=1) > APART
        return self.link[0, wide], self.link[1, wide]

    def driven(self, leader: np.ndarray) -> np.ndarray:
        """The joint that each joint follows, ``leader`` for what mimics, where loops determine it the first that drives them."""
        drives = np.where(self.follows | (self.variable < 0), len(leader), self.variable).min(
            axis=1, initial=len(leader)
        )
        instead = np.arange(len(leader))
        owner, slot = np.nonzero(self.follows & (drives < len(leader))[:, None])
        instead[self.variable[owner, slot]] = drives[owner]
        return instead[leader]

    def slopes(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gaps (B, M) and their derivatives by the leading joints (B, M, V), 0 where an object has fewer of either."""
        chains = self.chains
        turn, shift = chains.motion(values)
        places = np.stack(
            [apply(turn[link], point) + shift[link] for link, point in zip(self.link, self.point, strict=True)]
        )
        k = self.joint
        holder = chains.parent[k]
        axis, slide = (apply(turn[holder], way[k]) for way in (chains.axis, chains.slide))
        origin = apply(turn[holder], chains.joints.origin[k]) + shift[holder]
        speed = np.cross(axis, places[self.side, self.at] - origin) + slide
        speed = speed * (self.rate * np.where(self.side == 0, 1.0, -1.0))[:, None]
        rank = np.arange(len(self.owner)) - np.searchsorted(self.owner, self.owner)
        count, most = len(self.batch), int(rank.max(initial=0)) + 1
        gap, slope = np.zeros((count, most, 3)), np.zeros((count, most, 3, self.variable.shape[1]))
        gap[self.owner, rank] = places[0] - places[1]
        where: Any = (self.owner[self.at], rank[self.at], slice(None), self.slot)
        np.add.at(slope, where, speed)
        return gap.reshape(count, -1), slope.reshape(count, 3 * most, -1)

    def settle(self, states: np.ndarray) -> np.ndarray:
        """Joint values (J,) that mimics and loops obey, the driving joints as in ``states``."""
        joints = self.batch.joints()
        rest, wanted = follow(joints, self.batch.rest()), follow(joints, states)
        driven = np.zeros(len(rest), dtype=bool)
        driven[self.variable[self.follows]] = True
        values = rest.copy()
        for stage in range(1, STAGES + 1):
            share = stage / STAGES
            values = follow(joints, np.where(driven, values, rest + share * (wanted - rest)))
            for _ in range(ROUNDS):
                gap, slope = self.slopes(values)
                going = np.abs(gap).max(axis=1, initial=0.0) >= CLOSED  # each object stops by itself
                if not going.any():
                    break
                values = self._stepped(joints, values, gap, slope, going)
        return values

    def _stepped(
        self, joints: JointTable, values: np.ndarray, gap: np.ndarray, slope: np.ndarray, going: np.ndarray
    ) -> np.ndarray:
        """A step of the objects that are ``going`` (B,)."""
        held = np.where(self.follows[:, None], slope, 0.0)
        size = held.shape[2]
        matrix, right = np.zeros((size, size, len(held))), np.zeros((size, len(held)))
        for i in range(size):
            for m in range(held.shape[1]):
                right[i] += held[:, m, i] * gap[:, m]
                for j in range(size):
                    matrix[i, j] += held[:, m, i] * held[:, m, j]
            matrix[i, i] += np.where(self.follows[:, i], 1e-15, 1.0)
        step = solved(matrix, right).T
        moved, chosen = values.copy(), self.follows & going[:, None]
        moved[self.variable[chosen]] -= step[chosen]
        return follow(joints, moved)


def loops_of(batch: Batch) -> Loops | None:
    """The loops of a batch; None where its program closes none."""
    closures = batch.program.closures
    if not closures:
        return None
    links, joints = batch.links(), batch.joints()
    start = np.searchsorted(links.owner, np.arange(len(batch)))
    owners, rows, points = [], [], []
    for closure in closures:
        owner = batch.owner(closure.scope)
        owners.append(owner)
        rows.append(np.stack([start[owner] + batch.link_numbers(closure.scope, side) for side in closure.links]))
        points.append(
            np.stack([np.stack(batch.read(list(p), closure.scope), axis=-1).reshape(-1, 3) for p in closure.points])
        )
    order = np.argsort(np.concatenate(owners), kind="stable")
    owner, link = np.concatenate(owners)[order], np.concatenate(rows, axis=1)[:, order]
    point = np.concatenate(points, axis=1)[:, order]
    leader, rate = leading(joints)
    at, side, joint = above(batch, link)
    used = np.unique(leader[joint])
    used = used[np.argsort(joints.owner[used], kind="stable")]
    slot_of = np.zeros(len(leader), dtype=np.int64)
    slot_of[used] = np.arange(len(used)) - np.searchsorted(joints.owner[used], joints.owner[used])
    variable = np.full((len(batch), int(slot_of[used].max(initial=0)) + 1), -1, dtype=np.int64)
    variable[joints.owner[used], slot_of[used]] = used
    made = Loops(
        batch,
        Chains(links, joints),
        owner,
        link,
        point,
        at,
        side,
        joint,
        rate[joint],
        slot_of[leader[joint]],
        variable,
        np.zeros_like(variable, dtype=bool),
    )
    made.follows[...] = determined(made.slopes(follow(joints, batch.rest()))[1])
    return made


def leading(joints: JointTable) -> tuple[np.ndarray, np.ndarray]:
    """The joint (a row of the table) that each joint follows in the end, and how many times as fast it moves."""
    base = np.searchsorted(joints.owner, joints.owner)
    leader = np.where(joints.mimic >= 0, base + joints.mimic, np.arange(len(base)))
    rate = np.where(joints.mimic >= 0, joints.multiplier, 1.0)
    while not np.array_equal(leader, leader[leader]):
        rate = rate * np.where(leader != leader[leader], rate[leader], 1.0)
        leader = leader[leader]
    return leader, rate


def above(batch: Batch, link: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Every joint above the links (2, C): (closure, side, row of the table of joints)."""
    links, joints = batch.links(), batch.joints()
    first = np.searchsorted(links.owner, joints.owner)
    holder, mover = np.full(len(links.owner), -1, dtype=np.int64), np.full(len(links.owner), -1, dtype=np.int64)
    holder[first + joints.child], mover[first + joints.child] = first + joints.parent, np.arange(len(joints.owner))
    found = []
    side, at = (grid.ravel() for grid in np.meshgrid(np.arange(2), np.arange(link.shape[1]), indexing="ij"))
    row = link.ravel()
    while len(row):
        joint = mover[row]
        keep = joint >= 0
        side, at, row, joint = side[keep], at[keep], row[keep], joint[keep]
        found.append(np.stack([at, side, joint]))
        row = holder[row]
    return tuple(np.concatenate(found, axis=1))


def determined(slope: np.ndarray) -> np.ndarray:
    """Which of the variables (B, V) the equations determine: the last ones whose columns are independent."""
    count, _, size = slope.shape
    found = np.zeros((count, size), dtype=bool)
    basis: list[np.ndarray] = []
    for k in reversed(range(size)):
        column = slope[:, :, k]
        left = column.copy()
        for unit in basis:
            left -= unit * (unit * left).cumsum(axis=1)[:, -1:]
        whole, rest = (np.sqrt((v * v).cumsum(axis=1)[:, -1]) for v in (column, left))
        found[:, k] = (whole > 1e-12) & (rest > INDEPENDENT * whole)
        basis.append(np.where(found[:, k], 1.0 / np.where(rest > 0.0, rest, 1.0), 0.0)[:, None] * left)
    return found
