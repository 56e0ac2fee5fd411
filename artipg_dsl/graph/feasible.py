"""Ranges that can never be met: intervals of all draws, narrowed by their bounds until one is empty or nothing moves.

Static and conservative: a conflict found here holds for every object; one that is not found here is met when sampling.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..records import dataclass
from .defined import Defined
from .expr import TRUE, Column, Expr, Scope, both, negate
from .interval import Interval, Intervals
from .linear import Linear
from .program import Draw, Program, Union

_ROUNDS = 6
_SMALL = 1e-9
_ALIKE = 1e-5
_Causes = dict[
    int, tuple[tuple[int, ...], tuple[int, ...]]
]  # of a narrowed draw: requirements, and the draws they read


@dataclass(frozen=True, slots=True)
class Conflict:
    """What can never be met: a draw whose range is empty, or a requirement; with the requirements that lead there.

    ``certain``: every object has it, so that nothing can ever be drawn; else it is within an alternative or a repeat.
    """

    draw: int | None
    requirement: int | None
    reasons: tuple[int, ...]
    draws: tuple[int, ...]
    low: float
    high: float
    scope: Scope
    certain: bool


class _Narrowed(Intervals):
    """Intervals of expressions with some draws at less than their domain."""

    def __init__(self, program: Program, box: Mapping[int, Interval]):
        super().__init__(program.draws, program.definitions)
        self.box = {program.draws[k].column: ends for k, ends in box.items()}

    def _of(self, node: Expr) -> Interval:
        low, high = super()._of(node)
        if node.op == "phi" and node.args[-1].op == "const" and math.isinf(float(node.args[-1].value)):
            end = float(node.args[-1].value)
            return min(low, end), max(high, end)  # no bound where no alternative states one
        if node.op == "reduce" and node.value[0] in ("min", "max"):
            kind, child = node.value
            if child.count is None or self.of(child.count)[0] < 1.0:  # of no rows
                return (low, math.inf) if kind == "min" else (-math.inf, high)
        return low, high

    def column(self, column: Column) -> Interval:
        found = self.box.get(column)
        return super().column(column) if found is None else found

    def decide(self, reader: Linear, node: Expr) -> list[Column]:
        """The draws at less than their domain that an expression reads: without them it might be otherwise."""
        return [column for column in _sorted_columns(reader, node) if column in self.box]


def find_conflicts(program: Program, given: Mapping[int, float] | None = None) -> list[Conflict]:
    """Everything that can never be met, given the values of some draws (by index), in the order of the text."""
    found, box, causes = _narrow(program, given)
    return [*found.values(), *_broken(program, {} if found else box, found, causes)]


def find_ranges(program: Program) -> dict[int, Interval]:
    """The intervals of the draws (by index) that the requirements narrow, whatever else is drawn."""
    return _narrow(program, None)[1]


def _narrow(
    program: Program, given: Mapping[int, float] | None
) -> tuple[dict[object, Conflict], dict[int, Interval], _Causes]:
    """The draws without room, if any, the intervals of those that have less than their domain, and why they have."""
    box = {k: (v, v) for k, v in (given or {}).items() if math.isfinite(v)}
    reader = Linear(lambda c: c not in program.definitions, program.definitions, through=True)
    numbers = {d.column: k for k, d in enumerate(program.draws)}
    causes: _Causes = {}
    found: dict[object, Conflict] = {}
    for _ in range(_ROUNDS):
        intervals = _Narrowed(program, box)
        moved = False
        found |= {k: c for k, d in enumerate(program.draws) if (c := _without_option(d, intervals)) is not None}
        for k, draw in enumerate(program.draws):
            if k in found or draw.kind == "choice" or draw.low is None or draw.high is None:
                continue
            low, high, why, read = _range(draw, intervals, reader)
            if k in box:
                low, high = max(low, box[k][0]), min(high, box[k][1])
            others = tuple(dict.fromkeys(numbers[c] for c in read if c in numbers and c is not draw.column))
            alike = low - high < _ALIKE  # whole numbers beside one that is left out: no range to tell of
            if draw.kind == "count" and why and math.isfinite(low) and math.isfinite(high):
                low, high = math.ceil(low - _SMALL), math.floor(high + _SMALL)
            if low > high + _SMALL * max(1.0, abs(low)):
                reasons, chain = _led(causes, why, others)
                chain = tuple(d for d in chain if d != k)
                scope = draw.column.scope
                one, other = (None, reasons[0]) if alike and reasons else (k, None)
                found[k] = Conflict(one, other, reasons, chain, low, high, scope, is_certain(scope, intervals))
            elif why and (low, high) != intervals.column(draw.column) and (given is None or k not in given):
                box[k] = (low, max(low, high))
                causes[k] = tuple(why), others
                moved = True
        if found or not moved:
            break
    return found, box, causes


def _without_option(draw: Draw, intervals: _Narrowed) -> Conflict | None:
    """That requirements leave none of the options of a choice."""
    shut: dict[int, int] = {}
    for limit in draw.limits:
        if intervals.of(limit.allowed)[1] <= 0.0:
            shut.setdefault(limit.option, limit.requirement)
    taken = [k for k, weight in enumerate(draw.weights) if intervals.of(weight)[1] > 0.0]
    if not taken or not all(k in shut for k in taken):
        return None
    reasons, scope = tuple(dict.fromkeys(shut[k] for k in taken)), draw.column.scope
    return Conflict(None, reasons[0], reasons, (), math.nan, math.nan, scope, is_certain(scope, intervals))


def _led(causes: _Causes, why: Sequence[int], draws: Iterable[int]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Requirements, with those that narrowed some draws, from one draw to the next; and the draws on the way."""
    reasons, chain, left = dict.fromkeys(why), dict[int, None](), list(draws)
    for draw in left:
        if draw not in chain:
            chain[draw] = None
            more, others = causes.get(draw, ((), ()))
            reasons |= dict.fromkeys(more)
            left += others
    return tuple(reasons), tuple(chain)


