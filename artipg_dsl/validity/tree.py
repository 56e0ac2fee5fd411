"""The links of a batch as trees: what is above what, which joint moves what, and how far it can move."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.runs import distinct
from ..runtime.batch import Batch
from ..runtime.motion import JointChains, apply, follow, multiply
from .bodies import Pieces
from .meant import find_allowed

if TYPE_CHECKING:
    from .validate import Collisions

_KEPT = 500_000  # links, each in a state, of which the poses are kept
_SHARES = distinct(np.concatenate([[0.002, 0.005, 0.01, 0.02, 0.035], np.linspace(0.0, 1.0, 41), [0.98, 0.995]]))
RestPoses = tuple[np.ndarray, np.ndarray, list[np.ndarray], np.ndarray]


class Tree:
    """Links above each link, joint axes at rest, and which joints move others along."""

    def __init__(self, batch: Batch):
        self.batch, self.links, self.joints = batch, batch.links(), batch.joints()
        count = len(self.links.owner)
        self.first = np.searchsorted(self.links.owner, np.arange(len(batch)))
        self.start = np.append(self.first, count)
        self.above = np.full(count, -1, dtype=np.int64)  # parent link of each link
        self.joint = np.full(count, -1, dtype=np.int64)
        self.child = self.first[self.joints.owner] + self.joints.child
        self.above[self.child] = self.first[self.joints.owner] + self.joints.parent
        self.joint[self.child] = np.arange(len(self.child))
        chain = [np.arange(count)]
        while (chain[-1] >= 0).any():
            assert len(chain) <= count, "the links form a ring"
            chain.append(np.where(chain[-1] >= 0, self.above[np.maximum(chain[-1], 0)], -1))
        self.chain = np.stack(chain, axis=1)  # (L, depth): the link itself, its parent, ...
        self._chains = JointChains(self.links, self.joints)
        self.turn, self.shift = batch.pose()
        holder = np.maximum(self.above[self.child], 0)
        self.axis = apply(self.turn[holder], self.joints.axis)
        self.origin = apply(self.turn[holder], self.joints.origin) + self.shift[holder]
        self.turns, self.slides = self.joints.that("turns"), self.joints.that("slides")
        self.advance = np.where(self.turns, self.joints.advance, 0.0)  # of a turn by a radian
        self.low = np.where(np.isnan(self.joints.low), -np.pi, self.joints.low)
        self.high = np.where(np.isnan(self.joints.high), np.pi, self.joints.high)
        base = np.searchsorted(self.joints.owner, self.joints.owner)
        self.leader = np.where(self.joints.mimic >= 0, base + self.joints.mimic, np.arange(len(base)))
        assert np.array_equal(self.leader, self.leader[self.leader]), "a joint follows one that follows another"
        if batch.loops is not None:  # what the loops of an object determine follows its first driving joint
            self.leader = batch.loops.driven(self.leader)
        self.gates = batch.gates
        self.gated = np.zeros(len(base), dtype=bool)  # they move only while others are open
        if self.gates is not None:
            self.gated[self.gates.joint] = True
        self._poses: dict[bytes, RestPoses] = {}
        self.alone = np.bincount(self.leader, minlength=len(base))[self.leader] == 1
        self.alone &= ~self.joints.that("tilts")  # a ball turns about no axis of the table
        if batch.loops is not None:
            self.alone[batch.loops.drivers()] = False

    def named(self, found: Collisions) -> dict[tuple[str, str, str], np.ndarray]:
        """Per pair of paths of links and path of the joint ("" at rest): the rows of ``found``."""
        program, start = self.batch.program, np.searchsorted(self.joints.owner, found.owner)
        first, second = (self.links.definition[self.first[found.owner] + link] for link in (found.first, found.second))
        kinds = np.append(self.joints.definition, -1)
        joint = np.where(found.joint >= 0, kinds[np.minimum(start + found.joint, len(kinds) - 1)], -1)
        groups: dict[tuple[str, str, str], list[int]] = {}
        for row, (a, b, j) in enumerate(zip(first.tolist(), second.tolist(), joint.tolist(), strict=True)):
            pair = sorted((program.links[a].path, program.links[b].path))
            groups.setdefault((pair[0], pair[1], program.joints[j].path if j >= 0 else ""), []).append(row)
        return {key: np.array(rows) for key, rows in groups.items()}

    def at(self, states: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Turn and shift of the links from rest with the joints at ``states`` (J,), and the closures (of ``Loops``) that are open."""
        turn, shift, apart, _ = self.poses(states[None])
        return turn[0], shift[0], apart[0]

    def poses(self, states: np.ndarray) -> RestPoses:
        """The same for states (S, J): (S, L, 3, 3), (S, L, 3), then the closures and the joint values of each state;
        kept for as long as there is room."""
        key = states.tobytes()
        found = self._poses.get(key)
        if found is None:
            values = self.batch.settle(states)
            turn, shift = self._chains.motion(follow(self.joints, values))
            loops, none = self.batch.loops, np.zeros(0, dtype=np.int64)
            apart = [none if loops is None else loops.apart(*pose) for pose in zip(turn, shift, strict=True)]
            turn = multiply(turn, self.turn.transpose(0, 2, 1))
            found = turn, shift - apply(turn, self.shift), apart, values
            if sum(kept[1].shape[0] * kept[1].shape[1] for kept in self._poses.values()) + shift.size // 3 > _KEPT:
                self._poses.clear()
            self._poses[key] = found
        return found

    @cached_property
    def following(self) -> tuple[np.ndarray, np.ndarray]:
        """The joint that leads each object (S, B), -1 for none, and the states (S, J) that show what joints do that move others,
        or turn about more than one axis."""
        made = [(lead, states) for lead, states, _ in lead_states(self, ~self.alone, _SHARES)]
        lead = np.array([lead for lead, _ in made], dtype=np.int64).reshape(len(made), len(self.first))
        return lead, np.array([states for _, states in made]).reshape(len(made), len(self.joints.owner))

    def blame(self, body: Pieces, i: np.ndarray, j: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The links of pairs of pieces that meet; where the text does not allow it, the pieces remember."""
        first, second = body.link[i], body.link[j]
        wrong = ~self.permitted(first, second)
        body.met[i[wrong]] = body.met[j[wrong]] = True
        return first, second

    def permitted(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Pairs that the text allows to overlap or to block one another."""
        return np.isin(np.minimum(first, second) * len(self.above) + np.maximum(first, second), self._allowed)

    @cached_property
    def _allowed(self) -> np.ndarray:
        """The pairs of links that ``allow overlap`` and ``free`` name: the lower times their number, plus the higher."""
        pairs = find_allowed(self.batch, ("overlap", "free"))
        return pairs[:, 0] * len(self.above) + pairs[:, 1]

    def joint_above(self, link: np.ndarray, level: int) -> np.ndarray:
        """The joints (n,) so many levels above links (n,): 0 for those that move them; -1 where there is none."""
        above = self.chain[link, level]
        return np.where(above >= 0, self.joint[above], -1)

    def carried(self, body: Pieces, chosen: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """(pieces, joints): the pieces that each of the joints ``chosen`` (J,) bool moves, level by level of the tree."""
        for level in range(self.chain.shape[1] - 1):
            joint = self.joint_above(body.link, level)
            piece = np.flatnonzero((joint >= 0) & np.append(chosen, False)[joint])
            if len(piece):
                yield piece, joint[piece]


def lead_states(tree: Tree, chosen: np.ndarray, shares: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, int]]:
    """States (J,) in which one leading joint of ``chosen`` (J,) bool of every object stands at each share of its range.

    The first such joint of every object, then the second, ...: (that joint of each object (B,), -1 for none; states with
    the others at rest, what the joint waits for open; which share).
    """
    joints = tree.joints
    leads = chosen & (tree.leader == np.arange(len(joints.owner)))
    base = np.searchsorted(joints.owner, joints.owner)
    rank = np.cumsum(leads) - leads
    rank = rank - rank[base] if len(rank) else rank
    for turn in range(int(rank[leads].max(initial=-1)) + 1):
        at = np.flatnonzero(leads & (rank == turn))
        lead = np.full(len(tree.first), -1)
        lead[joints.owner[at]] = at
        for number, share in enumerate(shares):
            states = joints.rest.copy()
            states[at] = tree.low[at] + share * (tree.high[at] - tree.low[at])
            if tree.gates is not None:
                states = tree.gates.open(states, np.isin(np.arange(len(states)), at), tree.low, tree.high)
            yield lead, states, number
