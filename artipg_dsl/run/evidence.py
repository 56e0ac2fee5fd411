"""The evidence about the objects of a job: gathered some objects at a time, by one process or several, and put together.

What is put together does not depend on the number of processes: the objects are always divided in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ..errors import NoObject
from ..export.strict import Strict, check_meshes, join_strict, require_manifold
from ..records import dataclass
from ..validity.evidence import Evidence, find_evidence, join_evidence
from .job import Job
from .schema import to_runs
from .sharing import share
from .workers import map_each

_TOGETHER = 64  # objects
_STEPS = ("drawing objects", "checking them as they are drawn", "drawing objects until they are valid")
_LATER = ("checking them in all states", "checking what is seen")

Stage = Callable[[int, str], None]
"""Told the number of a step of what is done with some objects, and the step in words."""


@dataclass(frozen=True, slots=True)
class _Seen:
    """What is known of some objects: as they are drawn, and as they are ``delivered`` (None, and ``why``, where one cannot be)."""

    drawn: Evidence
    delivered: Evidence | None
    meshes: Strict | None
    why: str | None
    counted: tuple[int, int, int]  # objects, valid first attempts, attempts


@dataclass(frozen=True, slots=True)
class _Task:
    job: Job
    states: int
    meshes: bool

    def look(self, numbers: np.ndarray, stage: Stage = lambda *_: None) -> _Seen:
        """The evidence about the objects of some numbers."""
        runs = to_runs(numbers)
        free, job = (self.job.but(numbers=runs, **more) for more in ({"checked": False}, {}))
        stage(0, _STEPS[0])
        batch = free.batch()
        stage(1, _STEPS[1])
        drawn = find_evidence(batch, 0)
        stage(2, _STEPS[2])
        delivered: Evidence | None = None
        seen: Strict | None = None
        why = None
        try:
            batch = job.batch()
            stage(3, _LATER[0])
            delivered = find_evidence(batch, self.states)
            if self.meshes:
                stage(4, _LATER[1])
                seen = check_meshes(batch, self.states)
        except NoObject as error:
            why = error.message + (f"\n  = help: {error.hint}" if error.hint else "")
        made = job.statistics
        return _Seen(drawn, delivered, seen, why, (made.objects, made.first_valid, made.attempts))


def examine(
    job: Job,
    states: int,
    meshes: bool = False,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda *_: None,
    stage: Callable[[str], None] = lambda _: None,
) -> dict[str, Any]:
    """All evidence as plain data. ``drawn`` are objects that meet the requirements, ``delivered`` what is handed out;
    ``meshes``: what is delivered, by what is seen of it. ``progress`` is told (objects done, of), ``stage`` what is being done.
    Raises UserError where meshes are asked for and manifold3d is not installed."""
    if meshes:
        require_manifold()
    task, numbers = _Task(job, states, meshes), job.request.objects
    parts = [numbers[start : start + _TOGETHER] for start in range(0, len(numbers), _TOGETHER)]
    steps = 4 + meshes
    found = list(_looked_at(task, parts, workers, steps, progress, stage))
    objects, first_valid, attempts = (sum(column) for column in zip(*(f.counted for f in found), strict=True))
    delivered = [f.delivered for f in found if f.delivered is not None]
    seen = [f.meshes for f in found if f.meshes is not None]
    whole = len(delivered) == len(found)
    return {
        "category": job.program.name,
        "seed": job.request.seed,
        "objects": len(numbers),
        "checked": job.request.checks(),
        "first_valid": first_valid / max(objects, 1),
        "attempts": attempts,
        "drawn": asdict(join_evidence([f.drawn for f in found])),
        "delivered": asdict(join_evidence(delivered)) if whole else None,
        "meshes": asdict(join_strict(seen)) if whole and seen else None,
        "exhausted": next((f.why for f in found if f.why is not None), None),
        "kinds": {joint.path: joint.kind for joint in job.program.joints},
    }


def _looked_at(
    task: _Task,
    parts: Sequence[np.ndarray],
    workers: int,
    steps: int,
    progress: Callable[[int, int], None],
    stage: Callable[[str], None],
) -> Iterator[_Seen]:
    """The evidence about each part, in their order."""
    done, total = 0, sum(len(part) for part in parts)

    def told(step: int, words: str) -> None:
        stage(f"{words} (step {step + 1} of {steps})")

    def count(part: Sequence[int] | np.ndarray) -> None:
        nonlocal done
        done += len(part)
        progress(done, total)

    def alone(part: np.ndarray) -> _Seen:
        seen = task.look(part, told)
        count(part)
        return seen

    def others(rest: Sequence[np.ndarray], many: int) -> Iterator[_Seen]:
        stage(f"checking objects with {many} workers")
        looked = map_each(_look, rest, many, _take, task, here=task.look)
        for part, seen in zip(rest, looked, strict=True):
            count(part)
            yield seen

    progress(0, total)

    return share(parts, workers, alone, others)


_task: _Task | None = None  # what this worker works for


def _take(task: _Task) -> None:
    global _task
    _task = task


def _look(numbers: np.ndarray) -> _Seen:
    assert _task is not None
    return _task.look(numbers)
