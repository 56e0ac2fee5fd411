"""Objects that are made together: the files of a shard, a folder for each object, or both.

Every file of a shard and every object's folder exists whole or not at all. A chunk writes what is missing, so that it can be
repeated, and holds nothing but plain data, so that it can be done by another process. What is counted on the way is a file, too, so that
a run that goes on where another ended makes no object twice.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..export.content import Content
from ..export.objects import find_lacking, object_folder, write_objects
from ..export.registry import Format
from ..export.remote import Place
from ..export.write import ExportError, is_there, write_bytes
from ..geometry import facts
from ..records import dataclass
from ..sampling.statistics import Statistics
from .memory import Room

if TYPE_CHECKING:
    from ..runtime.batch import Batch
    from .job import Job

_FEW = 32  # objects in a chunk without shards, where several processes share the work

ReportProgress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Chunk:
    """``formats`` of some objects; those of shards only where ``shard`` numbers one.

    ``counts`` names the file of what was counted on the way, which is there until the run has come to its end; "" where no one
    asks, or another chunk has the same objects and speaks for them. ``force``: what is there is written again.
    """

    out: Place
    numbers: np.ndarray
    formats: tuple[Format, ...]
    content: Content
    shard: int = 0
    counts: str = ""
    force: bool = False

    @property
    def each(self) -> list[Format]:
        """The formats that write files per object."""
        return [entry for entry in self.formats if entry.per_object]

    @property
    def shared(self) -> bool:
        """Whether objects share a file."""
        return len(self.each) < len(self.formats)

    def write(self, job: Job, room: Room, progress: ReportProgress | None = None) -> None:
        """Write what is missing, as many objects at a time as there is room for; ``progress(done, of)`` hears of objects that have their
        files, or, where all of them share files, that are made."""
        missing = [e for e in self.formats if e.shard and not is_there(shard_path(self.out, e, self.shard))]
        absent = self.numbers if self.force and self.each else self.absent()
        uncounted = self.counts and not is_there(self.out / self.counts)
        numbers = self.numbers if uncounted or missing else absent
        parts: dict[str, list[Any]] = {entry.name: [] for entry in missing}
        job, done = job.fresh(), 0
        while done < len(numbers):
            size = room.begin(len(numbers) - done)
            batch = job.batch(numbers[done : done + size])
            for entry in missing:
                parts[entry.name].append(entry.part(batch, self.content))
            self._write_objects(
                batch,
                np.intersect1d(batch.numbers, absent, assume_unique=True),
                offset_progress(progress, done, len(numbers)),
            )
            room.end(size)
            done += size
            if progress and not self.each:
                progress(done, len(numbers))
        for entry in missing:  # force: the same command elsewhere may have written the same bytes meanwhile
            write_bytes(shard_path(self.out, entry, self.shard), entry.joined(parts.pop(entry.name)), force=True)
        if uncounted:
            counted = json.dumps(job.statistics.plain(), separators=(",", ":")).encode()
            write_bytes(self.out / self.counts, counted, force=True)
        if len(numbers):
            facts.flush()

    def _write_objects(self, batch: Batch, only: np.ndarray, progress: ReportProgress | None) -> None:
        if len(only):
            write_objects(
                batch,
                self.out,
                self.each,
                only=only,
                force=self.force,
                add=not self.force,
                progress=progress,
                resolution=self.content.resolution,
                details=self.content.details,
            )

    def is_complete(self) -> bool:
        """Whether there is nothing to write."""
        shards = all(is_there(shard_path(self.out, entry, self.shard)) for entry in self.formats if entry.shard)
        counted = not self.counts or is_there(self.out / self.counts)
        return shards and counted and not (self.force and self.each) and not len(self.absent())

    def absent(self) -> np.ndarray:
        """The objects whose folders lack some of their files."""
        found = [n for n in self.numbers.tolist() if find_lacking(object_folder(self.out, n), self.each)]
        return np.array(found, dtype=np.int64)

    def split(self) -> list[Chunk]:
        """The same work in smaller pieces: the shard, and few objects at a time."""
        parts = []
        if self.shared:
            parts = [replace(self, formats=tuple(entry for entry in self.formats if entry.shard))]
        for first in range(0, len(self.numbers) if self.each else 0, _FEW):
            counts = "" if self.shared or not self.counts else counts_name(self.shard, first)
            some = self.numbers[first : first + _FEW]
            parts.append(replace(self, formats=tuple(self.each), numbers=some, counts=counts))
        return parts


def counts_name(shard: int, first: int | None = None) -> str:
    """The file of what was counted while a shard was made, or some of its objects."""
    return f"counts-{shard:05d}{'' if first is None else f'-{first:05d}'}.json"


def read_counts(out: Place, chunks: Iterable[Chunk]) -> Statistics:
    """What was counted while chunks were made. Raises ExportError."""
    found = Statistics()
    for path in (out / chunk.counts for chunk in chunks if chunk.counts):
        try:
            found.take(Statistics.of(json.loads(path.read_bytes())))
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise ExportError(f"cannot read {path}: {error}", "remove it, and give the same command again") from None
    return found


def offset_progress(progress: ReportProgress | None, done: int, total: int) -> ReportProgress | None:
    """Progress of a piece of some work, of which so much was done before it."""
    return (lambda finished, _: progress(done + finished, total)) if progress else None


def shard_path(out: Place, entry: Format, index: int) -> Place:
    return out / f"{entry.kind}-{index:05d}{entry.suffix}"
