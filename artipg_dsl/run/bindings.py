"""A folder of bound details: for each fitted object a file of its details and a record of how well they were bound.

What is there already, bound from the same file with the same options, is left alone. An object that cannot be bound is listed with the
reason, and stops no other.
"""

from __future__ import annotations

import os
import shlex
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..details.dressing import SUMMARY as BOUND
from ..errors import UserError
from ..export.containers import npz_bytes
from ..export.write import ensure_folder, is_there, sweep_unfinished, write_bytes
from ..files import read_arrays
from ..fit.real import check_record
from ..fit.sources import MEMORY, File, Item, mark
from . import manifest as manifests
from .binding import Arrays, Binding, Fit, summarize
from .fits import FACTS, FITS, SUMMARY, Folder, list_objects, read_record, refuse_other
from .fitting import Record, to_text
from .folders import refuse_others
from .job import Job, ProgramChanged
from .resume import REPEAT, reopen
from .sharing import share
from .sources import seen_from, seen_here
from .workers import map_each

_RECORDS = "records"  # of the objects, in the folder; they lay beside its summary before
_NAMED = 3  # files that a message names
_HINT = "apgc fit CATEGORY FILES -o fitted writes such a folder"
_TITLES = {"points": "the number of points", "assignment": "the assignment", "completed": "what was hidden completed"}
_AGAIN = "the command that fitted these objects writes it anew, and fits only what is missing"


