"""A folder of fitted objects: a record and a picture for each file, all values in one file, and the objects as samples.

Files are fitted in groups of a fixed order, so that a group gives the same whoever works on it. A group all of whose records are there
and tell of the same files, program and options is left alone.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from ..errors import UserError
from ..export.content import Content
from ..export.registry import choose_formats
from ..export.write import ensure_folder, is_there, sweep_unfinished, write_bytes
from ..fit.sources import File, Held, Item
from ..records import dataclass
from ..sampling.sample import Sampler
from ..view.overlay import overlay
from ..view.png import png_bytes
from ..view.sheet import Painter
from . import manifest as manifests
from .chunk import shard_path
from .dataset import write_dataset
from .facts import Facts
from .fitting import (
    Asked,
    Group,
    Record,
    Work,
    describe_options,
    good_ones,
    groups_of,
    prepare_fitted,
    summarize,
    to_text,
)
from .folders import FITTED, refuse_others
from .job import Job
from .output import Output
from .resume import REPEAT, clear
from .sharing import LONG, share
from .sources import seen_from, seen_here
from .workers import map_each

FITS, PICTURES, KEPT, VALUES, SUMMARY = "fits", "pictures", "kept", "values.jsonl", FITTED
FACTS, CHOICES = "facts.json", "choices.json"  # what was known, and what was found, in the same form
_TILE = 320


@dataclass(frozen=True, slots=True)
class Folder:
    """Where records go, and pictures if they are wanted."""

    out: Path
    pictures: bool = False

    def write(self, record: Mapping[str, Any]) -> None:
        write_bytes(self.out / FITS / f"{record['name']}.json", to_text(seen_from(self.out, record)), force=True)

    def record(self, name: str) -> Record | None:
        """The record of that name; None where it lacks what the summary tells, so that the file is fitted again."""
        found = seen_here(self.out, read_record(self.out / FITS / f"{name}.json") or {})
        kinds: dict[str, Any] = {"name": str, "source": str, "failed": str}
        if "drawn" in found:
            kinds |= {"drawn": dict, "verdict": str, "valid": bool, "distance": dict}
            del kinds["failed"]
        if not all(isinstance(found.get(key), kind) for key, kind in kinds.items()) or found["name"] != name:
            return None
        return found if "drawn" not in found or isinstance(found["distance"].get("both"), int | float) else None

    def keep(self, item: Item, mark: str) -> Record:
        """Keep the arrays of what was fitted from memory; what its record says of them, nothing of what is in a file of its own. Raises
        UserError where they have changed since they had this mark."""
        if isinstance(item.real, File) and not item.real.held:
            return {}
        item.real.require(mark)
        name = f"{KEPT}/{item.name}.npz"
        write_bytes(self.out / name, item.real.bytes(), force=True)
        return {"kept": name}

    def real(self, record: Mapping[str, Any]) -> File:
        """What was fitted, as a record names it."""
        kept = record.get("kept")
        return File(self.out / kept, held=True) if isinstance(kept, str) else File(Path(str(record["source"])))

    def has(self, item: Item, options: Mapping[str, Any], facts: Facts) -> bool:
        found = self.record(item.name)
        if found is None or found.get("options") != options or found.get("facts", {}) != facts:
            return False
        if found.get("file") != item.real.mark():
            return False
        return "kept" not in found or self.real(found).path.is_file()


def write_fits(
    sampler: Sampler,
    asked: Asked,
    folder: Folder,
    items: Sequence[Item],
    *,
    force: bool = False,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
    doing: Callable[[str], None] = lambda _: None,
) -> tuple[Record, list[Record], Job | None]:
    """Fit what the folder does not have yet, and write it; what its summary says, the records of all objects, and the job of those that
    fit, if any do. ``progress(done, total)`` hears of objects as their groups are finished, ``doing`` of what this process does with a
    group. Raises UserError."""
    options = asked.plain(sampler.program.hash)
    if not force:
        _refuse_others(folder, items)
        _refuse_changes(folder, items, asked, options)
    _make_ready(folder)

    def done(group: Group) -> bool:
        return all(folder.has(item, options, asked.facts.get(item.name, {})) for item in group)

    left = [group for group in groups_of(items, asked.facts) if force or not done(group)]
    ready = len(items) - sum(map(len, left))
    if progress:
        progress(ready, len(items))
    for count in _each(sampler, asked, folder, left, workers, doing):
        ready += count
        if progress:
            progress(ready, len(items))
    records = [found for item in items if (found := folder.record(item.name)) is not None]
    summary = summarize(sampler.program.name, options, records)
    if force:
        _drop_others(folder.out, {item.name for item in items})
    values = str(folder.out / VALUES)
    job = prepare_fitted(sampler, asked.source, records, values) if good_ones(records) else None
    _finish(folder.out, summary, records, job)
    return summary, records, job


def save_fits(job: Job, out: Path, records: Sequence[Record], items: Mapping[str, Item], *, force: bool) -> None:
    """Write the folder of objects that are fitted already, which are those of a job; ``items``: the real ones by name. Raises UserError."""
    summary = summarize(job.program.name, records[0]["options"], records)
    refuse_other(out / SUMMARY, summary, force)
    folder = Folder(out)
    _make_ready(folder)
    for record in records:
        folder.write(record | folder.keep(items[record["name"]], record["file"]))
    _finish(out, summary, records, job.fresh())


def _make_ready(folder: Folder) -> None:
    """Raises UserError for a folder of something else."""
    refuse_others(folder.out, "fitted objects", hint="fitted objects go into a folder of their own")
    for name in (FITS, PICTURES):
        sweep_unfinished(ensure_folder(folder.out / name))


def refuse_other(place: Path, summary: Record, force: bool) -> None:
    """Refuse a folder whose summary, which is at this place, says something else. Raises UserError."""
    if not force and place.exists() and place.read_bytes() != to_text(seen_from(place.parent, summary)):
        raise UserError(f"{place.parent} holds other objects", "choose another folder, or replace them with force")


def _refuse_others(folder: Folder, items: Sequence[Item]) -> None:
    """Refuse a folder of fits of other files that are still there: what it says of them would be gone; of those that could
    not be read it says nothing. Raises UserError."""
    named = {item.real.path.resolve() for item in items if isinstance(item.real, File)}
    held = {item.real.mark() for item in items if isinstance(item.real, Held)}
    others = []
    for one in list_objects(seen_here(folder.out, read_record(folder.out / SUMMARY) or {}), "name", "source"):
        record = {**one, **(folder.record(one["name"]) or {})}
        real = folder.real(record)
        if real.path.exists() and real.path.resolve() not in named and not (real.held and record.get("file") in held):
            others.append(str(real.path))
    if others:
        raise UserError(
            f"{folder.out} holds fits of {others[0]}" + (f" and {len(others) - 1} more" if others[1:] else ""),
            "name them, too, or another folder; `apgc fit --force` leaves them out",
        )


def _refuse_changes(folder: Folder, items: Sequence[Item], asked: Asked, options: Mapping[str, Any]) -> None:
    """Refuse a folder of fits of the same files that are to be replaced unasked: they were made with other options, or with facts of objects
    of which nothing is said now. Raises UserError."""
    for item in items:
        found = folder.record(item.name) or {}
        old, facts = found.get("options"), found.get("facts")
        if "drawn" not in found or not isinstance(old, dict) or found.get("file") != item.real.mark():
            continue
        if changed := describe_options(old, options):
            raise UserError(f"{folder.out} holds fits made with other options: {changed}", REPEAT)
        if facts and item.name not in asked.facts:
            raise UserError(
                f"{folder.out} holds a fit of {item.name} with facts, and none are given now",
                f"repeat them: --facts {folder.out / FACTS}; {json.dumps({item.name: {}}, ensure_ascii=False)} takes them back",
            )


def _drop_others(out: Path, names: Collection[str]) -> None:
    """Remove the files of objects that the summary of a folder lists, and that are none of ``names``."""
    listed = read_record(out / SUMMARY) or {}
    for key in ("objects", "failed"):
        for one in list_objects({"objects": listed.get(key)}, "name"):
            if one["name"] not in names and Path(one["name"]).name == one["name"]:  # should it have been edited
                for place in (
                    f"{FITS}/{one['name']}.json",
                    f"{PICTURES}/{one['name']}.png",
                    f"{KEPT}/{one['name']}.npz",
                ):
                    (out / place).unlink(missing_ok=True)


def _each(
    sampler: Sampler, asked: Asked, folder: Folder, groups: list[Group], workers: int, doing: Callable[[str], None]
) -> Iterator[int]:
    own = cache(lambda: _Writer.of(Work(sampler, asked, doing), folder))

    def alone(group: Group) -> int:
        return own().write(group)

    def others(rest: Sequence[Group], many: int) -> Iterator[int]:
        return map_each(_write_theirs, rest, many, _take, sampler, asked, folder, here=alone)

    return share(groups, workers, alone, others, pace=LONG)


# ---------------------------------------------------------------- one group


@dataclass(slots=True, eq=False)
class _Writer:
    work: Work
    folder: Folder
    painter: Painter | None

    @staticmethod
    def of(work: Work, folder: Folder) -> _Writer:
        return _Writer(work, folder, Painter("auto", _TILE) if folder.pictures else None)

    def write(self, group: Group) -> int:
        """Write the records of a group, and the pictures; how many they are."""
        for item, (record, one) in zip(group, self.work.fit(group), strict=True):
            picture = self.folder.out / PICTURES / f"{record['name']}.png"
            if self.painter is not None and one is not None:
                image = overlay(one.batch, one.row, one.cloud, self.painter, states=one.states)
                write_bytes(picture, png_bytes(image), force=True)
            else:
                picture.unlink(missing_ok=True)  # it shows what was fitted before
            self.folder.write(record | self.folder.keep(item, record["file"]))
        return len(group)


_theirs: _Writer | None = None  # what this worker writes with


def _take(sampler: Sampler, asked: Asked, folder: Folder) -> None:
    global _theirs
    _theirs = _Writer.of(Work(sampler, asked), folder)


def _write_theirs(group: Group) -> int:
    assert _theirs is not None
    return _theirs.write(group)


# ---------------------------------------------------------------- records


def read_record(path: Path) -> dict[str, Any] | None:
    """What a file of a run says, None where it cannot be read."""
    try:
        found = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    return found if isinstance(found, dict) else None


def list_objects(summary: Mapping[str, Any] | None, *keys: str) -> list[Mapping[str, Any]]:
    """What a summary says of its objects, as far as it has text under these keys: it may be missing, or edited by hand."""
    found = (summary or {}).get("objects")
    entries = found if isinstance(found, list) else []
    return [one for one in entries if isinstance(one, dict) and all(isinstance(one.get(key), str) for key in keys)]


def _finish(out: Path, summary: Record, records: Sequence[Record], job: Job | None) -> None:
    """Write what was found of all objects: the summary, the values, what was known, and the objects as samples, those of a job if there are
    any."""
    good = [seen_from(out, r) for r in good_ones(records)]
    lines = [
        json.dumps({"name": r["name"], "source": r["source"], "drawn": r["drawn"]}, ensure_ascii=False) for r in good
    ]
    write_bytes(out / VALUES, "".join(line + "\n" for line in lines).encode(), force=True)
    write_bytes(out / SUMMARY, to_text(seen_from(out, summary)), force=True)
    for name, key in ((FACTS, "facts"), (CHOICES, "choices")):
        told = {r["name"]: r[key] for r in records if r.get(key)}
        if told:
            write_bytes(out / name, _listed(told), force=True)
        else:
            (out / name).unlink(missing_ok=True)
    output = Output.of(choose_formats("annotation"), Content())
    if job is not None:
        if not _holds(out, job, output):
            write_dataset(job, out, output, force=True)
    elif manifests.read_manifest(out) is not None:
        clear(out)


def _listed(told: Record) -> bytes:
    """What is said of each object, a line for each thing."""
    objects = [
        f" {json.dumps(name, ensure_ascii=False)}: {{\n"
        + ",\n".join(
            f"  {json.dumps(key, ensure_ascii=False)}: {json.dumps(value, ensure_ascii=False)}"
            for key, value in own.items()
        )
        + "\n }"
        for name, own in told.items()
    ]
    return ("{\n" + ",\n".join(objects) + "\n}\n").encode()


def _holds(out: Path, job: Job, output: Output) -> bool:
    """Whether a folder has the objects of a job already, perhaps in further formats, which `apgc export` has added."""
    old = manifests.read_manifest(out)
    if old is None or "counts" not in old:
        return False
    new = manifests.expect_added(old, manifests.build_manifest(job.program, job.request, output, out=out))
    shards = [shard_path(out, entry, k) for entry in output.writers for k in range(len(new["shards"]))]
    return manifests.describe_difference(old, new) is None and all(map(is_there, shards))
