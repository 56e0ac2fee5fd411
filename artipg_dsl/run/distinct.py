"""Mutants of an original that are nearly the same as another of it, found before anything is written.

The measure is that of a report: the same choices, counts and kinematic graph, and all values within 2 % of their ranges. Which mutants are
left out depends on their original alone: ranges that the text does not give are those of objects of the category, not of the mutants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..quality.duplicates import Ranges, find_near_duplicates, find_ranges
from ..quality.graphs import find_graphs
from ..sampling.mutation import Mutation
from .job import Job
from .sharing import share
from .workers import map_each

_TOGETHER = 256  # objects at a time, as far as the mutants of one original go
_DRAWN = 256  # objects that tell the ranges of values


def leave_out_near_duplicates(job: Job, workers: int, progress: Callable[[int, int], None] | None) -> tuple[Job, int]:
    """The job of the mutants of a job but for near-duplicates, and how many these are; its last mutation numbers them by original.

    Every mutant is made for it. Raises NoObject.
    """
    step = job.request.mutations[-1]
    assert isinstance(step, Mutation) and step.sources is not None
    ranges = find_ranges(job.sampler.batch(np.arange(_DRAWN), 0, checked=False))
    numbers = job.request.objects
    items = _split(numbers, step.group)

    def find(item: np.ndarray) -> np.ndarray:
        return _find(job, ranges, step.group, item)

    found: Iterator[np.ndarray] = share(
        items,
        workers,
        find,
        lambda rest, many: map_each(_find_theirs, rest, many, _take, job.fresh(), ranges, step.group, here=find),
    )
    kept, done = [], 0
    for item, left_out in zip(items, found, strict=True):
        kept.append(item[~left_out])
        done += len(item)
        if progress:
            progress(done, len(numbers))
    left = np.concatenate(kept)
    made = job.of(left)
    made.statistics.near_duplicates = len(numbers) - len(left)
    return made, len(numbers) - len(left)


def _split(numbers: np.ndarray, group: int) -> list[np.ndarray]:
    """Numbers in pieces that keep the mutants of an original together."""
    first = np.flatnonzero(np.append(True, np.diff(numbers // group) > 0))
    wanted = np.arange(0, len(numbers), _TOGETHER)
    cuts = np.unique(first[np.minimum(np.searchsorted(first, wanted), len(first) - 1)])
    return [part for part in np.split(numbers, cuts) if len(part)]


def _find(job: Job, ranges: Ranges, group: int, numbers: np.ndarray) -> np.ndarray:
    """(k,) which of the mutants are near-duplicates of one of the same original before them."""
    batch = job.fresh().batch(numbers)
    graphs = find_graphs(batch)
    original = np.unique(numbers // group, return_inverse=True)[1]
    return find_near_duplicates(batch, original * len(graphs.nodes) + graphs.code, ranges=ranges)


_theirs: tuple[Job, Ranges, int] | None = None  # what this worker works for


def _take(job: Job, ranges: Ranges, group: int) -> None:
    global _theirs
    _theirs = job, ranges, group


def _find_theirs(numbers: np.ndarray) -> np.ndarray:
    assert _theirs is not None
    return _find(*_theirs, numbers)
