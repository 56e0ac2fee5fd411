"""Pair coverage of choices: which two alternatives or counts have been seen together, of all that can be.

Two choices meet in the rows of the deepest table that both stand in or below: in one object, or in one element of a
repeat. Of a count of many values its thirds are told apart. A pair that no object shows is
asked for: objects are evaluated with both values given. If one is valid the pair is possible and was missed; if none
is, guards and requirements exclude it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import combinations, pairwise

import numpy as np

from ..graph.expr import Scope
from ..graph.program import Draw
from ..records import dataclass
from ..runtime.batch import Batch
from ..runtime.kernels import State
from ..runtime.plan import make_plan
from ..sampling.sample import Sampler
from .asking import Question, ask

_LEVELS = 4  # values of a count that are told apart
_TRIED = 128  # objects asked for a pair that was not seen
_TOGETHER = 8192  # objects evaluated at once: as many one by one take hundreds of times as long


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


@dataclass(frozen=True, slots=True)
class _Unseen:
    """A level of each of two factors that no object shows together."""

    first: Factor
    i: int
    second: Factor
    j: int

    @property
    def table(self) -> Scope:
        return _common(self.first, self.second)

    def ends(self) -> Iterator[tuple[float, float]]:
        """What to ask for: the least values of both levels, and the largest."""
        one, two = self.first.levels[self.i], self.second.levels[self.j]
        yield one.low, two.low
        if one.low != one.high or two.low != two.high:
            yield one.high, two.high

    def plain(self) -> LevelPair:
        first, second = self.first, self.second
        return LevelPair(first.name, first.levels[self.i].name, second.name, second.levels[self.j].name)


def measure_coverage(sampler: Sampler, batch: Batch, progress: Callable[[int, int], None] | None = None) -> Coverage:
    """The pair coverage of a batch; whether a pair that it does not show is possible is found by trial.

    ``progress(done, total)`` counts values that are tried, then pairs of values.
    """
    seen = 0
    unseen: list[_Unseen] = []
    for first, second in combinations(list_factors(batch), 2):
        table = find_together(batch, first, second)
        seen += int(table.sum())
        unseen += [_Unseen(first, i, second, j) for i, j in np.argwhere(~table).tolist()]
    may = _find_possible(sampler, batch.state, unseen, progress or (lambda done, total: None))
    missed = tuple(pair.plain() for k, pair in enumerate(unseen) if k in may)
    excluded = tuple(pair.plain() for k, pair in enumerate(unseen) if k not in may)
    return Coverage(seen, seen + len(missed), missed, excluded)


def _common(first: Factor, second: Factor) -> Scope:
    """The deepest table that both factors stand in or below."""
    return next(scope for scope in first.scope.ancestors() if second.scope.within(scope))


def find_together(batch: Batch, first: Factor, second: Factor) -> np.ndarray:
    """(levels, levels) which levels of two factors some row of their deepest common table shows."""
    table = _common(first, second)
    whole = slice(0, len(batch))
    return (_shown(batch, first, table, whole).T.astype(np.int64) @ _shown(batch, second, table, whole)) > 0


def _shown(batch: Batch, factor: Factor, table: Scope, objects: slice) -> np.ndarray:
    """(rows of ``table`` in ``objects``, levels) bool: whether a row of the factor at or below it has the level."""
    own, inside = _rows(batch, factor.scope, objects), _rows(batch, table, objects)
    value = batch.state.values[factor.number][own]
    row = batch.rowmap.up(factor.scope, table)[own] - inside.start
    found = np.zeros((inside.stop - inside.start, len(factor.levels)), dtype=bool)
    for k, level in enumerate(factor.levels):
        found[row[(value >= level.low) & (value <= level.high)], k] = True
    return found


def _rows(batch: Batch, scope: Scope, objects: slice) -> slice:
    return slice(*np.searchsorted(batch.owner(scope), [objects.start, objects.stop]).tolist())


class _Asked:
    """Objects that were asked for a level, or for two."""

    def __init__(self, batch: Batch, objects: slice):
        self.batch, self.objects = batch, objects
        self.known: dict[tuple[int, Scope], np.ndarray] = {}

    def shown(self, factor: Factor, table: Scope) -> np.ndarray:
        place = factor.number, table
        if place not in self.known:
            self.known[place] = _shown(self.batch, factor, table, self.objects)
        return self.known[place]

    def show(self, pair: _Unseen) -> bool:
        """Whether a valid one shows the pair."""
        table = pair.table
        both = self.shown(pair.first, table)[:, pair.i] & self.shown(pair.second, table)[:, pair.j]
        owner = self.batch.owner(table)[_rows(self.batch, table, self.objects)]
        return bool((both & ~self.batch.state.failed[owner]).any())

    def have_room(self, pair: _Unseen, for_second: bool) -> bool:
        """Whether one shows a level of the pair where the other factor has a value, too."""
        first, second = self.shown(pair.first, pair.table), self.shown(pair.second, pair.table)
        room = first[:, pair.i] & second.any(axis=1) if for_second else second[:, pair.j] & first.any(axis=1)
        return bool(room.any())


def _find_possible(
    sampler: Sampler, like: State, unseen: Sequence[_Unseen], progress: Callable[[int, int], None]
) -> set[int]:
    """The pairs that a valid object shows that is asked for one of the levels, or for both where they can stand in one row.

    Objects are evaluated for their draws and requirements alone.
    """
    plan, numbers = make_plan(sampler.program, ()), np.arange(_TRIED)

    def asked(wanted: Sequence[Mapping[int, float]]) -> Iterator[_Asked]:
        for answers in ask(
            sampler.program, plan, like.seed, like.given, [Question(w, numbers) for w in wanted], _TOGETHER
        ):
            progress(answers.first, len(wanted))
            yield from (_Asked(answers.batch, objects) for objects in answers.objects())

    asks = [(k, ends) for k, pair in enumerate(unseen) for ends in pair.ends()]
    alone: dict[tuple[int, float], list[int]] = {}
    for place, (k, ends) in enumerate(asks):
        for number, value in zip((unseen[k].first.number, unseen[k].second.number), ends, strict=True):
            alone.setdefault((number, value), []).append(place)
    found: set[int] = set()
    room = dict.fromkeys(range(len(asks)), 0)
    for (number, value), some in zip(alone, asked([{number: value} for number, value in alone]), strict=True):
        for place in alone[number, value]:
            pair = unseen[asks[place][0]]
            if some.show(pair):
                found.add(asks[place][0])
            room[place] += some.have_room(pair, for_second=number == pair.first.number)
    both = [place for place, (k, _) in enumerate(asks) if k not in found and room[place] == 2]
    pairs = [(unseen[asks[place][0]], asks[place][1]) for place in both]
    wanted = [{pair.first.number: one, pair.second.number: two} for pair, (one, two) in pairs]
    for place, some in zip(both, asked(wanted), strict=True):
        if some.show(unseen[asks[place][0]]):
            found.add(asks[place][0])
    return found