def _range(draw: Draw, intervals: _Narrowed, reader: Linear) -> tuple[float, float, list[int], list[Any]]:
    """The range of a draw, the requirements that make it narrower than its domain, and what they read."""
    low, high = intervals.of(draw.ends[0])[0], intervals.of(draw.ends[1])[1]
    why: dict[str, list[int]] = {"low": [], "high": []}
    read: dict[str, list[Any]] = {"low": _sorted_columns(reader, draw.low), "high": _sorted_columns(reader, draw.high)}
    for bound in draw.bounds:
        if intervals.of(bound.guard)[0] < 1.0:
            continue
        ends = intervals.of(bound.value)
        if any(map(math.isnan, ends)):
            continue
        if (ends[0] > low) if bound.side == "low" else (ends[1] < high):
            low, high = (ends[0], high) if bound.side == "low" else (low, ends[1])
            why[bound.side] = [bound.requirement, *bound.also]
            read[bound.side] = [*_sorted_columns(reader, bound.value), *intervals.decide(reader, bound.guard)]
    for union in draw.unions:
        low, high = _hull(union, intervals, low, high, why, read, reader)
    return low, high, why["low"] + why["high"], read["low"] + read["high"]


def _hull(
    union: Union,
    intervals: _Narrowed,
    low: float,
    high: float,
    why: dict[str, list[int]],
    read: dict[str, list[Any]],
    reader: Linear,
) -> tuple[float, float]:
    """The range narrowed to what a union of intervals leaves of it; an empty one where no interval has room."""
    if intervals.of(union.guard)[0] < 1.0 or low > high + _SMALL:
        return low, high
    ends = [(intervals.of(one)[0], intervals.of(two)[1]) for one, two in union.intervals]
    if any(math.isnan(end) for pair in ends for end in pair):
        return low, high
    left = [(max(one, low), min(two, high)) for one, two in ends if max(one, low) <= min(two, high) + _SMALL]
    columns = [c for pair in union.intervals for end in pair for c in _sorted_columns(reader, end)]
    columns += intervals.decide(reader, union.guard)
    if not left:
        why["low"], read["low"] = [union.requirement, *union.also, *why["low"]], [*columns, *read["low"]]
        above, below = [one for one, two in ends if one > high], [two for _, two in ends if two < low]
        return (
            (min(above), high)
            if above
            else (low, max(below))
            if below
            else max(ends, key=lambda pair: pair[1] - pair[0])
        )
    first, last = min(one for one, _ in left), max(two for _, two in left)
    for side, moved in (("low", first > low), ("high", last < high)):
        if moved:  # what is beyond the end that was there is left out by what made that end, too
            why[side], read[side] = [union.requirement, *union.also, *why[side]], [*columns, *read[side]]
    return first, last


