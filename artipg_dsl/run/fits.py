"""A folder of fitted objects: a record and a picture for each file, all values in one file, and the objects as samples.

Files are fitted in groups of a fixed order, so that a group gives the same whoever works on it. A group all of whose records are there
and tell of the same files, program and options is left alone.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UserError
from ..export.content import Content
from ..export.registry import choose_formats
from ..export.write import ensure_folder, sweep_unfinished, write_bytes
from ..fit.fitting import TOGETHER, fit, usual_size
from ..fit.model import Model
from ..fit.pose import Frame, Posed, pose
from ..fit.reading import read_cloud
from ..fit.states import can_open
from ..records import dataclass
from ..sampling.sample import Sampler
from ..view.overlay import overlay
from ..view.png import png_bytes
from ..view.sheet import Painter
from . import manifest as manifests
from .dataset import write_dataset
from .job import prepare
from .output import Output
from .request import read_request
from .resume import clear
from .sharing import LONG, share
from .workers import map_each

FITS, PICTURES, VALUES, SUMMARY = "fits", "pictures", "values.jsonl", "fit.json"
_VERSION = 3  # of what the search finds, so that nothing that another one found is kept
_TILE = 320
_NO_MATCH = "does not fit"


@dataclass(frozen=True, slots=True)
class Asked:
    """What is fitted: ``source`` names the program; ``words`` maps names of labels to words of ``semantic``."""

    source: str
    out: Path
    frame: Frame
    seed: int = 0
    checked: bool = True
    words: tuple[tuple[str, str], ...] = ()
    pictures: bool = True
    opened: bool = True  # joints are moved where nothing at rest fits

    def plain(self, program: str) -> dict[str, Any]:
        return {
            "version": _VERSION,
            "program": program,
            "frame": asdict(self.frame),
            "seed": self.seed,
            "checked": self.checked,
            "words": [list(pair) for pair in self.words],
            "opened": self.opened,
        }


@dataclass(frozen=True, slots=True)
class Item:
    """A file to fit, and what its results are called."""

    path: Path
    name: str


def _name_files(paths: Sequence[Path]) -> list[Item]:
    """Names of files that are their own: as short as their folders allow."""
    parts = [[*path.resolve().parts[1:-1], path.stem] for path in paths]
    shared = 0
    while all(len(p) > shared + 1 and p[shared] == parts[0][shared] for p in parts) and len(paths) > 1:
        shared += 1
    shared = min(shared, min(map(len, parts)) - 1) if len(paths) > 1 else len(parts[0]) - 1
    found: list[Item] = []
    taken: set[str] = set()
    for path, part in zip(paths, parts, strict=True):
        name = plain = "-".join(part[shared:])
        number = 1
        while name in taken:
            number += 1
            name = f"{plain}-{number}"
        taken.add(name)
        found.append(Item(path, name))
    return found


def write_fits(
    sampler: Sampler,
    asked: Asked,
    paths: Sequence[Path],
    *,
    force: bool = False,
    workers: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Any]:
    """Fit the files and write the folder; what the summary says. Raises UserError."""
    if (asked.out / manifests.NAME).exists() and not (asked.out / SUMMARY).exists():
        raise UserError(f"{asked.out} holds samples that were not fitted", "choose another folder with -o")
    if not force:
        _refuse_others(asked.out, paths)
    items = _name_files(paths)
    for folder in (FITS, PICTURES):
        sweep_unfinished(ensure_folder(asked.out / folder))
    groups = [items[at : at + TOGETHER] for at in range(0, len(items), TOGETHER)]
    options = asked.plain(sampler.program.hash)
    left = [group for group in groups if force or not all(_done(asked, options, item) for item in group)]
    done = len(items) - sum(map(len, left))
    if progress:
        progress(done, len(items))
    for group in _each(sampler, asked, left, workers):
        done += len(group)
        if progress:
            progress(done, len(items))
    return _summarize(sampler, asked, options, items)


def _refuse_others(out: Path, paths: Sequence[Path]) -> None:
    """Refuse a folder of fits of other files that are still there: what it says of them would be gone; of those that could
    not be read it says nothing. Raises UserError."""
    named = {path.resolve() for path in paths}
    sources = [Path(one["source"]) for one in list_objects(read_record(out / SUMMARY), "source")]
    others = [str(path) for path in sources if path.exists() and path.resolve() not in named]
    if others:
        raise UserError(
            f"{out} holds fits of {others[0]}" + (f" and {len(others) - 1} more" if others[1:] else ""),
            "name all its files, choose another folder with -o, or use --force to leave them out",
        )


def _each(sampler: Sampler, asked: Asked, groups: list[list[Item]], workers: int) -> Iterator[list[Item]]:
    def fit(group: list[Item]) -> list[Item]:
        return _fit_group(_Work.of(sampler, asked), group)

    def others(rest: Sequence[list[Item]], many: int) -> Iterator[list[Item]]:
        return map_each(_fit_theirs, rest, many, _take, sampler, asked, here=fit)

    return share(groups, workers, fit, others, pace=LONG)


# ---------------------------------------------------------------- one group


@dataclass(slots=True, eq=False)
class _Work:
    model: Model
    opened: Model | None
    asked: Asked
    usual: float
    painter: Painter | None

    @staticmethod
    def of(sampler: Sampler, asked: Asked) -> _Work:
        model = Model(sampler)
        opened = Model(sampler, opened=True) if asked.opened and can_open(sampler.program) else None
        return _Work(model, opened, asked, usual_size(model), Painter("auto", _TILE) if asked.pictures else None)


_theirs: _Work | None = None  # what this worker works for


def _take(sampler: Sampler, asked: Asked) -> None:
    global _theirs
    _theirs = _Work.of(sampler, asked)


def _fit_theirs(group: list[Item]) -> list[Item]:
    assert _theirs is not None
    return _fit_group(_theirs, group)


def _fit_group(work: _Work, group: list[Item]) -> list[Item]:
    asked = work.asked
    options = asked.plain(work.model.program.hash)
    read: list[tuple[Item, Posed]] = []
    marks = {item.name: mark(item.path) for item in group}  # of what is read: files may change while they are fitted
    left_out: dict[str, str] = {}
    for item in group:
        try:
            cloud = read_cloud(item.path)
            left_out[item.name] = cloud.lost
            read.append((item, pose(cloud, asked.frame, item.path.suffix.lower(), work.usual)))
        except UserError as wrong:
            reason = wrong.message + (f" ({wrong.hint})" if wrong.hint else "")
            _write(asked, item, {"failed": reason}, marks[item.name], options)
    if not read:
        return group
    found = fit(
        work.model,
        [posed for _, posed in read],
        seed=asked.seed,
        checked=asked.checked,
        words=dict(asked.words),
        opened=work.opened,
    )
    for (item, posed), one in zip(read, found, strict=True):
        if work.painter is not None:
            image = overlay(one.batch, one.row, one.cloud, work.painter, states=one.states)
            write_bytes(asked.out / PICTURES / f"{item.name}.png", png_bytes(image), force=True)
        labels = {"labels": sorted(set(posed.names))} if asked.words else {}
        lost = {"lost": left_out[item.name]} if left_out[item.name] else {}
        _write(asked, item, {**one.told, **labels, **lost, "drawn": one.values}, marks[item.name], options)
    return group


# ---------------------------------------------------------------- records


def mark(path: Path) -> str:
    """What a file holds, in short; nothing for one that cannot be read."""
    digest = blake2b(digest_size=16)
    try:
        with open(path, "rb") as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    except OSError:
        return ""
    return digest.hexdigest()


def _write(asked: Asked, item: Item, told: Mapping[str, Any], file: str, options: Mapping[str, Any]) -> None:
    record = {"name": item.name, "source": str(item.path), **told, "file": file, "options": options}
    write_bytes(asked.out / FITS / f"{item.name}.json", _to_text(record), force=True)


def _to_text(record: Mapping[str, Any]) -> bytes:
    return (json.dumps(record, indent=1, ensure_ascii=False) + "\n").encode()


def read_record(path: Path) -> dict[str, Any] | None:
    """What a file of a run says, None where it cannot be read."""
    try:
        found = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def list_objects(summary: Mapping[str, Any] | None, *keys: str) -> list[Mapping[str, Any]]:
    """What a summary says of its objects, as far as it has text under these keys: it may be missing, or edited by hand."""
    found = (summary or {}).get("objects")
    entries = found if isinstance(found, list) else []
    return [one for one in entries if isinstance(one, dict) and all(isinstance(one.get(key), str) for key in keys)]


def _record(asked: Asked, item: Item) -> dict[str, Any] | None:
    """The record of a file; None where it lacks what the summary tells, so that the file is fitted again."""
    found = read_record(asked.out / FITS / f"{item.name}.json") or {}
    kinds: dict[str, Any] = {"name": str, "source": str, "failed": str}
    if "drawn" in found:
        kinds |= {"drawn": dict, "verdict": str, "valid": bool, "distance": dict}
        del kinds["failed"]
    if not all(isinstance(found.get(key), kind) for key, kind in kinds.items()) or found["name"] != item.name:
        return None
    return found if "drawn" not in found or isinstance(found["distance"].get("both"), int | float) else None


def _done(asked: Asked, options: Mapping[str, Any], item: Item) -> bool:
    found = _record(asked, item)
    return found is not None and found.get("options") == options and found.get("file") == mark(item.path)


def _summarize(sampler: Sampler, asked: Asked, options: Mapping[str, Any], items: Sequence[Item]) -> dict[str, Any]:
    """Write what was found of all files: the summary, the values, and the objects as samples."""
    records = [found for item in items if (found := _record(asked, item)) is not None]
    good = [r for r in records if "drawn" in r and r["verdict"] != _NO_MATCH and r["valid"]]
    number = {r["name"]: k for k, r in enumerate(good)}
    objects = [
        {
            "object": number.get(r["name"]),
            "name": r["name"],
            "source": r["source"],
            "verdict": r["verdict"],
            "distance": r["distance"]["both"],
            "valid": r["valid"],
            **({"lost": r["lost"]} if r.get("lost") else {}),
        }
        for r in records
        if "drawn" in r
    ]
    failed = [{"name": r["name"], "source": r["source"], "reason": r["failed"]} for r in records if "failed" in r]
    shares = [one["distance"] for one in objects]
    summary = {
        "category": sampler.program.name,
        "options": options,
        "median": None if not shares else round(float(np.median(shares)), 4),
        "objects": objects,
        "failed": failed,
    }
    if asked.words and all("labels" in r for r in records if "drawn" in r):
        summary["labels"] = sorted({name for r in records for name in r.get("labels", ())})
    lines = [
        json.dumps({"name": r["name"], "source": r["source"], "drawn": r["drawn"]}, ensure_ascii=False) for r in good
    ]
    write_bytes(asked.out / VALUES, "".join(line + "\n" for line in lines).encode(), force=True)
    write_bytes(asked.out / SUMMARY, _to_text(summary), force=True)
    if good:
        request = read_request(asked.source, seed=asked.seed, checked=asked.checked, values=[r["drawn"] for r in good])
        written = Output.of(choose_formats("annotation"), Content())
        write_dataset(prepare(sampler, request, values=str(asked.out / VALUES)), asked.out, written, force=True)
    elif (old := manifests.read_manifest(asked.out)) is not None:
        clear(asked.out, old)
    return summary
