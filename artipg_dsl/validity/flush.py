"""Links that touch where a joint moves one on the other: what can be asked of a few objects at once, for `check`."""

from __future__ import annotations

import numpy as np

from ..geometry.collide import common_point, separate
from ..geometry.runs import distinct
from ..geometry.vectors import dot
from ..records import dataclass
from ..runtime.motion import apply
from .bodies import Pieces, Placed, enumerate_ranges, link_boxes
from .contact import part_name
from .tree import Tree
from .validate import Collisions, find_near_pieces

_GAP = 1e-4  # metres: what comes nearer touches, as do the chords of a pin and of its bore of the same radius
_FEW = 3  # objects: that links touch in fewer may be by chance
_SHARES = (0.3, 0.6)  # of the way of a joint from rest
_ALONG = 0.9  # the cosine of an angle to an axis
_OFF = 1e-3  # metres: what is nearer to an axis lies on it


@dataclass(frozen=True, slots=True)
class Flush:
    """Two parts, by name, that a joint, by its definition, moves on one another without a gap."""

    parts: tuple[str, str]
    joint: int


def find_flush(tree: Tree, body: Pieces, found: Collisions) -> list[Flush]:
    """The pairs of links that touch at rest in each of the objects that have both, at least three, and that in the first of these a joint
    moves along one another; ``found``: what overlaps, which is told."""
    one, other = find_near_pieces(tree, body, np.arange(len(body)), body.low - _GAP, body.high + _GAP, None)
    free = ~tree.permitted(body.link[one], body.link[other])
    one, other = one[free], other[free]
    touch, _ = _touching(Placed(body, one), Placed(body, other))
    one, other = one[touch], other[touch]
    links, start = tree.links.definition, tree.first[found.owner]
    told = set(map(tuple, np.sort(links[[start + found.first, start + found.second]].T, axis=1).tolist()))
    pairs = np.sort(links[np.stack([body.link[one], body.link[other]], axis=1)], axis=1)
    there = np.zeros((len(tree.first), len(tree.batch.program.links)), dtype=bool)
    there[tree.links.owner, links] = True
    flush = []
    for pair in sorted(set(map(tuple, pairs.tolist())) - told):
        rows = np.flatnonzero((pairs == pair).all(axis=1))
        if len(distinct(body.owner[one[rows]])) < max(_FEW, int(there[:, pair].all(axis=1).sum())):
            continue
        i, j = int(one[rows[0]]), int(other[rows[0]])
        joint = _rubbing(tree, body, int(body.link[i]), int(body.link[j]))
        if joint is not None:
            flush.append(
                Flush((part_name(tree, body, i), part_name(tree, body, j)), int(tree.joints.definition[joint]))
            )
    return flush


def _touching(first: Placed, second: Placed) -> tuple[np.ndarray, np.ndarray]:
    """Which pairs of pieces (k,) are near one another and do not overlap, and the ways (k, 3) across what is between them."""
    first.pieces.ready(first.piece, second.piece)
    hit, away = separate(first, second, 0.9)
    return np.flatnonzero(~hit & (dot(away, away) < _GAP * _GAP)), away


def _rubbing(tree: Tree, body: Pieces, first: int, second: int) -> int | None:
    """The joint that moves one of two links and leaves them touching, on its way to one of its ends; of what moves both, none does."""
    above = [set(tree.joint[tree.chain[link][tree.chain[link] >= 0]].tolist()) - {-1} for link in (first, second)]
    for joint in sorted(above[0] ^ above[1]):
        for end in (tree.low[joint], tree.high[joint]) if tree.turns[joint] or tree.slides[joint] else ():
            way = end - tree.joints.rest[joint]
            if way and all(_rub_at(tree, body, (first, second), joint, share * way) for share in _SHARES):
                return joint
    return None


def _rub_at(tree: Tree, body: Pieces, links: tuple[int, int], joint: int, way: float) -> bool:
    """Whether two links touch with a joint, or what it follows, some way from rest. What turns touches along its axis as a hinge
    does: counted are faces across the axis, and places off it."""
    states = tree.joints.rest.copy()
    leader = tree.leader[joint]
    rate = 1.0 if leader == joint else tree.joints.multiplier[joint]
    if rate:
        states[leader] += way / rate
    turn, shift, _ = tree.at(states)
    begin, end = link_boxes(body, len(tree.links.owner))[2:]
    mine = np.arange(begin[links[0]], end[links[0]])
    k, theirs = enumerate_ranges(
        np.full(len(mine), begin[links[1]]), np.full(len(mine), end[links[1]] - begin[links[1]])
    )
    first, second = (
        Placed(body, piece, turn[body.link[piece]], shift[body.link[piece]]) for piece in (mine[k], theirs)
    )
    near, away = _touching(first, second)
    if tree.slides[joint] or not len(near):
        return bool(len(near))
    holder = tree.above[tree.child[joint]]
    axis = apply(turn[[holder]], tree.axis[[joint]])[0]
    origin = apply(turn[[holder]], tree.origin[[joint]])[0] + shift[holder]
    across = np.abs(away[near] @ axis) > _ALONG * np.linalg.norm(away[near], axis=1)
    off = np.cross(common_point(first.at(near), second.at(near)) - origin, axis)
    return bool((across | (np.linalg.norm(off, axis=1) > _OFF)).any())
