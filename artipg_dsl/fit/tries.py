"""What is tried instead of what was found: every other value of each choice and count, in copies for which new parts are drawn."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields

import numpy as np

from ..geometry.runs import runs
from ..random import mix
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.laws import TOLERANCE
from ..sampling.search import domain_ends
from .focus import differing
from .model import Changes, Model
from .ruled import Ruled
from .search import best_of

_BLOCK = 96  # copies at a time
_RARE = 1e-4  # a weight of what the text does not have
_COUNTED = 8  # a count changes by as much at a time, at most


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
    told = alternatives(model, batch)
    order = np.argsort(told.copy, kind="stable")
    told = Changes(*(getattr(told, field.name)[order] for field in fields(Changes)))
    before, unseen = model.structures(batch), _unseen(model, batch, told, first)
    hidden, odds = _Hidden.of(told, unseen, len(batch)), odds_of(batch, told)
    shown = np.flatnonzero(unseen <= 0)
    twins = _twins(model, batch)
    shown, partner = _beside(model, batch, told, shown, odds, twins, first)
    turn = np.repeat(np.arange(len(shown)) - np.searchsorted(told.copy[shown], told.copy[shown]), lanes)
    at, lane, partner = np.repeat(shown, lanes), np.tile(np.arange(lanes), len(shown)), np.repeat(partner, lanes)
    step = max(1, _BLOCK // lanes) * lanes
    for start in range(0, len(at), step):
        part = slice(start, start + step)
        of, draw, row = told.copy[at[part]], told.draw[at[part]], told.row[at[part]]
        other = np.flatnonzero(lane[part] > 0)
        copy, more = hidden.others(other, of, turn[part])
        paired = np.flatnonzero(partner[part] >= 0)
        asked = [_taken(told, at[part], np.arange(len(of))), _taken(told, more, copy)]
        asked += [_taken(told, partner[part][paired], paired), *_alike(twins, of, draw)]
        alike = np.isin(draw, list(twins)) if twins else None
        tried = model.altered(batch, of, _joined(asked), lane=lane[part] + first, alike=alike)
        good = ~tried.state.failed & differing(batch, tried, of).anywhere(len(of))
        good &= model.structures(tried) != before[of]
        base = other - lane[part][other]
        good[other] &= ~good[base] | differing(tried, model.assembled([(tried, other)]), base).anywhere(len(other))
        kept = np.flatnonzero(good)
        kept = np.sort(kept[best_of(model.fingerprints(tried)[kept], of[kept], np.zeros(len(kept)), len(kept))])
        if len(kept):
            yield Tries(
                model.assembled([(tried, kept)]),
                of[kept],
                draw[kept],
                row[kept],
                told.value[at[part]][kept],
                odds[at[part]][kept],
            )


def _taken(told: Changes, at: np.ndarray, copy: np.ndarray) -> Changes:
    """Some changes of candidates, each made in a ``copy`` (n,)."""
    return Changes(copy, told.draw[at], told.row[at], told.value[at])


def _joined(several: list[Changes]) -> Changes:
    return Changes(*(np.concatenate([getattr(one, field.name) for one in several]) for field in fields(Changes)))


def _twins(model: Model, batch: Batch) -> dict[int, Changes]:
    """By the number of a choice that rules others: the changes of all rows that have a twin to this."""
    found = {}
    for one in model.ruled:
        none = np.zeros(0, dtype=np.int64)
        told = [Changes(none, none, none, np.zeros(0))]
        for number, twin in one.twins:
            value = twin[batch.state.values[number].astype(np.int64)]
            row = np.flatnonzero(value >= 0)
            owner = batch.owner(model.program.draws[number].column.scope)[row]
            told.append(Changes(owner, np.full(len(row), number), row, value[row].astype(np.float64)))
        found[one.ruling] = _joined(told)
    return found


def _alike(twins: dict[int, Changes], of: np.ndarray, draw: np.ndarray) -> list[Changes]:
    """The changes to twins in copies made ``of`` candidates, in which a ``draw`` (K,) is changed."""
    found = []
    for ruling, changes in twins.items():
        copies = np.flatnonzero(draw == ruling)
        copy, at = np.nonzero(of[copies][:, None] == changes.copy)
        found.append(_taken(changes, at, copies[copy]))
    return found


def _beside(
    model: Model, batch: Batch, told: Changes, shown: np.ndarray, odds: np.ndarray, twins: dict[int, Changes], lane: int
) -> tuple[np.ndarray, np.ndarray]:
    """The changes that are tried, by candidate, of those ``shown`` (n,); and beside which other one each is made, -1 for none. What rules
    others is tried with each other value of each choice that twins do not share as well: handles of two kinds are no likelier than of one
    while that is the kind of the rest. A rarer value is not tried if nothing shows such a choice any longer: it would only hide it."""
    first, second = [shown], [np.full(len(shown), -1)]
    for one in model.ruled:
        changes, apart = twins[one.ruling], np.isin(told.draw[shown], one.apart)
        leading = shown[(told.draw[shown] == one.ruling) & np.isin(told.copy[shown], changes.copy)]
        lost = leading[(odds[leading] < 0.0) & _hides(model, batch, told, leading, shown[apart], one, twins, lane)]
        first[0], second[0] = (column[~np.isin(first[0], lost)] for column in (first[0], second[0]))
        leading, others = np.setdiff1d(leading, lost), shown[apart]
        number, other = np.nonzero(told.copy[leading][:, None] == told.copy[others])
        first.append(leading[number])
        second.append(others[other])
    every, partner = np.concatenate(first), np.concatenate(second)
    order = np.argsort(told.copy[every], kind="stable")
    return every[order], partner[order]


def _hides(
    model: Model,
    batch: Batch,
    told: Changes,
    leading: np.ndarray,
    shown: np.ndarray,
    one: Ruled,
    twins: dict[int, Changes],
    lane: int,
) -> np.ndarray:
    """(n,) bool of changes ``leading`` (n,) of a choice that rules: whether they hide one of the choices that the changes ``shown`` are of."""
    of = told.copy[leading]
    if not len(of):
        return np.zeros(0, dtype=bool)
    changes = [_taken(told, leading, np.arange(len(of))), *_alike(twins, of, told.draw[leading])]
    alike, lanes = np.ones(len(of), dtype=bool), np.full(len(of), lane)
    made = model.altered(batch, of, _joined(changes), lane=lanes, alike=alike)
    others = alternatives(model, made, one.apart)
    many, idle = len(model.program.draws), _unseen(model, made, others, lane) > 0
    named = others.copy * many + others.draw
    still = np.setdiff1d(named, named[idle])  # a value may show by what it rules out, so each has to
    copy, at = np.nonzero(of[:, None] == told.copy[shown])
    return np.bincount(copy, ~np.isin(copy * many + told.draw[shown[at]], still), minlength=len(of)) > 0


def _unseen(model: Model, batch: Batch, told: Changes, lane: int) -> np.ndarray:
    """(n,) for changes of one row each: 1 where nothing shows one, -1 where it cannot be, 0 where something does."""
    found = [np.zeros(0, dtype=np.int64)]
    for start in range(0, len(told.copy), _BLOCK):
        of, draw, row, value = (getattr(told, field.name)[start : start + _BLOCK] for field in fields(Changes))
        tried = model.altered(batch, of, Changes(np.arange(len(of)), draw, row, value), lane=np.full(len(of), lane))
        same = ~differing(batch, tried, of).anywhere(len(of))
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
    def of(told: Changes, unseen: np.ndarray, size: int) -> _Hidden:
        """``unseen`` (n,) as ``_unseen`` has it for changes ``told`` (n,), which are sorted by their candidates, ``size`` in all."""
        rows = np.stack([told.copy, told.draw, told.row])
        first = np.flatnonzero((np.diff(rows, axis=1, prepend=-1) != 0).any(axis=0))
        many = np.diff(np.append(first, len(told.copy)))
        alike = np.minimum.reduceat(unseen, first) > 0 if len(first) else np.zeros(0, dtype=bool)
        first, many = first[alike], many[alike]
        count = np.bincount(told.copy[first], minlength=size)
        return _Hidden(first, many, np.cumsum(count) - count, count)

    def others(self, some: np.ndarray, of: np.ndarray, turn: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """For ``some`` of the copies made ``of`` candidates, each in its ``turn``: copies, and the changes that give them other values of all
        rows that nothing shows."""
        many = self.count[of[some]]
        row, copy = runs(self.begin[of[some]], many), np.repeat(some, many)
        return copy, self.first[row] + turn[copy] % self.many[row]


def odds_of(batch: Batch, told: Changes) -> np.ndarray:
    """(n,) by how much the text has the values of some changes more often than those that their rows have, in natural logarithms."""
    found = np.zeros(len(told.draw))
    for number in np.unique(told.draw).tolist():
        draw, mine = batch.program.draws[number], np.flatnonzero(told.draw == number)
        row, scope = told.row[mine], draw.column.scope
        if draw.kind == "choice":
            weights = np.stack(batch.read(draw.weights, scope), axis=1)[row]
            values = np.broadcast_to(np.arange(weights.shape[1]), weights.shape)
        elif draw.distribution in ("values", "weighted"):
            values = np.stack(batch.read(draw.arguments, scope), axis=1)[row]
            weights = np.ones(values.shape)
            if draw.distribution == "weighted":
                values, weights = np.split(values, 2, axis=1)
        else:
            continue
        now, then = (
            np.where(np.abs(values - one[:, None]) < TOLERANCE, weights, 0.0).sum(axis=1)
            for one in (batch.state.values[number][row], told.value[mine])
        )
        found[mine] = np.log(np.maximum(then, _RARE)) - np.log(np.maximum(now, _RARE))
    return found


def alternatives(model: Model, batch: Batch, numbers: Iterable[int] | None = None) -> Changes:
    """Every other value that one discrete row of a candidate can have, or one of the draws of some ``numbers``."""
    found: list[list[np.ndarray]] = [[], [], [], []]
    for number in (*model.discrete, *model.ruling) if numbers is None else numbers:
        draw = model.program.draws[number]
        owner, old = batch.owner(draw.column.scope), batch.state.values[number]
        if draw.kind == "choice":
            possible = [float(k) for k, weight in enumerate(draw.weights) if weight.constant != 0.0]
            options = np.broadcast_to(possible, (len(old), len(possible)))
        elif draw.kind == "count":
            low, high = domain_ends(batch, number)
            steps = np.arange(1.0, 1.0 + np.minimum(high - low, _COUNTED).max(initial=0.0))
            options = old[:, None] + np.concatenate([-steps, steps])
        else:
            options = np.stack(batch.read(draw.arguments, draw.column.scope), axis=1)
        rows, which = np.nonzero(np.abs(options - old[:, None]) > 1e-9)
        told = owner[rows], np.full(len(rows), number), rows, options[rows, which]
        for column, one in zip(found, told, strict=True):
            column.append(one)
    copy, draws, row, value = (np.concatenate([np.zeros(0, dtype=np.int64), *column]) for column in found)
    return Changes(copy, draws.astype(np.int64), row.astype(np.int64), value)
