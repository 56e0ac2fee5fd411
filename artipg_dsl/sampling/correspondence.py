"""Which elementary primitive of an object became which of its mutant: what details and labels are carried over by.

A primitive that both have is its own match. One in a new row of a repeat takes the nearest row that was there, on every
level: of ranks 0 .. n - 1, rank r takes min(r, n - 1). One in another template takes its counterpart by the slot of the
role that both are bound to: the k-th of the slot takes the k-th that was there, or the last. What is bound to no slot has
no match.
"""

from __future__ import annotations

import numpy as np

from ..graph.expr import Scope
from ..graph.program import Program, Site
from ..records import dataclass
from ..runtime.batch import Batch

SAME, REPLICA, SLOT, NONE = range(4)


@dataclass(frozen=True, slots=True, eq=False)
class Correspondence:
    """A row per elementary primitive of the objects after, sorted by object, then primitive definition, then row.

    ``object`` (K,) is the number after, ``source`` the one before; ``site`` the definition, ``rank`` the row among those of
    the definition in the object; ``before_site`` and ``before_rank`` those of the match, -1 where there is none; ``how``:
    0 the same, 1 a replica of a row that was there, 2 by slot, 3 none. ``position`` and ``before_position`` (K, 3) are the
    places of their frames at joint values 0, nan where there is none.
    """

    object: np.ndarray
    source: np.ndarray
    site: np.ndarray
    rank: np.ndarray
    before_site: np.ndarray
    before_rank: np.ndarray
    how: np.ndarray
    position: np.ndarray
    before_position: np.ndarray

    def arrays(self) -> dict[str, np.ndarray]:
        return {name: getattr(self, name) for name in self.__slots__}


def find_correspondence(before: Batch, after: Batch) -> Correspondence:
    """The table from a batch to what was made of it, object by object in the same order."""
    tables = before.sites(), after.sites()
    owners, columns = [], []
    slots = _Slots(before, after)
    for number, site in enumerate(after.program.sites):
        new = tables[1][number]
        row, exact = _nearest(before, after, site.scope)
        match = np.where(row >= 0, number, -1)
        how = np.where(row < 0, NONE, np.where(exact, SAME, REPLICA))
        for other, other_row in slots.of(number):
            free = (match < 0) & (other_row >= 0)
            match, row = np.where(free, other, match), np.where(free, other_row, row)
            how = np.where(free, SLOT, how)
        rank = np.full(len(row), -1)
        place = np.full((len(row), 3), np.nan)
        for other in np.unique(match[match >= 0]).tolist():
            mine = match == other
            rank[mine] = tables[0][other].rank[row[mine]]
            place[mine] = tables[0][other].translation[row[mine]]
        owners.append(new.owner)
        columns.append((np.full(len(row), number), new.rank, match, rank, how, new.translation, place))
    owner = np.concatenate(owners) if owners else np.zeros(0, dtype=np.int64)
    order = np.argsort(owner, kind="stable")
    joined = [np.concatenate(c)[order] for c in zip(*columns, strict=True)]
    owner = owner[order]
    sites, ranks, match, rank = (c.astype(np.int32) for c in joined[:4])
    return Correspondence(
        after.numbers[owner],
        before.numbers[owner],
        sites,
        ranks,
        match,
        rank,
        joined[4].astype(np.uint8),
        joined[5],
        joined[6],
    )


def _nearest(before: Batch, after: Batch, scope: Scope) -> tuple[np.ndarray, np.ndarray]:
    """For each row of a scope after, the nearest row before (-1: none), and whether it is the same."""
    if scope.parent is None:
        index = np.arange(len(after))
        return index, np.ones(len(index), dtype=bool)
    above, same = _nearest(before, after, scope.parent)
    new, old = after.rowmap.rows(scope), before.rowmap.rows(scope)
    parent = above[new.parent]
    count = np.append(old.count, 0)[parent]  # -1 reads the 0 at the end
    rank = np.minimum(new.rank, count - 1)
    row = np.where(count > 0, np.append(old.start, 0)[parent] + rank, -1)
    return row, same[new.parent] & (rank == new.rank) & (row >= 0)


