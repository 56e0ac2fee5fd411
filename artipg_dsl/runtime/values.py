"""Objects given by their values: what is not said is drawn, and what does not fit is moved as little as possible."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import UserError
from .batch import Batch
from .kernels import Kept, State
from .sample import Exhausted, Sampler, Statistics, colliding
from .settled import again, chosen, made

TRIALS = 25  # attempts at what is not given


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """``records``: for each object, its values by the index of their draw: one, or one per row in the order of the rows.

    ``plain`` is what the file said, as a manifest keeps it.
    """

    records: tuple[Mapping[int, tuple[float, ...]], ...]
    plain: tuple[Mapping[str, Any], ...]

    def batch(self, sampler: Sampler, numbers: np.ndarray, seed: int, statistics: Statistics, checked: bool) -> Batch:
        """The objects of the given numbers, which index the records. Raises Exhausted, UserError."""
        attempt = np.zeros(len(numbers), dtype=np.int64)
        left, first = np.arange(len(numbers)), True
        while len(left):
            trial = self.tried(sampler, numbers[left], seed, attempt[left])
            bad = trial.state.failed.copy()
            sound = np.flatnonzero(~bad)
            if checked and len(sound):
                bad[sound[colliding(trial if len(sound) == len(trial) else again(trial, sound), statistics)]] = True
            statistics.add(trial.state, first, bad)
            left, first = left[bad], False
            attempt[left] += 1
            if len(left) and attempt.max() >= TRIALS:
                raise Exhausted(numbers[left], statistics, TRIALS)
        return self.tried(sampler, numbers, seed, attempt)

    def tried(self, sampler: Sampler, numbers: np.ndarray, seed: int, attempt: np.ndarray) -> Batch:
        """One attempt. How many rows there are follows from the values of the tables above: those are known first."""
        kept: dict[int, Kept] = {}
        known = -1
        while True:
            batch = made(sampler.program, sampler.plan, State(seed, numbers, attempt, kept=kept))
            if sum(len(k.address) for k in kept.values()) == known:
                break
            known = sum(len(k.address) for k in kept.values())
            kept = {k: found for k in range(len(sampler.program.draws)) if (found := self.held(batch, k)) is not None}
        self.refuse(batch)
        return batch

    def held(self, batch: Batch, number: int) -> Kept | None:
        """The values given of a draw, for the rows that there are."""
        rows = chosen(batch, number, np.arange(len(batch)))
        count = np.bincount(rows.owner, minlength=len(batch))
        value = np.full(len(rows.row), np.nan)
        for place, record in enumerate(self.records[n] for n in batch.numbers.tolist()):
            given = record.get(number)
            if given is not None and len(given) in (1, count[place]) and count[place]:
                value[rows.owner == place] = given
        said = ~np.isnan(value)
        if not said.any():
            return None
        order = np.argsort(rows.key[said], kind="stable")
        still = np.zeros(len(order))
        return Kept(rows.key[said][order], value[said][order], still, still.astype(bool))

    def refuse(self, batch: Batch) -> None:
        """Lists must have a value for each row."""
        for number, draw in enumerate(batch.program.draws):
            count = np.bincount(batch.owner(draw.column.scope), minlength=len(batch))
            for place, name in enumerate(batch.numbers.tolist()):
                given = self.records[name].get(number)
                if given is not None and count[place] and len(given) not in (1, count[place]):
                    raise UserError(
                        f"object {name} gives {len(given)} values of `{draw.column.name}`, but has {count[place]}",
                        "give one for all, or one for each",
                    )
