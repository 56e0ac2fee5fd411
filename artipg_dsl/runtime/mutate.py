"""New objects from old ones: APA swaps templates, DPA changes counts, CPA perturbs parameters (Arti-PG, section 3).

It is the sampler's own evaluation with most draws kept: a row keeps its value by its random address, so elements of a
repeat keep theirs by rank, the inputs of a role outlive a swap, new rows and new templates are drawn in their
conditional range, determined parameters follow, and what no longer fits is moved as little as possible.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from fnmatch import fnmatch
from typing import Any

import numpy as np

from ..graph.expr import leaves
from ..graph.program import Draw, Program
from ..graph.random import key, uniform
from .batch import Batch
from .kernels import Kept, State, full
from .sample import ATTEMPTS, Exhausted, Sampler, Statistics, colliding

OPERATIONS = ("apa", "dpa", "cpa")
PATIENCE = 6  # attempts before what is kept may give way, a little more with each further one
SHARE = 0.5


@dataclass(frozen=True, slots=True)
class Mutation:
    """One step of making new objects from old ones: the arguments of ``mutate``."""

    operations: tuple[str, ...] = OPERATIONS
    variant: int = 0
    strength: float = 1.0
    share: float = SHARE
    only: str = "*"

    def plain(self) -> dict[str, Any]:
        return {**asdict(self), "operations": list(self.operations)}


@dataclass(frozen=True, slots=True)
class Change:
    """One draw of one object before and after. ``kind``: swapped, recounted, varied, adapted, new or gone."""

    path: str
    kind: str
    before: Any
    after: Any


def structural(program: Program) -> set[int]:
    """The choices that decide which parts there are (not which material they have)."""
    read = {column for scope in program.scopes if scope.count is not None for column in leaves(scope.count)}
    return {k for k, d in enumerate(program.draws) if d.kind == "choice" and d.column in read}


def mutate(
    sampler: Sampler, batch: Batch, *, operations: Sequence[str] = OPERATIONS, variant: int = 0, strength: float = 1.0,
    share: float = SHARE, only: str = "*", statistics: Statistics | None = None, checked: bool = False,
) -> Batch:  # fmt: skip
    """Mutants of all objects of a batch, one each; another ``variant`` gives another one.

    ``only`` is a pattern of draw names (``handle*``) outside of which nothing is changed on purpose; ``share`` of the
    eligible templates and counts are changed, at least one; ``strength`` scales the declared steps of CPA. ``checked``:
    only mutants without collisions. Raises ValueError for an unknown operation, Exhausted when no attempt is valid.
    """
    unknown = [o for o in operations if o not in OPERATIONS]
    if unknown:
        raise ValueError(f"unknown operation {unknown[0]!r}; there are {', '.join(OPERATIONS)}")
    salt = f"mutant {variant} of {batch.state.salt or 'the original'}"
    plan = _Plan(sampler, batch, frozenset(operations), salt, strength, share, only)
    statistics = statistics if statistics is not None else Statistics()
    attempt = np.zeros(len(batch), dtype=np.int64)
    everything = np.arange(len(batch))
    left = everything
    first = True
    while len(left):
        trial = plan.state(left, attempt[left])
        sampler.plan.function(trial)
        bad = trial.failed.copy()
        sound = np.flatnonzero(~bad)
        if checked and len(sound):
            state = plan.state(left[sound], attempt[left[sound]])
            tables, values = sampler.plan.function(state)
            bad[sound[colliding(Batch(sampler.program, sampler.plan, state, tables, values), statistics)]] = True
        statistics.add(trial, first, bad)
        left, first = left[bad], False
        attempt[left] += 1
        if len(left) and attempt.max() >= ATTEMPTS:
            raise Exhausted(batch.numbers[left], statistics, ATTEMPTS)
    state = plan.state(everything, attempt)
    tables, values = sampler.plan.function(state)
    return Batch(sampler.program, sampler.plan, state, tables, values)


@dataclass(slots=True)
class _Plan:
    """What is kept, moved and swapped of a batch."""

    sampler: Sampler
    batch: Batch
    operations: frozenset[str]
    salt: str
    strength: float
    share: float
    only: str

    def state(self, objects: np.ndarray, attempt: np.ndarray) -> State:
        """The evaluation of some objects of the batch, each with its attempt."""
        old = self.batch.state
        tries = np.zeros(len(self.batch), dtype=np.int64)
        tries[objects] = attempt
        made = State(old.seed, old.objects[objects], attempt, dict(old.given), salt=self.salt)
        swaps = self.swaps()
        for number, draw in enumerate(self.sampler.program.draws):
            rows = self.batch.rowmap.rows(draw.column.scope)
            order = np.argsort(rows.address, kind="stable")
            reach = self.reach(number, draw) + self.give(draw, rows.owner, tries)
            kept = Kept(rows.address[order], old.values[number][order], reach[order], swaps[number][order])
            made.kept[number] = kept
        return made

    def eligible(self, draw: Draw) -> bool:
        return fnmatch(draw.column.name, self.only)

    def swaps(self) -> list[np.ndarray]:
        """Which rows of each choice and count are to change: a share of the eligible, at least one per object and kind."""
        batch, program = self.batch, self.sampler.program
        parts = structural(program)
        wanted: list[np.ndarray] = [np.zeros(batch.rowmap.rows(d.column.scope).size, dtype=bool) for d in program.draws]
        for operation, numbers in (
            ("apa", [k for k in sorted(parts)]), ("dpa", [k for k, d in enumerate(program.draws) if d.kind == "count"])
        ):  # fmt: skip
            if operation not in self.operations:
                continue
            lots = []
            for number in numbers:
                draw = program.draws[number]
                rows = batch.rowmap.rows(draw.column.scope)
                lot = uniform(key(batch.seed, draw.address, self.salt, operation), rows.address)
                lots.append(lot if self.eligible(draw) and self.can_change(draw) else np.full(rows.size, 2.0))
            lowest = np.full(len(batch), np.inf)
            for number, lot in zip(numbers, lots, strict=True):
                np.minimum.at(lowest, batch.rowmap.rows(program.draws[number].column.scope).owner, lot)
            for number, lot in zip(numbers, lots, strict=True):
                owner = batch.rowmap.rows(program.draws[number].column.scope).owner
                wanted[number] = (lot < 1.0) & ((lot < self.share) | (lot == lowest[owner]))
        return wanted

    def can_change(self, draw: Draw) -> bool:
        """A count of one possible value cannot."""
        if draw.kind != "count":
            return True
        low, high = draw.low.constant, draw.high.constant  # type: ignore[union-attr]
        return low is None or high is None or high > low

    def reach(self, number: int, draw: Draw) -> np.ndarray:
        """How far CPA may move each row of a draw: the declared step, or a tenth of the domain."""
        rows = self.batch.rowmap.rows(draw.column.scope)
        if draw.kind != "real" or "cpa" not in self.operations or not self.eligible(draw):
            return np.zeros(rows.size)
        if draw.vary is not None:
            relative, amount = draw.vary
            step = full(rows, self.batch.read([amount], draw.column.scope)[0])
            if relative:
                step = step * np.abs(self.batch.state.values[number])
            return self.strength * step
        return 0.1 * self.strength * self.width(draw)

    def width(self, draw: Draw) -> np.ndarray:
        low, high = self.batch.read([draw.low, draw.high], draw.column.scope)  # type: ignore[list-item]
        return np.asarray(high, dtype=np.float64) - np.asarray(low, dtype=np.float64)

    def give(self, draw: Draw, owner: np.ndarray, tries: np.ndarray) -> np.ndarray:
        """How far what is kept may move after many attempts that failed."""
        late = np.maximum(tries[owner] - PATIENCE, 0)
        if draw.kind != "real" or not late.any():
            return np.zeros(len(owner))
        return 0.05 * late * self.width(draw)


def changes(before: Batch, after: Batch, index: int) -> list[Change]:
    """What a mutant differs in from what it was made from, in the order of the declarations."""
    found: list[Change] = []
    for number, draw in enumerate(after.program.draws):
        old, new = (_by_address(b, number, index) for b in (before, after))
        for address in dict.fromkeys([*old, *new]):
            path, a = old.get(address, (None, None))
            again, b = new.get(address, (None, None))
            if a == b:
                continue
            kind = "new" if path is None else "gone" if again is None else _kind(draw, number, after, address)
            found.append(Change(path or again or draw.column.name, kind, _plain(draw, a), _plain(draw, b)))
    return found


def _by_address(batch: Batch, number: int, index: int) -> dict[int, tuple[str, float]]:
    draw = batch.program.draws[number]
    rows = batch.rowmap.rows(draw.column.scope)
    names = batch.rowmap.names(draw.column.scope, draw.column.name)
    here = np.flatnonzero(rows.owner == index)
    return {int(rows.address[r]): (names[r], float(batch.state.values[number][r])) for r in here}


def _kind(draw: Draw, number: int, after: Batch, address: int) -> str:
    if draw.kind == "choice":
        return "swapped"
    if draw.kind == "count":
        return "recounted"
    kept = after.state.kept.get(number)
    at = None if kept is None else int(np.searchsorted(kept.address, np.uint64(address)))
    return "varied" if kept is not None and at is not None and kept.reach[at] > 0 else "adapted"


def _plain(draw: Draw, value: float | None) -> Any:
    if value is None:
        return None
    return draw.options[int(value)] if draw.kind == "choice" else int(value) if draw.kind == "count" else value
