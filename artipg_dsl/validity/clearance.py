"""``range a .. clearance``: joints that go on, from their rest value, as far as nothing is in the way.

Each alone, all others at rest, and then, for ``clearance all``, with all others anywhere (``together.py``). Turning:
intervals of angles are proved free or halved, as in the check of collisions; the end is where the first begins that is not
free. Sliding: the way is halved for as long as the hull of a piece at both ends meets another. They stop a hair before:
1e-4 rad, 0.01 mm; before what others can bring into the way 2e-3 rad, 0.5 mm.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.collide import overlap
from ..runtime.batch import Batch
from ..runtime.tables import JointTable
from .bodies import Pieces, Placed, gather
from .together import least_share, list_ways
from .tree import Tree
from .turns import HALVINGS, Turns, without_apart_boxes
from .validate import find_near_pieces, find_turns, split_blocks

_HALVES = 24  # of the way of a slide
HAIR_TURN, HAIR_SLIDE = 1e-4, 1e-5
WIDE_TURN, WIDE_SLIDE = 2e-3, 5e-4


def limit_joints(batch: Batch) -> JointTable:
    """The joints of a batch, with the high ends that the solids leave to those that go on."""
    tree, joints = Tree(batch), batch.joints()
    goes_on = np.array([joint.clearance for joint in batch.program.joints], dtype=bool)[joints.definition]
    body = gather(batch, tree.first, tree.turn, tree.shift)
    low, high = np.full((len(batch), 3), np.inf), np.full((len(batch), 3), -np.inf)
    np.minimum.at(low, body.owner, body.low)
    np.maximum.at(high, body.owner, body.high)
    size = high - low
    across = np.sqrt(size[:, 0] ** 2 + size[:, 1] ** 2 + size[:, 2] ** 2)[
        joints.owner
    ]  # farther off nothing is in the way
    ends = tree.low, tree.high
    tree.low = joints.rest.copy()
    tree.high = np.where(tree.slides, np.minimum(tree.high, joints.rest + across), tree.high)
    most = np.where(goes_on, tree.high - joints.rest, np.inf)
    room = most.copy()
    for part in split_blocks(body):
        for piece, joint in tree.carried(part, goes_on & tree.slides):
            _sliding(tree, part, piece, joint, room)
        for piece, joint in tree.carried(part, goes_on & tree.turns):
            i, turns = find_turns(tree, part, piece, joint)
            keep = np.flatnonzero(~tree.permitted(part.link[turns.piece], part.link[turns.other]))
            _turning(part, turns.at(keep), joint[i[keep]], room)
    hair = np.where(tree.slides, HAIR_SLIDE, HAIR_TURN)
    room = np.where(room < most, np.maximum(room - hair, 0.0), room)
    tree.low, tree.high = ends[0], np.where(goes_on, joints.rest + room, ends[1])
    whatever = np.array([joint.whatever for joint in batch.program.joints], dtype=bool)[joints.definition]
    if whatever.any():
        room = np.where(whatever, _shared(tree, body, whatever), room)
    return replace(joints, high=np.where(goes_on, joints.rest + room, joints.high))


def _shared(tree: Tree, body: Pieces, whatever: np.ndarray) -> np.ndarray:
    """How far (J,) the joints ``whatever`` (J,) bool go with all others anywhere within their ranges.

    Two that are in the way of one another stop at the same share of what each has alone.
    """
    way = list_ways(tree)
    matter = (way.joint >= 0).sum(axis=1) > 1  # what one joint alone does is known
    matter &= (np.append(whatever, False)[way.joint]).any(axis=1) & ~tree.permitted(way.first, way.second)
    way, share = way.at(np.flatnonzero(matter)), np.ones(len(whatever))
    for part in split_blocks(body):
        share = np.minimum(share, least_share(tree, part, way, whatever)[0])
    room = (tree.high - tree.joints.rest) * share
    hair = np.where(tree.slides, WIDE_SLIDE, WIDE_TURN)
    return np.where(share < 1.0, np.maximum(room - hair, 0.0), room)


def _sliding(tree: Tree, body: Pieces, piece: np.ndarray, joint: np.ndarray, room: np.ndarray) -> None:
    """Lower ``room`` (J,) to how far pieces slide along the axes of joints before they meet others."""
    way = tree.axis[joint] * (tree.high - tree.joints.rest)[joint][:, None]
    i, j = find_near_pieces(
        tree, body, piece, body.low[piece] + np.minimum(way, 0.0), body.high[piece] + np.maximum(way, 0.0), joint
    )
    keep = ~tree.permitted(body.link[piece[i]], body.link[j])
    i, j = i[keep], j[keep]
    body.ready(piece[i], j)
    still = np.zeros((len(i), 3))
    meets = np.flatnonzero(overlap(Placed(body, piece[i], ends=(still, way[i])), Placed(body, j)))
    i, j = i[meets], j[meets]
    free, met = np.zeros(len(i)), np.ones(len(i))
    for _ in range(_HALVES):
        middle = (free + met) / 2
        hit = overlap(Placed(body, piece[i], ends=(still[: len(i)], way[i] * middle[:, None])), Placed(body, j))
        free, met = np.where(hit, free, middle), np.where(hit, middle, met)
    np.minimum.at(room, joint[i], free * (tree.high - tree.joints.rest)[joint[i]])


def _turning(body: Pieces, turns: Turns, joint: np.ndarray, room: np.ndarray) -> None:
    """Lower ``room`` (J,) to how far joints turn before pieces meet others; ``joint`` (k,) of each turn."""
    turns.row = joint
    turns = without_apart_boxes(body, turns)
    for _ in range(HALVINGS):
        turns = turns.at(np.flatnonzero(turns.start < room[turns.row]))
        if not len(turns.row):
            return
        hit, apart = turns.examined(body)
        middle = (turns.start + turns.stop) / 2
        np.minimum.at(room, turns.row[hit], middle[hit])
        turns = turns.at(np.flatnonzero(~apart)).halved()
    np.minimum.at(room, turns.row, turns.start)
