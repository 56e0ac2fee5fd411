"""A folder of samples: shards, a folder per object where a format asks for it, and the manifest.

Every shard and every object's folder exists whole or not at all. A second run with the same options writes what is
missing and touches nothing else; with other options it refuses, or starts anew when forced to.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..export.content import SHARD, Content
from ..export.objects import find_lacking, object_folder
from ..export.registry import FORMATS, Format
from ..export.write import ExportError, write_bytes
from ..geometry.resolution import Resolution
from . import manifest as manifests
from .chunk import Chunk, ReportProgress
from .job import Job
from .manifest import Manifest
from .output import Output
from .resume import make_ready, sweep_all
from .schema import expand
from .workers import write_shared


def write_dataset(
    job: Job,
    out: Path | str,
    output: Output,
    *,
    part: tuple[int, int] = (1, 1),
    force: bool = False,
    progress: ReportProgress | None = None,
    workers: int = 1,
) -> Manifest:
    """Write the objects of a job to the folder ``out`` and return the manifest. Raises ExportError, NoObject.

    Objects are made only for shards where something is missing (all of them until a run has come to its end and its counts
    are known). ``part`` (k, n) writes every n-th shard from the k-th on, so that n runs share the work; the counts are then
    left out. ``progress(done, total)`` hears of objects as they are finished; ``workers``: how many processes share the work.
    """
    out, numbers, shard = Path(out), job.request.objects, output.shard
    manifest = make_ready(out, manifests.build_manifest(job.program, job.request, output, out=out), force)
    counting = "counts" not in manifest and part[1] == 1
    remade = job.tables is not None  # what was counted then is known, or it is not
    first, step = (part[0] - 1) * shard, part[1] * shard
    chunks = [
        Chunk(
            out, numbers[at : at + shard], output.writers, output.content, at // shard, always=counting and not remade
        )
        for at in range(first, len(numbers), step)
    ]
    _carry_out(job, chunks, progress, workers)
    counts = job.counts()
    if counting and counts is not None:
        manifest = manifests.build_manifest(job.program, job.request, output, out=out, counts=counts)
        write_bytes(out / manifests.NAME, manifests.to_text(manifest), force=True)
    return manifest


def _carry_out(job: Job, chunks: list[Chunk], progress: ReportProgress | None, workers: int) -> None:
    """Write all chunks, here or by other processes in smaller pieces."""
    total, done = sum(len(chunk.numbers) for chunk in chunks), 0
    if workers > 1:
        for piece in write_shared(job, workers, [piece for chunk in chunks for piece in chunk.split()]):
            done += len(piece.numbers) if piece.each or not chunks[0].each else 0
            if progress:
                progress(done, total)
        return
    for chunk in chunks:
        chunk.write(job.batch, _offset(progress, done, total))
        done += len(chunk.numbers)
        if progress:
            progress(done, total)


def _offset(progress: ReportProgress | None, done: int, total: int) -> ReportProgress | None:
    return (lambda finished, _: progress(done + finished, total)) if progress else None


def add_formats(
    job: Job,
    out: Path,
    formats: Sequence[Format],
    *,
    resolution: Resolution | None = None,
    force: bool = False,
    progress: ReportProgress | None = None,
    workers: int = 1,
) -> None:
    """Further files for the objects of a job in their folder; formats that it has are refused, or written again by ``force``.

    ``resolution`` of the meshes, None: that of the folder.
    The manifest names the new formats once all objects have them; until then the same call completes what is missing.
    """
    numbers = job.request.objects
    manifest = manifests.read_manifest(out)
    assert manifest is not None
    identity = manifest["identity"]
    listed = identity["formats"]
    resolution = resolution or Output.from_manifest(identity).content.resolution
    doubled = [entry.name for entry in formats if entry.name in listed]
    there = {n for n in numbers.tolist() if not find_lacking(object_folder(out, n), formats)}
    if doubled and len(there) == len(numbers) and not force:
        raise ExportError(f"{out} already has its objects as {', '.join(doubled)}", "use --force to write them again")
    sweep_all(out)
    content = Content(resolution=resolution)
    chunks = [
        Chunk(out, numbers[first : first + SHARD], tuple(formats), content, force=force)
        for first in range(0, len(numbers), SHARD)
    ]
    _carry_out(job, chunks, progress, workers)
    new = [entry.name for entry in formats if entry.name not in listed]
    if new and not any(find_lacking(object_folder(out, n), formats) for n in expand(identity["numbers"]).tolist()):
        identity["formats"] = [name for name in FORMATS if name in {*listed, *new}]
        write_bytes(out / manifests.NAME, manifests.to_text(manifest), force=True)