def write_bindings(
    fitted: Path,
    asked: Binding,
    out: Path,
    real: Sequence[Path] = (),
    *,
    force: bool = False,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Record:
    """Bind the details of the objects in a folder of fits and write the folder ``out``; what its summary says. ``real``: the files that were
    fitted, where they are not where they were. Raises UserError."""
    summary = _read_summary(fitted)
    job, work = _open_fits(fitted, summary, real)
    told, _ = bind_into(out, job, asked, work, summary, force=force, workers=workers, progress=progress)
    return told


def bind_into(
    out: Path,
    job: Job,
    asked: Binding,
    work: Sequence[Fit],
    fitted: Record,
    *,
    force: bool = False,
    workers: int,
    progress: Callable[[int, int], None] | None,
) -> tuple[Record, list[Record]]:
    """Bind what the folder ``out`` does not have yet, and write it; what its summary says, and the records of all objects. ``fitted``: the
    summary of their fit. ``progress(done, total)`` hears of each that is finished. Raises UserError."""
    refuse_others(out, "details", hint="details go into a folder of their own")
    for folder in (out, out / _RECORDS):
        sweep_unfinished(ensure_folder(folder))
    options = asked.plain(job.program.hash)
    if not force:
        _refuse_others(out, work)
        _refuse_changes(out, work, options)
    left = [one for one in work if force or not _done(out, options, one)]
    done = len(work) - len(left)
    if progress:
        progress(done, len(work))
    for _ in _each(job, asked, out, left, workers):
        done += 1
        if progress:
            progress(done, len(work))
    read = (read_kept(out, one.name) for one in work)
    records = [seen_here(out, found) for found in read if found is not None]
    told = summarize(fitted["category"], options, records, fitted["objects"])
    _tell(out, told, {one.name for one in work})
    return told, records


def read_bound(out: Path, record: Record) -> Arrays | None:
    """The arrays of an object that was bound into a folder; None where the record says that it could not be. Raises UserError."""
    if "failed" in record:
        return None
    path = out / f"{record['name']}.npz"
    try:
        with open(path, "rb") as file:
            return read_arrays(file)
    except (OSError, ValueError) as wrong:
        raise UserError(f"{path} cannot be read: {wrong}", "remove it, and bind again") from None


def read_kept(out: Path, name: str) -> Record | None:
    """The record of an object in a folder of details, also of one that has it beside its summary."""
    found, before = read_record(out / _RECORDS / f"{name}.json"), _beside(out, name)
    return read_record(before) if found is None and before is not None else found


def save_bindings(
    out: Path, told: Record, bound: Sequence[tuple[Record, Arrays | None]], *, force: bool = False
) -> None:
    """Write the folder of details that are bound already; ``told``: what its summary says. Raises UserError."""
    refuse_others(out, "details", hint="details go into a folder of their own")
    refuse_other(out / BOUND, told, force)
    for folder in (out, out / _RECORDS):
        sweep_unfinished(ensure_folder(folder))
    for record, arrays in bound:
        _write(out, record, arrays)
    _tell(out, told, {record["name"] for record, _ in bound})


# ---------------------------------------------------------------- fitted objects


def _read_summary(fitted: Path) -> Record:
    """The summary of a folder of fits, some of which fit. Raises UserError."""
    if not fitted.is_dir():
        raise UserError(f"there is no folder {fitted} of fitted objects", _HINT)
    found = read_record(fitted / SUMMARY)
    if found is None:
        raise UserError(f"{fitted} is not a folder of fitted objects", _HINT)
    summary = seen_here(fitted, found)
    if all(one["object"] is None for one in _fitted_objects(fitted, summary)):
        raise UserError(f"no object in {fitted} fits its category", "see the verdicts in its fit.json")
    return summary


def open_fits(fitted: Path, real: Sequence[Path]) -> tuple[Job, list[Record], list[Item]]:
    """The job of the objects of a folder of fits, the records of all files, and what these are. ``real``: the files that were fitted, where
    they are not where they were. Raises UserError."""
    summary = _read_summary(fitted)
    job, work = _open_fits(fitted, summary, real)
    failed = list_objects({"objects": summary.get("failed")}, "name", "source")
    folder, records = Folder(fitted), []
    for one in [*summary["objects"], *failed]:
        record = folder.record(one["name"])
        if record is None or not isinstance(record.get("options"), dict):
            raise UserError(f"the record of {one['name']} in {fitted} is missing or damaged", _AGAIN)
        if one.get("object") is not None:
            check_record(record)
        records.append(record)
    found = {one.name: one.real for one in work}
    return job, records, [Item(record["name"], found.get(record["name"], folder.real(record))) for record in records]


def _open_fits(fitted: Path, summary: Record, real: Sequence[Path]) -> tuple[Job, list[Fit]]:
    good = [one for one in summary["objects"] if one["object"] is not None]
    try:
        job = reopen(fitted)
    except ProgramChanged as changed:
        raise UserError(
            f"{fitted} was fitted with another text of {summary['category']}: it, or a module it uses, has changed"
            f" (digest {changed.made[:8]} then, {changed.now[:8]} now), and with it what the fitted values mean",
            f"fit again: {_fit_again(changed.source, fitted, summary)}",
        ) from None
    strange = {one["object"] for one in good} - set(job.request.objects.tolist())
    if strange:
        raise UserError(f"{fitted} has no object {min(strange)}, which its {SUMMARY} lists", _AGAIN)
    marked = {mark(path): path for path in real}
    work = []
    for one in good:
        record = read_record(fitted / FITS / f"{one['name']}.json") or {}
        record = {**record, "name": one["name"], "source": one["source"]}
        moved = marked.get(record.get("file", ""))
        found = Folder(fitted).real(record) if moved is None else File(moved)
        work.append(Fit(int(one["object"]), record, found))
    if real and not marked.keys() & {one.record.get("file") for one in work}:
        more = f" and {len(real) - 1} more" if real[1:] else ""
        raise UserError(
            f"{real[0]}{more}: none of these was fitted, or they have changed since", "name the files that were fitted"
        )
    return job, work


def _fitted_objects(folder: Path, summary: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """What the summary of a fit says of its objects. Raises UserError where it was changed so that it cannot be read."""
    found = list_objects(summary, "name", "source", "verdict")
    numbers = [one.get("object", "") for one in found]
    whole = all(number is None or type(number) is int for number in numbers)
    if not whole or found != summary.get("objects") or not isinstance(summary.get("category"), str):
        raise UserError(f"{folder / SUMMARY} is damaged", _AGAIN)
    return found


def _refuse_others(out: Path, work: Sequence[Fit]) -> None:
    """Refuse a folder of details of other files that are still there, or of what was fitted from memory: they would be gone from its summary.
    Raises UserError."""
    files = {one.record.get("file") for one in work}
    sources = {one.real.path.resolve() for one in work if isinstance(one.real, File)}
    others = []
    for one in list_objects(read_record(out / BOUND), "name"):
        record = seen_here(out, read_kept(out, one["name"]) or {})
        source = str(record.get("source", ""))
        path = Path(source)
        if record.get("file") in files or (source != MEMORY and (path.resolve() in sources or not path.is_file())):
            continue
        others.append(f"{one['name']}, fitted from memory," if source == MEMORY else source)
    if others:
        raise UserError(
            f"{out} holds details of {others[0]}" + (f" and {len(others) - 1} more" if others[1:] else ""),
            "name another folder; `apgc bind --force` leaves them out",
        )


def _refuse_changes(out: Path, work: Sequence[Fit], options: Mapping[str, Any]) -> None:
    """Refuse a folder of details of the same fits that were bound with other options: they would be replaced unasked. Raises UserError."""
    for one in work:
        found = read_kept(out, one.name) or {}
        old = found.get("options")
        if "failed" in found or not isinstance(old, dict) or not _is_of(found, one):
            continue
        if changed := manifests.describe_changes(_TITLES, old, options):
            raise UserError(f"{out} holds details bound with other options: {changed}", REPEAT)


def _fit_again(source: str, folder: Path, summary: Mapping[str, Any]) -> str:
    """The command that fits the files of a folder, with the options that tell how they stand."""
    frame = summary.get("options", {}).get("frame", {})
    options = [f"--{name}={frame[name]}" for name in ("up", "front", "unit") if frame.get(name, "auto") != "auto"]
    options += ["--normalised"] if frame.get("normalised") else []
    options += [f"--facts={shlex.quote(str(folder / FACTS))}"] if (folder / FACTS).is_file() else []
    known = [{**one, **(Folder(folder).record(one["name"]) or {})} for one in summary["objects"]]
    files = list(dict.fromkeys(str(Folder(folder).real(one).path) for one in known))
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
            "--force",
            "-o",
            shlex.quote(str(folder)),
        ]
    )


