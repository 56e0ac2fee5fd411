"""Details bound to fitted objects: a record of each and the arrays of its details, in files or in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from ..details.assign import ASSIGNMENTS
from ..details.binding import bind
from ..details.record import VERSION, to_arrays
from ..details.report import report
from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError, UserError
from ..fit.real import check_record, closed, read_real
from ..fit.sources import File, Held
from ..records import dataclass
from .fitting import Record, explain
from .job import Job
from .sharing import share
from .workers import map_each

Arrays = dict[str, np.ndarray]


@dataclass(frozen=True, slots=True)
class Fit:
    """What is bound to: the ``number`` of a fitted object, the ``record`` of its fit, and what it was fitted to."""

    number: int
    record: Mapping[str, Any]
    real: File | Held

    @property
    def name(self) -> str:
        return str(self.record["name"])


@dataclass(frozen=True, slots=True)
class Binding:
    """How details are bound: ``points`` of each surface, by an ``assignment``; ``completed``: what was hidden, too."""

    points: int
    assignment: str
    completed: bool = True

    def plain(self, program: str) -> Record:
        return {
            "version": VERSION,
            "program": program,
            "points": self.points,
            "assignment": self.assignment,
            "completed": self.completed,
        }

    def bind(self, job: Job, one: Fit) -> tuple[Record, Arrays | None]:
        """The record of one object and the arrays of its details, None where it could not be bound: then the record has the reason."""
        record, arrays = one.record, None
        told: Record = {"name": one.name, "object": one.number, "source": str(one.real)}
        try:
            check_record(record)
            one.real.require(record["file"])
            real = read_real(one.real, record)
            batch = job.batch(np.array([one.number]))
            if record.get("joints"):
                real = closed(batch, real, record["joints"])
            details = bind(batch, real, self.points, self.assignment, self.completed)
            if not len(details):
                raise UserError(
                    "none of its points has a counterpart on the structure", "give more of them: --points 8192"
                )
            arrays = to_arrays(details, job.program.hash)
            told |= report(batch, real, arrays, self.points)
        except UserError as wrong:
            told["failed"] = explain(wrong)
        told |= {key: record.get(key) for key in ("file", "to_object")} | {"options": self.plain(job.program.hash)}
        told |= {key: record[key] for key in ("joints", "drawn") if record.get(key)}
        return told, arrays


def read_assignment(name: Any) -> str:
    """How points are assigned. Raises UsageError."""
    if not isinstance(name, str) or name not in ASSIGNMENTS:
        hint = f"the ways are {', '.join(ASSIGNMENTS)}"
        raise UsageError(f"there is no assignment {name!r}", did_you_mean(str(name), ASSIGNMENTS) or hint)
    return name


_theirs: tuple[Job, Binding] | None = None  # what this worker works for


def _take(job: Job, asked: Binding) -> None:
    global _theirs
    _theirs = job, asked


def _bind_theirs(one: Fit) -> tuple[Record, Arrays | None]:
    assert _theirs is not None
    job, asked = _theirs
    return asked.bind(job, one)


def bind_all(
    job: Job, asked: Binding, fits: Sequence[Fit], workers: int, progress: Callable[[int, int], None]
) -> list[tuple[Record, Arrays | None]]:
    """The records and details of all objects, in their order. ``progress(done, total)`` hears of each that is finished."""

    def alone(one: Fit) -> tuple[Record, Arrays | None]:
        return asked.bind(job, one)

    def others(rest: Sequence[Fit], many: int) -> Iterator[tuple[Record, Arrays | None]]:
        return map_each(_bind_theirs, rest, many, _take, job, asked, here=alone)

    found: list[tuple[Record, Arrays | None]] = []
    progress(0, len(fits))
    for one in share(fits, workers, alone, others):
        found.append(one)
        progress(len(found), len(fits))
    return found


def summarize(
    category: str, options: Mapping[str, Any], records: Sequence[Mapping[str, Any]], fitted: Sequence[Mapping[str, Any]]
) -> Record:
    """What is said of all objects together; ``fitted``: the objects as the summary of their fit has them."""
    objects = [
        {
            "object": r["object"],
            "name": r["name"],
            "details": f"{r['name']}.npz",
            "points": r["points"],
            "completed": r["completed"],
        }
        | r["figures"]
        for r in records
        if "failed" not in r
    ]
    failed = [{"name": r["name"], "reason": r["failed"]} for r in records if "failed" in r]
    failed += [
        {"name": one["name"], "reason": f"{one['verdict']}: it is not among the fitted objects"}
        for one in fitted
        if one["object"] is None
    ]
    return {"category": category, "options": options, "objects": objects, "failed": failed}
