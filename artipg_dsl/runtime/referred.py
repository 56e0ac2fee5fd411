"""References resolved: the number, within its object, of what each row means."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..graph.expr import Expr, Scope
from ..graph.reference import Elsewhere, Onward, Reference, Under
from .tables import Instances, Rowmap

ReadRows = Callable[[Sequence[Expr], Scope], list[np.ndarray]]


class Referred:
    """Resolves references to definitions whose rows stand in ``scopes`` and are numbered by ``instances``."""

    def __init__(self, rowmap: Rowmap, instances: Instances, scopes: Sequence[Scope], read: ReadRows):
        self.rowmap, self.instances, self.scopes, self.read = rowmap, instances, scopes, read

    def numbers(self, scope: Scope, reference: Reference) -> np.ndarray:
        """For each row of ``scope`` the number of the first alternative that exists; -1 where none does."""
        found = np.full(self.rowmap.rows(scope).size, -1, dtype=np.int64)
        for item in reference:
            if isinstance(item, int):
                number = self.instances.numbers(item, self.rowmap.across(scope, self.scopes[item]))
            else:
                number = _at(self.stated(item), self.rowmap.across(scope, item.scope))
            found = np.where(found < 0, number, found)
        return found

    def stated(self, item: Under | Elsewhere | Onward) -> np.ndarray:
        """The numbers in the rows in which an alternative is stated."""
        match item:
            case Under():
                return self.numbers(item.scope, item.links)
            case Elsewhere():
                return _at(self.numbers(item.repeat, item.links), self.element(item))
            case Onward():
                own, rank = self.numbers(item.scope, item.links), self.rowmap.rows(item.scope).rank
                onward = np.zeros(len(own), dtype=bool)
                for guard in item.guards:
                    onward |= self.rowmap.across(item.scope, guard) >= 0
                return own[np.maximum.accumulate(np.where(onward & (rank > 0), 0, np.arange(len(own))))]

    def element(self, item: Elsewhere) -> np.ndarray:
        """The row of the repeat that is meant in each row of the scope; -1 where there is no such element."""
        rows = self.rowmap.rows(item.repeat)
        if item.rank is None:
            row = self.rowmap.up(item.scope, item.repeat)
            return np.where(rows.rank[row] > 0, row - 1, -1)
        assert item.repeat.parent is not None
        parent = self.rowmap.across(item.scope, item.repeat.parent)
        rank = np.rint(self.read([item.rank], item.scope)[0]).astype(np.int64)
        there = (parent >= 0) & (rank >= 0) & (rank < _at(rows.count, parent))
        return np.where(there, _at(rows.start, parent) + rank, -1)


def _at(values: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Whole numbers by row, -1 for row -1."""
    return np.append(values, -1)[row]
