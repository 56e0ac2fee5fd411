"""Objects given by their values: what is not said is drawn, and what does not fit is moved as little as possible."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError, UserError
from ..graph import expr as E
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept, State
from ..runtime.repairs import Repairs
from .clips import Asked, Blame, log_moved
from .known import evaluate_again, make_batch, rows_of_draw
from .repair import Handler, RepairOutcome, find_causes, join_solved, repair
from .sample import Sampler
from .statistics import Exhausted, Statistics

if TYPE_CHECKING:
    from ..graph.program import Draw
    from ..graph.scopes import Column

_TRIALS = 25  # attempts where a repair finds nothing
_DRAWN = 5  # of these, so many draw what is not given alone; then what failed gives way, at last everything
_EVERYTHING = 15
_CHECKED = 256  # objects at a time


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """``records``: for each object, its values by the index of their draw: one, or one per row in the order of the rows;
    nan for one that is to be drawn.

    ``plain`` is what the file said, as a manifest keeps it.
    """

    records: tuple[Mapping[int, tuple[float, ...]], ...]
    plain: tuple[Mapping[str, Any], ...]

    def batch(self, sampler: Sampler, numbers: np.ndarray, seed: int, statistics: Statistics, checked: bool) -> Batch:
        """The objects of the given numbers, which index the records, repaired. Raises Exhausted, UsageError, UserError."""
        if numbers.max(initial=0) >= len(self.records):
            raise UsageError(f"there is no object {numbers.max()}: {len(self.records)} are given, numbered from 0")
        trial = self.tried(sampler, numbers, seed, np.zeros(len(numbers), dtype=np.int64))
        asked = self.asked(trial)
        found = repair(sampler, trial, asked, statistics=statistics, checked=checked)
        return self.redrawn(sampler, trial, asked, found, statistics, checked) if len(found.failed) else found.batch

    def check(self, sampler: Sampler, numbers: np.ndarray, seed: int) -> None:
        """Find values of what objects do not have before any object is made. Raises UserError."""
        for first in range(0, len(numbers), _CHECKED):
            some = numbers[first : first + _CHECKED]
            self.tried(sampler, some, seed, np.zeros(len(some), dtype=np.int64))

    def redrawn(
        self, sampler: Sampler, trial: Batch, asked: Asked, found: RepairOutcome, statistics: Statistics, checked: bool
    ) -> Batch:
        """Objects that a repair could not put right: more and more of their values are drawn again."""
        handler = Handler(sampler, frozenset(), checked)
        behind: dict[int, set[int]] = {n: set() for n in found.failed.tolist()}
        for cause, objects in found.failing.items():
            for place in objects.tolist():
                if place in behind:
                    behind[place].update(handler.behind(cause))
        left, solved = found.failed, []
        for attempt in range(1, _TRIALS):
            released = [
                set()
                if attempt <= _DRAWN
                else behind[p]
                if attempt <= _EVERYTHING
                else set(range(len(sampler.program.draws)))
                for p in left.tolist()
            ]
            trying = self.tried(sampler, trial.numbers[left], trial.seed, np.full(len(left), attempt), released)
            bad = np.zeros(len(left), dtype=bool)
            for objects in find_causes(trying, checked, statistics).values():
                bad[objects] = True
            statistics.add(trying.state, False, bad)
            good = np.flatnonzero(~bad)
            if len(good):
                solved.append((evaluate_again(trying, good), left[good]))
            left = left[bad]
            if not len(left):
                break
        else:
            raise Exhausted(trial.numbers[left], statistics, _TRIALS)
        whole = join_solved(found.batch, solved)
        drawn = np.zeros(len(whole), dtype=bool)
        drawn[found.failed] = True
        more = log_moved(trial, asked, whole, Blame(handler.behind, found.failing), drawn).without(~drawn)
        whole.repairs = Repairs.joined([found.repairs, more])
        return whole

    def asked(self, batch: Batch) -> Asked:
        """The values given for the rows of a batch, and what was drawn where none is."""
        values, stated = [], []
        for number in range(len(batch.program.draws)):
            value, said = self.given(batch, number)
            rows = rows_of_draw(batch, number, np.arange(len(batch))).row
            asked, known = batch.state.values[number].copy(), np.zeros(len(batch.state.values[number]), dtype=bool)
            asked[rows[said]], known[rows[said]] = value[said], True
            values.append(asked)
            stated.append(known)
        return Asked(values, stated)

    def tried(
        self,
        sampler: Sampler,
        numbers: np.ndarray,
        seed: int,
        attempt: np.ndarray,
        released: Sequence[set[int]] | None = None,
    ) -> Batch:
        """One attempt, without the values of the draws that are ``released`` for each object.

        How many rows there are follows from the values of the tables above: those are known first.
        """
        kept: dict[int, Kept] = {}
        known = -1
        while True:
            batch = make_batch(sampler.program, sampler.plan, State(seed, numbers, attempt, kept=kept))
            if sum(len(k.address) for k in kept.values()) == known:
                break
            known = sum(len(k.address) for k in kept.values())
            kept = {
                k: found
                for k in range(len(sampler.program.draws))
                if (found := self.keep_given(batch, k, released)) is not None
            }
        moved = self.refuse(batch)
        if released is None:
            self.refuse_absent(batch, moved)
        return batch

    def keep_given(self, batch: Batch, number: int, released: Sequence[set[int]] | None) -> Kept | None:
        """The values given of a draw, for the rows that there are."""
        rows = rows_of_draw(batch, number, np.arange(len(batch)))
        value, said = self.given(batch, number)
        said &= ~np.isnan(value)
        if released is not None:
            said &= ~np.array([number in r for r in released], dtype=bool)[rows.owner]
        if not said.any():
            return None
        order = np.argsort(rows.key[said], kind="stable")
        still = np.zeros(len(order))
        return Kept(rows.key[said][order], value[said][order], still, still.astype(bool))

    def given(self, batch: Batch, number: int) -> tuple[np.ndarray, np.ndarray]:
        """The value given for each row of a draw, object by object, and whether there is one."""
        owner, place, _ = _listed(batch, number)
        value, said = np.zeros(len(owner)), np.zeros(len(owner), dtype=bool)
        ends = np.searchsorted(owner, np.arange(len(batch) + 1))
        for first, last, name in zip(ends[:-1].tolist(), ends[1:].tolist(), batch.numbers.tolist(), strict=True):
            values = self.records[name].get(number)
            if values is None or first == last:
                continue
            if len(values) == 1:  # one for all
                value[first:last], said[first:last] = values[0], True
            else:  # one each, as far as they go
                there = place[first:last] < len(values)
                value[first:last] = np.asarray(values)[np.where(there, place[first:last], 0)]
                said[first:last] = there
        return value, said

    def refuse(self, batch: Batch) -> np.ndarray:
        """Lists must have a value for each row, where the choices and counts that make the rows stand as they were given: where they do
        not (B,)."""
        moved = np.zeros(len(batch), dtype=bool)
        for number, draw in enumerate(batch.program.draws):
            if draw.kind != "real":
                value, said = self.given(batch, number)
                rows = rows_of_draw(batch, number, np.arange(len(batch)))
                apart = said & ~(value == batch.state.values[number][rows.row])
                moved[rows.owner[apart]] = True
        for number, draw in enumerate(batch.program.draws):
            count = _listed(batch, number)[2]
            for place, name in enumerate(batch.numbers.tolist()):
                given = self.records[name].get(number)
                if given is not None and count[place] and len(given) not in (1, count[place]) and not moved[place]:
                    raise UserError(
                        f"object {name} gives {len(given)} values of `{draw.column.name}`, but has {count[place]}",
                        "give one value for all, or one for each",
                    )
        return moved

    def refuse_absent(self, batch: Batch, moved: np.ndarray) -> None:
        """A value must belong to something that the object has, unless what decides about that was ``moved`` (B,)."""
        draws = batch.program.draws
        there: dict[str, np.ndarray] = {}
        for number, draw in enumerate(draws):
            own = np.bincount(rows_of_draw(batch, number, np.arange(len(batch))).owner, minlength=len(batch)) > 0
            there[draw.column.name] = there.get(draw.column.name, np.zeros(len(batch), dtype=bool)) | own
        for place, number in enumerate(batch.numbers.tolist()):
            for k, values in self.records[number].items() if not moved[place] else ():
                name = draws[k].column.name
                if there[name][place] or np.isnan(values).all():
                    continue
                drawn = batch.drawn(place)
                names = (column.name for d in draws if d.column.name == name for column in _deciding(d))
                deciding = [other for other in sorted(set(names)) if other in drawn]
                others = ", ".join(f"{other}={drawn[other]}" for other in deciding)
                left = [f"`{other}`" for other in deciding if other not in self.plain[number]]
                raise UserError(
                    f"object {number} gives `{name}`, which no object has with {others or 'its other values'}",
                    f"give {' and '.join(left)}, too: without a value it is drawn"
                    if left
                    else "leave it out, or change what it goes with",
                )


def _deciding(draw: Draw) -> list[Column]:
    """What decides whether the rows of a draw are there."""
    counts = (scope.count for scope in draw.column.scope.ancestors())
    return [leaf for count in counts if count is not None for leaf in E.leaves(count)]


def _listed(batch: Batch, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the rows of a draw stand in the list that ``Batch.drawn`` gives of its name: owner and place of each row.

    Alternatives of a part may share the name: their rows make one list in the order of the elements. ``count`` (B,) is how
    long the list of each object is.
    """
    draws = batch.program.draws
    mine = rows_of_draw(batch, number, np.arange(len(batch))).owner
    shared = [k for k, draw in enumerate(draws) if draw.column.name == draws[number].column.name]
    ranks = {k: [rank for _, rank in batch.rowmap.ranks(draws[k].column.scope)] for k in shared}
    depth = max(len(found) for found in ranks.values())
    if len(shared) == 1 or depth == 0:
        count = np.bincount(mine, minlength=len(batch))
        return mine, np.arange(len(mine)) - (np.cumsum(count) - count)[mine], count
    owners = {k: batch.owner(draws[k].column.scope) for k in shared}
    owner = np.concatenate(list(owners.values()))
    source = np.concatenate([np.full(len(found), k) for k, found in owners.items()])
    levels = [
        np.concatenate([ranks[k][level] if level < len(ranks[k]) else np.full(len(owners[k]), -1) for k in shared])
        for level in range(depth)
    ]
    order = np.lexsort((source, *reversed(levels), owner))
    count = np.bincount(owner, minlength=len(batch))
    place = np.empty(len(owner), dtype=np.int64)
    place[order] = np.arange(len(owner)) - (np.cumsum(count) - count)[owner[order]]
    return mine, place[source == number], count
