"""What the parts of a category cost: primitives, convex pieces, pairs of pieces, and the time it takes to make them.

Work of the check goes with the pieces, with the pairs that it tells apart, and where the text says ``require stable`` with the pairs
of primitives whose common volume may have to be measured; the other stages with primitives.
"""

from __future__ import annotations

import time
from collections.abc import Iterable

import numpy as np

from ..geometry.pieces import amounts, build
from ..geometry.sites import SiteTable
from ..records import dataclass
from ..runtime.batch import Batch
from ..validity.mass import weighing

_TOO_MANY = 1500  # pieces of a part in one object
_TOO_TIGHT = 150_000  # pairs of its pieces with those on other links: the check of an object takes a second
_TOO_CROWDED = 10_000  # pairs of its primitives with others that they may overlap, where these are weighed


@dataclass(frozen=True, slots=True)
class Cost:
    """Of a part, per object: primitives, convex pieces, pairs of its pieces with those on other links, and seconds to make
    the pieces (0.0 where they are counted alone); pairs of its primitives with others of the same body that come before them, whose
    boxes overlap (none where nothing is weighed, or where they are too few for a warning and no times are asked for)."""

    part: str
    primitives: float
    pieces: float
    pairs: float
    seconds: float
    shared: float


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
    shared, start = _shared(batch, tables, timed), 0
    for table, pieces in zip(tables, held, strict=True):
        own = shared[start : start + len(table)].sum()
        start += len(table)
        others = in_object[table.owner] - in_link[first[table.owner] + table.link]
        part = batch.program.parts[batch.program.sites[table.number].part].path
        sums = found.setdefault(part, [0.0] * 5)
        new = len(table), pieces.sum(), (pieces * others).sum(), _making(table) if timed else 0.0, own
        for place, value in enumerate(new):
            sums[place] += float(value) / len(batch)
    return sorted((Cost(part, *sums) for part, sums in found.items()), key=lambda cost: (-cost.pieces, cost.part))


def find_heavy(found: Iterable[Cost]) -> list[Cost]:
    """The parts of too many pieces, or too many pairs of them or of primitives that overlap."""
    most = _TOO_MANY, _TOO_TIGHT, _TOO_CROWDED
    return [
        cost for cost in found if any(a > b for a, b in zip((cost.pieces, cost.pairs, cost.shared), most, strict=True))
    ]


def _links(batch: Batch) -> tuple[np.ndarray, int]:
    """The row of each object's first link (B,), and how many links there are in all."""
    owner = batch.links().owner
    return np.searchsorted(owner, np.arange(len(batch))), len(owner)


def _shared(batch: Batch, tables: list[SiteTable], every: bool) -> np.ndarray:
    """For each row of the tables of primitives, one table after the other, with how many it may share volume that is weighed once.
    Unless ``every`` is set, they are counted where those of a part with all of an object could be too many: that takes long."""
    count = sum(map(len, tables))
    own: dict[str, int] = {}
    for table in tables:
        part = batch.program.parts[batch.program.sites[table.number].part].path
        own[part] = own.get(part, 0) + len(table)
    in_all = sum(np.bincount(table.owner, minlength=len(batch)) for table in tables)
    most = max(own.values(), default=0) / len(batch) * np.max(in_all, initial=0)
    if not batch.program.stable or not count or not (every or most > _TOO_CROWDED):
        return np.zeros(count)
    known = weighing(batch)
    return np.bincount(known.place[known.touching.pairs.row], minlength=count)


def _making(table: SiteTable) -> float:
    """Seconds to make the pieces of a table; what is found once per primitive is found before."""
    build(table.primitive, table.params)
    begun = time.process_time()
    build(table.primitive, table.params)
    return time.process_time() - begun
