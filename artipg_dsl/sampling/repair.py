"""The exception handler of Arti-PG: finds the parameters of an object that are in error, and changes them least.

In this order: every value is clipped into its conditional range, in the order of the draws; where the text says which
values should ``repair`` a requirement, those give way before others; then a search among the values that what failed
depends on (``sampling.search``). What it cannot put right is left to whoever asked, to be drawn again. Files of
parameters, mutants and samples that are not to be drawn again all go through here.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING

import numpy as np

from ..graph.depend import draws_behind, reads_across
from ..graph.expr import Expr
from ..graph.program import Draw
from ..graph.reference import definitions_of
from ..random import mix
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import Kept
from ..runtime.laws import is_listed
from ..runtime.needs import pose_cells
from ..runtime.repairs import Cause, Repairs, find_yielding
from ..validity.faults import find_faults
from ..validity.formulas import find_fallible, find_unsaid
from .clips import Asked, Blame, Clips, log_moved, read_clipped
from .known import evaluate_again, match_keys, rows_of_draw
from .search import AGAIN, Search, Spots, domain_ends, find_broken
from .statistics import Statistics

if TYPE_CHECKING:
    from .sample import Sampler

_GROUP = 64  # objects that are searched together
Solved = tuple[Batch, np.ndarray]  # a batch of objects put right, and their places among all


@dataclass(frozen=True, slots=True, eq=False)
class RepairOutcome:
    """Objects after a repair: those that ``failed`` (places in the batch) are as bad as they were."""

    batch: Batch
    failed: np.ndarray
    repairs: Repairs
    failing: dict[Cause, np.ndarray] = field(repr=False)  # the objects in which something was wrong to begin with


def repair(
    sampler: Sampler,
    batch: Batch,
    asked: Asked | None = None,
    *,
    statistics: Statistics | None = None,
    checked: bool = True,
    counted: bool = False,
    fixed: Iterable[int] = (),
) -> RepairOutcome:
    """The objects of a batch, each made valid by the least change.

    ``asked``: the values that they should have (default: those they have), which the batch has kept as far as they fit. Draws that
    are given, and those ``fixed``, are not moved on purpose.
    ``checked``: solids count, too. What happened is counted in ``statistics``, what fails at first unless it is ``counted``
    there already.
    """
    statistics = statistics if statistics is not None else Statistics()
    asked = Asked.all(batch) if asked is None else asked
    counts = Statistics() if counted else statistics
    failing = find_causes(batch, checked, counts)
    bad = np.zeros(len(batch), dtype=bool)
    for objects in failing.values():
        bad[objects] = True
    moved = read_clipped(batch, asked)
    counts.add(batch.state, True, bad | np.isin(np.arange(len(batch)), moved.owner))
    target = [_target(batch, k, values) for k, values in enumerate(asked.values)]
    handler = Handler(sampler, frozenset(fixed) | set(batch.state.given), checked)
    asides = handler.asides(moved, bad)
    solved: list[Solved] = []
    if bad.any() or asides:
        search = Search(
            sampler, batch, target, asked.stated, handler.sound if checked or find_fallible(sampler.program) else None
        )
        wanted = np.flatnonzero(bad)
        for start in range(0, len(wanted), _GROUP):
            solved += handler.solve(search, failing, wanted[start : start + _GROUP])
        for cause, objects in asides.items():
            objects = np.setdiff1d(objects, np.concatenate([np.zeros(0, dtype=np.int64), *(s[1] for s in solved)]))
            for start in range(0, len(objects), _GROUP):
                solved += handler.aside(search, moved, cause, objects[start : start + _GROUP])
    found = join_solved(batch, solved)
    still = bad.copy()
    for _, places in solved:
        still[places] = False
    blamed = {**failing, **{c: np.union1d(o, failing.get(c, o)) for c, o in asides.items()}}
    log = log_moved(batch, asked, found, Blame(handler.behind, blamed))
    found.repairs = log = log.without(still)
    tally(statistics, log, failing, still)
    return RepairOutcome(found, np.flatnonzero(still), log, failing)


@dataclass(frozen=True, slots=True, eq=False)
class Mended:
    """Objects that a repair has put right, and their ``places`` in the batch that they come from."""

    batch: Batch
    places: np.ndarray

    def within(self, batch: Batch) -> Batch:
        """They in the place of those of a batch."""
        found = join_solved(batch, [(self.batch, self.places)])
        log = self.batch.repairs
        found.repairs = replace(log, owner=self.places[log.owner])
        return found


def mend(
    sampler: Sampler,
    batch: Batch,
    objects: np.ndarray,
    statistics: Statistics,
    checked: bool,
    fixed: Iterable[int] = (),
) -> Mended:
    """What can be put right of some objects of a batch, whose failures have been counted; draws ``fixed`` do not move."""
    outcome = repair(
        sampler, evaluate_again(batch, objects), statistics=statistics, checked=checked, counted=True, fixed=fixed
    )
    good = np.setdiff1d(np.arange(len(objects)), outcome.failed)
    found = evaluate_again(outcome.batch, good)
    found.repairs = outcome.repairs.of(good)
    return Mended(found, objects[good])


def tally(statistics: Statistics, log: Repairs, failing: dict[Cause, np.ndarray], still: np.ndarray) -> None:
    """Count what was repaired; a value that was clipped in time is a failure that was repaired."""
    mended: dict[Cause, set[int]] = {
        cause: set(objects[~still[objects]].tolist()) for cause, objects in failing.items()
    }
    for owner, cause in zip(log.owner.tolist(), log.cause, strict=True):
        if owner not in mended.setdefault(cause, set()) and not (cause in failing and owner in failing[cause]):
            statistics.fail(cause, 1)
        mended[cause].add(owner)
    for cause, objects in mended.items():
        if objects:
            statistics.repaired[cause] = statistics.repaired.get(cause, 0) + len(objects)


def find_causes(batch: Batch, checked: bool, statistics: Statistics) -> dict[Cause, np.ndarray]:
    """What is wrong with objects, each with the places of those that have it; solids of those that meet the text alone."""
    found: dict[Cause, np.ndarray] = {cause: np.unique(owners) for cause, owners in find_broken(batch)}
    sound = np.flatnonzero(~batch.state.failed)
    if len(sound) and (checked or find_fallible(batch.program)):
        part = batch if len(sound) == len(batch) else evaluate_again(batch, sound)
        for cause, objects in (_solids(part) if checked else _silent(part)).items():
            found[cause] = sound[objects]
            statistics.fail(cause, len(objects))
    return found


def _silent(batch: Batch) -> dict[Cause, np.ndarray]:
    """Labels of objects that have no value, and of which."""
    return {("solid", fault.words): fault.objects for fault in find_unsaid(batch)}


def _solids(batch: Batch) -> dict[Cause, np.ndarray]:
    """What is wrong with the solids of objects, and with which."""
    found = find_faults(batch)
    struck = found.collisions
    named = found.tree.named(struck) if len(struck) else {}
    return {("collision", key): np.unique(struck.owner[rows]) for key, rows in named.items()} | {
        ("solid", fault.words): fault.objects for fault in found.others
    }


def _target(batch: Batch, number: int, asked: np.ndarray) -> np.ndarray:
    """What was asked, within the declared domain; what the evaluation drew where nothing was."""
    low, high = domain_ends(batch, number)
    drawn = batch.state.values[number]
    if batch.program.draws[number].kind == "choice":
        return drawn
    within = np.minimum(np.maximum(asked, low), high)
    if batch.program.draws[number].kind == "count":
        within = np.minimum(np.maximum(np.round(within), np.ceil(low)), np.floor(high))
    lost = np.isnan(asked)
    if is_listed(batch.program.draws[number].distribution):
        lost |= within != asked  # the ends of a domain need not be in the list
    return np.where(lost, drawn, within)


class Handler:
    """The stages, and what each cause depends on."""

    def __init__(self, sampler: Sampler, fixed: frozenset[int], checked: bool):
        self.sampler, self.program, self.fixed, self.checked = sampler, sampler.program, fixed, checked
        self._behind: dict[Cause, tuple[list[int], bool]] = {}

    def sound(self, batch: Batch) -> np.ndarray:
        """Which objects have their solids in order, of some that meet the requirements."""
        good = np.ones(len(batch), dtype=bool)
        for objects in (_solids(batch) if self.checked else _silent(batch)).values():
            good[objects] = False
        return good

    # ------------------------------------------------------------ where to look

    def behind(self, cause: Cause) -> list[int]:
        """The draws on which it depends whether something is wrong."""
        return self._known(cause)[0]

    def _known(self, cause: Cause) -> tuple[list[int], bool]:
        if cause not in self._behind:
            roots = self.roots(cause)
            draws = range(len(self.program.draws)) if roots is None else draws_behind(self.program, roots)
            self._behind[cause] = (
                [k for k in draws if k not in self.fixed],
                roots is None or reads_across(self.program, roots),
            )
        return self._behind[cause]

    def roots(self, cause: Cause) -> list[Expr] | None:
        """The expressions in question; None for all."""
        kind, about = cause
        program = self.program
        if kind == "requirement":
            requirement = program.requirements[about]
            tables = [s.count for s in requirement.scope.ancestors() if s.count is not None]
            return [requirement.condition, requirement.guard, *tables]
        if kind in ("draw", "domain", "absent"):
            draw = program.draws[about]
            ends = [e for e in (draw.low, draw.high, *draw.weights) if e is not None]
            return [
                *ends,
                *(e for b in draw.bounds for e in (b.value, b.guard)),
                *(limit.allowed for limit in draw.limits),
            ]
        if kind == "collision":
            links = {k for k, link in enumerate(program.links) if link.path in about[:2]}
            held = [s for s in program.sites if links & set(definitions_of(s.link))]
            sites = [e for s in held for e in (*s.parameters, *pose_cells(s.pose))]
            joints = [j for j in program.joints if j.path == about[2]]
            return sites + [e for j in joints for e in (*j.origin, *j.axis, j.low, j.high) if e is not None]
        return None

    def spots(self, batch: Batch, failing: dict[Cause, np.ndarray], objects: np.ndarray, hints: bool) -> Spots:
        """The rows behind what fails in some objects, or those that the text says should give way."""
        found: list[tuple[np.ndarray, np.ndarray | int, np.ndarray]] = []
        for cause, owners in failing.items():
            draws, sideways = self._known(cause)
            if hints:
                draws = [k for k in find_yielding(self.program, cause) if k not in self.fixed]
            some = np.intersect1d(owners, objects)
            rows = None
            if cause in batch.state.faults and not sideways:
                rows = np.unique(np.concatenate(batch.state.faults[cause]))
            for number in draws if len(some) else ():
                mine = self.beside(batch, cause, rows, self.program.draws[number])
                owner = batch.owner(self.program.draws[number].column.scope)
                row = np.flatnonzero(mine & np.isin(owner, some))
                found.append((owner[row], number, row))
        return Spots.of(found)

    def beside(self, batch: Batch, cause: Cause, rows: np.ndarray | None, draw: Draw) -> np.ndarray:
        """Which rows of a draw have to do with the rows at fault: those above, below or in the same row as these."""
        scope = draw.column.scope
        if rows is None:
            return np.ones(batch.rowmap.rows(scope).size, dtype=bool)
        own = (
            self.program.draws[cause[1]].column.scope
            if cause[0] == "draw"
            else self.program.requirements[cause[1]].scope
        )
        common = next(s for s in own.ancestors() if scope.within(s))
        marked = np.unique(batch.rowmap.up(own, common)[rows])
        return np.isin(batch.rowmap.up(scope, common), marked)

    # ------------------------------------------------------------ stages

    def solve(
        self, search: Search, failing: dict[Cause, np.ndarray], objects: np.ndarray, depth: int = 0
    ) -> list[Solved]:
        """Put objects right as far as that goes: by the hints, by one value alone, by several together."""
        found: list[Solved] = []
        left = objects
        hinted = self.spots(search.batch, failing, objects, hints=True)
        all_of = self.spots(search.batch, failing, objects, hints=False)
        better: Solved | None = None
        for spots, several in ((hinted, False), (all_of, False), (all_of, True)):
            here = spots.part(left)
            if not len(here.owner):
                continue
            moves = search.together(here) if several else search.alone(here)
            if not len(moves.place):
                continue
            judged = search.judged(moves)
            won, partly = search.best(moves, judged, only=False)
            if len(won):
                right = search.shrunk(moves.part(won), None)
                found.append((search.evaluated(right)[0], right.place))
                left = np.setdiff1d(left, right.place)
            if spots is all_of and not several:
                before = self.count(search.batch)
                some = partly[judged.faults[partly] < before[moves.place[partly]]]
                better = search.evaluated(moves.part(some))[0], moves.place[some]
        if better is None or depth >= AGAIN or not len(left):
            return found
        keep = np.isin(better[1], left)
        return found + self.onwards(search, better[0], np.flatnonzero(keep), better[1][keep], depth + 1)

    def onwards(self, search: Search, batch: Batch, some: np.ndarray, places: np.ndarray, depth: int) -> list[Solved]:
        """Search again from objects of which less is wrong than before."""
        if not len(some):
            return []
        nearer = evaluate_again(batch, some)
        target, stated = [], []
        for number in range(len(self.program.draws)):
            old, new = rows_of_draw(search.batch, number, places), rows_of_draw(nearer, number, np.arange(len(nearer)))
            here, there = match_keys(old.key, new.key)
            value = nearer.state.values[number].copy()
            kept = nearer.state.values[number][new.row[there]]
            moved = np.abs(kept - search.batch.state.values[number][old.row[here]]) > 0.0
            value[new.row[there]] = np.where(moved, kept, search.target[number][old.row[here]])
            target.append(value)
            known = np.zeros(len(value), dtype=bool)
            known[new.row[there]] = search.stated[number][old.row[here]]
            stated.append(known)
        failing = {cause: np.unique(owners) for cause, owners in find_broken(nearer)}
        inner = Search(self.sampler, nearer, target, stated, search.sound)
        return [(b, places[p]) for b, p in self.solve(inner, failing, np.arange(len(nearer)), depth)]

    def count(self, batch: Batch) -> np.ndarray:
        """How many rows are at fault, per object."""
        found = np.zeros(len(batch))
        for _, owners in find_broken(batch):
            found += np.bincount(owners, minlength=len(batch))
        return found

    # ------------------------------------------------------------ hints where clipping would do

    def asides(self, moved: Clips, bad: np.ndarray) -> dict[Cause, np.ndarray]:
        """Objects in which a value has been clipped by a requirement that names others to give way."""
        found: dict[Cause, set[int]] = {}
        for owner, draw, cause in zip(moved.owner.tolist(), moved.draw.tolist(), moved.why, strict=True):
            if not bad[owner] and cause is not None and cause[0] == "requirement":
                hints = set(self.program.requirements[cause[1]].repair) - self.fixed
                if hints and draw not in hints:
                    found.setdefault(cause, set()).add(owner)
        return {cause: np.array(sorted(owners)) for cause, owners in found.items()}

    def aside(self, search: Search, moved: Clips, cause: Cause, objects: np.ndarray) -> list[Solved]:
        """Let what a requirement names give way, so that what it has clipped can stay."""
        spots = self.spots(search.batch, {cause: objects}, objects, hints=True)
        if not len(spots.owner):
            return []
        free = np.array([why != cause for why in moved.why], dtype=bool)
        allowed = Spots.of(
            [(spots.owner, spots.draw, spots.row), (moved.owner[free], moved.draw[free], moved.row[free])]
        )
        moves = search.alone(spots)
        if not len(moves.place):
            return []
        won, _ = search.best(moves, search.judged(moves, allowed), only=True)
        if not len(won):
            return []
        right = search.shrunk(moves.part(won), allowed)
        return [(search.evaluated(right)[0], right.place)]


def join_solved(batch: Batch, solved: Sequence[Solved]) -> Batch:
    """The objects of a batch, some of them replaced by what they have become."""
    if not solved:
        return batch
    rest = np.setdiff1d(np.arange(len(batch)), np.concatenate([places for _, places in solved]))
    values = []
    for number, draw in enumerate(batch.program.draws):
        keys, held = [], []
        for part, places in [*solved, (None, rest)]:
            if part is None:
                at = rows_of_draw(batch, number, rest)
                keys.append(mix(batch.rowmap.rows(draw.column.scope).address[at.row], rest[at.owner]))
                held.append(batch.state.values[number][at.row])
            else:
                rows = part.rowmap.rows(draw.column.scope)
                keys.append(mix(rows.address, places[rows.owner]))
                held.append(part.state.values[number])
        key, value = np.concatenate(keys), np.concatenate(held)
        order = np.argsort(key, kind="stable")
        still = np.zeros(len(key))
        values.append(Kept(key[order], value[order], still, still.astype(bool)))
    return evaluate_again(batch, np.arange(len(batch)), values=values)
