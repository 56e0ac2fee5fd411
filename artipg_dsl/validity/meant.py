"""What statements about parts mean in the rows where they are said: which parts, and which of two sides belong together.

A statement stands in a table: that of the category, of a `when`, of the elements of a repeat. It speaks of the parts of
each of its rows; of what lies around those, or in none of them, it speaks wherever it has a row at all.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import fields

import numpy as np

from ..geometry.runs import runs
from ..graph.expr import Scope
from ..graph.program import Allowed, Clear, Program
from ..records import dataclass
from ..runtime.batch import Batch

_NONE = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Meant:
    """Parts of one side of a statement: ``row`` (k,) of the table of parts, ``group`` (k, R) the elements of the R repeats that it
    stands in, the innermost first; -1 where it is said of the part in all elements. ``value`` (k,): of what is given for the rows of
    the statement, the greatest of those in which it is said of the part."""

    row: np.ndarray
    group: np.ndarray
    value: np.ndarray


def find_meant(
    batch: Batch,
    statement: Allowed | Clear,
    nodes: Sequence[int],
    ranks: Sequence[tuple[str, int]],
    values: np.ndarray | None = None,
) -> Meant:
    """The parts that one side of a statement names, where it is said; ``values`` (rows of its scope,), by default noughts."""
    scope = statement.scope
    repeats = [s for s in scope.ancestors() if s.kind == "repeat"]
    values = np.zeros(batch.rowmap.rows(scope).size) if values is None else values
    found = [_of(batch, scope, repeats, node, ranks, values) for node in nodes]
    found.append(
        Meant(_NONE, _NONE.reshape(0, len(repeats)), np.zeros(0))
    )  # a compiled program may name no part at all
    return Meant(*(np.concatenate([getattr(one, f.name) for one in found]) for f in fields(Meant)))


def same_elements(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Which pairs of parts (k,) a statement speaks of, by the elements (k, R) that they are meant in."""
    return np.logical_and.reduce((first == second) | (first < 0) | (second < 0), axis=1)


def _of(
    batch: Batch,
    scope: Scope,
    repeats: Sequence[Scope],
    node: int,
    ranks: Sequence[tuple[str, int]],
    values: np.ndarray,
) -> Meant:
    rowmap, part = batch.rowmap, batch.program.parts[node]
    common = next(s for s in scope.ancestors() if part.scope.within(s))
    of, row = rowmap.up(scope, common), rowmap.up(part.scope, common)
    said, most = np.zeros(rowmap.rows(common).size, dtype=bool), np.full(rowmap.rows(common).size, -np.inf)
    said[of] = True
    np.maximum.at(most, of, values)
    group = np.full((len(row), len(repeats)), -1)
    for column, repeat in enumerate(repeats):
        if part.scope.within(repeat):
            group[:, column] = rowmap.up(part.scope, repeat)
    keep = np.flatnonzero(said[row] & _elements(batch, part.scope, ranks))
    return Meant(batch.part_rows(node)[keep], group[keep], most[row[keep]])


def _elements(batch: Batch, scope: Scope, ranks: Sequence[tuple[str, int]]) -> np.ndarray:
    """Which rows of a scope lie in the elements (name of a repeat, rank; -1 for the last) that are meant."""
    keep = np.ones(batch.rowmap.rows(scope).size, dtype=bool)
    for repeat in scope.ancestors():
        for name, rank in ranks:
            if repeat.kind == "repeat" and repeat.name == name:
                rows = batch.rowmap.rows(repeat)
                at = batch.rowmap.up(scope, repeat)
                wanted = rows.count[rows.parent[at]] - 1 if rank < 0 else rank
                keep &= rows.rank[at] == wanted
    return keep


def _pair_parts(owner: np.ndarray, first: Meant, second: Meant) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the table of parts, of the objects ``owner``, that one another side of a statement are: all of the first with
    all of the second, of one element with those of the same."""
    mine, theirs = owner[first.row], owner[second.row]
    order = np.argsort(theirs, kind="stable")
    start = np.searchsorted(theirs[order], mine)
    count = np.searchsorted(theirs[order], mine, side="right") - start
    i, j = np.repeat(np.arange(len(mine)), count), order[runs(start, count)]
    together = same_elements(first.group[i], second.group[j])
    return first.row[i[together]], second.row[j[together]]


def find_allowed(batch: Batch, kinds: Collection[str]) -> np.ndarray:
    """Pairs (k, 2) of rows of the table of links that ``allow`` statements of these kinds name in each object, the lower first."""
    asked = [said for said in batch.program.allowed if said.kind in kinds]
    if not asked:  # the table of parts is long
        return np.zeros((0, 2), dtype=np.int64)
    parts = batch.parts()
    link = np.searchsorted(batch.links().owner, np.arange(len(batch)))[parts.owner] + parts.link
    found = []
    for said in asked:
        sides = (find_meant(batch, said, *side) for side in zip((said.first, said.second), said.ranks, strict=True))
        found.append(np.stack([link[row] for row in _pair_parts(parts.owner, *sides)], axis=1))
    return np.unique(np.sort(np.concatenate(found), axis=1), axis=0)


def sites_of(batch: Batch, row: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each table of primitives, its rows that lie in parts ``row`` of the table of parts: (row of the table, index into ``row``)."""
    program: Program = batch.program
    place = np.full(batch.part_count, -1)
    place[row] = np.arange(len(row))
    found = []
    for site in program.sites:
        at, index = site.part, np.full(batch.rowmap.rows(site.scope).size, -1)
        while at >= 0:
            own = place[batch.part_rows(at)[batch.rowmap.up(site.scope, program.parts[at].scope)]]
            index = np.where(index < 0, own, index)
            at = program.parts[at].parent
        found.append((np.flatnonzero(index >= 0), index[index >= 0]))
    return found
