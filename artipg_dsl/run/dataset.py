"""A folder of samples: shards, a folder per object where a format asks for it, and the manifest.

Every shard and every object's folder exists whole or not at all. A second run with the same options writes what is
missing and touches nothing else; with other options it refuses, or starts anew when forced to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..export.content import SHARD, Content
from ..export.objects import lacking, object_folder
from ..export.registry import FORMATS, Format
from ..export.write import ExportError, write_bytes
from ..geometry.resolution import Resolution
from . import manifest as manifests
from .chunk import Chunk, Progress
from .counts import Counts
from .manifest import Manifest
from .output import Output
from .request import Request
from .resume import make_ready, sweep_all
from .schema import expand

if TYPE_CHECKING:
    from ..graph.program import Program
    from ..runtime.batch import Batch

Share = Callable[[list[Chunk]], Iterable[Chunk]]  # writes chunks elsewhere, and gives each back when it is done


def write_dataset(
    program: Program,
    sample: Callable[[np.ndarray], Batch],
    out: Path | str,
    request: Request,
    output: Output,
    *,
    part: tuple[int, int] = (1, 1),
    force: bool = False,
    progress: Progress | None = None,
    counts: Callable[[], Counts] | None = None,
    share: Share | None = None,
) -> Manifest:
    """Write the objects of a request to ``out`` and return the manifest.

    ``sample(numbers)`` makes the batch of some of them; it is called only for shards where something is missing
    (for all of them until a run has come to its end and its counts are known). ``part`` (k, n) writes every n-th shard from
    the k-th on, so that n runs share the work; the counts are then left out. ``progress(done, total)`` hears of objects as
    they are finished; ``counts()`` is asked once all objects have been sampled. ``share`` writes the chunks elsewhere: it has
    its own way to sample.
    """
    out, numbers, shard = Path(out), request.objects, output.shard
    manifest = make_ready(out, manifests.build(program, request, output, out=out), force)
    counting = counts is not None and "counts" not in manifest and part[1] == 1
    first, step = (part[0] - 1) * shard, part[1] * shard
    chunks = [
        Chunk(out, numbers[at : at + shard], output.writers, output.content, at // shard, always=counting)
        for at in range(first, len(numbers), step)
    ]
    carry_out(chunks, sample, share, progress)
    if counting:
        assert counts is not None
        manifest = manifests.build(program, request, output, out=out, counts=counts())
        write_bytes(out / manifests.NAME, manifests.text(manifest), force=True)
    return manifest


def carry_out(
    chunks: list[Chunk], sample: Callable[[np.ndarray], Batch], share: Share | None, progress: Progress | None
) -> None:
    """Write all chunks, here or by ``share`` in smaller pieces."""
    total, done = sum(len(chunk.numbers) for chunk in chunks), 0
    if share is not None:
        for piece in share([piece for chunk in chunks for piece in chunk.split()]):
            done += len(piece.numbers) if piece.each or not chunks[0].each else 0
            if progress:
                progress(done, total)
        return
    for chunk in chunks:
        chunk.write(sample, _offset(progress, done, total))
        done += len(chunk.numbers)
        if progress:
            progress(done, total)


def _offset(progress: Progress | None, done: int, total: int) -> Progress | None:
    return (lambda finished, _: progress(done + finished, total)) if progress else None


def add_formats(
    sample: Callable[[np.ndarray], Batch],
    out: Path,
    numbers: np.ndarray,
    formats: Sequence[Format],
    *,
    force: bool = False,
    progress: Progress | None = None,
    resolution: Resolution | None = None,
    share: Share | None = None,
) -> None:
    """Further files for objects of a folder of samples; formats that it has are refused, or written again by ``force``.

    ``resolution`` of the meshes, None: that of the folder.
    The manifest names the new formats once all objects have them; until then the same call completes what is missing.
    """
    manifest = manifests.read(out)
    assert manifest is not None
    identity = manifest["identity"]
    listed = identity["formats"]
    resolution = resolution or Output.from_manifest(identity).content.resolution
    doubled = [entry.name for entry in formats if entry.name in listed]
    there = {n for n in numbers.tolist() if not lacking(object_folder(out, n), formats)}
    if doubled and len(there) == len(numbers) and not force:
        raise ExportError(f"{out} has its objects as {', '.join(doubled)}", "use --force to write them again")
    sweep_all(out)
    content = Content(resolution=resolution)
    chunks = [
        Chunk(out, numbers[first : first + SHARD], tuple(formats), content, force=force)
        for first in range(0, len(numbers), SHARD)
    ]
    carry_out(chunks, sample, share, progress)
    new = [entry.name for entry in formats if entry.name not in listed]
    if new and not any(lacking(object_folder(out, n), formats) for n in expand(identity["numbers"]).tolist()):
        identity["formats"] = [name for name in FORMATS if name in {*listed, *new}]
        write_bytes(out / manifests.NAME, manifests.text(manifest), force=True)
