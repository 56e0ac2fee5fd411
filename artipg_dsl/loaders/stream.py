"""Batches of objects that are made on the way: nothing is stored, and no object comes twice unless asked for.

Item ``i`` of epoch ``e`` is object ``e * size + i`` of the source, or ``i`` again where ``fresh`` is false; with several categories they
take turns. A batch is a function of its number and the epoch alone: it is the same on any number of workers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError
from ..run.job import Job, open_job
from ..run.request import read_request
from ..run.settings import Value
from .draws import Draws
from .tasks import Arrays, find_task, make_arrays, state_of
from .transforms import Transform

if TYPE_CHECKING:
    from ..graph.program import Program


class Stream:
    """``len(stream)`` batches an epoch; ``stream.batch(k, epoch)`` makes one of them.

    ``categories``: a name, a file, or several, in turn. ``task``: see ``TASKS``. ``size``: objects an epoch; ``batch``: objects a
    batch; ``points``: of each cloud. ``states``: "rest", "open", "random", or joints by name, ``lid=20%``. ``set`` and ``checked`` as
    in ``sample``. ``fresh``: other objects in each epoch; otherwise the same objects and points, while random states and
    transforms are new. ``transforms`` are applied in their order. ``view``: the camera of ``partial``, as in camera files. Raises
    CompileError, SettingError, UsageError.
    """

    def __init__(
        self,
        categories: str | Path | Sequence[str | Path],
        task: str = "segmentation",
        *,
        size: int = 10_000,
        batch: int = 32,
        points: int = 2048,
        seed: int = 0,
        states: str = "rest",
        set: Mapping[str, Value] | None = None,
        checked: bool = True,
        fresh: bool = True,
        transforms: Iterable[Transform] = (),
        view: Mapping[str, Any] | None = None,
    ):
        self.sources = [str(c) for c in ([categories] if isinstance(categories, str | Path) else categories)]
        self.task = find_task(task)
        for name, number in {"size": size, "batch": batch, "points": points}.items():
            if not isinstance(number, int) or number < 1:
                raise UsageError(f"{name} is {number!r}", "give a whole number from 1")
        if not self.sources:
            raise UsageError("there is no category to make objects of", 'name one, such as Stream("Microwave")')
        self.size, self.each, self.points, self.seed = size, batch, points, int(seed)
        self.states, self.fresh, self.view = states, fresh, dict(view or {})
        self.transforms = list(transforms)
        self._settings, self._checked = set, checked
        self.words  # noqa: B018  # what is wrong with the arguments is told here, not in a worker
        state_of(self._jobs[0].of([0]).batch(), states, 0)

    def __len__(self) -> int:
        return -(-self.size // self.each)

    def __getstate__(self) -> dict[str, Any]:
        """Another process opens the programs itself: they are kept compiled on disk."""
        return {name: value for name, value in self.__dict__.items() if name != "_jobs"}

    @cached_property
    def _jobs(self) -> list[Job]:
        return [self._open(source) for source in self.sources]

    def _open(self, source: str) -> Job:
        return open_job(read_request(source, seed=self.seed, n=1, settings=self._settings, checked=self._checked))

    @property
    def categories(self) -> list[str]:
        """The names that ``category`` counts."""
        return [job.program.name for job in self._jobs]

    @cached_property
    def words(self) -> dict[str, list[str]]:
        """What numbers mean: ``semantic``, class by class, and ``affordance``, the last axis of the array."""
        first, *others = [job.program for job in self._jobs]
        for other in others:
            if _classes(other) != _classes(first):
                raise UsageError(
                    f"{first.name} and {other.name} number their semantic classes differently",
                    "let both use the vocabulary of one module, or stream them apart",
                )
        known = {name for job in self._jobs for name in _affordances(job.program)}
        return {"semantic": _classes(first), "affordance": sorted(known)}

    def batch(self, k: int, epoch: int = 0) -> Arrays:
        """Batch ``k`` of an epoch: the arrays of the task, with ``object`` (B,), its number, and ``category`` (B,).

        Raises NoObject, UserError.
        """
        if not 0 <= k < len(self):
            raise IndexError(f"there are {len(self)} batches, no batch {k}")
        item = np.arange(k * self.each, min((k + 1) * self.each, self.size))
        place = item + (epoch * self.size if self.fresh else 0)
        number, category = np.divmod(place, len(self.sources))
        found: Arrays = {}
        for c in np.unique(category).tolist():
            mine = np.flatnonzero(category == c)
            made = self._jobs[c].of(number[mine]).batch()
            state = state_of(made, self.states, 0 if self.fresh else epoch)
            for name, array in make_arrays(made, self.task, self.points, state, self.words, self.view).items():
                found.setdefault(name, np.empty((len(item), *array.shape[1:]), array.dtype))[mine] = array
        for rank, transform in enumerate(self.transforms):
            found = transform(found, Draws(self.seed, str(rank), place, epoch))
        return {"object": number, "category": category} | found


def _classes(program: Program) -> list[str]:
    return list(program.vocabularies.get("semantic", ()))


def _affordances(program: Program) -> list[str]:
    return [label.name for label in program.labels if label.vocabulary == "affordance"]
