"""A folder of bound details: for each fitted object a file of its details and a record of how well they were bound.

What is there already, bound from the same file with the same options, is left alone. An object that cannot be bound is listed with the
reason, and stops no other.
"""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..details.binding import bind
from ..details.record import VERSION, to_arrays
from ..details.report import report
from ..errors import UserError
from ..export.containers import npz_bytes
from ..export.write import ensure_folder, is_there, sweep_unfinished, write_bytes
from ..fit.real import check_record, closed, read_real
from ..records import dataclass
from .fits import FITS, SUMMARY, list_objects, mark, read_record
from .job import Job, ProgramChanged
from .resume import reopen
from .sharing import share
from .workers import map_each

_SUMMARY = "bind.json"
_NAMED = 3  # files that a message names
_HINT = "apgc fit CATEGORY FILES -o fitted writes such a folder"
_AGAIN = "the command that fitted these objects writes it anew, and fits only what is missing"


Item = tuple[int, Mapping[str, Any], Path]  # the number of an object, what was fitted, and its file


@dataclass(frozen=True, slots=True)
class Binding:
    """What is bound: the objects of the folder ``fitted`` into ``out``, with ``points`` each, by an ``assignment``; ``completed``: what was
    hidden, too."""

    fitted: Path
    out: Path
    points: int
    assignment: str
    completed: bool = True

    def plain(self, program: str) -> dict[str, Any]:
        return {
            "version": VERSION,
            "program": program,
            "points": self.points,
            "assignment": self.assignment,
            "completed": self.completed,
        }


