"""What is tried instead of what was found: every other value of each choice and count, in copies for which new parts are drawn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ..geometry.runs import runs
from ..random import mix
from ..records import dataclass
from ..runtime.batch import Batch
from .alternatives import alternatives, odds_of
from .focus import differing
from .model import Changes, Model
from .ruled import Ruled
from .search import best_of

_BLOCK = 96  # copies at a time


@dataclass(frozen=True, slots=True, eq=False)
class Tries:
    """Copies of candidates ``of`` which (K,), each with another ``value`` (K,) in one ``row`` (K,) of a ``draw`` (K,); ``odds`` (K,): by how
    much the text has it more often than the old one, in natural logarithms."""

    batch: Batch
    of: np.ndarray
    draw: np.ndarray
    row: np.ndarray
    value: np.ndarray
    odds: np.ndarray

    def places(self, *, each: bool) -> np.ndarray:
        """(K,) uint64 that are the same for those of which the likeliest is kept: the values of one row, or ``each`` value by itself."""
        rows = mix(self.draw.astype(np.uint64), self.row)
        return mix(rows, self.value.view(np.uint64)) if each else rows


def tries(model: Model, batch: Batch, lanes: int, first: int) -> Iterator[Tries]:
    """Every other value of each choice and count of candidates, with ``lanes`` draws of what is new, numbered from ``first``; some at a time.
    Those that change no surface are left out, and those that cannot be. In all lanes but the first, the choices and counts that nothing
    shows have other values as well: a handle would never be found that is on the other side than one that is not there was thought to be."""
    options = _Options.of(model, batch, first)
    changes, before = options.changes, model.structures(batch)
    unseen = _unseen(model, batch, changes, first)
    hidden = _Hidden.of(changes, unseen, len(batch))
    shown, partner = options.beside(np.flatnonzero(unseen <= 0))
    of = changes.copy[shown]
    turn = np.repeat(np.arange(len(shown)) - np.searchsorted(of, of), lanes)
    at, lane, partner = np.repeat(shown, lanes), np.tile(np.arange(lanes), len(shown)), np.repeat(partner, lanes)
    step = max(1, _BLOCK // lanes) * lanes
    for start in range(0, len(at), step):
        part = slice(start, start + step)
        one = changes.take(at[part])
        of = one.copy
        other = np.flatnonzero(lane[part] > 0)
        copy, more = hidden.others(other, of, turn[part])
        paired = np.flatnonzero(partner[part] >= 0)
        asked = [changes.take(at[part], np.arange(len(of))), changes.take(more, copy)]
        asked += [changes.take(partner[part][paired], paired), *options.alike(one)]
        alike = np.isin(one.draw, list(options.twins)) if options.twins else None
        tried = model.altered(batch, of, Changes.joined(asked), lane=lane[part] + first, alike=alike)
        good = ~tried.state.failed & differing(batch, tried, of).anywhere(len(of))
        good &= model.structures(tried) != before[of]
        base = other - lane[part][other]
        good[other] &= ~good[base] | differing(tried, model.assembled([(tried, other)]), base).anywhere(len(other))
        kept = np.flatnonzero(good)
        kept = np.sort(kept[best_of(model.fingerprints(tried)[kept], of[kept], np.zeros(len(kept)), len(kept))])
        if len(kept):
            one = one.take(kept)
            found = model.assembled([(tried, kept)])
            yield Tries(found, one.copy, one.draw, one.row, one.value, options.odds[at[part]][kept])


@dataclass(frozen=True, slots=True, eq=False)
class _Options:
    """What can be tried on a ``batch`` of candidates: ``changes`` (n,) of one row each, sorted by candidate, and their ``odds`` (n,). New parts
    are drawn in ``lane``. ``twins``: by the number of a choice that rules others, the changes of all rows that have a twin to this."""

    model: Model
    batch: Batch
    changes: Changes
    odds: np.ndarray
    twins: Mapping[int, Changes]
    lane: int

    @staticmethod
    def of(model: Model, batch: Batch, lane: int) -> _Options:
        changes = alternatives(model, batch)
        changes = changes.take(np.argsort(changes.copy, kind="stable"))
        twins = {one.ruling: _to_twins(model, batch, one) for one in model.ruled}
        return _Options(model, batch, changes, odds_of(batch, changes), twins, lane)

    def alike(self, changes: Changes) -> list[Changes]:
        """What else changes in copies that have one of the ``changes`` each: if that is of a choice that rules others, these to their twins."""
        found = []
        for ruling, theirs in self.twins.items():
            copies = np.flatnonzero(changes.draw == ruling)
            copy, at = np.nonzero(changes.copy[copies][:, None] == theirs.copy)
            found.append(theirs.take(at, copies[copy]))
        return found

    def beside(self, shown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The changes that are tried, by candidate, of those ``shown`` (n,); and beside which other one each is made, -1 for none. What rules
        others is tried with each other value of each choice that twins do not share as well: handles of two kinds are no likelier than of one
        while that is the kind of the rest. A rarer value is not tried if nothing shows such a choice any longer: it would only hide it."""
        draw, of = self.changes.draw, self.changes.copy
        first, second = [shown], [np.full(len(shown), -1)]
        for one in self.model.ruled:
            others = shown[np.isin(draw[shown], one.apart)]
            leading = shown[(draw[shown] == one.ruling) & np.isin(of[shown], self.twins[one.ruling].copy)]
            lost = leading[(self.odds[leading] < 0.0) & self.hides(leading, others, one)]
            first[0], second[0] = (column[~np.isin(first[0], lost)] for column in (first[0], second[0]))
            leading = np.setdiff1d(leading, lost)
            number, other = np.nonzero(of[leading][:, None] == of[others])
            first.append(leading[number])
            second.append(others[other])
        every, partner = np.concatenate(first), np.concatenate(second)
        order = np.argsort(of[every], kind="stable")
        return every[order], partner[order]

    def hides(self, leading: np.ndarray, others: np.ndarray, ruled: Ruled) -> np.ndarray:
        """(n,) bool of changes ``leading`` (n,) of a choice that rules: whether they hide a choice that one of the changes ``others`` is of."""
        if not len(leading):
            return np.zeros(0, dtype=bool)
        model, one, other = self.model, self.changes.take(leading), self.changes.take(others)
        many, of = len(model.program.draws), one.copy
        asked = Changes.joined([self.changes.take(leading, np.arange(len(of))), *self.alike(one)])
        made = model.altered(
            self.batch, of, asked, lane=np.full(len(of), self.lane), alike=np.ones(len(of), dtype=bool)
        )
        left = alternatives(model, made, ruled.apart)
        named = left.copy * many + left.draw
        idle = _unseen(model, made, left, self.lane) > 0
        still = np.setdiff1d(named, named[idle])  # a value may show by what it rules out, so each has to
        copy, at = np.nonzero(of[:, None] == other.copy)
        return np.bincount(copy, ~np.isin(copy * many + other.draw[at], still), minlength=len(of)) > 0


