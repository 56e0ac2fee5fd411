"""Links that overlap at rest, or that a joint drives into one another, and what else no object examined is free of: what can be
asked of a few objects at once, for `check`."""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..records import dataclass
from ..runtime.tables import plain_name
from .apart import find_too_near
from .bodies import Pieces
from .contact import describe_contact, meeting_parts, value_in_words
from .fault import Fault
from .floating import Solids, find_inverted
from .loops import find_open
from .tree import Tree
from .validate import Collisions, find_collisions

_FEW = 3  # objects: that a joint collides in fewer may be bad luck


@dataclass(frozen=True, slots=True)
class Stuck:
    """Two links, by path, and the parts of them that overlap, by name (`leg[0].rod`), in the order of their links."""

    links: tuple[str, str]
    parts: tuple[str, str]


@dataclass(frozen=True, slots=True)
class Driven(Stuck):
    """The same of links that a joint, by its definition, drives into one another: at a value, in words, of the first object;
    ``turned``: they would not meet with its range on the other side of its rest value. ``follower``: the path of the joint that
    moves them where that one only leads it, else nothing."""

    joint: int
    value: str
    turned: bool
    follower: str


def find_meeting(tree: Tree, body: Pieces) -> Collisions:
    """What meets at rest and, in the objects where nothing does, while one joint moves."""
    return find_collisions(tree.batch, tree, body, np.zeros(0, dtype=np.int64))


def _pairs(tree: Tree, found: Collisions) -> np.ndarray:
    """(m, 2) the definitions of the links of each row, the lower first."""
    start = tree.first[found.owner]
    sides = [tree.links.definition[start + side] for side in (found.first, found.second)]
    return np.sort(np.stack(sides, axis=1), axis=1)


def _there(tree: Tree) -> np.ndarray:
    """(B, definitions) which object has which link."""
    there = np.zeros((len(tree.first), len(tree.batch.program.links)), dtype=bool)
    there[tree.links.owner, tree.links.definition] = True
    return there


def find_driven(tree: Tree, body: Pieces, found: Collisions) -> list[Driven]:
    """The pairs of links that one joint drives into one another in each of the objects that have both, of those that are free at
    rest and at least three."""
    still = distinct(found.owner[found.joint < 0])
    there = _there(tree)
    there[still] = False
    moving = _driving(tree, found)
    turned = None  # what meets on the other side; where loops close there is not known
    driven = []
    for key in sorted(set(map(tuple, moving[found.joint >= 0].tolist()))):
        one, other, joint = key
        rows = np.flatnonzero((moving == key).all(axis=1))
        hit = len(distinct(found.owner[rows]))
        if hit < _FEW or hit < int((there[:, one] & there[:, other]).sum()):
            continue
        if turned is None and tree.batch.loops is None:
            turned = _meeting_beyond(tree, body)
        contact = describe_contact(tree, body, found, int(rows[0]))
        assert contact.value is not None
        first, second = sorted(tree.batch.program.links[link].path for link in (one, other))
        value = value_in_words(tree.batch.program.joints[joint].kind, contact.value)
        free = turned is not None and key not in turned
        driven.append(Driven((first, second), contact.parts, joint, value, free, _follower(tree, found, int(rows[0]))))
    return driven


def _follower(tree: Tree, found: Collisions, row: int) -> str:
    """The path of the joint that moves one of two links which the joint of the row carries neither of, nothing where it does."""
    owner = found.owner[row]
    lead = int(np.searchsorted(tree.joints.owner, owner)) + int(found.joint[row])
    carried = tree.chain[tree.first[owner] + np.array([found.first[row], found.second[row]])].ravel()
    carried = carried[carried >= 0]
    moving = tree.joint[carried]
    moving = moving[(moving >= 0) & (tree.leader[moving] == lead)] if lead not in tree.joint[carried] else moving[:0]
    return tree.batch.program.joints[tree.joints.definition[moving[0]]].path if len(moving) else ""


def _driving(tree: Tree, found: Collisions) -> np.ndarray:
    """(m, 3) the definitions of the links of each row and that of the joint that brings it about, -1 for none."""
    joints = np.append(tree.joints.definition, -1)
    start = np.searchsorted(tree.joints.owner, found.owner)
    joint = joints[np.where(found.joint >= 0, start + found.joint, len(joints) - 1)]
    return np.append(_pairs(tree, found), joint[:, None], axis=1)


def _meeting_beyond(tree: Tree, body: Pieces) -> set[tuple[int, ...]]:
    """What meets with the range of every joint on the other side of its rest value: definitions of links and of the joint."""
    turned = Tree(tree.batch)
    turned.low, turned.high = 2 * tree.joints.rest - tree.high, 2 * tree.joints.rest - tree.low
    beyond = find_collisions(tree.batch, turned, body)
    return set(map(tuple, _driving(turned, beyond).tolist()))


def find_stuck(tree: Tree, body: Pieces, found: Collisions) -> list[Stuck]:
    """The pairs of links that overlap with all joints at rest in each of the objects that have both, without those that the text
    allows to; the parts are those of the first object. Of links that overlap in some objects, the pairs of parts that overlap in
    each that has both: a part of a link may be absent where the link is not."""
    found, there = found.at(found.joint < 0), _there(tree)
    pairs = _pairs(tree, found)
    stuck = []
    for one, other in sorted(set(map(tuple, pairs.tolist()))):
        rows = np.flatnonzero((pairs == (one, other)).all(axis=1))
        first, second = sorted(tree.batch.program.links[link].path for link in (one, other))
        if len(distinct(found.owner[rows])) == int((there[:, one] & there[:, other]).sum()):
            stuck.append(Stuck((first, second), describe_contact(tree, body, found, int(rows[0])).parts))
        else:
            stuck += [Stuck((first, second), parts) for parts in _always(tree, body, found, rows.tolist())]
    return stuck


def _always(tree: Tree, body: Pieces, found: Collisions, rows: list[int]) -> list[tuple[str, str]]:
    """The parts, by name, of the first of those rows of one pair of links that are of the same two parts, where each object that has
    both parts has such a row."""
    parts = tree.batch.parts()
    paths = np.array([plain_name(name) for name in parts.name], dtype=object)
    met: dict[tuple[str, ...], list[tuple[tuple[str, str], int]]] = {}
    for row in rows:
        names = meeting_parts(tree, body, found, row)
        met.setdefault(tuple(plain_name(name) for name in names), []).append((names, int(found.owner[row])))
    always = []
    for key, told in met.items():
        having = [set(parts.owner[paths == path].tolist()) for path in key]
        both = set.intersection(*having)
        if len(both) > 1 and both == {owner for _, owner in told}:  # one alone may be bad luck
            always.append(told[0][0])
    return always


def find_never(solids: Solids) -> list[Fault]:
    """What is wrong with each of the objects: no surface at all, solids without thickness, links that nothing holds, loops that
    do not close, parts that come too near one another, and joints that rest outside their range. Parts that float are told apart."""
    tree, body = solids.tree, solids.body
    wrong = (
        *solids.missing(),
        *solids.degenerate(),
        *solids.find_unheld(),
        *find_open(tree),
        *find_too_near(tree, body),
        *find_inverted(tree),
    )
    return [fault for fault in wrong if len(fault.objects) == len(tree.first)]