def counterparts(program: Program) -> dict[int, list[int]]:
    """For each primitive that is bound to slots, those that stand for it in the other alternatives of its part, of the innermost slot
    first: the k-th that another binds to the slot, or the last."""
    found: dict[int, list[int]] = {}
    for number, groups in _members(program).items():
        for home, sites in sorted(groups, key=lambda group: -_depth(group[0])):
            branches: dict[Scope | None, list[int]] = {}
            for site in sites:
                branches.setdefault(_alternative(program, site, home), []).append(site)
            own = branches.pop(_alternative(program, number, home))
            others = (other[min(own.index(number), len(other) - 1)] for other in branches.values())
            found.setdefault(number, []).extend(others)
    return found


def _depth(scope: Scope) -> int:
    return sum(1 for _ in scope.ancestors())


class _Slots:
    """Primitives bound to the same slot of alternatives of one part."""

    def __init__(self, before: Batch, after: Batch):
        self.before, self.after = before, after
        self.members = _members(after.program)

    def of(self, number: int) -> list[tuple[int, np.ndarray]]:
        """Candidates for the rows of a primitive: (definition before, row before or -1 per row after)."""
        found = []
        for home, sites in self.members.get(number, ()):
            base, _ = _nearest(self.before, self.after, home)
            place = self._order(
                self.after,
                home,
                [
                    s
                    for s in sites
                    if _alternative(self.after.program, s, home) is _alternative(self.after.program, number, home)
                ],
                number,
            )
            up = self.after.rowmap.up(self.after.program.sites[number].scope, home)
            others: dict[Scope | None, list[int]] = {}
            for site in sites:
                branch = _alternative(self.after.program, site, home)
                if branch is not _alternative(self.after.program, number, home):
                    others.setdefault(branch, []).append(site)
            for group in others.values():
                found.extend(self._paired(home, group, base[up], place))
        return found

    def _order(self, batch: Batch, home: Scope, sites: list[int], number: int) -> np.ndarray:
        """The place of each row of a primitive among all that its slot binds, per row of the home table."""
        starts = np.zeros(batch.rowmap.rows(home).size, dtype=np.int64)
        for site in sites:
            up = batch.rowmap.up(batch.program.sites[site].scope, home)
            if site == number:
                first = np.searchsorted(up, up)
                return starts[up] + np.arange(len(up)) - first
            starts += np.bincount(up, minlength=len(starts))
        return starts

    def _paired(
        self, home: Scope, sites: list[int], base: np.ndarray, place: np.ndarray
    ) -> list[tuple[int, np.ndarray]]:
        """The k-th, or the last, of what the slot bound before in the row ``base`` of its home."""
        batch = self.before
        size = batch.rowmap.rows(home).size
        ups = [batch.rowmap.up(batch.program.sites[site].scope, home) for site in sites]
        counts = [np.append(np.bincount(up, minlength=size), 0) for up in ups]
        wanted = np.minimum(place, np.sum(counts, axis=0)[base] - 1)
        found, start = [], np.zeros(size + 1, dtype=np.int64)
        for site, up, count in zip(sites, ups, counts, strict=True):
            first = np.append(np.searchsorted(up, np.arange(size)), 0)
            inside = (base >= 0) & (wanted >= start[base]) & (wanted < (start + count)[base])
            found.append((site, np.where(inside, first[base] + wanted - start[base], -1)))
            start = start + count
        return found


def _alternative(program: Program, number: int, home: Scope) -> Scope | None:
    """The table under ``home`` that a primitive belongs to."""
    return next((s for s in program.sites[number].scope.ancestors() if s.parent is home), None)


def _members(program: Program) -> dict[int, list[tuple[Scope, list[int]]]]:
    """For each primitive the slots it is bound to: the table that all alternatives share, and the primitives of all."""
    groups: dict[tuple[str, str, Scope], list[int]] = {}
    for slot in program.slots:
        groups.setdefault((slot.path, slot.name, slot.scope), []).extend(
            number for number, site in enumerate(program.sites) if _under(program, site, slot.parts)
        )
    found: dict[int, list[tuple[Scope, list[int]]]] = {}
    for (_, _, home), sites in groups.items():
        for site in sites:
            found.setdefault(site, []).append((home, sites))
    return found


def _under(program: Program, site: Site, parts: tuple[int, ...]) -> bool:
    part = site.part
    while part >= 0:
        if part in parts:
            return True
        part = program.parts[part].parent
    return False
