"""A folder of samples: shards, a folder per object where a format asks for it, and the manifest.

Every shard and every object's folder exists whole or not at all. A second run with the same options writes what is
missing and touches nothing else; with other options it refuses, or starts anew when forced to.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry.resolution import Resolution
from . import manifest as manifests
from .chunk import OBJECTS, Chunk, Progress, lacking, object_folder
from .content import SHARD, STANDARD, Content
from .registry import FORMATS, Format
from .write import ExportError, ensure_folder, explain, sweep, write_bytes

if TYPE_CHECKING:
    from ..graph.program import Program
    from ..runtime.batch import Batch

Run = Callable[[list[Chunk]], Iterable[Chunk]]  # writes chunks, and gives each back when it is done


def write_dataset(
    program: Program,
    sample: Callable[[np.ndarray], Batch],
    out: Path | str,
    *,
    seed: int,
    numbers: Sequence[int] | np.ndarray,
    formats: Sequence[Format],
    content: Content = STANDARD,
    shard: int | None = None,
    settings: dict[str, Any] | None = None,
    made: dict[str, Any] | None = None,
    source: str = "",
    part: tuple[int, int] = (1, 1),
    force: bool = False,
    progress: Progress | None = None,
    counts: Callable[[], dict[str, Any]] | None = None,
    run: Run | None = None,
) -> dict[str, Any]:
    """Write the objects ``numbers`` (ascending) to ``out`` and return the manifest.

    ``sample(numbers)`` makes the batch of some of them; it is called only for shards where something is missing
    (for all of them until a run has come to its end and its counts are known).
    ``content`` says what the shards hold; ``shard`` how many objects, by default what is handy.
    ``source`` names the program for whoever reads the folder. ``part`` (k, n) writes every n-th shard from the k-th on,
    so that n runs share the work; the counts are then left out. ``progress(done, total)`` hears of objects as they are
    finished; ``counts()`` is asked once all objects have been sampled. ``run`` writes the chunks elsewhere: it has its own way
    to sample.
    """
    out, numbers = Path(out), np.asarray(numbers, dtype=np.int64)
    names = [f.name for f in formats]
    content = content.of(names)
    shard = shard or content.shard_size()
    make: dict[str, Any] = {"seed": seed, "numbers": numbers, "content": content, "formats": names}
    make |= {"shard": shard, "settings": settings, "made": made, "source": source}
    manifest = prepare(out, manifests.build(program, **make), force)
    counting = counts is not None and "counts" not in manifest and part[1] == 1
    first, step = (part[0] - 1) * shard, part[1] * shard
    every = tuple(formats)
    chunks = [
        Chunk(out, numbers[at : at + shard], every, content, at // shard, always=counting)
        for at in range(first, len(numbers), step)
    ]
    carry_out(chunks, sample, run, progress)
    if counting:
        assert counts is not None
        manifest = manifests.build(program, **make, counts=counts())
        write_bytes(out / manifests.NAME, manifests.text(manifest), force=True)
    return manifest


def carry_out(
    chunks: list[Chunk], sample: Callable[[np.ndarray], Batch], run: Run | None, progress: Progress | None
) -> None:
    """Write all chunks, here or by ``run`` in smaller pieces."""
    total, done = sum(len(chunk.numbers) for chunk in chunks), 0
    if run is not None:
        for piece in run([piece for chunk in chunks for piece in chunk.split()]):
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


def prepare(out: Path, manifest: dict[str, Any], force: bool) -> dict[str, Any]:
    """Make the folder ready: keep what belongs to the same options, refuse (or with ``force`` remove) anything else.

    Returns the manifest that holds: the old one where its files are kept.
    """
    old = manifests.read(out)
    if old is not None:
        changed = manifests.difference(old, manifest)
        if changed and not force:
            raise ExportError(
                f"{out} holds samples made with other options: {changed}",
                "choose another folder, repeat the old options to complete them, or use --force to replace them",
            )
        if not changed and not force:
            sweep(out)
            if (out / OBJECTS).is_dir():
                sweep(out / OBJECTS)
            return old
        clear(out, old)
    elif not force and (out / OBJECTS).exists() and any((out / OBJECTS).iterdir()):
        raise ExportError(
            f"{out / OBJECTS} holds objects, and no {manifests.NAME} beside it says which",
            "choose another folder, or use --force to write among them",
        )
    ensure_folder(out)
    sweep(out)
    write_bytes(out / manifests.NAME, manifests.text(manifest), force=True)
    return manifest


def clear(out: Path, old: dict[str, Any]) -> None:
    """Remove what an earlier run with the manifest ``old`` wrote, and nothing else."""
    try:
        (out / manifests.NAME).unlink()  # first, so that a half-cleared folder does not pass for a whole one
        for shard in old.get("shards", []):
            for path in out.glob(f"*-{shard}.*"):
                if path.suffix in (".npz", ".jsonl"):
                    path.unlink()
        shutil.rmtree(out / OBJECTS, ignore_errors=True)
    except OSError as error:
        raise explain(error, out) from error


def add_formats(
    sample: Callable[[np.ndarray], Batch],
    out: Path,
    numbers: np.ndarray,
    formats: Sequence[Format],
    *,
    force: bool = False,
    progress: Progress | None = None,
    resolution: Resolution | None = None,
    run: Run | None = None,
) -> None:
    """Further files for objects of a folder of samples; formats that it has are refused, or written again by ``force``.

    ``resolution`` of the meshes, None: that of the folder.
    The manifest names the new formats once all objects have them; until then the same call completes what is missing.
    """
    manifest = manifests.read(out)
    assert manifest is not None
    listed = manifest["identity"]["formats"]
    resolution = resolution or Resolution(**manifest["identity"].get("meshes", {}))
    doubled = [entry.name for entry in formats if entry.name in listed]
    there = {n for n in numbers.tolist() if not lacking(object_folder(out, n), formats)}
    if doubled and len(there) == len(numbers) and not force:
        raise ExportError(f"{out} has its objects as {', '.join(doubled)}", "use --force to write them again")
    sweep(out)
    if (out / OBJECTS).is_dir():
        sweep(out / OBJECTS)
    content = Content(resolution=resolution)
    chunks = [
        Chunk(out, numbers[first : first + SHARD], tuple(formats), content, force=force)
        for first in range(0, len(numbers), SHARD)
    ]
    carry_out(chunks, sample, run, progress)
    every = [n for first, last in manifest["identity"]["numbers"] for n in range(first, last + 1)]
    new = [entry.name for entry in formats if entry.name not in listed]
    if new and not any(lacking(object_folder(out, n), formats) for n in every):
        manifest["identity"]["formats"] = [name for name in FORMATS if name in {*listed, *new}]
        write_bytes(out / manifests.NAME, manifests.text(manifest), force=True)
