"""Variants: what a buyer would call another model, seen among the samples and reached by settings.

A variant is a few settings, as ``--set`` takes them. An object shows it if it has, of each setting's name, some row with
the value. Whether settings reach it is tried: a few objects are sampled with them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..records import dataclass
from ..runtime.batch import Batch
from ..sampling.known import evaluate_again
from ..sampling.sample import Sampler, find_faulty, is_examined
from ..sampling.statistics import Exhausted, Statistics
from .asking import Question, ask

_NEAR = 1e-6  # of values that are not whole, as people write them
_FIRST = 16  # first attempts with the settings of a variant
_TRIED = 4  # objects sampled with those that none of them reach
_TOGETHER = 256  # objects examined at once


@dataclass(frozen=True, slots=True)
class Variant:
    """Its name, its settings in words, how many objects show it, and whether its settings reach it: ``refused`` says why not."""

    name: str
    settings: str
    objects: int
    refused: str


Given = Mapping[str, Mapping[int, float]]  # by the name of a variant: values by the index of their draw


def find_variants(
    sampler: Sampler, batch: Batch, given: Given, settings: Mapping[str, Mapping[str, str]], checked: bool
) -> list[Variant]:
    """The variants of a program among the objects of a batch, but for those that contradict what the batch was given.

    ``given``: the settings of each by draws, nan where an alternative cannot have the value. ``settings``: the same as they
    are written. ``checked``: collisions were looked for.
    """
    wanted = {name: values for name, values in given.items() if not _contradicts(batch.state.given, values)}
    found = []
    for (name, values), reached in zip(
        wanted.items(), _reach(sampler, batch, [*wanted.values()], checked), strict=True
    ):
        seen = int(_shown(batch, values).sum())
        written = " ".join(f"{key}={value}" for key, value in settings[name].items())
        refused = "" if reached else _refused(sampler, batch.seed, values, checked)
        found.append(Variant(name, written, seen, refused))
    return found


def _contradicts(fixed: Mapping[int, Any], values: Mapping[int, float]) -> bool:
    return any(k in fixed and np.ndim(fixed[k]) == 0 and not _same(np.asarray(fixed[k]), v) for k, v in values.items())


def _same(drawn: np.ndarray, value: float) -> np.ndarray:
    return np.isclose(drawn, value, rtol=_NEAR, atol=_NEAR, equal_nan=True)


def _shown(batch: Batch, values: Mapping[int, float]) -> np.ndarray:
    """(B,) bool: which objects have every setting, in one row at least of the draws that share its name."""
    every = np.ones(len(batch), dtype=bool)
    names = {batch.program.draws[k].column.name for k in values}
    for name in sorted(names):
        some = np.zeros(len(batch), dtype=bool)
        for number, value in values.items():
            column = batch.program.draws[number].column
            if column.name == name and not np.isnan(value):
                owner = batch.rowmap.rows(column.scope).owner
                some[owner[_same(batch.state.values[number], value)]] = True
        every &= some
    return every


def _reach(sampler: Sampler, batch: Batch, wanted: Sequence[Mapping[int, float]], checked: bool) -> Iterator[bool]:
    """Whether a first attempt with these settings gives a valid object that shows them."""
    beyond = [{k: np.inf if np.isnan(value) else value for k, value in values.items()} for values in wanted]
    questions = [Question(values, np.arange(_FIRST)) for values in beyond]  # nan would leave the draw open
    for answers in ask(sampler.program, sampler.plan, batch.seed, batch.state.given, questions, _TOGETHER):
        hopeful = np.zeros(len(answers.batch), dtype=bool)
        for values, objects in zip(wanted[answers.first :], answers.objects(), strict=False):
            hopeful[objects] = (_shown(answers.batch, values) & ~answers.batch.state.failed)[objects]
        if is_examined(sampler.program, checked) and hopeful.any():
            places = np.flatnonzero(hopeful)
            hopeful[places[find_faulty(evaluate_again(answers.batch, places), Statistics(), checked)]] = False
        yield from (bool(hopeful[objects].any()) for objects in answers.objects())


def _refused(sampler: Sampler, seed: int, values: Mapping[int, float], checked: bool) -> str:
    """What keeps these settings from giving such an object; empty if they do."""
    try:
        few = sampler.batch(np.arange(_TRIED), seed, given=dict(values), checked=checked)
    except Exhausted:
        return "leaves no valid object"
    return "" if _shown(few, values).any() else "has no effect: what is set is not there"


__all__ = ["Given", "Variant", "find_variants"]
