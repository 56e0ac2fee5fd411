"""Drawers that are pulled out of what guides them: at an end of their range nothing of the link that holds them lies beside them.

A cap or a lid leaves what it sits on as well, and looks the same; so only what is labelled `drawer` is looked at. Of 120 drawers of
the shipped categories each lies beside its holder by 77 % of its length at rest, and by 12 % where it is open, at least.
"""

from __future__ import annotations

import numpy as np

from ..geometry.runs import distinct
from ..geometry.vectors import dot
from ..records import dataclass
from .bodies import Pieces, enumerate_ranges, link_boxes
from .tree import Tree

_WORD = "drawer"
_HELD = 0.5  # of the length of a drawer, along its way, lies beside what holds it at rest


@dataclass(frozen=True, slots=True)
class Unguided:
    """A joint, by its definition, its parent and its child, by path, and how far the child is out of the parent, in the first object."""

    joint: int
    parent: str
    child: str
    out: float


def find_unguided(tree: Tree, body: Pieces) -> list[Unguided]:
    """The joints that slide drawers out of what holds them, in each of the objects that have them."""
    begin, end = link_boxes(body, len(tree.links.owner))[2:]
    full = end > begin
    called = np.array([word == _WORD for word in tree.batch.link_words], dtype=bool)
    slides = tree.slides & called[tree.child] & full[tree.child] & full[tree.above[tree.child]]
    joint = np.flatnonzero(slides)
    if not len(joint):
        return []
    child, parent = tree.child[joint], tree.above[tree.child[joint]]
    own, holder = (_extent(tree, body, joint, begin[link], end[link]) for link in (child, parent))
    rest = tree.joints.rest[joint]
    held, *moved = (
        np.minimum(holder[:, 1], own[:, 1] + way) - np.maximum(holder[:, 0], own[:, 0] + way)
        for way in (np.zeros(len(joint)), tree.low[joint] - rest, tree.high[joint] - rest)
    )
    left = np.minimum(*moved)
    gone = (held > _HELD * (own[:, 1] - own[:, 0])) & (left <= 0.0)
    kind, found = tree.joints.definition[joint], []
    for number in distinct(kind).tolist():
        mine = np.flatnonzero(kind == number)
        if gone[mine].all():
            k = int(mine[0])
            one, other = (tree.batch.program.links[tree.links.definition[link[k]]].path for link in (parent, child))
            found.append(Unguided(number, one, other, -float(left[k])))
    return found


def _extent(tree: Tree, body: Pieces, joint: np.ndarray, begin: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(k, 2) where the pieces ``begin .. end`` (k,) of a link lie along the axis of each joint (k,), metres."""
    k, piece = enumerate_ranges(begin, end - begin)
    height = np.empty((len(k), 2))
    for at, corners in body.classes(piece):
        along = dot(corners, tree.axis[joint][k[at], None])
        height[at] = np.stack([along.min(axis=1), along.max(axis=1)], axis=1)
    start = np.flatnonzero(np.diff(k, prepend=-1))
    return np.stack([np.minimum.reduceat(height[:, 0], start), np.maximum.reduceat(height[:, 1], start)], axis=1)