def _to_twins(model: Model, batch: Batch, ruled: Ruled) -> Changes:
    """The changes of all rows that have a twin to this."""
    none = np.zeros(0, dtype=np.int64)
    found = [Changes(none, none, none, np.zeros(0))]
    for number, twin in ruled.twins:
        value = twin[batch.state.values[number].astype(np.int64)]
        row = np.flatnonzero(value >= 0)
        owner = batch.owner(model.program.draws[number].column.scope)[row]
        found.append(Changes(owner, np.full(len(row), number), row, value[row].astype(np.float64)))
    return Changes.joined(found)


def _unseen(model: Model, batch: Batch, changes: Changes, lane: int) -> np.ndarray:
    """(n,) for changes of one row each: 1 where nothing shows one, -1 where it cannot be, 0 where something does."""
    found = [np.zeros(0, dtype=np.int64)]
    for start in range(0, len(changes.copy), _BLOCK):
        at = np.arange(start, min(start + _BLOCK, len(changes.copy)))
        copy, of = np.arange(len(at)), changes.copy[at]
        tried = model.altered(batch, of, changes.take(at, copy), lane=np.full(len(at), lane))
        same = ~differing(batch, tried, of).anywhere(len(at))
        found.append(np.where(tried.state.failed, -1, same.astype(np.int64)))
    return np.concatenate(found)


@dataclass(frozen=True, slots=True, eq=False)
class _Hidden:
    """Rows that nothing shows: of the other values that each can have, which stand one after the other among all changes, the ``first`` and how
    ``many``; those of each candidate from ``begin`` (K,) on, ``count`` (K,)."""

    first: np.ndarray
    many: np.ndarray
    begin: np.ndarray
    count: np.ndarray

    @staticmethod
    def of(changes: Changes, unseen: np.ndarray, size: int) -> _Hidden:
        """``unseen`` (n,) as ``_unseen`` has it for ``changes`` (n,), which are sorted by their candidates, ``size`` in all."""
        rows = np.stack([changes.copy, changes.draw, changes.row])
        first = np.flatnonzero((np.diff(rows, axis=1, prepend=-1) != 0).any(axis=0))
        many = np.diff(np.append(first, len(changes.copy)))
        alike = np.minimum.reduceat(unseen, first) > 0 if len(first) else np.zeros(0, dtype=bool)
        first, many = first[alike], many[alike]
        count = np.bincount(changes.copy[first], minlength=size)
        return _Hidden(first, many, np.cumsum(count) - count, count)

    def others(self, some: np.ndarray, of: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For ``some`` of the copies made ``of`` candidates, each in its ``turn``: copies, and the changes that give them other values of all
        rows that nothing shows."""
        many = self.count[of[some]]
        row, copy = runs(self.begin[of[some]], many), np.repeat(some, many)
        return copy, self.first[row] + turn[copy] % self.many[row]
