"""Which details the objects of a job wear: their own, if these were bound to them or to what they were made from, else borrowed ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..details.dressing import SUMMARY, Dressing
from ..details.store import read_dressing, require_donors
from ..errors import UserError
from .bindings import read_kept
from .fits import list_objects, read_record
from .job import Job
from .params import read_values

Drawn = Mapping[int, Any]  # the values of the objects that details are bound to, by their numbers


def dress_as(job: Job, dressing: Dressing, drawn: Drawn) -> Dressing:
    """How objects of a job wear details that are bound to those of the values ``drawn``. Raises UserError."""
    own = _has(job, drawn)
    chosen = replace(dressing, borrowed=not own)
    require_donors(chosen, job.program, job.originals if own else None)
    return chosen


def dress(job: Job, folder: str | Path, strength: float) -> Dressing:
    """How objects of a job wear the details in a folder. Raises UserError, UsageError."""
    dressing = read_dressing(folder, strength)
    return dress_as(job, dressing, {} if job.request.values is None else _read_drawn(Path(dressing.folder)))


def _read_drawn(folder: Path) -> Drawn:
    """The values of the objects that the details in a folder are bound to, as far as its records have them."""
    objects = list_objects(read_record(folder / SUMMARY), "name")
    return {one["object"]: (read_kept(folder, one["name"]) or {}).get("drawn") for one in objects}


def _has(job: Job, drawn: Drawn) -> bool:
    """Whether the objects of these numbers and values are those of the job, or what its mutants are made from."""
    given = job.request.values
    if given is None or not drawn:
        return False
    for number, values in drawn.items():
        if not isinstance(number, int) or not 0 <= number < len(given) or not isinstance(values, Mapping):
            return False
        try:
            if read_values([values], job.program, "").plain[0] != given[number]:
                return False
        except UserError:  # values of another program
            return False
    return True
