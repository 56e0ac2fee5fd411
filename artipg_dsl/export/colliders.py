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

from ..geometry.merge import Convex
from ..validity.bodies import Pieces, pack_inset, turn_points
from ..validity.tree import Tree
from ..validity.validate import find_meetings, find_meetings_at_rest
from . import solids
from .hulls import BUDGET, Body, Hull, shrink, wrap

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
        wrap(hull for body in merged.values() for hull in body.hulls)
        for check in (
            find_meetings_at_rest,
            find_meetings,
        ):  # most of what meets does so at rest, which is soon looked at
            _set_apart(tree, merged, check)
    return [body.in_order() for body in bodies]


def _set_apart(tree: Tree, bodies: dict[int, Body], check: _Check) -> None:
    """Reduce hulls until ``check`` finds none that meets another link. Pieces do not: hulls alone are held against others."""
    new = {hull for body in bodies.values() for hull in body.hulls if len(hull.pieces) > 1}
    alone: dict[Convex, Hull] = {}
    while bodies:
        hulls = [(i, hull) for i, body in bodies.items() for hull in body.hulls]
        met = _meeting(tree, check, hulls, [BOTH if hull in new else OTHER for _, hull in hulls])
        blamed: dict[int, set[Hull]] = {}
        for i, hull in _to_blame(tree, check, met, alone):
            blamed.setdefault(i, set()).add(hull)
        for i in {i for i, _ in met} - set(blamed):  # both reach out of their pieces, which alone would not do
            blamed[i] = {hull for k, hull in met if k == i and len(hull.pieces) > 1}
        bodies = {i: bodies[i] for i in sorted(blamed)}
        new = {hull for _, hull in met if len(hull.pieces) > 1}
        for i, body in bodies.items():
            new |= body.reduce(blamed[i])
        wrap(hull for body in bodies.values() for hull in body.hulls)


def _to_blame(tree: Tree, check: _Check, met: list[_Mine], alone: dict[Convex, Hull]) -> list[_Mine]:
    """Hulls that meet the very pieces of others, each of which is ``alone`` a hull."""
    hulls = [(i, hull) for i, hull in met if len(hull.pieces) > 1]
    pieces = []
    for i, hull in met:
        for piece in hull.pieces:
            if piece not in alone:
                alone[piece] = Hull(piece.source, (piece,))
            pieces.append((i, alone[piece]))
    found = _meeting(tree, check, hulls + pieces, [ONE] * len(hulls) + [OTHER] * len(pieces))
    return [(i, hull) for i, hull in found if len(hull.pieces) > 1]


def _meeting(tree: Tree, check: _Check, hulls: list[_Mine], side: list[int]) -> list[_Mine]:
    """Which hulls meet one of the other side on another link."""
    if not hulls:
        return []
    shrink(hull for _, hull in hulls)
    corners = [hull.inner for _, hull in hulls if hull.inner is not None]
    owner = np.array([i for i, _ in hulls])
    link = tree.first[owner] + np.array([hull.link for _, hull in hulls])
    first = np.cumsum([0, *map(len, corners)])
    each = np.repeat(link, np.diff(first))
    placed = turn_points(tree.turn[each], np.concatenate(corners)[:, None])[:, 0] + tree.shift[each]
    body = pack_inset(placed, first[:-1], owner, link)
    body.side = np.array(side, dtype=np.int64)[body.source]
    check(tree, body)
    return [hulls[k] for k in np.sort(body.source[body.met]).tolist()]
