"""Pair coverage of choices: which two alternatives or counts have been seen together, of all that can be.

Two choices meet in the rows of the deepest table that both stand in or below: in one object, or in one element of a
repeat. Of a count of many values its thirds are told apart. A pair that no object shows is
asked for: objects are evaluated with both values given. If one is valid the pair is possible and was missed; if none
is, guards and requirements exclude it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations, pairwise

import numpy as np

from ..graph.expr import Scope
from ..graph.program import Draw
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import State
from ..runtime.plan import make_plan
from ..sampling.known import make_batch
from ..sampling.sample import Sampler

_LEVELS = 4  # values of a count that are told apart
_TRIED = 128  # objects asked for a pair that was not seen


@dataclass(frozen=True, slots=True)
class Level:
    """A value of a choice or count, or a range of values of a count."""

    name: str
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Factor:
    """A choice or count: the index of its draw, and what is told apart of it."""

    number: int
    name: str
    scope: Scope
    levels: tuple[Level, ...]


@dataclass(frozen=True, slots=True)
class LevelPair:
    """Two names with the levels of each, ``first = handle`` and ``one = "none"``."""

    first: str
    one: str
    second: str
    two: str


@dataclass(frozen=True, slots=True)
class Coverage:
    """``seen`` and ``possible`` count pairs; ``missed`` are possible and were not seen, ``excluded`` are impossible."""

    seen: int
    possible: int
    missed: tuple[LevelPair, ...]
    excluded: tuple[LevelPair, ...]

    @property
    def share(self) -> float:
        return self.seen / self.possible if self.possible else 1.0


def list_factors(batch: Batch) -> list[Factor]:
    """The choices and counts of a program with their levels; not those that were given a value."""
    found = []
    for number, draw in enumerate(batch.program.draws):
        if number in batch.state.given:
            continue
        levels = _levels(draw, batch.state.values[number])
        if len(levels) > 1:
            found.append(Factor(number, draw.column.name, draw.column.scope, levels))
    return found


def _levels(draw: Draw, drawn: np.ndarray) -> tuple[Level, ...]:
    if draw.kind == "choice":
        never = [w.constant is not None and w.constant <= 0 for w in draw.weights]
        names = zip(draw.options, never, strict=True)
        return tuple(Level(name, k, k) for k, (name, no) in enumerate(names) if not no)
    if draw.kind != "count" or not len(drawn):
        return ()
    low, high = float(drawn.min()), float(drawn.max())
    for end, pick in ((draw.low, min), (draw.high, max)):
        if end is not None and end.constant is not None:
            low, high = (
                (min(low, np.ceil(end.constant)), high) if pick is min else (low, max(high, np.floor(end.constant)))
            )
    values = range(int(low), int(high) + 1)
    if len(values) <= _LEVELS:
        return tuple(Level(str(v), v, v) for v in values)
    ends = [values[len(values) * k // 3] for k in range(3)] + [values[-1] + 1]
    return tuple(Level(f"{a}..{b - 1}" if b - a > 1 else str(a), a, b - 1) for a, b in pairwise(ends))


def measure_coverage(sampler: Sampler, batch: Batch, progress: Callable[[int, int], None] | None = None) -> Coverage:
    """The pair coverage of a batch; whether a pair that it does not show is possible is found by trial.

    ``progress(done, total)`` counts pairs of factors.
    """
    seen = 0
    missed: list[LevelPair] = []
    excluded: list[LevelPair] = []
    trials = _Trials(sampler, batch.state)
    together = list(combinations(list_factors(batch), 2))
    for k, (first, second) in enumerate(together):
        if progress is not None:
            progress(k, len(together))
        table = find_together(batch, first, second)
        seen += int(table.sum())
        for i, j in np.argwhere(~table).tolist():
            pair = LevelPair(first.name, first.levels[i].name, second.name, second.levels[j].name)
            (missed if trials.possible(first, i, second, j) else excluded).append(pair)
    return Coverage(seen, seen + len(missed), tuple(missed), tuple(excluded))


def _common(first: Factor, second: Factor) -> Scope:
    """The deepest table that both factors stand in or below."""
    return next(scope for scope in first.scope.ancestors() if second.scope.within(scope))


def find_together(batch: Batch, first: Factor, second: Factor) -> np.ndarray:
    """(levels, levels) which levels of two factors some row of their deepest common table shows."""
    table = _common(first, second)
    return (_shown(batch, first, table).T.astype(np.int64) @ _shown(batch, second, table)) > 0


def _shown(batch: Batch, factor: Factor, table: Scope) -> np.ndarray:
    """(rows of ``table``, levels) bool: whether a row of the factor at or below it has the level."""
    value = batch.state.values[factor.number]
    row = batch.rowmap.up(factor.scope, table)
    found = np.zeros((batch.rowmap.rows(table).size, len(factor.levels)), dtype=bool)
    for k, level in enumerate(factor.levels):
        found[row[(value >= level.low) & (value <= level.high)], k] = True
    return found


class _Trials:
    """Objects with values given on purpose, evaluated for their draws and requirements alone, and kept."""

    def __init__(self, sampler: Sampler, like: State):
        self.program, self.seed, self.fixed = sampler.program, like.seed, like.given
        self.plan = make_plan(sampler.program, ())
        self.made: dict[tuple[tuple[int, float], ...], Batch] = {}

    def given(self, *values: tuple[int, float]) -> Batch:
        if len(values) > 1:  # asked for once
            return self.evaluate(values)
        if values not in self.made:
            self.made[values] = self.evaluate(values)
        return self.made[values]

    def evaluate(self, values: tuple[tuple[int, float], ...]) -> Batch:
        numbers = np.arange(_TRIED)
        state = State(self.seed, numbers, np.zeros(len(numbers), dtype=np.int64), {**self.fixed, **dict(values)})
        return make_batch(self.program, self.plan, state)

    def possible(self, first: Factor, i: int, second: Factor, j: int) -> bool:
        """Whether a valid object shows both levels when it is asked to."""
        table = _common(first, second)
        for one, two in _ends(first.levels[i], second.levels[j]):
            alone = [
                (first, i, second, self.given((first.number, one))),
                (second, j, first, self.given((second.number, two))),
            ]
            meet = True
            for factor, level, other, batch in alone:
                has, around = _shown(batch, factor, table)[:, level], _shown(batch, other, table)
                fine = ~batch.state.failed[batch.owner(table)]
                if (fine & has & around[:, j if other is second else i]).any():
                    return True
                meet &= bool((has & around.any(axis=1)).any())
            if meet:  # both can stand in one row, so it is worth while to ask for both
                batch = self.given((first.number, one), (second.number, two))
                both = _shown(batch, first, table)[:, i] & _shown(batch, second, table)[:, j]
                if (both & ~batch.state.failed[batch.owner(table)]).any():
                    return True
        return False


def _ends(one: Level, two: Level) -> Iterator[tuple[float, float]]:
    yield one.low, two.low
    if one.low != one.high or two.low != two.high:
        yield one.high, two.high
