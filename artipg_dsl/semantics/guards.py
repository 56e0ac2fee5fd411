"""Conditions over discrete facts: what a part is, the value of a count, rank, choice or switch.

A condition is a formula over a few variables with small domains, so questions about guards (can both hold? does one
follow from the other? what can this part be here?) are answered by trying all assignments.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Hashable, Iterable, Iterator
from itertools import product

from ..records import dataclass

_MAX_ASSIGNMENTS = 20_000
VERSUS = " <> "  # in the name of a variable that says how two values compare: -1, 0 or 1

Assignment = dict[str, Hashable]


@dataclass(frozen=True, slots=True)
class Condition:
    """Base; ``TRUE`` is ``And(())``."""


@dataclass(frozen=True, slots=True)
class Atom(Condition):
    """The variable ``key`` takes one of ``allowed`` out of ``domain``."""

    key: str
    allowed: frozenset[Hashable]
    domain: tuple[Hashable, ...]


@dataclass(frozen=True, slots=True)
class Compare(Condition):
    """The whole number ``key``, within ``low .. high`` (None: no end), stands in relation ``op`` to ``value``."""

    key: str
    op: str
    value: int
    low: int = 0
    high: int | None = None


@dataclass(frozen=True, slots=True)
class And(Condition):
    terms: tuple[Condition, ...]


@dataclass(frozen=True, slots=True)
class Or(Condition):
    terms: tuple[Condition, ...]


@dataclass(frozen=True, slots=True)
class Not(Condition):
    term: Condition


TRUE = And(())

OPERATORS: dict[str, Callable[[int, int], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def conjunction(terms: Iterable[Condition]) -> Condition:
    """All of the terms, without repetition."""
    flat: list[Condition] = []
    for term in terms:
        for part in term.terms if isinstance(term, And) else (term,):
            if part not in flat:
                flat.append(part)
    return flat[0] if len(flat) == 1 else And(tuple(flat))


def holds(condition: Condition, values: Assignment) -> bool:
    """Whether a condition holds under an assignment of all its variables."""
    match condition:
        case Atom(key=key, allowed=allowed):
            return values[key] in allowed
        case Compare(key=key, op=op, value=value):
            return OPERATORS[op](values[key], value)  # type: ignore[arg-type]
        case And(terms=terms):
            return all(holds(t, values) for t in terms)
        case Or(terms=terms):
            return any(holds(t, values) for t in terms)
        case Not(term=term):
            return not holds(term, values)
    raise TypeError(condition)


def domains(conditions: Iterable[Condition]) -> dict[str, tuple[Hashable, ...]]:
    """The variables of the conditions with the values worth trying, in order of first mention."""
    found: dict[str, list[Hashable]] = {}
    stack = list(conditions)[::-1]
    while stack:
        at = stack.pop()
        match at:
            case Atom(key=key, domain=domain):
                known = found.setdefault(key, [])
                known.extend(v for v in domain if v not in known)
            case Compare(key=key, value=value, low=low, high=high):
                known = found.setdefault(key, [])
                near = [v for v in (value - 1, value, value + 1) if v >= low and (high is None or v <= high)]
                known.extend(v for v in near or [low] if v not in known)
            case And(terms=terms) | Or(terms=terms):
                stack.extend(terms[::-1])
            case Not(term=term):
                stack.append(term)
    return {key: tuple(values) for key, values in found.items()}


def assignments(given: Condition, *others: Condition) -> Iterator[Assignment] | None:
    """All assignments to the variables of all conditions under which ``given`` holds; None where they are too many."""
    tables = domains((given, *others))
    total = 1
    for values in tables.values():
        total *= max(1, len(values))
    if total > _MAX_ASSIGNMENTS:
        return None
    keys = tuple(tables)
    every = (dict(zip(keys, values, strict=True)) for values in product(*tables.values()))
    return (values for values in every if holds(given, values))


def consistent(*conditions: Condition) -> bool:
    """Whether all of the conditions can hold together (True where that is too much to try)."""
    found = assignments(conjunction(conditions))
    return found is None or any(True for _ in found)


def implies(given: Condition, wanted: Condition) -> bool:
    """Whether ``wanted`` holds wherever ``given`` does (True where that is too much to try)."""
    if wanted == TRUE:
        return True
    known = given.terms if isinstance(given, And) else (given,)
    if wanted in known:
        return True
    found = assignments(given, wanted)
    return found is None or all(holds(wanted, values) for values in found)


def possible(given: Condition, key: str, domain: tuple[Hashable, ...]) -> frozenset[Hashable]:
    """The values of ``domain`` that the variable ``key`` can take where ``given`` holds."""
    if key not in domains((given,)):
        return frozenset(domain)
    found = assignments(given, Atom(key, frozenset(domain), domain))
    return frozenset(domain) if found is None else frozenset(values[key] for values in found)