# ---------------------------------------------------------------- one object


_theirs: tuple[Job, Binding, Path] | None = None  # what this worker works for


def _take(job: Job, asked: Binding, out: Path) -> None:
    global _theirs
    _theirs = job, asked, out


def _each(job: Job, asked: Binding, out: Path, work: list[Fit], workers: int) -> Iterator[None]:
    def alone(one: Fit) -> None:
        _write(out, *asked.bind(job, one))

    def others(rest: Sequence[Fit], many: int) -> Iterator[None]:
        return map_each(_write_theirs, rest, many, _take, job, asked, out, here=alone)

    return share(work, workers, alone, others)


def _write_theirs(one: Fit) -> None:
    assert _theirs is not None
    job, asked, out = _theirs
    _write(out, *asked.bind(job, one))


def _write(out: Path, record: Record, arrays: Arrays | None) -> None:
    """Write the files of one object."""
    path = out / f"{record['name']}.npz"
    if arrays is None:
        path.unlink(missing_ok=True)
    else:
        write_bytes(path, npz_bytes(arrays), force=True)
    write_bytes(out / _RECORDS / f"{record['name']}.json", to_text(seen_from(out, record)), force=True)
    if (before := _beside(out, record["name"])) is not None:
        before.unlink(missing_ok=True)


def _beside(out: Path, name: str) -> Path | None:
    """Where the record of an object lay before; of none that is called like the summary."""
    return None if f"{name}.json" == BOUND else out / f"{name}.json"


def _tell(out: Path, told: Record, names: Collection[str]) -> None:
    """Write the summary, and remove the files of objects that the one before lists and that are none of ``names``."""
    before = read_record(out / BOUND) or {}
    listed = [
        one["name"] for key in ("objects", "failed") for one in list_objects({"objects": before.get(key)}, "name")
    ]
    write_bytes(out / BOUND, to_text(told), force=True)
    for name in listed:
        if name not in names and Path(name).name == name:  # should it have been edited
            for path in (out / _RECORDS / f"{name}.json", _beside(out, name), out / f"{name}.npz"):
                if path is not None:
                    path.unlink(missing_ok=True)


def _done(out: Path, options: Mapping[str, Any], one: Fit) -> bool:
    found = read_kept(out, one.name)
    if found is None or "failed" in found or found.get("options") != options or found.get("object") != one.number:
        return False
    whole = isinstance(found.get("figures"), dict) and {"points", "completed"} <= found.keys()
    return whole and _is_of(found, one) and is_there(out / f"{one.name}.npz")


def _is_of(found: Record, one: Fit) -> bool:
    """Whether a record of details is of a fit as it is now."""
    return all(
        (found.get(key) or None) == (one.record.get(key) or None) for key in ("file", "to_object", "joints", "drawn")
    )
