"""Mutants of an original that are nearly the same as another of it, found before anything is written.

The measure is that of a report: the same choices, counts and kinematic graph, and all values within 2 % of their ranges. Which mutants are
left out depends on their original alone: ranges that the text does not give are those of objects of the category, not of the mutants.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ..export.remote import Place
from ..quality.duplicates import Ranges, find_near_duplicates, find_ranges
from ..quality.graphs import find_graphs
from ..sampling.mutation import Mutation
from .job import Job
from .manifest import describe_strangers, read_manifest
from .schema import expand
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


def recall_distinct(job: Job, out: Place) -> Job | None:
    """The same job as a folder that is finished has kept it, so that nothing is compared again; None where it does not tell.

    Of each original at least one mutant is kept, so a folder of as many mutants as these, with those left out, is of the same
    originals. Raises ExportError.
    """
    old, numbers = read_manifest(out), job.request.objects
    if old is None or not (left_out := old.get("counts", {}).get("near_duplicates", 0)):
        return None
    kept = expand(old["identity"]["numbers"])
    if len(kept) + left_out != len(numbers) or not np.isin(kept, numbers).all():
        return None
    if describe_strangers(old, job.request):
        return None
    made = job.of(kept)
    made.statistics.near_duplicates = left_out
    return made


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
