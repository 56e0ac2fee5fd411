"""Batches of objects that are made on the way: nothing is stored, and no object comes twice unless asked for.

Item ``i`` of epoch ``e`` is object ``e * size + i`` of the source, or ``i`` again where ``fresh`` is false; with several categories they
take turns. A batch is a function of its number and the epoch alone: it is the same on any number of workers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..annotate.cloud import Dress
from ..annotate.sampling import MOST
from ..api.bound import Worn, lend_details
from ..arguments import read_flag, read_paths, read_whole
from ..details.dressing import refuse_idle_strength
from ..errors import SettingError, UsageError
from ..run.job import Job, open_job, open_program, prepare
from ..run.prior import PriorFile, read_prior
from ..run.request import read_request
from ..run.schema import LARGEST
from ..run.settings import Value
from .classes import find_classes
from .draws import Draws, read_epoch
from .tasks import Arrays, find_task, make_arrays, one_camera, state_of
from .transforms import Transform, apply_transform, read_transforms

if TYPE_CHECKING:
    from ..graph.program import Program
    from ..run.request import Request
    from ..runtime.batch import Batch


_OF_EACH = 16  # objects of a category that are made at once, by making several batches together
_MOST_POINTS = 1 << 20  # of batches that are made together


class Stream:
    """``len(stream)`` batches an epoch; ``stream.batch(k, epoch)`` makes one of them.

    ``categories``: a name, a file, or several, in turn. ``task``: see ``TASKS``. ``size``: objects an epoch; ``batch``: objects a
    batch; ``points``: of each cloud. ``states``: "rest", "open", "random", or joints by name, ``lid=20%``. ``set``, ``checked`` and
    ``frame`` as in ``sample``, and ``prior``; with several categories, ``set`` holds for all of them, or has for each its own,
    ``{"Door": {"width": "90cm"}}``, and those that a file of priors does not speak of are drawn as declared.
    ``fresh``: other objects in each epoch; otherwise the same objects and points, while random states and transforms are new.
    ``classes``: classes of one's own, by the words of `semantic`, ``{"door": "door", "drawer": "door", "*": "body"}``.
    ``transforms`` are applied in their order. ``view``: the camera of ``partial``, as in camera files. ``details``: a
    folder that ``apgc bind`` has written, or what ``bind`` of fitted objects gives, whose details the points borrow, scaled by
    ``detail_strength`` 0 .. 1; with several categories, those of each, by the name that the category was given by. Raises CompileError,
    SettingError, UsageError, UserError.
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
        set: Mapping[str, Value] | Mapping[str, Mapping[str, Value]] | None = None,
        checked: bool = True,
        prior: str | Path | Mapping[str, Any] | None = None,
        frame: str | Path | None = None,
        fresh: bool = True,
        classes: Mapping[str, str] | None = None,
        transforms: Iterable[Transform] = (),
        view: Mapping[str, Any] | None = None,
        details: Worn | Mapping[str, Worn] = None,
        detail_strength: float = 1.0,
    ):
        self.sources = read_paths("categories", categories, 'Stream(["Microwave", "Door"])')
        self.task = find_task(task)
        if not self.sources:
            raise UsageError("there is no category to make objects of", 'name one, such as Stream("Microwave")')
        if twice := next((s for k, s in enumerate(self.sources) if s in self.sources[:k]), None):
            raise UsageError(f"{twice} is named twice: each of its objects would come twice", "name it once")
        if view is not None and not isinstance(view, Mapping):
            raise UsageError(f"view is {view!r}", 'it says what a camera file says: view={"width": 320}')
        if view is not None and not self.task.partial:
            raise UsageError(f"{self.task.name} has no camera to look through", "leave out `view`, or take completion")
        refuse_idle_strength(details, detail_strength)
        self.size, self.each = read_whole("size", size, 1, LARGEST), read_whole("batch", batch, 1)
        self.points = read_whole("points", points, 1, MOST)
        self.seed = read_whole("seed", seed)
        self.states, self.fresh = states, read_flag("fresh", fresh)
        self.camera = one_camera(view or {}, self.points) if self.task.partial else None
        self.transforms, self._chosen = read_transforms(transforms), classes
        self._nested, self._checked = (
            isinstance(set, Mapping) and any(isinstance(v, Mapping) for v in set.values()),
            checked,
        )
        each: Mapping[str, Any] = (
            self._by_source("settings", set or {}) if self._nested else dict.fromkeys(self.sources, set)
        )
        self._settings = each
        self._prior = None if prior is None else read_prior(prior)
        self._frame = frame
        self.words  # noqa: B018  # what is wrong with the arguments is told here, not in a worker
        if self._prior is not None and all(job.request.prior is None for job in self._jobs):
            raise UsageError(f"{self._prior.name} says nothing of {', '.join(self.categories)}", "leave out `prior`")
        for job in self._jobs:
            state_of(job.of([0]).batch(), states, 0)
        self._dresses = self._find_dresses(details, detail_strength)

    def __len__(self) -> int:
        return -(-self.size // self.each)

    def __getstate__(self) -> dict[str, Any]:
        """Another process opens the programs itself: they are kept compiled on disk."""
        return {name: value for name, value in self.__dict__.items() if name != "_jobs"}

    @cached_property
    def _jobs(self) -> list[Job]:
        return [self._open(source) for source in self.sources]

    def _open(self, source: str) -> Job:
        settings = self._settings.get(source)
        request = read_request(source, seed=self.seed, n=1, settings=settings, checked=self._checked, frame=self._frame)
        try:
            return self._open_request(source, request)
        except SettingError as wrong:
            if len(self.sources) == 1 or self._nested:
                raise
            raise SettingError(wrong.message, f'set={{"{source}": {{...}}}} is for one of the categories') from None

    def _open_request(self, source: str, request: Request) -> Job:
        if not isinstance(self._prior, PriorFile) or len(self.sources) == 1:
            return open_job(replace(request, prior=self._prior))
        sampler, name = open_program(source)
        known = sampler.program.name in self._prior.categories
        return prepare(sampler, replace(request, source=name, prior=self._prior if known else None))

    def _by_source(self, what: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """What is given for each source by its name. Raises UsageError."""
        for name in given:
            if str(name) not in self.sources:
                raise UsageError(f"there are {what} for {name}, which is not streamed", f"name {self.sources[0]}")
        return {str(name): value for name, value in given.items()}

    def _find_dresses(self, details: Worn | Mapping[str, Worn], strength: float) -> list[Dress | None]:
        """How the points of each source are moved, None for one without details. Raises UsageError, UserError."""
        if details is None:
            return [None] * len(self.sources)
        if self.task.partial:
            raise UsageError(
                f"{self.task.name} compares points with what a camera sees of the structure",
                "leave out details, which cameras do not see",
            )
        from ..details.store import dress  # start-up: k-d trees load slowly

        each = (
            self._by_source("details", details)
            if isinstance(details, Mapping)
            else dict.fromkeys(self.sources, details)
        )
        pairs = zip(self.sources, self._jobs, strict=True)
        lent = [lend_details(each.get(source), strength, job.program) for source, job in pairs]
        return [None if worn is None else partial(dress, dressing=worn) for worn in lent]

    @property
    def categories(self) -> list[str]:
        """The names that ``category`` counts."""
        return [job.program.name for job in self._jobs]

    @cached_property
    def words(self) -> dict[str, list[str]]:
        """What numbers mean: ``semantic``, class by class, and ``affordance``, the last axis of the array."""
        known = {name for job in self._jobs for name in _affordances(job.program)}
        return {"semantic": self._classes[0], "affordance": sorted(known)}

    @cached_property
    def _classes(self) -> tuple[list[str], list[np.ndarray] | None]:
        programs = [job.program for job in self._jobs]
        found = find_classes(self._chosen, [list(p.vocabularies.get("semantic", ())) for p in programs])
        if found is None:
            odd = next(
                p for p in programs if p.vocabularies.get("semantic") != programs[0].vocabularies.get("semantic")
            )
            raise UsageError(
                f"{programs[0].name} and {odd.name} number their semantic classes differently",
                "name `classes` of your own, let both use the vocabulary of one module, or stream them apart",
            )
        return found

    def batch(self, k: int, epoch: int = 0) -> Arrays:
        """Batch ``k`` of an epoch: the arrays of the task, with ``object`` (B,), its number, and ``category`` (B,).

        Raises NoObject, IndexError, UsageError, UserError.
        """
        return next(self.batches([k], epoch))

    def batches(self, numbers: Iterable[int], epoch: int = 0) -> Iterator[Arrays]:
        """The batches of these numbers, one after the other, each as of ``batch``. Raises as it does.

        Those of many categories take less time together: of each, one object takes nearly as long as ten.
        """
        epoch, wanted = read_epoch(epoch), iter(numbers)
        if self.fresh and (epoch + 1) * self.size > LARGEST:
            raise UsageError(f"epoch is {epoch}", f"up to {LARGEST // self.size - 1:,} there are objects of their own")
        together = min(-(-_OF_EACH * len(self.sources) // self.each), _MOST_POINTS // (self.each * self.points))
        while some := [self._number(k) for k in islice(wanted, max(1, together))]:
            yield from self._make(some, epoch)

    def _number(self, k: int) -> int:
        number = read_whole("the number of a batch", k)
        if not 0 <= number < len(self):
            raise IndexError(f"there are {len(self)} batches, no batch {number}")
        return number

    def _make(self, numbers: Sequence[int], epoch: int) -> Iterator[Arrays]:
        """Some batches, whose objects are made at once."""
        ranges = [range(k * self.each, min((k + 1) * self.each, self.size)) for k in numbers]
        place = np.concatenate(ranges) + (epoch * self.size if self.fresh else 0)
        number, category = np.divmod(place, len(self.sources))
        every: Arrays = {}
        for c in np.unique(category).tolist():
            mine = np.flatnonzero(category == c)
            made = self._jobs[c].of(number[mine]).batch()
            state = state_of(made, self.states, 0 if self.fresh else epoch)
            for name, array in self._arrays(c, made, state).items():
                every.setdefault(name, np.empty((len(place), *array.shape[1:]), array.dtype))[mine] = array
        stop = 0
        for own in ranges:
            rows = slice(stop, stop := stop + len(own))
            found = {name: array[rows] for name, array in every.items()}
            for rank, transform in enumerate(self.transforms):
                found = apply_transform(transform, found, Draws(self.seed, str(rank), place[rows], epoch))
            yield {"object": number[rows], "category": category[rows]} | found

    def _arrays(self, category: int, made: Batch, state: np.ndarray) -> Arrays:
        found = make_arrays(made, self.task, self.points, state, self.words, self.camera, self._dresses[category])
        tables = self._classes[1]
        return (
            found
            if tables is None or "semantic" not in found
            else found | {"semantic": tables[category][found["semantic"]]}
        )


def _affordances(program: Program) -> list[str]:
    return [label.name for label in program.labels if label.vocabulary == "affordance"]
