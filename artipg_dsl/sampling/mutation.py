"""What a mutation is asked to change, and how much of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import read_amount, read_whole
from ..errors import UsageError, UserError
from ..records import dataclass
from ..runtime.batch import Batch
from .mutate import OPERATIONS, SHARE, mutate

if TYPE_CHECKING:
    from .sample import Sampler
    from .statistics import Statistics

_MOST_VARIANTS = 2**31
_STRONGEST = 1e6


@dataclass(frozen=True, slots=True)
class Mutation:
    """One step of making new objects from old ones, as ``mutate`` takes it.

    ``only`` lists names of parts and values that may be changed, with commas between: ``door`` (all of it), ``handle*``,
    ``cell[1].share``; ``share`` of the eligible templates and counts are changed, at least one; ``strength`` scales the
    steps of CPA. With ``one`` a single value of the names is changed and all other draws stay what they were.
    ``variant`` gives others; ``each`` so many of every object. ``sources`` are the numbers, as runs, of the objects that
    are changed if the new ones are numbered anew: the variants of the first, of the second, ...; with ``one`` each
    group begins with the object itself. ``unchecked``: mutants may collide, whatever was asked of the objects that they are made from.
    """

    operations: tuple[str, ...] = OPERATIONS
    variant: int = 0
    strength: float = 1.0
    share: float = SHARE
    only: str = "*"
    one: bool = False
    each: int = 1
    sources: tuple[tuple[int, int], ...] | None = None
    unchecked: bool = False

    def __post_init__(self) -> None:
        unknown = [name for name in self.operations if name not in OPERATIONS]
        if unknown or not self.operations:
            wrong = f"there is no operation `{unknown[0]}`" if unknown else "no operation is given"
            raise UsageError(wrong, f"the operations are {', '.join(OPERATIONS)}")
        if not isinstance(self.only, str):
            raise UsageError(f"only is {self.only!r}", 'it is text: "door" or "door,handle*"')
        read_amount("strength", self.strength, 0, _STRONGEST)
        read_amount("share", self.share, 0, 1)
        read_whole("variant", self.variant)
        if not 0 <= self.variant < _MOST_VARIANTS:  # -1 is the object itself, in `mutate`
            raise UsageError(f"the variant is {self.variant}, but must be a number from 0 and below {_MOST_VARIANTS}")

    def focused(self, one: str | None, called: Mapping[str, str] = MappingProxyType({})) -> Mutation:
        """The same, of the value ``one`` alone if it is named. Raises UsageError for a field that is not as usual and would change
        nothing; ``called``: the names of fields in the message, where they have others."""
        told = {
            name: called.get(name, name)
            for name in ("operations", "only", "share", "strength")
            if getattr(self, name) != getattr(_USUAL, name)
        }
        if one is not None and told:
            raise UsageError(
                f"{called.get('one', 'one')} redraws the value that it names, so {' and '.join(told.values())} "
                "cannot be given as well"
            )
        for name, what, of in (("strength", "steps", ("cpa",)), ("share", "templates and counts", ("apa", "dpa"))):
            if name in told and not set(of) & set(self.operations):
                raise UsageError(
                    f"{told[name]} applies to the {what} of {' and '.join(of)}, not to {','.join(self.operations)}",
                    f"leave out {told[name]}, or add {of[0]} to the operations",
                )
        if not self.share:
            raise UsageError(
                f"{called.get('share', 'share')} is 0, but one template or count changes at least",
                "give a small share for one alone; operations without apa and dpa change none",
            )
        return self if one is None else replace(self, only=one, one=True)

    def plain(self) -> dict[str, Any]:
        sources = None if self.sources is None else [list(run) for run in self.sources]
        told = {**asdict(self), "operations": list(self.operations), "sources": sources}
        return told if told.pop("unchecked") is False else told | {"unchecked": True}

    @staticmethod
    def of(plain: Mapping[str, Any]) -> Mutation:
        """The step that ``plain`` has written."""
        sources = plain.get("sources")
        runs = None if sources is None else tuple((int(first), int(last)) for first, last in sources)
        return Mutation(**{**plain, "operations": tuple(plain["operations"]), "sources": runs})

    @property
    def group(self) -> int:
        """How many new objects there are of each old one."""
        return self.each + self.one

    def origins(self, numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The number of the object that each new one is made from, and its variant (-1: that object itself)."""
        if self.sources is None:
            return numbers, np.full(len(numbers), self.variant)
        stock = np.concatenate([np.arange(first, last + 1) for first, last in self.sources])
        beyond = numbers[numbers >= len(stock) * self.group]
        if len(beyond):
            raise UserError(f"there is no object {beyond[0]}: there are {len(stock) * self.group}, numbered from 0")
        return stock[numbers // self.group], numbers % self.group - self.one + np.where(
            numbers % self.group < self.one, 0, self.variant
        )

    def apply(
        self,
        sampler: Sampler,
        batch: Batch,
        numbers: np.ndarray,
        variants: np.ndarray,
        statistics: Statistics,
        checked: bool,
    ) -> Batch:
        """The mutants ``numbers`` of the objects of a batch, one of each, in its order."""
        found = mutate(
            sampler,
            batch,
            operations=self.operations,
            variant=variants,
            strength=self.strength,
            share=self.share,
            only=self.only,
            one=self.one,
            statistics=statistics,
            checked=checked,
        )
        found.numbers = numbers
        return found


_USUAL = Mutation()


def read_operations(names: str | Iterable[str]) -> tuple[str, ...]:
    """``"apa,cpa"``, or a list of these. Raises UsageError where one is there twice: each is applied once."""
    listed = names.split(",") if isinstance(names, str) else list(names) if isinstance(names, Iterable) else [names]
    if not all(isinstance(name, str) for name in listed):
        raise UsageError(f"operations is {names!r}", 'it is text or a list: "apa,cpa" or ["apa", "cpa"]')
    found = tuple(name.strip() for name in listed)
    twice = [name for name in found if found.count(name) > 1]
    if twice:
        raise UsageError(f"the operation {twice[0]} is given twice", "each is applied once, in the order apa, dpa, cpa")
    return found
