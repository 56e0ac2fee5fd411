"""Sampling: first attempts of all objects, further attempts of those that fail, until all are valid."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ..graph.feasible import conflicts
from ..graph.program import Program
from ..runtime.batch import Batch
from ..runtime.kernels import State, preferred
from ..runtime.needs import narrowing, wanted
from ..runtime.plan import Plan, make_plan
from ..runtime.repairs import Cause, Repairs
from ..validity.sound import prove
from .prior import BLOCK, Resampling

if TYPE_CHECKING:
    from .repair import Mended

ATTEMPTS = 100
COLLIDING = 25  # attempts that end in a collision, until it is the program's fault
GROUP = 32  # objects that try again together


@dataclass(slots=True)
class Statistics:
    """How often what failed: ``missed`` draws without room and ``broken`` requirements, in objects, over all attempts.

    ``collided`` counts objects per pair of links, by path, and the joint that makes them meet ("" at rest); ``unsound``
    those whose solids are at fault otherwise, by what is wrong. ``outside`` counts values that were asked for out of their
    domain, per draw; ``repaired`` how many of all these failures were put right, by cause.
    ``examples`` tell of what ``collided`` counts the parts that meet, where and when, in the first object seen.
    ``declined`` are valid objects that preferences passed over, ``unkept`` objects per preference, over all attempts.
    ``candidates``: how many attempts each object considered, where they were resampled; ``candidates_valid`` of all of
    them, ``effective`` the effective number of candidates, summed over the objects.
    """

    objects: int = 0
    first_valid: int = 0
    attempts: int = 0
    missed: dict[int, int] = field(default_factory=dict)
    broken: dict[int, int] = field(default_factory=dict)
    collided: dict[tuple[str, str, str], int] = field(default_factory=dict)
    unsound: dict[str, int] = field(default_factory=dict)
    declined: int = 0
    unkept: dict[int, int] = field(default_factory=dict)
    candidates: int = 0
    candidates_valid: int = 0
    effective: float = 0.0
    outside: dict[int, int] = field(default_factory=dict)
    repaired: dict[Cause, int] = field(default_factory=dict)
    examples: dict[tuple[str, str, str], str] = field(default_factory=dict)

    def _tables(self) -> dict[str, dict[Any, int]]:
        return {
            "requirement": self.broken, "domain": self.outside, "draw": self.missed, "collision": self.collided, "solid": self.unsound
        }  # fmt: skip

    def fail(self, cause: Cause, count: int) -> None:
        """Count what failed in so many objects."""
        table = self._tables()[cause[0]]
        table[cause[1]] = table.get(cause[1], 0) + count

    def failures(self) -> dict[Cause, int]:
        """In how many attempts what failed, by cause."""
        return {(kind, about): count for kind, table in self._tables().items() for about, count in table.items()}

    def add(self, state: State, first: bool, bad: np.ndarray | None = None) -> None:
        """Count one attempt of some objects; ``bad`` says which of them failed, where that is more than the state knows."""
        self.attempts += len(state.objects)
        if first:
            self.objects += len(state.objects)
            self.first_valid += int((~(state.failed if bad is None else bad)).sum())
        for total, new in ((self.missed, state.missed), (self.broken, state.broken), (self.unkept, state.unkept)):
            _sum(total, new)

    def take(self, other: Statistics) -> None:
        """Add what was counted elsewhere."""
        self.objects += other.objects
        self.first_valid += other.first_valid
        self.attempts += other.attempts
        self.declined += other.declined
        self.candidates = max(self.candidates, other.candidates)
        self.candidates_valid += other.candidates_valid
        self.effective += other.effective
        for total, new in zip(self._tables().values(), other._tables().values(), strict=True):
            _sum(total, new)
        _sum(self.unkept, other.unkept)
        _sum(self.repaired, other.repaired)
        self.examples = other.examples | self.examples


def _sum(total: dict[Any, int], new: Mapping[Any, int]) -> None:
    for key, value in new.items():
        total[key] = total.get(key, 0) + value


class Exhausted(Exception):
    """Objects for which none of ``attempts`` was valid; ``statistics`` says what failed how often."""

    def __init__(self, numbers: np.ndarray, statistics: Statistics, attempts: int, hopeless: bool = False):
        super().__init__(f"no valid object after {attempts} attempts for {len(numbers)} objects")
        self.numbers, self.statistics, self.attempts = numbers, statistics, attempts
        self.hopeless = hopeless  # the values given leave nothing, whatever else is drawn


@lru_cache(maxsize=8)
def planned(program: Program) -> Sampler:
    """The sampler of a program that came from another process: one for all batches of it."""
    return Sampler(program)


def revived(program: Program, state: State, numbers: np.ndarray, history: tuple[Any, ...], repairs: Repairs) -> Batch:
    """A batch from what it was evaluated with; the same to the bit."""
    plan = planned(program).plan
    tables, values = plan.function(state)
    batch = Batch(program, plan, state, tables, values, numbers)
    batch.history, batch.repairs = history, repairs
    return batch


class Sampler:
    """A program ready to be sampled: planned once, evaluated for any object numbers."""

    def __init__(self, program: Program, plan: Plan | None = None):
        self.program = program
        self.plan = plan or make_plan(program, wanted(program))

    def __reduce__(self) -> tuple[Callable[[Program], Sampler], tuple[Program]]:
        """To another process goes the program, which is planned anew there."""
        return planned, (self.program,)

    @cached_property
    def lean(self) -> Plan:
        """Draws and requirements alone, with what narrows each draw: for trying values out."""
        return make_plan(self.program, narrowing(self.program))

    def batch(
        self, numbers: np.ndarray, seed: int, *, given: dict[int, float] | None = None, defaults: bool = False,
        statistics: Statistics | None = None, checked: bool = False, candidates: int = 0, mend: bool = False,
    ) -> Batch:  # fmt: skip
        """The objects of the given numbers; each is the same whatever else is in the batch. Raises Exhausted.

        ``checked``: only objects whose links do not penetrate one another, at rest and while each joint moves.
        ``candidates``: above 0, each object is one of so many attempts, resampled to the declared distributions.
        ``mend``: what fails is repaired, and drawn again only where that cannot be.
        """
        numbers = np.asarray(numbers, dtype=np.int64)
        trials = _Trials(
            self, seed, dict(given or {}), defaults, checked, statistics if statistics is not None else Statistics()
        )
        if candidates and not defaults:
            return trials.resampled(numbers, candidates)
        attempt = np.zeros(len(numbers), dtype=np.int64)
        bad, batch = trials.run(numbers, attempt, True)
        if not bad.any():
            return batch
        mended = trials.mended(batch, bad) if mend else None
        failed = np.flatnonzero(bad)
        if bad.all() and hopeless(self.program, trials.given):
            raise Exhausted(numbers, trials.statistics, 1, hopeless=True)
        for start in range(0, len(failed), GROUP):  # the first ones tell soon whether it is any use
            group = failed[start : start + GROUP]
            while len(group):
                attempt[group] += 1
                lost = (attempt[group] >= ATTEMPTS) | (trials.colliding(numbers[group]) >= COLLIDING)
                spare = np.array([trials.spare.get(n, -1) for n in numbers[group].tolist()])
                attempt[group[lost & (spare >= 0)]] = spare[lost & (spare >= 0)]  # rather than none
                group, lost = group[~lost | (spare < 0)], lost[~lost | (spare < 0)]
                if lost.any() or defaults:
                    without = group[lost] if lost.any() else group
                    raise Exhausted(numbers[without], trials.statistics, int(attempt[without].max()))
                group = group[trials.run(numbers[group], attempt[group], False)[0]]
        made = trials.made(numbers, attempt)[1]
        return made if mended is None else mended.within(made)


def hopeless(program: Program, given: dict[int, float]) -> bool:
    """Whether the values given leave no valid object at all, whatever else is drawn."""
    fixed = {k: float(v) for k, v in given.items() if np.ndim(v) == 0}
    return bool(fixed) and any(conflict.certain for conflict in conflicts(program, fixed))


class _Trials:
    """Attempts at objects, and how many of each one's ended in a collision."""

    def __init__(
        self,
        sampler: Sampler,
        seed: int,
        given: dict[int, float],
        defaults: bool,
        checked: bool,
        statistics: Statistics,
    ):
        self.sampler, self.seed, self.given, self.defaults = sampler, seed, given, defaults
        self.checked, self.statistics = checked, statistics
        self.hits: dict[int, int] = {}
        self.spare: dict[int, int] = {}  # the first valid attempt of objects that preferences passed over

    def colliding(self, numbers: np.ndarray) -> np.ndarray:
        return np.array([self.hits.get(n, 0) for n in numbers.tolist()], dtype=np.int64)

    def made(self, numbers: np.ndarray, attempt: np.ndarray) -> tuple[State, Batch]:
        state = State(self.seed, numbers, attempt.copy(), dict(self.given), self.defaults)
        tables, values = self.sampler.plan.function(state)
        return state, Batch(self.sampler.program, self.sampler.plan, state, tables, values)

    def run(self, numbers: np.ndarray, attempt: np.ndarray, first: bool) -> tuple[np.ndarray, Batch]:
        """One attempt each: which objects it fails, and the batch it makes."""
        state, batch = self.made(numbers, attempt)
        bad = state.failed.copy()
        sound = np.flatnonzero(~bad)
        if self.checked and len(sound):
            within = batch if len(sound) == len(numbers) else self.made(numbers[sound], attempt[sound])[1]
            struck = colliding(within, self.statistics)
            bad[sound[struck]] = True
            for number in within.numbers[struck].tolist():
                self.hits[number] = self.hits.get(number, 0) + 1
        self.statistics.add(state, first, bad)
        declined = np.zeros(len(bad), dtype=bool) if self.defaults else ~bad & ~preferred(state)
        self.statistics.declined += int(declined.sum())
        for number, tried in zip(numbers[declined].tolist(), attempt[declined].tolist(), strict=True):
            self.spare.setdefault(number, tried)
        return bad | declined, batch

    def mended(self, batch: Batch, bad: np.ndarray) -> Mended:
        """The objects of first attempts that a repair puts right; they are no longer ``bad``."""
        from .repair import mended  # late: the repair evaluates samplers

        declined = np.isin(batch.numbers, np.array(list(self.spare), dtype=np.int64))
        found = mended(self.sampler, batch, np.flatnonzero(bad & ~declined), self.statistics, self.checked)
        bad[found.places] = False
        return found

    def resampled(self, numbers: np.ndarray, candidates: int) -> Batch:
        """Objects that are each one of several attempts. Raises Exhausted."""
        struck = (lambda batch: colliding(batch, self.statistics)) if self.checked else None
        attempt = np.zeros(len(numbers), dtype=np.int64)
        for start in range(0, len(numbers), max(1, BLOCK // candidates)):
            part = slice(start, start + max(1, BLOCK // candidates))
            choice = Resampling(
                self.sampler.plan, self.seed, self.given, candidates, lambda n, a: self.made(n, a)[1], struck
            )
            attempt[part] = choice.attempts(numbers[part])
            self.statistics.candidates = candidates
            self.statistics.candidates_valid += choice.valid
            self.statistics.effective += choice.effective
            for state in choice.states:
                self.statistics.add(state, False)
            first = choice.states[0]
            self.statistics.objects += len(numbers[part])
            self.statistics.first_valid += int((~first.failed[::candidates]).sum())
            lost = numbers[part][attempt[part] < 0]
            if len(lost):
                raise Exhausted(
                    lost, self.statistics, len(choice.states) * candidates, hopeless(self.sampler.program, self.given)
                )
        return self.made(numbers, attempt)[1]


def colliding(batch: Batch, statistics: Statistics) -> np.ndarray:
    """Indices of the objects of a batch whose solids are at fault: that collide, tip over, ...; counted."""
    from ..validity.contact import contact, in_words  # late: only who asks for it pays for it
    from ..validity.faults import faults

    if batch.program.foreign:
        prove(batch)
    found = faults(batch)
    struck = found.collisions
    for key, rows in found.tree.named(struck).items() if len(struck) else ():
        if key not in statistics.examples:
            met = contact(found.tree, found.body, struck, int(rows[0]))
            kinds = (joint.kind for joint in batch.program.joints if joint.path == key[2])
            statistics.examples[key] = "" if met is None else in_words(next(kinds, ""), met)
        statistics.collided[key] = statistics.collided.get(key, 0) + len(np.unique(struck.owner[rows]))
    for fault in found.others:
        statistics.unsound[fault.words] = statistics.unsound.get(fault.words, 0) + len(fault.objects)
    return found.objects()
