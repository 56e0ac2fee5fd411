"""What was drawn for each object, by name, as people and files know it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np

from ..graph.expr import Scope
from ..graph.program import Program
from .draws import to_plain
from .tables import Rowmap


class _Column(NamedTuple):
    """The values of one draw: ``told``, one per row; of object i from ``start[i]`` to ``start[i + 1]``; ``places``, the ranks of the repeats
    above each row, None outside of repeats."""

    name: str
    start: list[int]
    told: list[Any]
    places: list[tuple[int, ...]] | None


class Drawn:
    """The drawn parameters, counts and choices of a batch. ``values``: a column (rows,) per draw, by its number in the program."""

    def __init__(
        self,
        program: Program,
        rowmap: Rowmap,
        owner: Callable[[Scope], np.ndarray],
        values: Mapping[int, np.ndarray],
        size: int,
    ):
        starts: dict[Scope, list[int]] = {}
        self._columns = []
        for number, draw in enumerate(program.draws):
            scope = draw.column.scope
            if scope not in starts:
                starts[scope] = np.searchsorted(owner(scope), np.arange(size + 1)).tolist()
            ranks = [rank.tolist() for _, rank in rowmap.ranks(scope)]
            places = list(zip(*ranks, strict=True)) if ranks else None
            told = [to_plain(draw, value) for value in values[number].tolist()]
            self._columns.append(_Column(draw.column.name, starts[scope], told, places))

    def of(self, index: int) -> dict[str, Any]:
        """Those of the object at ``index``: lists where a repeat draws several, with the values of all elements in their order, also where
        alternatives of a part share the name."""
        found: dict[str, list[tuple[tuple[int, ...], Any]]] = {}
        repeats: set[str] = set()
        for column in self._columns:
            rows = slice(column.start[index], column.start[index + 1])
            told = column.told[rows]
            if told and column.places is not None:
                repeats.add(column.name)
            if told:
                places = [()] * len(told) if column.places is None else column.places[rows]
                found.setdefault(column.name, []).extend(zip(places, told, strict=True))
        return {
            name: [value for _, value in sorted(several, key=itemgetter(0))] if name in repeats else several[0][1]
            for name, several in found.items()
        }
