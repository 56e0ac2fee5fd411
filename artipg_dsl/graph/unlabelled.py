"""Which surfaces no semantic label covers in some object that the program can make."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise

from ..records import dataclass
from .expr import Column, Expr, both
from .program import Program

_MOST = 65_536  # cases that are tried; conditions of more are taken to cover
_COMPARED = ("lt", "le", "eq")
_Term = tuple[Expr, ...]  # what a condition asks about: a truth, a number, or the difference of two numbers


@dataclass(frozen=True, slots=True)
class Bare:
    """The site ``number`` has no label on its ``surfaces`` (names; none: on all of it), or with ``partly`` one under a
    condition that need not hold."""

    number: int
    surfaces: tuple[str, ...]
    partly: bool


def find_unlabelled(program: Program) -> list[Bare]:
    """The sites that semantic labels leave bare.

    Conditions are read as they are written: a comparison may hold or not, a choice takes one of its options. So labels
    under a condition and under its opposite cover a surface together.
    """
    options = {draw.column: len(draw.options) for draw in program.draws if draw.options}
    said: dict[int, list[tuple[tuple[str, ...], Expr]]] = {}
    for label in program.labels:
        if label.vocabulary == "semantic":
            for target in label.targets:
                said.setdefault(target.site, []).append((target.surfaces, both(label.guard, label.value)))
    found = []
    known: dict[tuple[tuple[Expr, ...], tuple[Expr, ...]], bool] = {}  # most surfaces are labelled as others are
    for number, site in enumerate(program.sites):
        own = said.get(number, [])
        there = tuple([s.count for s in site.scope.ancestors() if s.kind == "guard" and s.count is not None])
        names = program.primitives[site.primitive].surfaces or ("",)
        on = {name: tuple([holds for named, holds in own if not named or name in named]) for name in names}
        for holding in on.values():
            if (there, holding) not in known:
                known[there, holding] = _covered(there, holding, options)
        bare = [name for name in names if not known[there, on[name]]]
        if bare:
            partly = any(on[name] for name in bare)
            found.append(Bare(number, () if len(bare) == len(names) else tuple(bare), partly))
    return found


def _covered(there: Sequence[Expr], holding: Sequence[Expr], options: Mapping[Column, int]) -> bool:
    """Whether one of ``holding`` is true wherever all of ``there`` are."""
    asked: dict[_Term, set[float]] = {}
    for condition in (*there, *holding):
        _gather(condition, asked)
    values = {}
    cases = 1
    for term, limits in asked.items():
        values[term] = _values(term, limits, options)
        cases *= len(values[term])
        if cases > _MOST:
            return True
    table = _Table.of(values, cases)
    bare = table.every
    for condition in there:
        bare &= table.where(condition)
    for condition in holding:
        bare &= ~table.where(condition)
    return not bare


@dataclass(frozen=True, slots=True)
class _Table:
    """All combinations of the values of terms. A set of them is an integer with a bit for each."""

    every: int
    takes: Mapping[_Term, list[tuple[float, int]]]  # the values of a term, each with the combinations that have it

    @classmethod
    def of(cls, values: Mapping[_Term, list[float]], cases: int) -> _Table:
        every = (1 << cases) - 1
        takes = {}
        run = 1  # for how many combinations in a row a term keeps its value
        for term, each in values.items():
            starts = every // ((1 << run * len(each)) - 1)  # where the first value begins anew
            takes[term] = [(value, (((1 << run) - 1) * starts) << run * k) for k, value in enumerate(each)]
            run *= len(each)
        return cls(every, takes)

    def where(self, condition: Expr) -> int:
        """The combinations in which a condition is true."""
        match condition.op:
            case "const":
                return self.every if condition.value else 0
            case "and":
                found = self.every
                for arg in condition.args:
                    found &= self.where(arg)
                return found
            case "or":
                found = 0
                for arg in condition.args:
                    found |= self.where(arg)
                return found
            case "not":
                return self.every & ~self.where(condition.args[0])
            case "lt" | "le" | "eq":
                term = _term(condition)
                holds: Callable[[float], bool] = partial(_compare, condition, term)
            case _:
                term = (condition,)
                holds = bool
        found = 0
        for value, cases in self.takes[term]:
            if holds(value):
                found |= cases
        return found


def _gather(condition: Expr, asked: dict[_Term, set[float]]) -> None:
    """The terms of a condition, with the constants that they are compared with."""
    if condition.op in ("and", "or", "not"):
        for arg in condition.args:
            _gather(arg, asked)
    elif condition.op in _COMPARED:
        term = _term(condition)
        asked.setdefault(term, set()).update(a.value for a in condition.args if a.op == "const")
        if len(term) == 2:
            asked[term].add(0.0)
    elif condition.op != "const":
        asked.setdefault((condition,), set())


def _term(compared: Expr) -> _Term:
    """What is compared with a constant, or the two that are compared, in an order of their own."""
    open_ends = [a for a in compared.args if a.op != "const"]
    return tuple(sorted(open_ends, key=id))


def _values(term: _Term, limits: set[float], options: Mapping[Column, int]) -> list[float]:
    """Values of a term that answer every comparison in each way that it can be answered."""
    if not limits:
        return [0.0, 1.0]  # false, true
    if len(term) == 1 and term[0].op == "col" and term[0].value in options:
        return [float(k) for k in range(options[term[0].value])]
    ends = sorted(limits)
    return [ends[0] - 1.0, *ends, *((a + b) / 2 for a, b in pairwise(ends)), ends[-1] + 1.0]


def _compare(condition: Expr, term: _Term, value: float) -> bool:
    """Whether a comparison holds where what it asks about has a value."""
    left, right = (_side(a, term, value) for a in condition.args)
    return left < right if condition.op == "lt" else left <= right if condition.op == "le" else left == right


def _side(side: Expr, term: _Term, value: float) -> float:
    """A side of a comparison: a constant, or what the term says of it; of two open sides the second counts as 0."""
    if side.op == "const":
        return float(side.value)
    return value if side is term[0] else 0.0


__all__ = ["Bare", "find_unlabelled"]
