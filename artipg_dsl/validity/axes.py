"""Axes that lie far off the link that is to hold them, as of a lid that turns about its free edge."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..geometry.runs import distinct
from ..geometry.vectors import dot
from ..records import dataclass
from ..runtime.motion import apply
from .bodies import Pieces, enumerate_ranges, link_boxes
from .rings import bound_rings, find_across
from .tree import Tree

if TYPE_CHECKING:
    from ..graph.primitive import Triple

_FAR = 0.6  # of how far what turns reaches from its axis; of the shipped categories no hinge lies farther off than 0.5
_NEAR = 5e-3  # metres: what an axis passes so near can have a bore for its pin
_LOOSE = 9.9e-3  # metres: of what a pin joins no links lie a centimetre apart
_WAYS = np.arange(16) * (np.pi / 8)  # across an axis


@dataclass(frozen=True, slots=True)
class LooseLoop:
    """Two links, by path, that a closure keeps on one axis and that are ``gap`` metres apart along it, in the first object."""

    closure: int
    links: tuple[str, str]
    gap: float


@dataclass(frozen=True, slots=True)
class FarAxis:
    """A joint, by its definition, its parent and its child, by path; metres, in the first object that has them."""

    joint: int
    parent: str
    child: str
    off: float
    reach: float


def find_far_axes(tree: Tree, body: Pieces) -> list[FarAxis]:
    """The joints whose axis lies outside the hull of the parent link, in each of the objects that have them: by more than a share
    of how far the child link reaches from the axis, so that nothing could hold it there. What moves in a closed loop is held by
    others, too."""
    begin, end = link_boxes(body, len(tree.links.owner))[2:]
    full = end > begin
    joint = np.flatnonzero(tree.turns & full[tree.child] & full[tree.above[tree.child]])
    if not len(joint) or tree.batch.loops is not None:
        return []
    child, parent = tree.child[joint], tree.above[tree.child[joint]]
    ways, height, _ = _measure(tree, body, joint, begin[parent], end[parent])
    _, own, reach = _measure(tree, body, joint, begin[child], end[child])
    beside = np.maximum(np.maximum(height[:, 0] - own[:, 1], own[:, 0] - height[:, 1]), 0.0)
    off = np.hypot(np.maximum(ways.max(axis=1), 0.0), beside)
    kind, found = tree.joints.definition[joint], []
    for number in distinct(kind).tolist():
        mine = np.flatnonzero(kind == number)
        if (off[mine] > _FAR * reach[mine]).all():
            k = int(mine[0])
            holder, held = (tree.batch.program.links[tree.links.definition[link[k]]].path for link in (parent, child))
            found.append(FarAxis(number, holder, held, float(off[k]), float(reach[k])))
    return found


def _measure(
    tree: Tree, body: Pieces, joint: np.ndarray, begin: np.ndarray, end: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of the pieces ``begin .. end`` (k,) of a link about the axis of each joint (k,): the least corner in each of the ways across
    it (k, 16), the heights along it (k, 2), and how far they reach from it (k,); metres."""
    k, piece = enumerate_ranges(begin, end - begin)
    axis, origin = tree.axis[joint][k], tree.origin[joint][k]
    along, across = find_across(axis)
    least, height, reach = np.empty((len(k), len(_WAYS))), np.empty((len(k), 2)), np.empty(len(k))
    for at, corners in body.classes(piece):
        local = corners - origin[at, None]
        h, x, y = (dot(local, way[at, None]) for way in (axis, along, across))
        height[at] = np.stack([h.min(axis=1), h.max(axis=1)], axis=1)
        reach[at] = np.sqrt(x * x + y * y).max(axis=1)
        for number, angle in enumerate(_WAYS):
            least[at, number] = (np.cos(angle) * x + np.sin(angle) * y).min(axis=1)
    start = np.flatnonzero(np.diff(k, prepend=-1))
    low, high = np.minimum.reduceat(height[:, 0], start), np.maximum.reduceat(height[:, 1], start)
    return np.minimum.reduceat(least, start), np.stack([low, high], axis=1), np.maximum.reduceat(reach, start)


def find_loose_loops(tree: Tree, body: Pieces, axes: dict[int, Triple]) -> list[LooseLoop]:
    """The closures of two axes, by their definition with the direction at joint values 0, whose links lie apart along the axis, in each
    of the objects that have them: what a pin joins lies side by side."""
    loops, program, found = tree.batch.loops, tree.batch.program, []
    if loops is None:
        return []
    begin, end = link_boxes(body, len(tree.links.owner))[2:]
    for number, direction in axes.items():
        rows = np.flatnonzero(loops.which == number)
        first = loops.link[0, rows]
        axis = np.stack(tree.batch.read(list(direction), program.closures[number].scope), axis=-1).reshape(-1, 3)
        axis = apply(tree.turn[first], axis)
        origin = apply(tree.turn[first], loops.point[0, rows]) + tree.shift[first]
        sides = []
        for link in loops.link[:, rows]:
            k, piece = enumerate_ranges(begin[link], end[link] - begin[link])
            rings = bound_rings(body, piece, axis[k], origin[k])
            at = rings.reach[:, 0] <= _NEAR
            low, high = np.full(len(rows), np.inf), np.full(len(rows), -np.inf)
            np.minimum.at(low, k[at], rings.height[at, 0])
            np.maximum.at(high, k[at], rings.height[at, 1])
            sides.append((low, high))
        (low, high), (other_low, other_high) = sides
        gap = np.maximum(other_low - high, low - other_high)
        if len(rows) and (np.isfinite(gap) & (gap > _LOOSE)).all():
            one, other = (program.links[tree.links.definition[link]].path for link in loops.link[:, rows[0]])
            found.append(LooseLoop(number, (one, other), float(gap[0])))
    return found
