"""A folder in a layout of the field: written category by category, and read back against the model.

``.layout/<category>.json`` keeps how the objects of a category were made, so that others can be added, lists written anew and
the folder checked. It is written last: a folder without it holds nothing of the category that counts. ``<category>.files`` has
the names and checksums of its own files, which go when it is replaced, ``lists`` those of the files that tell of all categories.
While objects are being made, ``<category>-<shard>.begun`` has the names of files that may not be whole.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, TypedDict
from zipfile import BadZipFile

import numpy as np

from ..errors import FORCE, UserError
from ..export.write import ExportError, ensure_folder, explain, replacing_file, sweep_unfinished, write_bytes
from ..layouts.entry import SPLITS, USUAL, Entry, Shares
from ..layouts.findings import Findings
from ..layouts.hdf5 import open_h5
from ..layouts.registry import LAYOUTS, Layout, require
from ..layouts.words import require_map
from ..records import dataclass
from ..sampling.statistics import Statistics
from ..shapes import Rule, fit
from .checksums import checksum, checksum_of, damage, keep_names, read_names
from .folders import LAYOUT, refuse_others
from .frame import read_frame
from .job import Job, open_job
from .manifest import make_relative
from .request import Drawn, Request
from .schema import expand, one_of, within
from .sharing import share
from .traces import keep_replays
from .workers import map_each

Progress = Callable[[int, int], None]
_RECORDS, _LISTS, _BEGUN = LAYOUT, "lists", ".begun"
_UNFINISHED = "was not finished, and loaders may read what is there: write it again"
_AGAIN = "is not compared with the model while files are damaged: write it again with --force"
_UNREADABLE = (OSError, ValueError, KeyError, EOFError, RuntimeError, BadZipFile)


def write_layout(
    job: Job,
    out: Path | str,
    layout: Layout,
    *,
    shares: Shares = USUAL,
    own: Mapping[str, Any] | None = None,
    force: bool = False,
    progress: Progress | None = None,
    workers: int = 1,
    frame: str | Path | None = None,
) -> Entry:
    """Write the objects of a job into the folder ``out``, beside other categories in the same layout.

    ``shares``: how many of every few objects go into train, val and test; ``own``: words of the user's. A folder of something else
    is refused; what it has of the category is, too, or replaced by ``force``. Objects are turned to lie as ``frame`` says,
    by default as in the layout's data set. Raises ExportError, UserError.
    """
    if frame or layout.frame:
        job = job.facing(read_frame(frame or layout.frame).of(job.program.name))
    out = Path(out)
    there = out.exists()
    refuse_others(out, "a layout", hint="a layout is a folder of its own")
    require(layout)
    entry = layout.entry(job.program, job.request.seed, job.request.objects, shares, own)
    place = out / _RECORDS / f"{entry.category}.json"
    known = entries(out, layout, refuse=True, but=entry.category if force else "")
    others = [other for other in known if other.category != entry.category]
    if place.exists() and not force:
        raise ExportError(f"{out} already has {entry.category}", f"use {FORCE} to write it again, or another folder")
    _check_alone(out, layout, entry, others)
    _clear(out, layout, entry.category, others)
    record = {
        "layout": layout.name,
        "category": entry.category,
        "source": make_relative(job.request.source, out),
        "request": job.request.to_manifest(),
        "shares": list(shares),
        "map": dict(own or {}),
        "words": dict(entry.words),
    }
    data = (json.dumps(record, indent=1) + "\n").encode()
    try:
        written = _carry_out(job, layout, entry, out, progress, workers)
        lists = _index(layout, sorted([*others, entry], key=lambda one: one.category), out)
        replays = [f"{_RECORDS}/{name}" for name in keep_replays(out / _RECORDS, job.request.mutations)]
        written |= {name: checksum_of(out / name) for name in replays} | {f"{_RECORDS}/{place.name}": checksum(data)}
        keep_names(out / _RECORDS / f"{entry.category}.files", written)
        _write_lists(out, lists)
    except UserError:
        _clear(out, layout, entry.category, others)
        if not there and out.is_dir() and not any(out.iterdir()):
            out.rmdir()
        raise
    write_bytes(place, data, force=True)
    return entry


def _check_alone(out: Path, layout: Layout, entry: Entry, others: Iterable[Entry]) -> None:
    """Where names of objects are those of their class, no other category of the folder is in it. Raises ExportError."""
    for known in others:
        if layout.alone and known.term and entry.term and known.term.name == entry.term.name:
            raise ExportError(
                f"{out} already has {known.category}, which {layout.name} calls {entry.term.name}, too",
                "choose a folder of its own",
            )


def _index(layout: Layout, known: list[Entry], out: Path) -> Mapping[str, Any]:
    """The lists of all categories, as the ``index`` of the layout has them. Raises ExportError where files are missing of which
    they are made."""
    try:
        return layout.index(known, out)
    except (OSError, ValueError, KeyError) as wrong:
        raise _missing(out, wrong) from None


def _missing(out: Path, wrong: Exception) -> ExportError:
    missing = wrong.filename if isinstance(wrong, FileNotFoundError) else None
    told = f"{missing} is missing" if missing else str(wrong)
    hint = "write its category again with --force, or choose another folder"
    return ExportError(f"{out} is damaged: {told.replace(f'{out}/', '')}", hint)


def _write_lists(out: Path, lists: Mapping[str, Any]) -> None:
    """Write the lists of all categories, and remove those of before that there are no more. Raises ExportError."""
    record = out / _RECORDS / _LISTS
    before, now = read_names(record), {name: "" for name in lists if not name.endswith("/")}
    keep_names(record, before | now, whole=False)  # whenever this ends, the next run knows what is there
    _remove(out, before.keys() - now.keys())
    for name, data in lists.items():
        if name.endswith("/"):
            ensure_folder(out / name)
        elif callable(data):
            with replacing_file(out / name, force=True) as stream:
                try:
                    data(stream)
                except (OSError, ValueError, KeyError) as wrong:
                    raise _missing(out, wrong) from None
        else:
            write_bytes(out / name, data, force=True)
    keep_names(record, {name: checksum_of(out / name) for name in now})


def entries(folder: Path, layout: Layout | None = None, *, refuse: bool = False, but: str = "") -> list[Entry]:
    """What a folder holds, by category. ``refuse``: in another layout than this; ``but``: of which category no record need be
    readable. Raises ExportError."""
    found = []
    for record in _records(folder, but):
        own = LAYOUTS[record["layout"]]
        if refuse and layout is not None and own is not layout:
            raise ExportError(f"{folder} is laid out as {own.name}", f"choose another folder for {layout.name}")
        found.append(_entry(record))
    return found


def find_taken(folder: Path, layout: Layout, entry: Entry) -> np.ndarray:
    """The numbers of objects that the folder has. A layout leaves out those that its data set has no form for, such as objects on which
    nothing moves; they are known by the names of files, and all count where files are named by none."""
    names = read_names(folder / _RECORDS / f"{entry.category}.files")
    called = layout.names(entry)
    found = (next(filter(called.__contains__, re.split("[^0-9A-Za-z]", name)), "") for name in names)
    taken = sorted({called[word] for word in found if word})
    together = not names or any(not name.startswith(_RECORDS) for name in names)
    return entry.numbers if together and not taken else np.array(taken, dtype=np.int64)


def find_cautions(folder: Path, layout: Layout) -> list[str]:
    """What loaders stumble over in a folder whose files are right: lists of splits without an object, names in its path."""
    known, found = entries(folder), []
    meant = [split for k, split in enumerate(SPLITS) if any(entry.shares[k] for entry in known)]
    taken = [entry.splits(find_taken(folder, layout, entry)) for entry in known]
    count = {split: sum(len(own[split]) for own in taken) for split in SPLITS}
    if empty := [split for split in meant if not count[split]]:
        found.append(
            f"no object is in {' or '.join(empty)}, and most loaders fail at an empty list: make more objects, or choose other --split"
        )
    found += [
        f"{split} has fewer than {least} objects, and {why}: make more, or choose other --split"
        for split, (least, why) in layout.least.items()
        if 0 < count[split] < least
    ]
    if layout.unseen and all(entry.shares[0] for entry in known):
        found.append(
            f"no category is in {layout.unseen}, and the training needs one: export it with --split 0,0,1 into the same folder"
        )
    odd = [name for name in folder.parts if layout.stumbles and layout.stumbles in name.strip(".")]
    if odd:
        found.append(
            f"loaders of {layout.name} misread a path with `{layout.stumbles}` in it: rename {odd[0]} before they read the folder"
        )
    return found


def check_layout(folder: Path | str, progress: Progress | None = None) -> Findings:
    """Read a folder as the field's loaders do, and compare it with its objects, made again. Files that are not as they were written
    are told once; what they are read for is not compared. Raises UserError."""
    folder, found = Path(folder), Findings()
    records, left = _records(folder), sorted((folder / _RECORDS).glob("*.files"))
    if not records and not left:
        raise UserError(f"{folder} is no folder in a layout", "give a folder that `apgc export --format` has laid out")
    known = [_entry(record) for record in records]
    names = [entry.category for entry in known]
    for path in left:
        found.of(path.stem, path.stem in names, _UNFINISHED)
    held = {name: read_names(folder / _RECORDS / f"{name}.files") for name in names}
    checked = any(any(own.values()) for own in held.values())  # older versions kept names alone
    common = bool(records) and _damaged(folder, _LISTS, checked, found)
    spoilt = {name: _damaged(folder, f"{name}.files", not held[name], found) or common for name in names}
    total, done = sum(len(entry.numbers) for entry in known), 0
    for record, entry in zip(records, known, strict=True):
        layout = LAYOUTS[record["layout"]]
        require(layout)
        if not found.of(entry.category, not spoilt[entry.category], _AGAIN):
            done += len(entry.numbers)
            continue
        job = open_job(Request.from_manifest(record["request"], record["source"], folder, folder / _RECORDS))
        for shard, numbers in enumerate(entry.chunks()):
            try:
                layout.check(folder, entry, job.batch(numbers), shard, found)
            except (*_UNREADABLE, UserError) as wrong:
                found.of(entry.category, False, f"cannot be read: {wrong}".replace(f"{folder}/", ""))
            done += len(numbers)
            if progress:
                progress(done, total)
    for name in dict.fromkeys(record["layout"] for record in records if not any(spoilt.values())):
        own = [entry for record, entry in zip(records, known, strict=True) if record["layout"] == name]
        _check_lists(folder, LAYOUTS[name], own, found)
    return found


def _damaged(folder: Path, record: str, sealed: bool, found: Findings) -> bool:
    """Whether any file of a record is not as it was written. Of one without checksums that is not known."""
    wrong, names = list(damage(folder, f"{_RECORDS}/{record}", sealed=sealed)), read_names(folder / _RECORDS / record)
    found.checked += len(names)
    for name, told in wrong:
        found.of(name, False, told)
    return bool(wrong) and (sealed or any(names.values()))


def _check_lists(folder: Path, layout: Layout, known: list[Entry], found: Findings) -> None:
    """Whether the lists of all categories are there and say what they would if they were written now."""
    try:
        lists = _index(layout, known, folder)
    except UserError as wrong:
        found.of(_RECORDS, False, str(wrong).replace(f"{folder} is damaged: ", ""))
        return
    for name, data in lists.items():
        path = folder / name
        if name.endswith("/"):
            found.of(name, path.is_dir(), "the folder is missing")
        elif found.of(name, path.is_file(), "the file is missing") and isinstance(data, bytes):
            found.of(name, path.read_bytes() == data, "does not list what its categories have")
        elif path.suffix == ".h5":
            try:
                open_h5(path).close()
            except OSError as wrong:
                found.of(name, False, str(wrong).replace(f"{path} ", ""))


@dataclass(frozen=True, slots=True)
class Piece:
    """Objects that are made together, and where their files go."""

    out: Path
    layout: str
    entry: Entry
    shard: int
    numbers: np.ndarray

    def write(self, job: Job) -> dict[str, str]:
        """The checksums of what is written by name; nothing is, where an object is refused or the work is interrupted.
        Raises UserError."""
        names: dict[str, str] = {}
        begun = self.out / _RECORDS / f"{self.entry.category}-{self.shard}{_BEGUN}"
        try:
            with begun.open("w", encoding="utf-8", newline="\n") as told:
                for name, data in LAYOUTS[self.layout].files(job.batch(self.numbers), self.entry, self.shard):
                    told.write(f"{name}\n")
                    told.flush()  # the next run removes what a killed one has left
                    names[name] = checksum(data)
                    write_bytes(self.out / name, data, force=True)
        except BaseException as wrong:
            _remove(self.out, [*names, str(begun.relative_to(self.out))])
            if isinstance(wrong, OSError):
                raise explain(wrong, begun) from wrong
            raise
        return names


def _clear(out: Path, layout: Layout, category: str, others: list[Entry]) -> None:
    """Remove what the folder has of a category, from the lists first: whenever this ends, they name what is there."""
    place, listed, lists = (out / _RECORDS / name for name in (f"{category}.json", f"{category}.files", _LISTS))
    begun = [path for path in (out / _RECORDS).glob(f"{category}-*{_BEGUN}") if _of(path, category)]
    names = [name for path in (listed, *begun) for name in read_names(path)]
    _sweep(out, [*names, *read_names(lists)])
    if place.exists() and others:
        _write_lists(out, _index(layout, others, out))
    elif not others:
        names += [*read_names(lists), str(lists.relative_to(out))]
    place.unlink(missing_ok=True)
    _remove(out, [*names, *(str(path.relative_to(out)) for path in (listed, *begun))])


def _of(begun: Path, category: str) -> bool:
    """Whether a record of what was begun is that of a category, whose name may begin like that of another."""
    return begun.name.removeprefix(f"{category}-").removesuffix(_BEGUN).isdigit()


def _sweep(out: Path, names: Iterable[str]) -> None:
    """Remove what killed processes have left unfinished beside files."""
    for folder in {out / _RECORDS, *((out / name).parent for name in names)}:
        if folder.resolve().is_relative_to(out.resolve()) and folder.is_dir():
            sweep_unfinished(folder)


def _remove(out: Path, names: Iterable[str]) -> None:
    """Remove files, and folders in ``out`` that are empty then."""
    for name in names:
        path = out / name
        if not path.resolve().is_relative_to(out.resolve()) or path.is_dir():
            continue
        path.unlink(missing_ok=True)
        for folder in path.parents:
            if folder == out or not folder.is_dir() or any(folder.iterdir()):
                break
            folder.rmdir()


def _carry_out(
    job: Job, layout: Layout, entry: Entry, out: Path, progress: Progress | None, workers: int
) -> dict[str, str]:
    """The checksums of what is written by name."""
    pieces = [Piece(out, layout.name, entry, k, numbers) for k, numbers in enumerate(entry.chunks())]
    done = 0
    ensure_folder(out / _RECORDS)
    written: dict[str, str] = {}
    listed = out / _RECORDS / f"{entry.category}.files"
    try:
        with listed.open("w", encoding="utf-8", newline="\n") as told:
            for piece, made in zip(pieces, _written(job, pieces, workers), strict=True):
                told.writelines(f"{name}\n" for name in made)
                told.flush()
                (out / _RECORDS / f"{entry.category}-{piece.shard}{_BEGUN}").unlink()
                written |= made
                done += len(piece.numbers)
                if progress:
                    progress(done, len(entry.numbers))
    except OSError as wrong:
        raise explain(wrong, listed) from wrong
    return written


def _written(job: Job, pieces: list[Piece], workers: int) -> Iterator[dict[str, str]]:
    given = replace(job, statistics=Statistics())

    def write(piece: Piece) -> dict[str, str]:
        return piece.write(job)

    return share(pieces, workers, write, lambda rest, many: map_each(_write, rest, many, _take, given, here=write))


_job: Job | None = None  # what this worker works for


def _take(job: Job) -> None:
    global _job
    _job = job


def _write(piece: Piece) -> dict[str, str]:
    assert _job is not None
    return piece.write(_job)


# ---------------------------------------------------------------- records


def _records(folder: Path, but: str = "") -> list[dict[str, Any]]:
    """The records of a folder, by category, without that of ``but`` where it cannot be read. Raises ExportError."""
    found = []
    for path in sorted((folder / _RECORDS).glob("*.json")):
        try:
            found.append(_read(path))
        except ExportError:
            if path.stem != but:
                raise
    return found


class _Record(TypedDict):
    """How the objects of a category were made."""

    layout: Annotated[str, one_of(LAYOUTS)]
    category: str
    source: str
    request: Drawn
    shares: Annotated[
        list[Annotated[int, within(0, 9999)]],
        Rule("three shares that are not all 0", lambda value: len(value) == 3 and any(value)),
    ]
    map: dict[str, dict[str, Any]]
    words: dict[str, Any]


def _read(path: Path) -> dict[str, Any]:
    try:
        record: dict[str, Any] = json.loads(path.read_bytes())
        fit(record, _Record)
        require_map(record["map"], "map")
    except (OSError, ValueError, RecursionError) as wrong:
        raise ExportError(f"cannot read {path}: {wrong}", f"write {path.stem} again with --force") from None
    return record


def _entry(record: Mapping[str, Any]) -> Entry:
    layout, request = LAYOUTS[record["layout"]], record["request"]
    term = layout.term(record["category"], record["map"])
    numbers = expand(tuple((first, last) for first, last in request["numbers"]))
    train, val, test = record["shares"]
    return Entry(record["category"], request["seed"], numbers, (train, val, test), term, record["words"], layout.chunk)
