"""What collides: the convex pieces that validity was proved on, or hulls of neighbours where there are too many.

An object of few pieces keeps them as they are. Of one with many, neighbours are put together with the
least tolerance of ``hulls.STEPS`` that leaves few. Then the hulls are examined as samples are, at rest and over the range of
every joint. Of two that meet, the one is to blame that meets the other's pieces, too: what it adds in a hollow is cut
off, or it is halved, until no link meets another, in the end into the pieces that were proved.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..validity.bodies import Pieces, pack_inset
from ..validity.tree import Tree
from ..validity.validate import find_meetings, find_meetings_at_rest
from . import solids
from .hulls import Body, Gathered, Hull, shrink, wrap

if TYPE_CHECKING:
    from ..runtime.batch import Batch

ONE, OTHER, BOTH = 1, 2, 3  # sides: what is of one is held against what is of the other
_NONE = np.zeros(0, dtype=np.int64)
_Check = Callable[[Tree, Pieces], np.ndarray]
_Mine = tuple[int, Hull]  # the number of an object and a hull of it


def make_colliders(
    batch: Batch, groups: list[solids.ShapedPieces], materials: dict[int, np.ndarray]
) -> list[list[Hull]]:
    """The colliders of each object, in the order of the pieces; ``materials`` by site: what each row is made of."""
    gathered = Gathered(groups, len(batch), materials)
    bodies = [Body(gathered, *ends) for ends in zip(gathered.first[:-1], gathered.first[1:], strict=True)]
    merged = {i: body for i, body in enumerate(bodies) if body.merged}
    if merged:
        tree = Tree(batch)
        wrap(gathered.stock, (hull for body in merged.values() for hull in body.hulls))
        for check in (find_meetings_at_rest, find_meetings):  # most of what meets does so at rest, which is soon seen
            _Apart(tree, gathered, check).reduce(merged)
    return [body.in_order() for body in bodies]


class _Apart:
    """Hulls are reduced until ``check`` finds none that meets another link. Pieces do not: hulls alone are held against others."""

    def __init__(self, tree: Tree, gathered: Gathered, check: _Check):
        self.tree, self.gathered, self.check = tree, gathered, check

    def reduce(self, bodies: dict[int, Body]) -> None:
        """Reduce the hulls of some objects."""
        new = {hull for body in bodies.values() for hull in body.hulls if len(hull.pieces) > 1}
        while bodies:
            hulls = [(i, hull) for i, body in bodies.items() for hull in body.hulls]
            met = self._meeting(hulls, [BOTH if hull in new else OTHER for _, hull in hulls])
            blamed: dict[int, set[Hull]] = {}
            for i, hull in self._to_blame(met):
                blamed.setdefault(i, set()).add(hull)
            for i in {i for i, _ in met} - set(blamed):  # both reach out of their pieces, which alone would not do
                blamed[i] = {hull for k, hull in met if k == i and len(hull.pieces) > 1}
            bodies = {i: bodies[i] for i in sorted(blamed)}
            new = {hull for _, hull in met if len(hull.pieces) > 1}
            for i, body in bodies.items():
                new |= body.reduce(blamed[i])
            wrap(self.gathered.stock, (hull for body in bodies.values() for hull in body.hulls))

    def _to_blame(self, met: list[_Mine]) -> list[_Mine]:
        """Hulls that meet the very pieces of others."""
        hulls = [(i, hull) for i, hull in met if len(hull.pieces) > 1]
        pieces = np.concatenate([_NONE, *(hull.pieces for _, hull in met)])
        return self._meeting(hulls, [ONE] * len(hulls), pieces)

    def _placed(self, points: np.ndarray, link: np.ndarray) -> np.ndarray:
        """Points (n, 3) with the poses of their links at rest, rows (n,) of the link table."""
        turn = np.ascontiguousarray(self.tree.turn.reshape(-1, 9).T)  # by columns: the matrix of each point is not made
        x, y, z = np.ascontiguousarray(points.T)
        cells = []
        for a, b, c, shift in zip(turn[::3], turn[1::3], turn[2::3], self.tree.shift.T, strict=True):
            cell = a.take(link) * x
            cell += b.take(link) * y
            cell += c.take(link) * z
            cells.append(cell + shift.take(link))
        return np.stack(cells, axis=-1)

    def _meeting(self, hulls: list[_Mine], side: list[int], others: np.ndarray = _NONE) -> list[_Mine]:
        """Which hulls meet one of the other side on another link; ``others`` (n,) are the numbers of pieces of that side."""
        if not hulls:
            return []
        shrink(hull for _, hull in hulls)
        several = [k for k, (_, hull) in enumerate(hulls) if hull.inner is not None]
        single = [k for k, (_, hull) in enumerate(hulls) if hull.inner is None]
        order = np.array(several + single)
        first = np.array([hull.pieces[0] for _, hull in hulls])[order]
        pieces = np.concatenate([first[len(several) :], others])  # that are hulls of their own
        numbers = np.concatenate([first[: len(several)], pieces])
        inner = [hull.inner for _, hull in hulls if hull.inner is not None]
        counts = np.concatenate([[len(corners) for corners in inner], self.gathered.stock.sizes(pieces)]).astype(
            np.int64
        )
        owner = self.gathered.owner[numbers]
        link = self.tree.first[owner] + self.gathered.link[numbers]
        each = np.repeat(link, counts)
        corners = np.concatenate([*inner, self.gathered.stock.inner(pieces)])
        placed = self._placed(corners, each)
        body = pack_inset(placed, np.cumsum(counts) - counts, owner, link)
        sides = np.concatenate([np.array(side, dtype=np.int64)[order], np.full(len(others), OTHER)])
        body.side = sides[body.source]
        self.check(self.tree, body)
        found = body.source[body.met]
        return [hulls[k] for k in np.sort(order[found[found < len(hulls)]]).tolist()]
