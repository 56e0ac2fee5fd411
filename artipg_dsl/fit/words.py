"""Labels as the search sees them: words of clouds and of candidates, and which of them speak against each other.

A map of names says which words it means. A point whose word it does not mean says nothing, and belongs to any other. Two of different words do
not belong together: a different word adds ``OTHER`` to a distance, as if it were one more axis.
"""

from __future__ import annotations

import numpy as np

from ..geometry.nearest import Nearest as Sets
from ..geometry.sites import SiteTable
from ..graph.expr import TRUE
from ..graph.program import Program
from ..runtime.batch import Batch

SETS_APART = 1e3  # diagonals
OTHER = 0.15  # what another word adds to a distance, in diagonals
_PLACE = 3  # axes of places, which come before those of normals
_NEAR = 0.05  # diagonals: to look for what lies farther off takes long
# diagonals, in which points are looked for: no farther than need be, and nothing lies beyond
_REACHES = 1.05 * OTHER, 2.0 * OTHER, 2.0


def words_of_rows(batch: Batch, meant: np.ndarray) -> np.ndarray:
    """The word of each primitive, in the tables of all sites put together, by its place in ``semantic``; 0 where it is none of the ``meant``
    ones, and where formulas say point by point what is labelled."""
    parted = _parted(batch.program)

    def words(table: SiteTable) -> np.ndarray:
        known = np.isin(table.semantic, meant) & (table.number not in parted)
        return np.where(known, table.semantic, 0)

    return np.concatenate([np.zeros(0, dtype=np.int64), *map(words, batch.sites())])


def _parted(program: Program) -> set[int]:
    """The sites whose surface has a word in part."""
    labels = (label for label in program.labels if label.vocabulary == "semantic")
    return {
        target.site
        for label in labels
        for target in label.targets
        if target.surfaces or label.value is not TRUE or label.guard.reads
    }


def unlike(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether two words are different ones."""
    return np.asarray((one > 0) & (other > 0) & (one != other))


def factors(word: np.ndarray, meant: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(K, n, W + 1) twice, for words (K, n): the product of one's first and another's second is 1 where the words are unlike, else 0."""
    each = (word[..., None] == meant).astype(np.float64)
    said = each.sum(axis=-1, keepdims=True)
    return np.concatenate([said, each], axis=-1), np.concatenate([said, -each], axis=-1)


class Nearest:
    """Points (n, d) with words (n,), each in the set ``of`` (n,), searched by distances that a different word makes longer."""

    def __init__(self, points: np.ndarray, of: np.ndarray, word: np.ndarray, meant: np.ndarray):
        self._meant = meant
        self.every = Sets(points, of, SETS_APART)
        self._own = Sets(points, self._worded(of, word), SETS_APART) if len(meant) else None

    def find(self, points: np.ndarray, of: np.ndarray, word: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The index (m,) of the nearest of their sets ``of`` (m,), for points (m, d) with words (m,); and how far the nearest one is,
        whatever its word (m,)."""
        far, found = self.every.find(points, of)
        said = np.flatnonzero(word > 0)
        if self._own is None or not len(said):
            return found, far
        most = np.sqrt(far**2 + OTHER**2)  # so far counts the nearest one with another word
        low = 0.0
        for high in _REACHES:
            some = said[(most[said] > low) & (most[said] <= high)]
            ways = [self._own.find(points[some], self._worded(of[some], one), high) for one in (word[some], 0 * some)]
            apart = np.stack([*(distance for distance, _ in ways), most[some]])
            index = np.stack([*(at for _, at in ways), found[some]])
            found[some] = index[apart.argmin(axis=0), np.arange(len(some))]
            low = high
        return found, far

    def _worded(self, of: np.ndarray, word: np.ndarray) -> np.ndarray:
        """Sets of a set and a word: of what says nothing, the first."""
        return np.asarray(of * (len(self._meant) + 1) + np.searchsorted(self._meant, word, side="right") * (word > 0))


class Twofold:
    """Points (n, 6) by place and normal, with words (n,), each in the set ``of`` (n,); searched by both, and by places alone, as normals of
    small parts are guessed."""

    def __init__(self, points: np.ndarray, of: np.ndarray, word: np.ndarray, meant: np.ndarray):
        self._points = points
        self.both = Nearest(points, of, word, meant)
        self.places = Nearest(points[:, :_PLACE], of, word, meant)
        self._worded = len(meant) > 0

    def find(
        self, points: np.ndarray, of: np.ndarray, word: np.ndarray
    ) -> tuple[tuple[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """The index (m,) of the nearest of their sets ``of`` (m,), for points (m, 6) with words (m,), and how far the nearest one is whatever
        its word (m,): by both, and by places."""
        if self._worded:
            return self.both.find(points, of, word), self.places.find(points[:, :_PLACE], of, word)
        near, index = self.places.every.two(points[:, :_PLACE], of)
        found = index[:, 0].copy()
        off = points - self._points[found]
        far = np.sqrt((off * off).sum(axis=1))
        rest = np.flatnonzero(far >= near[:, 1])  # in all others, places alone lie farther off
        far[rest], found[rest] = self.both.every.find(points[rest], of[rest])
        return (found, far), (index[:, 0], near[:, 0])

    def within(self, points: np.ndarray, of: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """(m,) bool: of which points (m, 6) the nearest place of their sets ``of`` (m,) may lie within ``reach`` (m,)."""
        found = np.ones(len(points), dtype=bool)
        some = np.flatnonzero(reach < _NEAR)
        far, _ = self.places.every.find(points[some, :_PLACE], of[some], _NEAR)
        found[some] = far <= reach[some]
        return found
