"""What sampling counts: attempts, and how often what failed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, fields
from typing import Any

import numpy as np

from ..records import dataclass
from ..runtime.kernels import State
from ..runtime.repairs import Cause

ATTEMPTS = 100  # at an object, until there is none


@dataclass(slots=True)
class Statistics:
    """How often what failed: ``missed`` draws without room and ``broken`` requirements, in objects, over all attempts.

    ``collided`` counts objects per pair of links, by path, and the joint that makes them meet ("" at rest); ``unsound``
    those whose solids are at fault otherwise, by what is wrong. ``outside`` counts values that were asked for out of their
    domain, ``absent`` those that were no number, per draw; ``repaired`` how many of all these failures were put right, by cause.
    ``examples`` tell of what ``collided`` counts the parts that meet, where and when, in the first object seen.
    ``declined`` are valid objects that preferences passed over, ``unkept`` objects per preference, over all attempts.
    ``candidates``: how many attempts each object considered, where they were resampled; ``candidates_valid`` of all of
    them, ``effective`` the effective number of candidates, summed over the objects. ``near_duplicates`` were made and left out.
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
    absent: dict[int, int] = field(default_factory=dict)
    repaired: dict[Cause, int] = field(default_factory=dict)
    examples: dict[tuple[str, str, str], str] = field(default_factory=dict)
    near_duplicates: int = 0

    def _tables(self) -> dict[str, dict[Any, int]]:
        return {
            "requirement": self.broken,
            "domain": self.outside,
            "absent": self.absent,
            "draw": self.missed,
            "collision": self.collided,
            "solid": self.unsound,
        }

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
        self.near_duplicates += other.near_duplicates
        for total, new in zip(self._tables().values(), other._tables().values(), strict=True):
            _sum(total, new)
        _sum(self.unkept, other.unkept)
        _sum(self.repaired, other.repaired)
        self.examples = other.examples | self.examples

    def plain(self) -> dict[str, Any]:
        """As JSON knows it: a mapping is a list of its entries."""
        found = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return {name: list(value.items()) if isinstance(value, dict) else value for name, value in found.items()}

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Statistics:
        """What ``plain`` has told. Raises KeyError, TypeError, ValueError."""
        made = cls()
        for entry in fields(cls):
            value = plain[entry.name]
            setattr(made, entry.name, {_key(k): v for k, v in value} if isinstance(value, list) else value)
        return made


def _key(value: Any) -> Any:
    return tuple(_key(item) for item in value) if isinstance(value, list) else value


def _sum(total: dict[Any, int], new: Mapping[Any, int]) -> None:
    for key, value in new.items():
        total[key] = total.get(key, 0) + value


class Exhausted(Exception):
    """Objects for which none of ``attempts`` was valid; ``statistics`` says what failed how often. ``mutants``: they are made
    from others, of which they keep values."""

    def __init__(
        self, numbers: np.ndarray, statistics: Statistics, attempts: int, hopeless: bool = False, mutants: bool = False
    ):
        super().__init__(f"no valid object after {attempts} attempts for {len(numbers)} objects")
        self.numbers, self.statistics, self.attempts = numbers, statistics, attempts
        self.mutants = mutants
        self.hopeless = hopeless  # the values given leave nothing, whatever else is drawn
