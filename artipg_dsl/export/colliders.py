"""What collides: the convex pieces that validity was proved on, or hulls of neighbours where there are too many.

An object of up to ``BUDGET`` pieces keeps them as they are. Of one with more, neighbours are put together with the
least tolerance of ``STEPS`` that brings it there. Then the hulls are examined as samples are, at rest and over the range of
every joint. Of two that meet, the one is to blame that meets the other's pieces, too: what it adds in a hollow is cut
off, or it is halved, until no link meets another, in the end into the pieces that were proved.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..validity.bodies import Alike, Pieces, pack_pieces, turn_points
from ..validity.tree import Tree
from ..validity.validate import find_meetings, find_meetings_at_rest
from . import solids
from .hulls import BUDGET, Body, Hull

if TYPE_CHECKING:
    from ..runtime.batch import Batch

ONE, OTHER, BOTH = 1, 2, 3  # sides: what is of one is held against what is of the other
_Check = Callable[[Tree, Pieces], np.ndarray]
_Mine = tuple[int, Hull]  # the number of an object and a hull of it


def make_colliders(
    batch: Batch, groups: list[solids.ShapedPieces], materials: dict[int, np.ndarray]
) -> list[list[Hull]]:
    """The colliders of each object, in the order of the pieces; ``materials`` by site: what each row is made of."""
    objects = solids.group_by_object(groups, len(batch))
    bodies = [Body(items, materials) for items in objects]
    merged = {i: bodies[i] for i, items in enumerate(objects) if len(items) > BUDGET}
    if merged:
        tree = Tree(batch)
        for check in (
            find_meetings_at_rest,
            find_meetings,
        ):  # most of what meets does so at rest, which is soon looked at
            _set_apart(tree, merged, check)
    return [body.in_order() for body in bodies]


def _set_apart(tree: Tree, bodies: dict[int, Body], check: _Check) -> None:
    """Reduce hulls until ``check`` finds none that meets another link. Pieces do not: hulls alone are held against others."""
    new = {hull for body in bodies.values() for hull in body.hulls if len(hull.pieces) > 1}
    while bodies:
        hulls = [(i, hull) for i, body in bodies.items() for hull in body.hulls]
        met = _meeting(tree, check, hulls, [BOTH if hull in new else OTHER for _, hull in hulls])
        blamed: dict[int, set[Hull]] = {}
        for i, hull in _to_blame(tree, check, met):
            blamed.setdefault(i, set()).add(hull)
        for i in {i for i, _ in met} - set(blamed):  # both reach out of their pieces, which alone would not do
            blamed[i] = {hull for k, hull in met if k == i and len(hull.pieces) > 1}
        bodies = {i: bodies[i] for i in sorted(blamed)}
        new = {hull for _, hull in met if len(hull.pieces) > 1}
        for i, body in bodies.items():
            new |= body.reduce(blamed[i])


def _to_blame(tree: Tree, check: _Check, met: list[_Mine]) -> list[_Mine]:
    """Hulls that meet the very pieces of others."""
    hulls = [(i, hull) for i, hull in met if len(hull.pieces) > 1]
    pieces = [(i, Hull(piece.source, (piece,))) for i, hull in met for piece in hull.pieces]
    found = _meeting(tree, check, hulls + pieces, [ONE] * len(hulls) + [OTHER] * len(pieces))
    return [(i, hull) for i, hull in found if len(hull.pieces) > 1]


def _meeting(tree: Tree, check: _Check, hulls: list[_Mine], side: list[int]) -> list[_Mine]:
    """Which hulls meet one of the other side on another link."""
    if not hulls:
        return []
    owner = np.array([i for i, _ in hulls])
    items = [hull.item for _, hull in hulls]
    link = tree.first[owner] + np.array([item.group.table.link[item.row] for item in items])
    corners = [hull.vertices for _, hull in hulls]
    ends = np.cumsum([len(points) for points in corners])
    each = np.repeat(link, np.diff(ends, prepend=0))
    turned = turn_points(tree.turn[each], np.concatenate(corners)[:, None])[:, 0]
    placed = np.split(turned + tree.shift[each], ends[:-1])
    alike: dict[tuple[int, bytes], list[int]] = {}
    for k, (_, hull) in enumerate(hulls):
        alike.setdefault((len(corners[k]), hull.faces.tobytes()), []).append(k)
    groups = [
        Alike(np.stack([placed[k] for k in numbers]), hulls[numbers[0]][1].faces, owner[numbers], link[numbers])
        for numbers in alike.values()
    ]
    body = pack_pieces(groups)
    number = np.concatenate(list(alike.values()))[body.source]
    body.side = np.array(side, dtype=np.int64)[number]
    check(tree, body)
    return [hulls[k] for k in np.sort(number[body.met]).tolist()]
