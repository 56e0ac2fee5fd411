"""Sampling: first attempts of all objects, further attempts of those that fail, until all are valid."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..graph.program import Program
from .batch import Batch
from .kernels import State
from .needs import wanted
from .plan import Plan, make_plan

ATTEMPTS = 100


@dataclass(slots=True)
class Statistics:
    """How often what failed: ``missed`` draws without room and ``broken`` requirements, in objects, over all attempts."""

    objects: int = 0
    first_valid: int = 0
    attempts: int = 0
    missed: dict[int, int] = field(default_factory=dict)
    broken: dict[int, int] = field(default_factory=dict)

    def add(self, state: State, first: bool) -> None:
        self.attempts += len(state.objects)
        if first:
            self.objects += len(state.objects)
            self.first_valid += int((~state.failed).sum())
        for total, new in ((self.missed, state.missed), (self.broken, state.broken)):
            for key, value in new.items():
                total[key] = total.get(key, 0) + value


class Exhausted(Exception):
    """Objects for which no attempt was valid; ``statistics`` says which requirements failed how often."""

    def __init__(self, numbers: np.ndarray, statistics: Statistics):
        super().__init__(f"no valid object after {ATTEMPTS} attempts for {len(numbers)} objects")
        self.numbers, self.statistics = numbers, statistics


class Sampler:
    """A program ready to be sampled: planned once, evaluated for any object numbers."""

    def __init__(self, program: Program, plan: Plan | None = None):
        self.program = program
        self.plan = plan or make_plan(program, wanted(program))

    def batch(
        self, numbers: np.ndarray, seed: int, *, given: dict[int, float] | None = None, defaults: bool = False,
        statistics: Statistics | None = None,
    ) -> Batch:  # fmt: skip
        """The objects of the given numbers; each is the same whatever else is in the batch. Raises Exhausted."""
        numbers = np.asarray(numbers, dtype=np.int64)
        statistics = statistics if statistics is not None else Statistics()
        attempt = np.zeros(len(numbers), dtype=np.int64)
        state = State(seed, numbers, attempt, dict(given or {}), defaults)
        tables, values = self.plan.function(state)
        statistics.add(state, True)
        failed = np.flatnonzero(state.failed)
        if not len(failed):
            return Batch(self.program, self.plan, state, tables, values)
        while len(failed):
            attempt[failed] += 1
            if attempt.max() >= ATTEMPTS or defaults:
                raise Exhausted(numbers[failed], statistics)
            trial = State(seed, numbers[failed], attempt[failed], dict(given or {}), defaults)
            self.plan.function(trial)
            statistics.add(trial, False)
            failed = failed[trial.failed]
        state = State(seed, numbers, attempt, dict(given or {}), defaults)
        tables, values = self.plan.function(state)
        return Batch(self.program, self.plan, state, tables, values)
