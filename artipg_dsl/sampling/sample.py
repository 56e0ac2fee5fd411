"""Sampling: first attempts of all objects, further attempts of those that fail, until all are valid."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from ..geometry.runs import distinct
from ..graph.feasible import find_conflicts
from ..graph.program import Program
from ..runtime.batch import Batch, full_plan
from ..runtime.kernels import State, preferred
from ..runtime.needs import find_wanted
from ..runtime.plan import Plan, make_plan
from ..validity.contact import contact_in_words, describe_contact
from ..validity.faults import find_faults
from ..validity.formulas import find_fallible, find_unsaid
from ..validity.sound import prove
from .known import make_batch
from .prior import BLOCK, Resampling
from .repair import Mended, mend
from .statistics import ATTEMPTS, Exhausted, Statistics

_COLLIDING = 25  # attempts that end in a collision, until it is the program's fault
_FRUITLESS = 50  # such attempts of all objects together, where no object has been valid yet
_GROUP = 32  # objects that try again together


@lru_cache(maxsize=8)
def _planned(program: Program) -> Sampler:
    """The sampler of a program that came from another process: one for all batches of it."""
    return Sampler(program, full_plan(program))


class Sampler:
    """A program ready to be sampled: planned once, evaluated for any object numbers."""

    def __init__(self, program: Program, plan: Plan | None = None):
        self.program = program
        self.plan = plan or make_plan(program, find_wanted(program))

    def __reduce__(self) -> tuple[Callable[[Program], Sampler], tuple[Program]]:
        """To another process goes the program, which is planned anew there."""
        return _planned, (self.program,)

    def batch(
        self,
        numbers: np.ndarray,
        seed: int,
        *,
        given: dict[int, float] | None = None,
        defaults: bool = False,
        statistics: Statistics | None = None,
        checked: bool = False,
        candidates: int = 0,
        mend: bool = False,
        progress: Callable[[int, int], None] | None = None,
    ) -> Batch:
        """The objects of the given numbers; each is the same whatever else is in the batch. Raises Exhausted.

        ``checked``: only objects whose links do not penetrate one another, at rest and while each joint moves.
        ``candidates``: above 0, each object is one of so many attempts, resampled to the declared distributions.
        ``mend``: what fails is repaired, and drawn again only where that cannot be.
        ``progress(done, total)`` is called as first attempts have been checked.
        """
        numbers = np.asarray(numbers, dtype=np.int64)
        trials = _Trials(
            self, seed, dict(given or {}), defaults, checked, statistics if statistics is not None else Statistics()
        )
        trials.progress = progress
        if candidates and not defaults:
            return trials.resampled(numbers, candidates)
        attempt = np.zeros(len(numbers), dtype=np.int64)
        bad, batch = trials.run(numbers, attempt, True)
        trials.progress = None
        if not bad.any():
            return batch
        mended = trials.mended(batch, bad) if mend else None
        failed = np.flatnonzero(bad)
        if bad.all() and _hopeless(self.program, trials.given):
            raise Exhausted(numbers, trials.statistics, 1, hopeless=True)
        for start in range(0, len(failed), _GROUP):  # the first ones tell soon whether it is any use
            group = failed[start : start + _GROUP]
            while len(group):
                attempt[group] += 1
                lost = (attempt[group] >= ATTEMPTS) | (trials.colliding(numbers[group]) >= _COLLIDING)
                lost |= trials.fruitless
                spare = np.array([trials.spare.get(n, -1) for n in numbers[group].tolist()])
                attempt[group[lost & (spare >= 0)]] = spare[lost & (spare >= 0)]  # rather than none
                group, lost = group[~lost | (spare < 0)], lost[~lost | (spare < 0)]
                if lost.any() or defaults:
                    without = group[lost] if lost.any() else group
                    raise Exhausted(numbers[without], trials.statistics, int(attempt[without].max()))
                group = group[trials.run(numbers[group], attempt[group], False)[0]]
        delivered = trials.made(numbers, attempt)[1]
        return delivered if mended is None else mended.within(delivered)

    def count_valid(self, numbers: np.ndarray, seed: int, given: dict[int, float], checked: bool) -> int:
        """How many of the first attempts at some objects are valid."""
        trials = _Trials(self, seed, given, False, checked, Statistics())
        return int((~trials.run(numbers, np.zeros(len(numbers), dtype=np.int64), True)[0]).sum())


def _hopeless(program: Program, given: dict[int, float]) -> bool:
    """Whether the values given leave no valid object at all, whatever else is drawn."""
    fixed = {k: float(v) for k, v in given.items() if np.ndim(v) == 0}
    return bool(fixed) and any(conflict.certain for conflict in find_conflicts(program, fixed))


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
        self.progress: Callable[[int, int], None] | None = None
        self.hits: dict[int, int] = {}
        self.valid = False  # whether any attempt was
        self.spare: dict[int, int] = {}  # the first valid attempt of objects that preferences passed over

    def colliding(self, numbers: np.ndarray) -> np.ndarray:
        return np.array([self.hits.get(n, 0) for n in numbers.tolist()], dtype=np.int64)

    @property
    def fruitless(self) -> bool:
        return not self.valid and sum(self.hits.values()) >= _FRUITLESS

    def made(self, numbers: np.ndarray, attempt: np.ndarray) -> tuple[State, Batch]:
        state = State(self.seed, numbers, attempt.copy(), dict(self.given), self.defaults)
        return state, make_batch(self.sampler.program, self.sampler.plan, state)

    def run(self, numbers: np.ndarray, attempt: np.ndarray, first: bool) -> tuple[np.ndarray, Batch]:
        """One attempt each: which objects it fails, and the batch it makes."""
        state, batch = self.made(numbers, attempt)
        bad = state.failed.copy()
        sound = np.flatnonzero(~bad)
        if is_examined(self.sampler.program, self.checked) and len(sound):
            struck = sound[self.faulty(numbers[sound], attempt[sound], batch)]
            bad[struck] = True
            for number in numbers[struck].tolist():
                self.hits[number] = self.hits.get(number, 0) + 1
        self.statistics.add(state, first, bad)
        self.valid |= not bad.all()
        declined = np.zeros(len(bad), dtype=bool) if self.defaults else ~bad & ~preferred(state)
        self.statistics.declined += int(declined.sum())
        for number, tried in zip(numbers[declined].tolist(), attempt[declined].tolist(), strict=True):
            self.spare.setdefault(number, tried)
        return bad | declined, batch

    def faulty(self, numbers: np.ndarray, attempt: np.ndarray, batch: Batch) -> np.ndarray:
        """Places of the objects at fault beyond the requirements; ``batch`` holds all of them, or more."""
        size = len(numbers) if self.progress is None else _GROUP
        found = []
        for start in range(0, len(numbers), size):
            part = slice(start, start + size)
            whole = len(batch) == len(numbers[part])
            within = batch if whole else self.made(numbers[part], attempt[part])[1]
            found.append(start + find_faulty(within, self.statistics, self.checked))
            if self.progress is not None:
                self.progress(min(start + size, len(numbers)), len(numbers))
        return np.concatenate(found)

    def mended(self, batch: Batch, bad: np.ndarray) -> Mended:
        """The objects of first attempts that a repair puts right; they are no longer ``bad``."""
        declined = np.isin(batch.numbers, np.array(list(self.spare), dtype=np.int64))
        found = mend(self.sampler, batch, np.flatnonzero(bad & ~declined), self.statistics, self.checked)
        bad[found.places] = False
        return found

    def resampled(self, numbers: np.ndarray, candidates: int) -> Batch:
        """Objects that are each one of several attempts. Raises Exhausted."""
        struck = None
        if is_examined(self.sampler.program, self.checked):
            struck = lambda batch: find_faulty(batch, self.statistics, self.checked)  # noqa: E731
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
                    lost, self.statistics, len(choice.states) * candidates, _hopeless(self.sampler.program, self.given)
                )
        return self.made(numbers, attempt)[1]


def is_examined(program: Program, checked: bool) -> bool:
    """Whether objects of a program are looked at beyond its requirements: ``checked``, or for what its labels say."""
    return checked or bool(find_fallible(program))


def find_faulty(batch: Batch, statistics: Statistics, checked: bool) -> np.ndarray:
    """Indices of the objects of a batch at fault beyond the requirements: labels without a value, and where they are
    ``checked`` solids that collide, tip over, ...; counted."""
    if not checked:
        silent = find_unsaid(batch)
        for fault in silent:
            statistics.unsound[fault.words] = statistics.unsound.get(fault.words, 0) + len(fault.objects)
        return distinct(np.concatenate([np.zeros(0, dtype=np.int64), *(fault.objects for fault in silent)]))
    if batch.program.foreign:
        prove(batch)
    found = find_faults(batch, soon=True)
    struck = found.collisions
    for key, rows in found.tree.named(struck).items() if len(struck) else ():
        if key not in statistics.examples:
            met = describe_contact(found.tree, found.body, struck, int(rows[0]))
            kinds = (joint.kind for joint in batch.program.joints if joint.path == key[2])
            statistics.examples[key] = contact_in_words(next(kinds, ""), met)
        statistics.collided[key] = statistics.collided.get(key, 0) + len(distinct(struck.owner[rows]))
    for fault in found.others:
        statistics.unsound[fault.words] = statistics.unsound.get(fault.words, 0) + len(fault.objects)
    return found.objects()
