"""Closed loops of joints: the values of some joints follow from the others, so that points stated by ``close`` stay together.

Of the joints on the loops of an object, the first of its table drive and the others follow: as many, from the last on,
as the loops can determine (a joint declared later yields, as parts do). They are solved for by Gauss-Newton steps
of all objects at once, led from rest to the values asked for, so that a loop does not jump to its other assembly.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..geometry.runs import distinct
from ..records import dataclass
from .motion import JointChains, MatrixCells, apply, carry, follow
from .newton import solve_small
from .tables import JointTable

if TYPE_CHECKING:
    from .batch import Batch

APART = 1e-6  # metres: farther than this, two points are not together
_CLOSED = 1e-13  # and nearer than this, no step brings them closer
_LED = 1e-5  # near enough on the way from rest, where the next stage moves them again
_STAGES = 6  # on the way from rest
_ROUNDS = 8  # steps for each
_INDEPENDENT = 1e-6  # of a column that the columns before do not make up
_BLOCK = 30_000  # links at a time, each in a state


@dataclass(frozen=True, slots=True, eq=False)
class Loops:
    """The closures of a batch: C pairs of points, sorted by object, on the rows ``link`` (2, C) of the table of links, each of the
    definition ``which`` (C,) of the program.

    ``joint`` (E,) moves the point ``side`` of closure ``at``, ``rate`` times as fast as the joint ``leads`` that it follows.
    ``slot`` numbers the leading joints of an object; ``follows`` (B, V) tells which of them the loops determine, and ``together``
    the first slot to which loops tie each.
    """

    joints: JointTable
    chains: JointChains
    owner: np.ndarray
    which: np.ndarray
    link: np.ndarray
    point: np.ndarray  # (2, C, 3), at joint values 0
    at: np.ndarray
    side: np.ndarray
    joint: np.ndarray
    rate: np.ndarray
    slot: np.ndarray
    variable: np.ndarray  # (B, V): the leading joint of each slot, -1 for none
    follows: np.ndarray
    together: np.ndarray

    def apart(self, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
        """The closures that are open with the links posed by ``turn`` and ``shift``."""
        first, second = (
            apply(turn[link], point) + shift[link] for link, point in zip(self.link, self.point, strict=True)
        )
        return np.flatnonzero(np.abs(first - second).max(axis=1) > APART)

    def beyond(self, values: np.ndarray) -> np.ndarray:
        """The joints that loops take out of their ranges, of the joint values (J,)."""
        joint = np.sort(self.variable[self.follows])
        return joint[self.excess(joint, values) > APART]

    def excess(self, joint: np.ndarray, values: np.ndarray) -> np.ndarray:
        """How far some joints are beyond their ranges, of the joint values (J,); 0 or less within."""
        high = self.joints.high[joint]
        low = np.where(self.joints.that("tilts")[joint], -high, self.joints.low[joint])  # a ball tilts to any side
        return np.maximum(low - values[joint], values[joint] - high)

    def driven(self, leader: np.ndarray) -> np.ndarray:
        """The joint that each joint follows, ``leader`` for what mimics, where loops determine it the first that drives these."""
        first = np.full(self.variable.shape, len(leader), dtype=np.int64)
        owner, slot = np.nonzero(~self.follows & (self.variable >= 0))
        np.minimum.at(first, (owner, self.together[owner, slot]), self.variable[owner, slot])
        instead = np.arange(len(leader))
        owner, slot = np.nonzero(self.follows)
        drives = first[owner, self.together[owner, slot]]
        led = drives < len(leader)
        instead[self.variable[owner, slot][led]] = drives[led]
        return instead[leader]

    def drivers(self) -> np.ndarray:
        """The joints that drive loops, several of one loop among them."""
        moved = np.zeros(self.variable.shape, dtype=bool)
        owner, slot = np.nonzero(self.follows)
        moved[owner, self.together[owner, slot]] = True
        drives = ~self.follows & (self.variable >= 0) & np.take_along_axis(moved, self.together, axis=1)
        return self.variable[drives]

    def slopes(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gaps (B, M) and their derivatives by the leading joints (B, M, V), 0 where an object has fewer of either."""
        gap, slope = self.equations(values[None])
        return gap[:, 0].T, slope[:, :, 0].transpose(2, 0, 1)

    def equations(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As ``slopes`` for states (S, J): gaps (M, S, B) and derivatives (M, V, S, B)."""
        chains = self.chains
        turn, shift = chains.cells(values)
        places = [self._placed(turn, shift, self.link[side], list(self.point[side].T)) for side in range(2)]
        holder = chains.parent[self.joint]
        above = [cell[:, holder] for cell in turn]
        axis, slide = (carry(above, list(way[:, self.joint])) for way in (chains.axis, chains.slide))
        origin = self._placed(turn, shift, holder, list(chains.origin[:, self.joint]))
        # from the joint to the point that it moves
        arm = [
            np.where(self.side == 0, a[:, self.at], b[:, self.at]) - o for a, b, o in zip(*places, origin, strict=True)
        ]
        speed = [axis[i - 2] * arm[i - 1] - axis[i - 1] * arm[i - 2] + slide[i] for i in range(3)]
        rate = self.rate * np.where(self.side == 0, 1.0, -1.0)
        rank = np.arange(len(self.owner)) - np.searchsorted(self.owner, self.owner)
        (count, size), most = self.variable.shape, int(rank.max(initial=0)) + 1
        gap, slope = np.zeros((3, len(values), most * count)), np.zeros((3, len(values), most * size * count))
        cell = (rank[self.at] * size + self.slot) * count + self.owner[self.at]
        turns = _times(cell)
        for k, (one, two, way) in enumerate(zip(*places, speed, strict=True)):
            gap[k][:, rank * count + self.owner] = one - two
            for at in turns:  # several joints that follow one another add up
                slope[k][:, cell[at]] += (way * rate)[:, at]
        gap = gap.reshape(3, len(values), most, count).transpose(2, 0, 1, 3)
        slope = slope.reshape(3, len(values), most, size, count).transpose(2, 0, 3, 1, 4)
        return gap.reshape(3 * most, len(values), count), slope.reshape(3 * most, size, len(values), count)

    @staticmethod
    def _placed(turn: MatrixCells, shift: MatrixCells, link: np.ndarray, point: MatrixCells) -> MatrixCells:
        """Points on links, posed."""
        moved = carry([cell[:, link] for cell in turn], point)
        return [at + cell[:, link] for at, cell in zip(moved, shift, strict=True)]

    def settle(self, states: np.ndarray) -> np.ndarray:
        """Joint values (..., J) that mimics and loops obey, the driving joints as in ``states`` (..., J); each row of states
        the same whatever the others are."""
        found = np.array(states, dtype=np.float64).reshape(-1, states.shape[-1])
        size = max(1, _BLOCK // max(self.chains.count, 1))
        for start in range(0, len(found), size):
            found[start : start + size] = self._settle_states(found[start : start + size])
        return found.reshape(states.shape)

    def _settle_states(self, states: np.ndarray) -> np.ndarray:
        joints = self.joints
        rest, wanted = follow(joints, joints.rest), follow(joints, states)
        driven = np.zeros(len(rest), dtype=bool)
        driven[self.variable[self.follows]] = True
        values = np.tile(rest, (len(states), 1))
        for stage in range(1, _STAGES + 1):
            share = stage / _STAGES
            values = follow(joints, np.where(driven, values, rest + share * (wanted - rest)))
            near = _CLOSED if stage == _STAGES else _LED
            open_ones = np.arange(len(states))
            for _ in range(_ROUNDS):
                gap, slope = self.equations(values[open_ones])
                going = np.abs(gap).max(axis=0, initial=0.0) >= near  # each object stops by itself
                some = np.flatnonzero(going.any(axis=1))
                if not len(some):
                    break
                open_ones = open_ones[some]
                step = self._step(gap[:, some], slope[:, :, some])
                values[open_ones] = self._stepped(values[open_ones], step, going[some])
        return values

    def _step(self, gap: np.ndarray, slope: np.ndarray) -> np.ndarray:
        """The Gauss-Newton step (V, S, B) of what follows."""
        _, size, *shape = slope.shape
        held = [[np.where(self.follows[:, i], column[i], 0.0) for i in range(size)] for column in slope]
        matrix, right = np.zeros((size, size, *shape)), np.zeros((size, *shape))
        for i in range(size):
            for m, column in enumerate(held):
                right[i] += column[i] * gap[m]
                for j in range(i, size):
                    matrix[i, j] += column[i] * column[j]
            for j in range(i):
                matrix[i, j] = matrix[j, i]
            matrix[i, i] += np.where(self.follows[:, i], 1e-15, 1.0)
        return solve_small(matrix.reshape(size, size, -1), right.reshape(size, -1)).reshape(size, *shape)

    def _stepped(self, values: np.ndarray, step: np.ndarray, going: np.ndarray) -> np.ndarray:
        """States (S, J) after a step of the objects that are ``going`` (S, B)."""
        moved = values.copy()
        for way, held, joint in zip(step, self.follows.T, self.variable.T, strict=True):
            at = np.flatnonzero(held)
            moved[:, joint[at]] -= np.where(going[:, at], way[:, at], 0.0)
        return follow(self.joints, moved)


def _times(cell: np.ndarray) -> list[np.ndarray]:
    """The places of what occurs for the first time, for the second, ..., in order."""
    order = np.argsort(cell, kind="stable")
    rank = np.empty(len(cell), dtype=np.int64)
    rank[order] = np.arange(len(cell)) - np.searchsorted(cell[order], cell[order])
    return [np.flatnonzero(rank == number) for number in range(int(rank.max(initial=-1)) + 1)]


def loops_of(batch: Batch) -> Loops | None:
    """The loops of a batch; None where none of its objects has any."""
    closures = [(k, closure) for k, closure in enumerate(batch.program.closures) if len(batch.owner(closure.scope))]
    if not closures:
        return None
    links, joints = batch.links(), batch.joints()
    start = np.searchsorted(links.owner, np.arange(len(batch)))
    owners, kinds, rows, points = [], [], [], []
    for number, closure in closures:
        owner = batch.owner(closure.scope)
        owners.append(owner)
        kinds.append(np.full(len(owner), number))
        rows.append(np.stack([start[owner] + batch.link_numbers(closure.scope, side) for side in closure.links]))
        points.append(
            np.stack([np.stack(batch.read(list(p), closure.scope), axis=-1).reshape(-1, 3) for p in closure.points])
        )
    order = np.argsort(np.concatenate(owners), kind="stable")
    owner, link = np.concatenate(owners)[order], np.concatenate(rows, axis=1)[:, order]
    which, point = np.concatenate(kinds)[order], np.concatenate(points, axis=1)[:, order]
    leader, rate = leaders_of(joints)
    at, side, joint, matter = _joints_above(batch, link)
    used = distinct(leader[joint])
    used = used[np.argsort(joints.owner[used], kind="stable")]
    slot_of = np.zeros(len(leader), dtype=np.int64)
    slot_of[used] = np.arange(len(used)) - np.searchsorted(joints.owner[used], joints.owner[used])
    variable = np.full((len(batch), int(slot_of[used].max(initial=0)) + 1), -1, dtype=np.int64)
    variable[joints.owner[used], slot_of[used]] = used
    slot = slot_of[leader[joint]]
    made = Loops(
        joints,
        JointChains(links, joints, matter),
        owner,
        which,
        link,
        point,
        at,
        side,
        joint,
        rate[joint],
        slot,
        variable,
        np.zeros_like(variable, dtype=bool),
        _tied(owner, at, slot, variable.shape),
    )
    made.follows[...] = _determined(made.slopes(follow(joints, joints.rest))[1])
    return made


def _tied(owner: np.ndarray, at: np.ndarray, slot: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """The first slot of an object (B, V) that closures tie each to, itself where none does; ``slot`` moves the closure ``at``."""
    found = np.tile(np.arange(shape[1]), (shape[0], 1))
    while True:
        least = np.full(len(owner), shape[1])
        np.minimum.at(least, at, found[owner[at], slot])
        before = found.copy()
        np.minimum.at(found, (owner[at], slot), least[at])
        if np.array_equal(found, before):
            return found


def leaders_of(joints: JointTable) -> tuple[np.ndarray, np.ndarray]:
    """The joint (a row of the table) that each joint follows in the end, and how many times as fast it moves."""
    base = np.searchsorted(joints.owner, joints.owner)
    leader = np.where(joints.mimic >= 0, base + joints.mimic, np.arange(len(base)))
    rate = np.where(joints.mimic >= 0, joints.multiplier, 1.0)
    while not np.array_equal(leader, leader[leader]):
        rate = rate * np.where(leader != leader[leader], rate[leader], 1.0)
        leader = leader[leader]
    return leader, rate


def _joints_above(batch: Batch, link: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Every joint above one of two links (2, C) and not above the other: (closure, side, row of the table of joints); last which
    joints (J,) are above any. Those above both move both, and the loop with them."""
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
    at, side, joint = np.concatenate(found, axis=1)
    matter = np.zeros(len(joints.owner), dtype=bool)
    matter[joint] = True
    _, where, count = np.unique(at * len(matter) + joint, return_inverse=True, return_counts=True)
    alone = count[where] == 1
    return at[alone], side[alone], joint[alone], matter


def _determined(slope: np.ndarray) -> np.ndarray:
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
        found[:, k] = (whole > 1e-12) & (rest > _INDEPENDENT * whole)
        basis.append(np.where(found[:, k], 1.0 / np.where(rest > 0.0, rest, 1.0), 0.0)[:, None] * left)
    return found
