"""A folder of samples: shards, a folder per object where a format asks for it, and the manifest.

Every shard and every object's folder exists whole or not at all. A second run with the same options writes what is
missing and touches nothing else; with other options it refuses, or starts anew when forced to.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..geometry.resolution import STANDARD as STANDARD_RESOLUTION
from ..geometry.resolution import Resolution
from . import manifest as manifests
from .content import SHARD, STANDARD, Content
from .registry import FORMATS, Format
from .robot import Robots
from .write import ExportError, ensure_folder, explain, refuse_existing, replacing_folder, sweep, write_bytes

if TYPE_CHECKING:
    from ..graph.program import Program
    from ..runtime.batch import Batch

OBJECTS = "objects"


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
    source: str = "",
    part: tuple[int, int] = (1, 1),
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
    counts: Callable[[], dict[str, Any]] | None = None,
) -> dict[str, Any]:
    """Write the objects ``numbers`` (ascending) to ``out`` and return the manifest.

    ``sample(numbers)`` makes the batch of some of them; it is called only for shards where something is missing
    (for all of them until a run has come to its end and its counts are known).
    ``content`` says what the shards hold; ``shard`` how many objects, by default what is handy.
    ``source`` names the program for whoever reads the folder. ``part`` (k, n) writes every n-th shard from the k-th on,
    so that n runs share the work; the counts are then left out. ``progress(done, total)`` hears of objects as they are
    finished; ``counts()`` is asked once all objects have been sampled.
    """
    out, numbers = Path(out), np.asarray(numbers, dtype=np.int64)
    names = [f.name for f in formats]
    content = content.of(names)
    shard = shard or content.shard_size()
    make: dict[str, Any] = {"seed": seed, "numbers": numbers, "content": content, "formats": names}
    make |= {"shard": shard, "settings": settings, "source": source}
    manifest = prepare(out, manifests.build(program, **make), force)
    counting = counts is not None and "counts" not in manifest and part[1] == 1
    done = 0
    mine = range((part[0] - 1) * shard, len(numbers), part[1] * shard)
    total = sum(len(numbers[first : first + shard]) for first in mine)
    for first in mine:
        chosen = numbers[first : first + shard]
        missing = [f for f in formats if f.shard and not shard_path(out, f, first // shard).exists()]
        each = [f for f in formats if f.per_object]
        absent = np.array([n for n in chosen.tolist() if lacking(object_folder(out, n), each)], dtype=np.int64)
        batch = sample(chosen) if counting or missing or len(absent) else None
        if batch is not None:
            for entry in missing:
                write_bytes(shard_path(out, entry, first // shard), entry.shard_bytes(batch, content))
            if len(absent):
                inner = _offset(progress, done, total)
                write_objects(batch, out, each, only=absent, add=True, progress=inner, resolution=content.resolution)
        done += len(chosen)
        if progress:
            progress(done, total)
    if counting:
        assert counts is not None
        manifest = manifests.build(program, **make, counts=counts())
        write_bytes(out / manifests.NAME, manifests.text(manifest), force=True)
    return manifest


def _offset(progress: Callable[[int, int], None] | None, done: int, total: int) -> Callable[[int, int], None] | None:
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


def shard_path(out: Path, entry: Format, index: int) -> Path:
    return out / f"{entry.name}-{index:05d}{entry.suffix}"


def object_folder(out: Path, number: int) -> Path:
    return out / OBJECTS / f"{number:06d}"


def add_formats(
    sample: Callable[[np.ndarray], Batch],
    out: Path,
    numbers: np.ndarray,
    formats: Sequence[Format],
    *,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
    resolution: Resolution | None = None,
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
    done = 0
    for first in range(0, len(numbers), SHARD):
        chosen = numbers[first : first + SHARD]
        absent = chosen if force else np.array([n for n in chosen.tolist() if n not in there], dtype=np.int64)
        if len(absent):
            inner = _offset(progress, done, len(numbers))
            write_objects(
                sample(absent), out, formats, force=force, add=not force, progress=inner, resolution=resolution
            )
        done += len(chosen)
        if progress:
            progress(done, len(numbers))
    every = [n for first, last in manifest["identity"]["numbers"] for n in range(first, last + 1)]
    new = [entry.name for entry in formats if entry.name not in listed]
    if new and not any(lacking(object_folder(out, n), formats) for n in every):
        manifest["identity"]["formats"] = [name for name in FORMATS if name in {*listed, *new}]
        write_bytes(out / manifests.NAME, manifests.text(manifest), force=True)


def lacking(folder: Path, formats: Sequence[Format]) -> list[Format]:
    """Those of the formats whose files an object's folder does not hold. Folders appear whole, so one file tells."""
    return [entry for entry in formats if not (folder / entry.file).exists()]


def write_objects(
    batch: Batch,
    out: Path,
    formats: Sequence[Format],
    *,
    only: np.ndarray | None = None,
    force: bool = False,
    add: bool = False,
    progress: Callable[[int, int], None] | None = None,
    resolution: Resolution = STANDARD_RESOLUTION,
) -> None:
    """A folder ``objects/<number>`` with the files of all formats for every object of the batch (or of ``only``).

    ``force``: write what is there again. ``add``: write what is missing and leave the rest alone. ``resolution`` of the meshes.
    """
    robots = Robots(batch, resolution=resolution, collision=not all(entry.seen for entry in formats))
    wanted = set(batch.numbers.tolist() if only is None else only.tolist())
    for i, number in enumerate(batch.numbers.tolist()):
        if number in wanted:
            folder = object_folder(out, number)
            write_object(robots, i, folder, lacking(folder, formats) if add else formats, force=force)
        if progress:
            progress(i + 1, len(batch))


def write_object(robots: Robots, i: int, folder: Path, formats: Sequence[Format], *, force: bool = False) -> None:
    """The files of all formats into the folder of object ``i``, all at once or not at all. Its other files stay."""
    for entry in formats:
        refuse_existing(folder / entry.file, force)
    files = {name: data for entry in formats for name, data in entry.files(robots, i).items()}
    with replacing_folder(folder, force=True) as partial:
        known = folder.is_dir()
        if known:
            shutil.copytree(folder, partial, copy_function=link_or_copy, dirs_exist_ok=True)
        for parent in dict.fromkeys(Path(name).parent for name in files):
            (partial / parent).mkdir(parents=True, exist_ok=True)
        for name, data in files.items():
            if known:  # never write into a file that the old folder shares
                (partial / name).unlink(missing_ok=True)
            (partial / name).write_bytes(data)


def link_or_copy(old: str, new: str) -> None:
    """The same file under another name; a copy on file systems without links."""
    try:
        os.link(old, new)
    except OSError:
        shutil.copy2(old, new)
