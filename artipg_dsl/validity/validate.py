"""Do the links of an object penetrate one another, at rest or while one joint runs through its range?

The truth is the convex pieces; what an export makes of them is examined here, too. Every pair of links counts, parents and children too.
Each joint moves alone, all others at rest, with everything that hangs on its link. Sliding is swept exactly (the hull
of a piece at both ends). Turning is decided over whole intervals: bounds about the axis leave the angles at which two
pieces can meet at all; there a plane that keeps them apart is looked for in the middle and proved for the interval, or
the interval is halved. A joint that others follow is looked at in many states.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..geometry.collide import find_near, overlap
from ..geometry.runs import distinct
from ..native import turning as native
from ..native.backend import machine as compiled
from ..records import dataclass
from ..runtime.batch import Batch
from .bodies import EXACT, FULL, Pieces, Placed, boxes_meet, enumerate_ranges, gather, link_boxes
from .following import meet_in_states
from .gated import find_behind_gates
from .rings import bound_rings
from .tree import Tree
from .turns import Turns, find_meeting

_BLOCK = 20_000  # pieces at a time
LinkPairs = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, slots=True)
class Collisions:
    """One row per pair of links that penetrate: object index, link numbers, and the joint (-1: at rest) and its value.

    The value is one at which they meet, the least that was found; between the ends of a sliding joint it is its high end.
    ``pieces`` (m, 2): one of either link that meet then, by ``Pieces.source``.
    """

    owner: np.ndarray
    first: np.ndarray
    second: np.ndarray
    joint: np.ndarray
    value: np.ndarray
    pieces: np.ndarray

    def __len__(self) -> int:
        return len(self.owner)

    def objects(self) -> np.ndarray:
        """Indices of the objects that have any."""
        return distinct(self.owner)

    def at(self, rows: np.ndarray) -> Collisions:
        """Some of them."""
        names = ("owner", "first", "second", "joint", "value", "pieces")
        return Collisions(*(getattr(self, name)[rows] for name in names))


def find_collisions(
    batch: Batch, tree: Tree | None = None, body: Pieces | None = None, lost: np.ndarray | None = None
) -> Collisions:
    """All penetrations of a batch, each pair of links once per joint that brings it about.

    ``body``: given pieces instead of the batch's own; their ``met`` tells afterwards which are to blame. ``lost``: objects
    that are invalid already; neither their joints nor those of objects that collide at rest are moved.
    """
    tree = tree or Tree(batch)
    body = body or gather(batch, tree.first, tree.turn, tree.shift)
    return _told(tree, find_meetings(tree, body, lost))


def find_meetings(tree: Tree, body: Pieces, lost: np.ndarray | None = None) -> np.ndarray:
    """Rows (link, link, joint, value, piece, piece) of all that meet: rows of the tables of links and joints, -1 at rest;
    pieces of either link by their ``source``. ``lost``: as of ``find_collisions``."""
    return np.concatenate([_nothing(), *(_block(tree, part, lost) for part in split_blocks(body))])


def find_meetings_at_rest(tree: Tree, body: Pieces) -> np.ndarray:
    """As ``find_meetings``, of what meets at rest."""
    return np.concatenate([_nothing(), *(_resting(tree, part) for part in split_blocks(body))])


def _told(tree: Tree, rows: np.ndarray) -> Collisions:
    """Hits as tables number things, without those that the text allows."""
    first, second, joint = (rows[:, k].astype(np.int64) for k in range(3))
    keep = ~tree.permitted(first, second)
    first, second, joint, value = first[keep], second[keep], joint[keep], rows[keep, 3]
    number = tree.links.number
    named = np.where(joint >= 0, np.append(tree.joints.number, -1)[joint], -1)
    pieces = rows[keep, 4:].astype(np.int64)
    return Collisions(tree.links.owner[first], number[first], number[second], named, value, pieces)


@dataclass(slots=True, eq=False)
class _Hits:
    """Pairs of links (rows of the link table) that meet, the joint (a row of the joint table, -1: rest) and its value.

    ``pieces``: those of either that meet.
    """

    first: np.ndarray
    second: np.ndarray
    joint: np.ndarray
    value: np.ndarray
    pieces: tuple[np.ndarray, np.ndarray]

    def rows(self) -> np.ndarray:
        """(m, 6), each pair once per joint, at its least value."""
        low, high = np.minimum(self.first, self.second), np.maximum(self.first, self.second)
        one, two = (np.where((self.first == low) == same, *self.pieces) for same in (True, False))
        table = np.stack([low, high, self.joint, self.value, one, two], axis=1).astype(np.float64)
        table = table[np.lexsort(table.T[::-1])]
        new = np.ones(len(table), dtype=bool)
        new[1:] = (table[1:, :3] != table[:-1, :3]).any(axis=1)
        return table[new]


def _nothing() -> np.ndarray:
    return np.zeros((0, 6))


def split_blocks(body: Pieces) -> Iterator[Pieces]:
    """Pieces of whole objects, some at a time."""
    edges = np.flatnonzero(np.diff(body.owner, prepend=-1, append=-1))
    start = 0
    while start < len(body):
        fits = edges[(edges > start) & (edges <= start + _BLOCK)]
        stop = int(fits[-1] if len(fits) else edges[edges > start][0])
        yield body.part(slice(start, stop))
        start = stop


def _block(tree: Tree, body: Pieces, lost: np.ndarray | None) -> np.ndarray:
    """Rows (link, link, joint, value) of some objects."""
    found = [_resting(tree, body)]
    if lost is not None:
        gone = np.isin(body.owner, np.append(lost, _told(tree, found[0]).owner))
        body = body.part(~gone) if gone.any() else body
        if not len(body):
            return found[0]
    for piece, joint in tree.carried(body, tree.slides & tree.alone & ~tree.gated):
        found.append(_sliding(tree, body, piece, joint))
    for piece, joint in tree.carried(body, tree.turns & tree.alone & ~tree.gated):
        found.append(_turning(tree, body, piece, joint))
    found.extend(_following(tree, body))
    found.extend(find_behind_gates(tree, body))
    return np.concatenate(found)


# ---------------------------------------------------------------- which pairs of pieces come near one another


def find_near_pieces(
    tree: Tree, body: Pieces, piece: np.ndarray, low: np.ndarray, high: np.ndarray, joint: np.ndarray | None
) -> LinkPairs:
    """Pairs (index into ``piece``, other piece) whose boxes overlap: the links' first, then the pieces' own.

    With joints, the other piece stays where it is; without, its link comes later in the table.
    """
    first, stop = tree.start[body.owner[piece]], tree.start[body.owner[piece] + 1]
    if joint is None:
        first = body.link[piece] + (1 if body.side is None else 0)
    lows, highs, begin, end = link_boxes(body, len(tree.links.owner))
    machine = compiled()
    if machine is not None:
        child = None if joint is None else tree.child[joint]
        scene = native.Scene(lows, highs, body.low, body.high, begin, end)
        i, other = native.near_pieces(machine, (first, stop), (low, high), child, tree.chain, scene)
        keep = body.opposed(piece[i], other)
        return i[keep], other[keep]
    i, link = enumerate_ranges(first, stop - first)
    if joint is not None:  # what hangs on the joint's link moves along
        child = tree.child[joint]
        stays = ~(tree.chain[link] == child[i][:, None]).any(axis=1)
        i, link = i[stays], link[stays]
    near = boxes_meet(i, link, low, high, lows, highs)
    i, link = i[near], link[near]
    k, other = enumerate_ranges(begin[link], (end - begin)[link])
    i = i[k]
    near = boxes_meet(i, other, low, high, body.low, body.high)
    i, other = i[near], other[near]
    keep = body.opposed(piece[i], other)
    return i[keep], other[keep]


def _meeting(body: Pieces, first: Placed, second: Placed) -> np.ndarray:
    """Which pairs of placed pieces meet: penetrate one another, or are nearer than they may be."""
    gap = body.apart(first.piece, second.piece)
    return overlap(first, second) if gap is None else find_near(first, second, gap, EXACT)


# ---------------------------------------------------------------- at rest, sliding, turning


def _resting(tree: Tree, body: Pieces) -> np.ndarray:
    piece = np.arange(len(body))
    i, j = find_near_pieces(tree, body, piece, body.low, body.high, None)
    body.ready(i, j)
    hit = _meeting(body, Placed(body, i), Placed(body, j))
    i, j = i[hit], j[hit]
    return _Hits(
        *tree.blame(body, i, j), np.full(len(i), -1), np.zeros(len(i)), (body.source[i], body.source[j])
    ).rows()


def _sliding(tree: Tree, body: Pieces, piece: np.ndarray, joint: np.ndarray) -> np.ndarray:
    axis, rest = tree.axis[joint], tree.joints.rest[joint]
    ends = tuple(axis * (end[joint] - rest)[:, None] for end in (tree.low, tree.high))
    low = body.low[piece] + np.minimum(*ends)
    high = body.high[piece] + np.maximum(*ends)
    i, j = find_near_pieces(tree, body, piece, low, high, joint)
    body.ready(piece[i], j)
    hit = _meeting(body, Placed(body, piece[i], ends=(ends[0][i], ends[1][i])), Placed(body, j))
    i, j = i[hit], j[hit]
    met = body.source[piece[i]], body.source[j]
    return _Hits(*tree.blame(body, piece[i], j), joint[i], tree.high[joint[i]], met).rows()


def _turning(tree: Tree, body: Pieces, piece: np.ndarray, joint: np.ndarray) -> np.ndarray:
    i, turns = find_turns(tree, body, piece, joint)
    hit, value = find_meeting(tree, body, turns)
    i, j = i[hit], turns.other[hit]
    met = body.source[piece[i]], body.source[j]
    return _Hits(*tree.blame(body, piece[i], j), joint[i], value + tree.joints.rest[joint[i]], met).rows()


def find_turns(tree: Tree, body: Pieces, piece: np.ndarray, joint: np.ndarray) -> tuple[np.ndarray, Turns]:
    """The turns by which pieces could meet others: (index into ``piece``, the turn, less the joint's rest value)."""
    axis, origin = tree.axis[joint], tree.origin[joint]
    own = bound_rings(body, piece, axis, origin)
    ends = [tree.advance[joint] * (end[joint] - tree.joints.rest[joint]) for end in (tree.low, tree.high)]
    own.height += np.stack([np.minimum(*ends), np.maximum(*ends)], axis=-1)
    if body.gap is not None:
        own.grow(body.gap[piece])
    middle = origin + axis * ((own.height[:, 0] + own.height[:, 1]) / 2)[:, None]
    wide = own.reach[:, 1][:, None] * np.sqrt(np.maximum(1.0 - axis * axis, 0.0))
    wide += np.abs(axis) * ((own.height[:, 1] - own.height[:, 0]) / 2)[:, None]
    i, j = find_near_pieces(tree, body, piece, middle - wide, middle + wide, joint)
    # the others' bounds about the same axes, each once
    pair, back = np.unique(joint[i] * len(body) + j, return_inverse=True)
    other = bound_rings(
        body, pair % max(len(body), 1), tree.axis[pair // max(len(body), 1)], tree.origin[pair // max(len(body), 1)]
    )
    meet = np.ones(len(i), dtype=bool)
    for mine, theirs in ((own.height, other.height), (own.reach, other.reach)):
        meet &= (mine[i, 0] < theirs[back, 1]) & (theirs[back, 0] < mine[i, 1])
    i, j, back = i[meet], j[meet], back[meet]
    rest = tree.joints.rest[joint[i]]
    at, start, stop = _angles(own.angle[i], other.angle[back], tree.low[joint[i]] - rest, tree.high[joint[i]] - rest)
    i, j = i[at], j[at]
    return i, Turns(piece[i], j, axis[i], origin[i], start, stop, tree.advance[joint[i]], np.arange(len(i)))


def _angles(
    own: np.ndarray, other: np.ndarray, low: np.ndarray, high: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By how much pieces with angles ``own`` (k, 2) can turn within ``low .. high`` and meet others: (index, start, stop)."""
    whole = (own[:, 1] - own[:, 0]) + (other[:, 1] - other[:, 0]) >= FULL - 1e-9
    index, starts, stops = [np.flatnonzero(whole)], [low[whole]], [high[whole]]
    most = int(np.ceil(max(np.abs(low).max(initial=0.0), np.abs(high).max(initial=0.0)) / FULL)) + 2
    for k in range(-most, most + 1):
        start = np.maximum(other[:, 0] - own[:, 1] + FULL * k, low)
        stop = np.minimum(other[:, 1] - own[:, 0] + FULL * k, high)
        at = np.flatnonzero(~whole & (stop - start > 1e-7))
        index.append(at)
        starts.append(start[at])
        stops.append(stop[at])
    found = np.concatenate(index)
    order = np.argsort(found, kind="stable")
    return found[order], np.concatenate(starts)[order], np.concatenate(stops)[order]


# ---------------------------------------------------------------- states of several joints


def _following(tree: Tree, body: Pieces) -> Iterator[np.ndarray]:
    """Joints that others follow, in many states."""
    leads, values = tree.following
    gaps = None if body.gap is None else lambda one, two: _meeting(body, one, two)
    for found in meet_in_states(tree, body, values, leads >= 0, gaps):
        (i, j), lead, states = found.pieces, leads[found.number], values[found.number]
        first, second = tree.blame(body, i, j)
        at = lead[tree.links.owner[first]]
        keep = (at >= 0) & np.isin(tree.links.owner[first], body.owner)
        if keep.any():
            met = body.source[i[keep]], body.source[j[keep]]
            yield _Hits(first[keep], second[keep], at[keep], states[at[keep]], met).rows()


def find_meetings_in_states(tree: Tree, body: Pieces, states: np.ndarray) -> Iterator[LinkPairs]:
    """Pairs of links that meet and may not, for each of the ``states`` (S, J)."""
    for found in meet_in_states(tree, body, states):
        yield tree.blame(body, *found.pieces)
