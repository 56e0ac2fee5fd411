"""Joints that move only while others are open: proved free over their ranges, with what they wait for anywhere that lets them move.

A joint that waits is looked at with its gates open, never shut: each alone, over its whole range and the intervals of its gates at once
(``together.py``), so that a rack clears its door wherever the door lets it out. All other joints rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.runs import distinct
from .bodies import Pieces
from .fault import Fault
from .together import Meeting, least_share, list_ways
from .tree import Tree

if TYPE_CHECKING:
    from ..runtime.gates import Gates


def find_behind_gates(tree: Tree, body: Pieces) -> Iterator[np.ndarray]:
    """Rows (link, link, joint, value, piece, piece), as of ``validate.find_meetings``, of what joints that wait bring about."""
    if tree.gates is None or not len(body):
        return
    way = list_ways(tree)
    here = np.isin(tree.links.owner[way.first], body.owner)
    if body.side is None:  # of other pairs it is asked whether they keep a distance
        here &= ~tree.permitted(way.first, way.second)
    way = way.at(np.flatnonzero(here & np.append(tree.gated & tree.alone, False)[way.joint].any(axis=1)))
    none = np.zeros(len(tree.joints.owner), dtype=bool)
    for chosen in _one_of_each(tree):
        rows = np.flatnonzero(np.append(chosen, False)[way.joint].any(axis=1))
        if not len(rows):
            continue
        part, found = way.at(rows), list[Meeting]()
        least_share(_with_gates_open(tree, tree.gates, chosen), body, part, none, found)
        for meeting in found:
            joint = part.joint[meeting.row]
            column = np.argmax(np.append(chosen, False)[joint], axis=1)
            at = np.arange(len(column))
            moved = joint[at, column]
            value = tree.joints.rest[moved] + meeting.value[at, column]
            first, second = tree.blame(body, meeting.piece, meeting.other)
            pieces = body.source[meeting.piece], body.source[meeting.other]
            swap = first > second
            ends = [np.where(swap, b, a) for a, b in ((first, second), pieces)]
            others = [np.where(swap, a, b) for a, b in ((first, second), pieces)]
            yield np.stack([ends[0], others[0], moved, value, ends[1], others[1]], axis=1).astype(np.float64)


def find_shut(tree: Tree) -> Iterator[Fault]:
    """The joints that never move, as what they wait for does not get so far."""
    gates = tree.gates
    if gates is None:
        return
    shut = (tree.high[gates.gate] < gates.low) | (tree.low[gates.gate] > gates.high)
    for row in distinct(tree.joints.definition[gates.joint[shut]]).tolist():
        joint = tree.batch.program.joints[row]
        at = gates.joint[shut][tree.joints.definition[gates.joint[shut]] == row]
        words = f"the joint `{joint.path}` never moves: what it waits for does not get so far"
        yield Fault(words, distinct(tree.joints.owner[at]), joint.where)


def _one_of_each(tree: Tree) -> Iterator[np.ndarray]:
    """The first joint (J,) bool of each object that waits and moves by itself, the second, ..."""
    waits = tree.gated & tree.alone
    rank = np.cumsum(waits) - waits
    base = np.searchsorted(tree.joints.owner, tree.joints.owner)
    rank = rank - rank[base] if len(rank) else rank
    for number in range(int(rank[waits].max(initial=-1)) + 1):
        yield waits & (rank == number)


def _with_gates_open(tree: Tree, gates: Gates, chosen: np.ndarray) -> Tree:
    """The tree with all joints at rest but those that are ``chosen`` (J,) and what they wait for, which is open."""
    opened, moves, rest = copy(tree), chosen.copy(), tree.joints.rest
    least, most = np.where(chosen, tree.low, rest), np.where(chosen, tree.high, rest)
    wanted = [np.full(len(rest), -np.inf), np.full(len(rest), np.inf)]
    for level in range(int(gates.level.max(initial=-1)), -1, -1):
        rows = np.flatnonzero((gates.level == level) & moves[gates.joint])
        np.maximum.at(wanted[0], gates.gate[rows], gates.low[rows])
        np.minimum.at(wanted[1], gates.gate[rows], gates.high[rows])
        moves[gates.gate[rows]] = True
    gate = moves & ~chosen
    opened.low = np.where(gate, np.clip(wanted[0], tree.low, tree.high), least)
    opened.high = np.where(gate, np.clip(wanted[1], tree.low, tree.high), most)
    follows = gate[tree.leader] & (tree.leader != np.arange(len(rest)))  # bolts that a gate draws are drawn with it
    one, two = (tree.joints.multiplier * ends[tree.leader] + tree.joints.offset for ends in (opened.low, opened.high))
    opened.low = np.where(follows, np.minimum(one, two), opened.low)
    opened.high = np.where(follows, np.maximum(one, two), opened.high)
    return opened
