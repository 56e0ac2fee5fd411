"""What the parts of a category cost: primitives, convex pieces, pairs of pieces, and the time it takes to make them.

Work of the check goes with the pieces and with the pairs that it tells apart; the other stages with primitives.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..geometry.pieces import amounts, build
from ..geometry.sites import SiteTable
from ..runtime.batch import Batch

_TOO_MANY = 1500  # pieces of a part in one object
_TOO_TIGHT = 150_000  # pairs of its pieces with those on other links: the check of an object takes a second


@dataclass(frozen=True, slots=True)
class Cost:
    """Of a part, per object: primitives, convex pieces, pairs of its pieces with those on other links, and seconds to make
    the pieces (0.0 where they are counted alone)."""

    part: str
    primitives: float
    pieces: float
    pairs: float
    seconds: float


def measure_costs(batch: Batch, *, timed: bool = False) -> list[Cost]:
    """Of each part of a batch, those of most pieces first. ``timed``: the pieces are made, too."""
    tables = [table for table in batch.sites() if len(table)]
    held = [amounts(table.primitive, table.params) for table in tables]
    first, links = _links(batch)
    in_link, in_object = np.zeros(links), np.zeros(len(batch))
    for table, pieces in zip(tables, held, strict=True):
        np.add.at(in_link, first[table.owner] + table.link, pieces)
        np.add.at(in_object, table.owner, pieces)
    found: dict[str, list[float]] = {}
    for table, pieces in zip(tables, held, strict=True):
        others = in_object[table.owner] - in_link[first[table.owner] + table.link]
        part = batch.program.parts[batch.program.sites[table.number].part].path
        sums = found.setdefault(part, [0.0, 0.0, 0.0, 0.0])
        new = len(table), pieces.sum(), (pieces * others).sum(), _making(table) if timed else 0.0
        for place, value in enumerate(new):
            sums[place] += float(value) / len(batch)
    return sorted((Cost(part, *sums) for part, sums in found.items()), key=lambda cost: (-cost.pieces, cost.part))


def find_heavy(found: Iterable[Cost]) -> list[Cost]:
    """The parts of too many pieces, or too many pairs of them."""
    return [cost for cost in found if cost.pieces > _TOO_MANY or cost.pairs > _TOO_TIGHT]


def _links(batch: Batch) -> tuple[np.ndarray, int]:
    """The row of each object's first link (B,), and how many links there are in all."""
    owner = batch.links().owner
    return np.searchsorted(owner, np.arange(len(batch))), len(owner)


def _making(table: SiteTable) -> float:
    """Seconds to make the pieces of a table; what is found once per primitive is found before."""
    build(table.primitive, table.params)
    begun = time.process_time()
    build(table.primitive, table.params)
    return time.process_time() - begun
