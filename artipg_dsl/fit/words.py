"""Labels as the search sees them: words of clouds and of candidates, and which of them speak against each other.

A map of names says which words it means. A point whose word it does not mean says nothing. Two of different words do not belong together:
the nearest of the same word is looked for, and where there is none a point counts as far off.
"""

from __future__ import annotations

import numpy as np

from ..geometry.sites import SiteTable
from ..graph.expr import TRUE
from ..graph.program import Program
from ..runtime.batch import Batch
from .states import tables

_OTHER = 0.15  # what another word adds to a distance, in diagonals


def words_of_rows(batch: Batch, meant: np.ndarray) -> np.ndarray:
    """The word of each primitive, in the tables of all sites put together, by its place in ``semantic``; 0 where it is none of the ``meant``
    ones, and where formulas say point by point what is labelled."""
    parted = _parted(batch.program)

    def words(table: SiteTable) -> np.ndarray:
        known = np.isin(table.semantic, meant) & (table.number not in parted)
        return np.where(known, table.semantic, 0)

    return np.concatenate([np.zeros(0, dtype=np.int64), *map(words, tables(batch))])


def _parted(program: Program) -> set[int]:
    """The sites whose surface has a word in part."""
    labels = (label for label in program.labels if label.vocabulary == "semantic")
    return {
        target.site
        for label in labels
        for target in label.targets
        if target.surfaces or label.value is not TRUE or label.guard.reads
    }


def axes(word: np.ndarray, meant: np.ndarray) -> np.ndarray:
    """(..., W) for words (...): coordinates in diagonals, by which different words lie apart from each other, and what says nothing as far from
    all of them."""
    return np.asarray((word[..., None] == meant) * (_OTHER / np.sqrt(2.0)))


def unlike(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Whether two words are different ones."""
    return np.asarray((one > 0) & (other > 0) & (one != other))
