"""The choices and counts of an object as facts have them: a list for a repeat, in which each element has its place."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..graph.expr import Scope
from ..runtime.batch import Batch
from ..runtime.draws import to_plain

Place = tuple[list[Any], int]  # a list, and where in it


def choices_of(batch: Batch, index: int, numbers: Iterable[int]) -> dict[str, Any]:
    """Those draws of the object at ``index``, of some ``numbers``, that are choices or counts, by their names."""
    found: dict[str, tuple[list[Any], dict[tuple[int, ...], Place]]] = {}
    for number in sorted(numbers):
        draw = batch.program.draws[number]
        scope, name = draw.column.scope, draw.column.name
        rows = np.flatnonzero(batch.owner(scope) == index)
        if draw.kind == "real" or not len(rows):
            continue
        if name not in found:  # alternatives that share the name lie in the same repeats
            found[name] = _places(batch, index, scope)
        _, places = found[name]
        for row, rank in zip(rows.tolist(), _ranks(batch, scope, rows), strict=True):
            several, at = places[rank]
            several[at] = to_plain(draw, batch.state.values[number][row])
    return {name: whole[0] for name, (whole, _) in found.items()}


def _places(batch: Batch, index: int, scope: Scope) -> tuple[list[Any], dict[tuple[int, ...], Place]]:
    """A list of what an object has, of nothing so far; and the places of elements in it, by their ranks."""
    whole: list[Any] = [None]
    places: dict[tuple[int, ...], Place] = {(): (whole, 0)}
    for repeat in reversed([one for one in scope.ancestors() if one.kind == "repeat"]):
        assert repeat.parent is not None
        above, count = np.flatnonzero(batch.owner(repeat.parent) == index), batch.rowmap.rows(repeat).count
        for rank, many in zip(_ranks(batch, repeat.parent, above), count[above].tolist(), strict=True):
            several, at = places[rank]
            several[at] = [None] * many
            places |= {(*rank, k): (several[at], k) for k in range(many)}
    return whole, places


def _ranks(batch: Batch, scope: Scope, rows: np.ndarray) -> list[tuple[int, ...]]:
    """The ranks of the repeats above some rows, outermost first."""
    ranks = [rank[rows].tolist() for _, rank in batch.rowmap.ranks(scope)]
    return list(zip(*ranks, strict=True)) if ranks else [()] * len(rows)
