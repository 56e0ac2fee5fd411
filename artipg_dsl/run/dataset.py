"""A folder of samples: shards, a folder per object where a format asks for it, and the manifest.

Every shard and every object's folder exists whole or not at all. A second run with the same options writes what is
missing and touches nothing else; with other options it refuses, or starts anew when forced to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from .. import cache
from ..details.dressing import Dressing
from ..errors import UsageError, UserError
from ..export.content import SHARD, Content
from ..export.objects import find_lacking, object_folder
from ..export.registry import FORMATS, Format, other_form
from ..export.remote import Place, Remote, place_of
from ..export.write import ExportError, write_bytes
from ..geometry.resolution import Resolution
from . import manifest as manifests
from .chunk import Chunk, ReportProgress, counts_name, offset_progress, read_counts
from .job import Job
from .manifest import Manifest
from .memory import Room, most_processes, share_of
from .output import Output, Shown, show
from .resume import drop_counts, make_ready, sweep_all, withdraw
from .schema import expand
from .sharing import ONE, Workers, processors, share
from .traces import keep_replays


def write_dataset(
    job: Job,
    out: Place | str,
    output: Output,
    *,
    part: tuple[int, int] = (1, 1),
    force: bool = False,
    progress: ReportProgress | None = None,
    workers: Workers = ONE,
    begin: Callable[[], None] | None = None,
) -> Manifest:
    """Write the objects of a job to the folder ``out`` and return the manifest. Raises ExportError, NoObject.

    Objects are made only for shards where something is missing, or which nobody has counted yet. ``part`` (k, n) writes every
    n-th shard from the k-th on, so that n runs share the work; the manifest then gets no counts.
    ``progress(done, total)`` hears of objects as they are finished. ``begin`` is called once the folder is ready for these objects.
    """
    out, numbers, shard = place_of(out), job.request.objects, output.shard
    wanted = manifests.build_manifest(job.program, job.request, output, out=out)
    workers = _able(workers, out)
    manifest = make_ready(out, wanted, force)  # once nothing stands in the way: it may replace what is there
    keep_replays(out, job.request.mutations)
    if begin:
        begin()
    counting = "counts" not in manifest and job.tables is None  # what is made from tables was counted when these were
    chunks = [
        Chunk(
            out, numbers[at : at + shard], output.writers, output.content, at // shard, _counts(at // shard, counting)
        )
        for at in _starts(len(numbers), shard, part)
    ]
    pieces = _pieces(chunks, workers.are_several)
    try:
        _carry_out(job, pieces, progress, workers)
    except UserError:
        if manifest is wanted and part[1] == 1:  # nobody else goes by it
            withdraw(out)
        raise
    _refuse_removed(out, manifest, pieces)
    try:
        job.statistics.take(read_counts(out, pieces))
    except ExportError:
        ended = manifests.read_manifest(out)  # by the same command elsewhere, which has put the counts together
        if ended is None or "counts" not in ended:
            raise
        manifest = ended
    counts = job.counts()
    if "counts" not in manifest and part[1] == 1 and counts is not None:
        manifest = manifests.build_manifest(job.program, job.request, output, out=out, counts=counts)
        write_bytes(out / manifests.NAME, manifests.to_text(manifest), force=True)
    if "counts" in manifest:
        drop_counts(out)
    return manifest


def _able(workers: Workers, out: Place) -> Workers:
    """Those that can write to a place. Raises UsageError where it is seen by one process alone, or where there is no cluster."""
    if isinstance(out, Remote) and out.private:
        if workers.count > 1 or workers.cluster:
            raise UsageError(
                f"{out} is seen by one process alone", "leave out --workers and --cluster, or choose another place"
            )
        return replace(workers, count=1)
    if workers.cluster:
        from .cluster import require_cluster  # start-up

        require_cluster(workers.cluster, workers.count)
    return workers


def _refuse_removed(out: Place, manifest: Manifest, pieces: Sequence[Chunk]) -> None:
    """Whether somebody has removed the folder meanwhile, and files with it. Raises ExportError; the same command then finds its manifest."""
    if manifests.read_manifest(out) is None and not all(piece.is_complete() for piece in pieces):
        write_bytes(out / manifests.NAME, manifests.to_text(manifest), force=True)
        raise _removed(out)


def _removed(out: Place) -> ExportError:
    return ExportError(f"files were removed from {out} while others were written", "the same command makes them again")


def number_of(objects: int, shard: int, part: tuple[int, int]) -> int:
    """How many of the objects are in this part, in shards of so many."""
    return sum(min(shard, objects - at) for at in _starts(objects, shard, part))


def _starts(objects: int, shard: int, part: tuple[int, int]) -> range:
    """Where the shards of this part begin: every n-th from the k-th on."""
    return range((part[0] - 1) * shard, objects, part[1] * shard)


def _counts(shard: int, counting: bool) -> str:
    return counts_name(shard) if counting else ""


def _pieces(chunks: list[Chunk], several: bool) -> list[Chunk]:
    """Work for one process or several; what is counted is so in the same pieces, by however many."""
    return [p for chunk in chunks for p in (chunk.split() if several or not chunk.shared else [chunk])]


def _carry_out(job: Job, pieces: list[Chunk], progress: ReportProgress | None, workers: Workers) -> None:
    """Write all pieces, here, by other processes, or on a cluster."""
    each = any(piece.each for piece in pieces)
    total, done = sum(len(piece.numbers) for piece in pieces if piece.each or not each), 0
    heard = 0

    def tell(finished: int) -> None:
        nonlocal heard
        heard = max(heard, finished)  # other processes are ahead of the pieces whose turn it is
        if progress:
            progress(heard, total)

    room = Room(share_of(workers.memory, 1), _taken(job, pieces))

    def is_counted(piece: Chunk) -> bool:
        return bool(piece.each) or not each

    def write(piece: Chunk) -> Chunk:
        piece.write(job, room, offset_progress(progress, done, total) if is_counted(piece) else None)
        return piece

    def others(rest: Sequence[Chunk], many: int) -> Iterable[Chunk]:
        from .workers import write_shared  # start-up: one process needs no others

        room.memory = share_of(workers.memory, many)
        from .tally import Tally  # start-up: it counts across processes

        return write_shared(job, many, rest, room, Tally(done, tell), each)

    made: Iterable[Chunk]
    if workers.cluster:
        from .cluster import write_on_cluster  # start-up

        made = write_on_cluster(job, workers.cluster, workers.count or processors(), pieces, room)
    else:
        # of a run that goes on where another ended it is not known how much is left: its progress tells
        pace = 0.0 if not pieces or pieces[0].is_complete() else room.pace() * len(pieces[0].numbers)
        made = share(pieces, workers.count, write, others, most=most_processes(workers.memory), pace=pace)
    for piece in made:
        done += len(piece.numbers) if is_counted(piece) else 0
        tell(done)
    if workers.cluster and pieces:
        sweep_all(pieces[0].out)  # others have written what a worker was at when it died
    room.keep()


def _taken(job: Job, pieces: list[Chunk]) -> str:
    """The entry of the cache that says how much memory and time an object takes; "" where there are no objects."""
    if not pieces or cache.folder() is None:
        return ""
    names = sorted({entry.name for piece in pieces for entry in piece.formats})
    return cache.key("memory", job.program.hash, repr(pieces[0].content), *names)


def add_formats(
    job: Job,
    out: Place,
    formats: Sequence[Format],
    *,
    resolution: Resolution | None,
    details: Dressing | None,
    force: bool,
    progress: ReportProgress | None,
    workers: Workers,
) -> bool:
    """Further files for the objects of a job in their folder; those that it has are left alone, or written again by ``force``;
    whether any are written.

    ``resolution`` of the meshes, None: that of the folder; ``details`` that they wear.
    The manifest names the new formats once all objects have them; until then the same call completes what is missing.
    """
    numbers = job.request.objects
    manifest = manifests.read_manifest(out)
    assert manifest is not None
    identity = manifest["identity"]
    own = Output.from_manifest(identity, out)
    resolution = resolution or own.content.resolution
    begun = force or any(find_lacking(object_folder(out, n), formats) for n in numbers.tolist())
    sweep_all(out)
    content = Content(resolution=resolution, details=details)
    anew = force and len(numbers) == manifest["objects"]
    named = _name_surfaces(manifest, out, formats, details is not None, anew)
    if _tell_shown(manifest, out, formats, show(resolution, details), own.shown, anew) or named:
        write_bytes(out / manifests.NAME, manifests.to_text(manifest), force=True)
    chunks = [
        Chunk(out, numbers[first : first + SHARD], tuple(formats), content, force=force)
        for first in range(0, len(numbers), SHARD)
    ]
    _carry_out(job, _pieces(chunks, workers.are_several), progress, workers)
    lacking = [n for n in expand(identity["numbers"]).tolist() if find_lacking(object_folder(out, n), formats)]
    if np.isin(lacking, numbers).any():
        raise _removed(out)
    manifest = manifests.read_manifest(out) or manifest  # another export into this folder may have ended meanwhile
    new = {entry.name for entry in formats}
    listed = [n for n in FORMATS if n in {*manifest["identity"]["formats"], *new} and other_form(n) not in new]
    if not lacking and listed != manifest["identity"]["formats"]:
        manifest["identity"]["formats"] = listed
        write_bytes(out / manifests.NAME, manifests.to_text(manifest), force=True)
    return begun


def _tell_shown(manifest: Manifest, out: Place, formats: Sequence[Format], now: Shown, own: Shown, anew: bool) -> bool:
    """Note what the meshes of formats show, before any is written, where it is not what the folder's ``own`` do; whether the manifest has
    changed. ``anew``: all objects are written again. Raises ExportError where some of them show something else."""
    known = manifest.get("shown", {})
    numbers = expand(manifest["identity"]["numbers"]).tolist()
    for entry in formats:
        was = known.get(entry.name, own)
        if was == now or anew or all(find_lacking(object_folder(out, n), [entry]) for n in numbers):
            continue
        other = [f"{_words(was[key])}, now {_words(now[key])}" for key in ("meshes", "details") if was[key] != now[key]]
        raise ExportError(
            f"{out} has objects as {entry.name} with other meshes ({' and '.join(other)})",
            "repeat the old options to complete them, write all of them again with --force, or into a folder of their own with -o",
        )
    told = known | {entry.name: now for entry in formats}
    manifest["shown"] = {name: shown for name, shown in told.items() if shown != own}
    if not manifest["shown"]:
        del manifest["shown"]
    return manifest.get("shown", {}) != known


def _words(shown: Mapping[str, Any] | None) -> str:
    return "as usual" if not shown else ", ".join(f"{name} {value}" for name, value in shown.items())


def _name_surfaces(manifest: Manifest, out: Place, formats: Sequence[Format], worn: bool, anew: bool) -> bool:
    """Note what the meshes of formats are of, before any is written; whether the manifest has changed. ``anew``: all objects are written
    again. Raises ExportError where some of them show another surface."""
    known = manifest.get("surfaces", {})
    if not worn and not known and "details" not in manifest["identity"]:
        return False
    said = manifests.name_surfaces([entry.name for entry in formats], worn=worn)
    numbers = expand(manifest["identity"]["numbers"]).tolist()
    other = [
        entry.name
        for entry in formats
        if known.get(entry.name, said.get(entry.name)) != said.get(entry.name)
        and not all(find_lacking(object_folder(out, n), [entry]) for n in numbers)  # a run that failed has left none
    ]
    if other and not anew:
        raise ExportError(
            f"{out} has objects as {', '.join(other)} that show {known[other[0]]}",
            "write all of them again with --force, or into a folder of their own with -o",
        )
    manifest["surfaces"] = known | said
    return manifest["surfaces"] != known