def _sorted_columns(reader: Linear, node: Expr | None) -> list[Any]:
    return [] if node is None else sorted(reader.columns(node), key=lambda c: c.path)


def _broken(
    program: Program, box: Mapping[int, Interval], found: Mapping[object, Conflict], causes: _Causes
) -> list[Conflict]:
    """Requirements that no values within the intervals keep, beyond those that a range has told already."""
    intervals = _Narrowed(program, box)
    reader = Linear(lambda c: c not in program.definitions, program.definitions, through=True)
    numbers = {d.column: k for k, d in enumerate(program.draws)}
    told = {r for conflict in found.values() for r in conflict.reasons}
    more = []
    for number, requirement in enumerate(program.requirements):
        if number in told or intervals.of(requirement.guard)[0] < 1.0:
            continue
        if intervals.of(requirement.condition)[1] >= 1.0:
            continue
        if requirement.slack is not None:
            low, high = (intervals.of(side) for side in requirement.slack)
            if not low[0] > high[1] + _SMALL:
                continue
        scope = requirement.scope
        read = [c for node in (requirement.condition, requirement.guard) for c in intervals.decide(reader, node)]
        reasons, chain = _led(causes, [number], [numbers[c] for c in read])
        more.append(Conflict(None, number, reasons, chain, math.nan, math.nan, scope, is_certain(scope, intervals)))
    return more


def find_idle(program: Program) -> list[int]:
    """The requirements on something drawn that hold whatever is drawn; those between constants are not among them."""
    intervals = Intervals(program.draws, program.definitions)
    defined = Defined(intervals)  # what has no value does not hold
    reader = Linear(lambda c: c not in program.definitions, program.definitions, through=True)
    return [
        number
        for number, requirement in enumerate(program.requirements)
        if reader.columns(requirement.condition)
        and (
            _is_same(requirement.condition)
            or intervals.of(negate(both(requirement.guard, negate(requirement.condition))))[0] >= 1.0
        )
        and defined.certain(both(requirement.guard, requirement.condition))
    ]


def _is_same(condition: Expr) -> bool:
    """Whether a value is compared with itself, and so found equal."""
    return condition.op in ("eq", "le") and condition.args[0] is condition.args[1]


class _Listed(Intervals):
    """Of numbers of a list from the least to the greatest of them: what is set or fitted may be another."""

    def column(self, column: Column) -> Interval:
        low, high = super().column(column)
        draw = self.draws.get(column)
        if draw is None or draw.distribution != "values" or not draw.arguments:
            return low, high
        ends = [self.of(value) for value in draw.arguments]
        return max(low, min(e[0] for e in ends)), min(high, max(e[1] for e in ends))


def find_settled(program: Program) -> list[tuple[int, bool]]:
    """The preferences that all objects meet, or none does, whatever is drawn: (number, whether they are met)."""
    intervals = _Listed(program.draws, program.definitions)
    found = []
    for number, preference in enumerate(program.preferences):
        low, high = intervals.of(preference.condition)
        if low >= 1.0 or (high <= 0.0 and preference.guard is TRUE):
            found.append((number, low >= 1.0))
    return found


def is_certain(scope: Scope, intervals: Intervals) -> bool:
    """Whether every object has a row of the table."""
    return all(s.count is None or s.count is TRUE or intervals.of(s.count)[0] >= 1.0 for s in scope.ancestors())


__all__ = ["Conflict", "is_certain", "find_conflicts", "find_idle", "find_ranges", "find_settled"]
