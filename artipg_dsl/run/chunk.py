"""Objects that are made together: the files of a shard, a folder for each object, or both.

Every file of a shard and every object's folder exists whole or not at all. A chunk writes what is missing, so that it can be
repeated, and holds nothing but plain data, so that it can be done by another process.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..export.content import Content
from ..export.objects import find_lacking, object_folder, write_objects
from ..export.registry import Format
from ..export.write import write_bytes
from ..geometry import facts

if TYPE_CHECKING:
    from ..runtime.batch import Batch

_FEW = 32  # objects in a chunk without shards, where several processes share the work

ReportProgress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Chunk:
    """``formats`` of some objects; those of shards only where ``shard`` numbers one.

    ``always``: the objects are made even where no file is missing, because they are counted. ``force``: what is there is
    written again.
    """

    out: Path
    numbers: np.ndarray
    formats: tuple[Format, ...]
    content: Content
    shard: int = 0
    always: bool = False
    force: bool = False
    counted: bool = True  # no other chunk has the same objects, or this is the one that speaks for them

    @property
    def each(self) -> list[Format]:
        """The formats that write files per object."""
        return [entry for entry in self.formats if entry.per_object]

    def write(self, sample: Callable[[np.ndarray], Batch], progress: ReportProgress | None = None) -> None:
        """Write what is missing; ``sample(numbers)`` makes the batch, ``progress(done, of)`` hears of objects with files."""
        missing = [e for e in self.formats if e.shard and not shard_path(self.out, e, self.shard).exists()]
        absent = self.numbers if self.force and self.each else self.absent()
        if not (self.always or missing or len(absent)):
            return
        batch = sample(self.numbers if self.always or missing else absent)
        for entry in missing:
            write_bytes(shard_path(self.out, entry, self.shard), entry.shard_bytes(batch, self.content))
        if len(absent):
            write_objects(
                batch,
                self.out,
                self.each,
                only=absent,
                force=self.force,
                add=not self.force,
                progress=progress,
                resolution=self.content.resolution,
            )
        facts.flush()

    def absent(self) -> np.ndarray:
        """The objects whose folders lack some of their files."""
        found = [n for n in self.numbers.tolist() if find_lacking(object_folder(self.out, n), self.each)]
        return np.array(found, dtype=np.int64)

    def split(self) -> list[Chunk]:
        """The same work in smaller pieces: the shard, and few objects at a time."""
        shared, each = tuple(entry for entry in self.formats if entry.shard), tuple(self.each)
        parts = [replace(self, formats=shared)] if shared else []
        whole = replace(self, formats=each, always=self.always and not shared, counted=not shared)
        for first in range(0, len(self.numbers) if each else 0, _FEW):
            parts.append(replace(whole, numbers=self.numbers[first : first + _FEW]))
        return parts


def shard_path(out: Path, entry: Format, index: int) -> Path:
    return out / f"{entry.kind}-{index:05d}{entry.suffix}"