def write_bindings(
    asked: Binding,
    real: Sequence[Path] = (),
    *,
    force: bool = False,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Bind the details of fitted objects and write the folder; what its summary says. ``real``: the files that were fitted, where they are
    not where they were. Raises UserError."""
    summary = read_record(asked.fitted / SUMMARY)
    if summary is None:
        raise UserError(f"{asked.fitted} is not a folder of fitted objects", _HINT)
    good = [one for one in _fitted_objects(asked.fitted, summary) if one["object"] is not None]
    if not good:
        raise UserError(f"no object in {asked.fitted} fits its category", "see the verdicts in its fit.json")
    sweep_unfinished(ensure_folder(asked.out))
    try:
        job = reopen(asked.fitted)
    except ProgramChanged as changed:
        raise UserError(
            f"{asked.fitted} was fitted with another text of {summary['category']}: it, or a module it uses, has changed"
            f" (digest {changed.made[:8]} then, {changed.now[:8]} now), and with it what the fitted values mean",
            f"fit again: {_fit_again(changed.source, asked.fitted, summary)}",
        ) from None
    strange = {one["object"] for one in good} - set(job.request.objects.tolist())
    if strange:
        raise UserError(f"{asked.fitted} has no object {min(strange)}, which its {SUMMARY} lists", _AGAIN)
    options = asked.plain(job.program.hash)
    marked = {mark(path): path for path in real}
    work: list[Item] = []
    for one in good:
        record = read_record(asked.fitted / FITS / f"{one['name']}.json") or {}
        path = marked.get(record.get("file", ""), Path(one["source"])) if real else Path(one["source"])
        work.append((int(one["object"]), record | {"name": one["name"]}, path))
    if real and not marked.keys() & {record.get("file") for _, record, _ in work}:
        more = f" and {len(real) - 1} more" if real[1:] else ""
        raise UserError(
            f"{real[0]}{more}: none of these was fitted, or they have changed since", "name the files that were fitted"
        )
    if not force:
        _refuse_others(asked.out, work)
    left = [item for item in work if force or not _done(asked, options, item)]
    done = len(work) - len(left)
    if progress:
        progress(done, len(work))
    for _ in _each(job, asked, left, workers):
        done += 1
        if progress:
            progress(done, len(work))
    return _summarize(asked, summary, options, [record["name"] for _, record, _ in work])


def _fitted_objects(folder: Path, summary: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """What the summary of a fit says of its objects. Raises UserError where it was changed so that it cannot be read."""
    found = list_objects(summary, "name", "source", "verdict")
    numbers = [one.get("object", "") for one in found]
    whole = all(number is None or type(number) is int for number in numbers)
    if not whole or found != summary.get("objects") or not isinstance(summary.get("category"), str):
        raise UserError(f"{folder / SUMMARY} is damaged", _AGAIN)
    return found


def _refuse_others(out: Path, work: Sequence[Item]) -> None:
    """Refuse a folder of details of other files that are still there: they would be gone from its summary. Raises UserError."""
    files, sources = {record.get("file") for _, record, _ in work}, {path.resolve() for _, _, path in work}
    others = []
    for one in list_objects(read_record(out / _SUMMARY), "name"):
        record = read_record(out / f"{one['name']}.json") or {}
        path = Path(str(record.get("source", "")))
        if record.get("file") not in files and path.resolve() not in sources and path.is_file():
            others.append(str(path))
    if others:
        raise UserError(
            f"{out} holds details of {others[0]}" + (f" and {len(others) - 1} more" if others[1:] else ""),
            "choose another folder with -o, or use --force to leave them out",
        )


def _fit_again(source: str, folder: Path, summary: Mapping[str, Any]) -> str:
    """The command that fits the files of a folder, with the options that tell how they stand."""
    frame = summary.get("options", {}).get("frame", {})
    options = [f"--{name}={frame[name]}" for name in ("up", "front", "unit") if frame.get(name, "auto") != "auto"]
    options += ["--normalised"] if frame.get("normalised") else []
    files = list(dict.fromkeys(one["source"] for one in summary["objects"]))
    straight = os.path.normpath(source)  # what `..` follows may be a link: then the path stays as it is
    if os.path.exists(source) and os.path.exists(straight) and os.path.samefile(source, straight):
        source = straight
    named = files if len(files) <= _NAMED else [*files[:_NAMED], "..."]
    return " ".join(
        [
            "apgc fit",
            *map(shlex.quote, [source, *named[:_NAMED]]),
            *named[_NAMED:],
            *options,
            "-o",
            shlex.quote(str(folder)),
        ]
    )


_theirs: tuple[Job, Binding] | None = None  # what this worker works for


def _take(job: Job, asked: Binding) -> None:
    global _theirs
    _theirs = job, asked


def _each(job: Job, asked: Binding, items: list[Item], workers: int) -> Iterator[str]:
    def bind(item: Item) -> str:
        return _bind_one(job, asked, item)

    return share(
        items, workers, bind, lambda rest, many: map_each(_bind_theirs, rest, many, _take, job, asked, here=bind)
    )


def _bind_theirs(item: Item) -> str:
    assert _theirs is not None
    return _bind_one(*_theirs, item)


def _bind_one(job: Job, asked: Binding, item: Item) -> str:
    """Write the files of one object; its name."""
    number, record, path = item
    options, name = asked.plain(job.program.hash), record["name"]
    told: dict[str, Any] = {"name": name, "object": number, "source": str(path)}
    try:
        check_record(record)
        if not path.exists():
            raise UserError(f"there is no file {path}", "name the files that were fitted: apgc bind FITTED FILES")
        if mark(path) != record["file"]:
            raise UserError(f"{path} is not the file that was fitted, or has changed since", "fit it again")
        real = read_real(path, record)
        batch = job.batch(np.array([number]))
        if record.get("joints"):
            real = closed(batch, real, record["joints"])
        details = bind(batch, real, asked.points, asked.assignment, asked.completed)
        if not len(details):
            raise UserError("none of its points has a counterpart on the structure", "give more of them: --points 8192")
        arrays = to_arrays(details, job.program.hash)
        told |= report(batch, real, arrays, asked.points)
    except UserError as wrong:
        told["failed"] = wrong.message + (f" ({wrong.hint})" if wrong.hint else "")
        (asked.out / f"{name}.npz").unlink(missing_ok=True)
    else:
        write_bytes(asked.out / f"{name}.npz", npz_bytes(arrays), force=True)
    told |= {key: record.get(key) for key in ("file", "to_object")} | {"options": options}
    told |= {key: record[key] for key in ("joints", "drawn") if record.get(key)}
    write_bytes(asked.out / f"{name}.json", _to_text(told), force=True)
    return str(name)


def _done(asked: Binding, options: Mapping[str, Any], item: Item) -> bool:
    number, record, _ = item
    found = read_record(asked.out / f"{record['name']}.json")
    if found is None or "failed" in found or found.get("options") != options or found.get("object") != number:
        return False
    whole = isinstance(found.get("figures"), dict) and {"points", "completed"} <= found.keys()
    same = all(
        (found.get(key) or None) == (record.get(key) or None) for key in ("file", "to_object", "joints", "drawn")
    )
    return whole and same and is_there(asked.out / f"{record['name']}.npz")


def _summarize(
    asked: Binding, fitted: Mapping[str, Any], options: Mapping[str, Any], names: Sequence[str]
) -> dict[str, Any]:
    records = [found for name in names if (found := read_record(asked.out / f"{name}.json")) is not None]
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
    failed = [{"name": r["name"], "source": r["source"], "reason": r["failed"]} for r in records if "failed" in r]
    failed += [
        {
            "name": one["name"],
            "source": one["source"],
            "reason": f"{one['verdict']}: it is not among the fitted objects",
        }
        for one in fitted["objects"]
        if one["object"] is None
    ]
    summary = {"category": fitted["category"], "options": options, "objects": objects, "failed": failed}
    write_bytes(asked.out / _SUMMARY, _to_text(summary), force=True)
    return summary


def _to_text(record: Mapping[str, Any]) -> bytes:
    return (json.dumps(record, indent=1, ensure_ascii=False) + "\n").encode()
