"""A folder of samples: shards, a folder per object where a format asks for it, and the manifest.

Every shard and every object's folder exists whole or not at all. A second run with the same options writes what is
missing and touches nothing else; with other options it refuses, or starts anew when forced to.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import manifest as manifests
from .content import STANDARD, Content
from .registry import Format
from .robot import Robots
from .write import ExportError, ensure_folder, explain, replacing_folder, sweep, write_bytes

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
        absent = np.array([n for n in chosen.tolist() if not object_folder(out, n).exists()], dtype=np.int64)
        robots = [f for f in formats if f.robot]
        batch = sample(chosen) if counting or missing or (robots and len(absent)) else None
        if batch is not None:
            for entry in missing:
                assert entry.shard is not None
                write_bytes(shard_path(out, entry, first // shard), entry.shard(batch, content))
            if robots and len(absent):
                write_objects(batch, out, robots, only=absent, progress=_offset(progress, done, total))
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


def write_objects(
    batch: Batch,
    out: Path,
    formats: Sequence[Format],
    *,
    only: np.ndarray | None = None,
    force: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """A folder ``objects/<number>`` with the files of all formats for every object of the batch (or of ``only``)."""
    robots = Robots(batch)
    wanted = set(batch.numbers.tolist() if only is None else only.tolist())
    for i, number in enumerate(batch.numbers.tolist()):
        if number in wanted:
            write_object(robots, i, object_folder(out, number), formats, force=force)
        if progress:
            progress(i + 1, len(batch))


def write_object(robots: Robots, i: int, folder: Path, formats: Sequence[Format], *, force: bool = False) -> None:
    """The folder of object ``i`` with the files of all formats, whole or not at all."""
    robot = robots.robot(i)
    with replacing_folder(folder, force=force) as partial:
        for entry in formats:
            if entry.robot:
                entry.robot(robot, partial)
