"""``apgc sample``: annotated objects into a folder."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError, UserError
from ..run.settings import split
from .messages import say
from .progress import Progress

if TYPE_CHECKING:
    from ..export.content import Content
    from ..geometry.resolution import Resolution
    from ..run.job import Job
    from ..run.manifest import Manifest
    from ..run.output import Output
    from ..run.schema import Runs

ABOUT_POINTS = {"motion": False, "surface": "boundary", "spread": "random", "per": "object", "balance": None}


def in_the_way(folder: Path) -> None:
    """Refuse a folder whose name, or that of one above it, is a file's: before the work, not after."""
    for place in (folder, *folder.parents):
        if place.exists() and not place.is_dir():
            raise UserError(f"{place} is a file: a folder is needed there", "choose another output folder")


def run(options: argparse.Namespace) -> int:
    from ..export.registry import choose
    from ..export.write import ExportError
    from ..run.output import Output

    begun = time.monotonic()
    try:
        formats = choose(options.format, views=options.views is not None)
    except ExportError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None
    output = Output.of(formats, content(options))
    for name, usual in ABOUT_POINTS.items():
        if getattr(options, name) != usual and "points" not in output.formats:
            raise UsageError(f"--{name} is about points, which are not among the formats", "add points to --format")
    if resolution(options) and not any(entry.per_object for entry in formats):
        raise UsageError(
            "--tolerance and --triangles are about meshes, which none of the formats has",
            "add one such as glb to --format",
        )
    if options.variant is not None and not options.mutate:
        raise UsageError("--variant is about mutants, which are not asked for", "add --mutate apa,dpa,cpa")
    in_the_way(Path(options.out))
    if options.views is not None:
        tell_engine()
    job = requested(options)
    manifest, count = written(job, Path(options.out), output, options)
    if options.stats:
        print(statistics(job, manifest))
    share = "" if options.shard[1] == 1 else f", part {options.shard[0]} of {options.shard[1]}"
    say(f"{counted(count)} in {options.out}{share} ({time.monotonic() - begun:.1f} s)")
    return 0


def written(job: Job, out: Path, output: Output, options: argparse.Namespace) -> tuple[Manifest, int]:
    """Write the objects of a job, with progress; the manifest, and how many they are. Raises ExportError."""
    from ..run.dataset import write_dataset

    count = len(job.request.objects)
    with Progress(job.program.name) as progress:
        progress(0, count)
        manifest = write_dataset(
            job, out, output, force=options.force, part=options.shard, progress=progress, workers=options.workers
        )
    return manifest, count


def counted(objects: int) -> str:
    return "1 object" if objects == 1 else f"{objects} objects"


# ---------------------------------------------------------------- what is asked for


def content(options: argparse.Namespace) -> Content:
    """What the files are to hold."""
    from ..run.output import read_content

    names = ("points", "surface", "spread", "per", "balance", "weights", "states", "motion", "views", "gripper")
    return read_content(
        **{name: getattr(options, name) for name in names}, tolerance=options.tolerance, triangles=options.triangles
    )


def resolution(options: argparse.Namespace) -> Resolution | None:
    """How fine meshes are to be, where that is asked for."""
    from ..geometry.resolution import Resolution

    asked = options.tolerance, options.triangles
    return None if asked == (None, None) else Resolution(tolerance=options.tolerance, triangles=options.triangles)


def objects(options: argparse.Namespace) -> Runs:
    """The numbers of the objects asked for."""
    from ..run.request import numbered

    return numbered(None if options.only else options.number or options.default_number, options.only)


def requested(options: argparse.Namespace) -> Job:
    """The job: objects that are drawn, or those of a file of values, or mutants of them. Raises UsageError, UserError."""
    from ..run.job import open_job
    from ..run.params import read_params
    from ..run.request import SEQUENTIAL, Request, read_sampling
    from ..sampling.mutate import Mutation, read_operations

    step = Mutation(read_operations(options.mutate), options.variant or 0) if options.mutate else None
    settings, values, numbers = split(options.set), None, objects(options)
    if options.params is not None:
        if settings or options.sampling != SEQUENTIAL:
            raise UsageError("--params gives the values: --set and --sampling have no meaning beside it")
        values = read_params(options.params)
        numbers = among(options, len(values))
    request = Request(
        options.program,
        options.seed or 0,
        numbers,
        settings,
        checked=not options.unchecked,
        candidates=read_sampling(options.sampling),
        repair=options.repair and values is None,  # values are repaired anyway
        values=values,
    )
    job = open_job(request, values=options.params or "values")
    return job if step is None else job.mutated(step)


def among(options: argparse.Namespace, count: int) -> Runs:
    """The numbers of the objects asked for, of those that a file gives. Raises UsageError."""
    from ..run.request import numbered

    beyond = [n for n in options.only or () if n >= count]
    if beyond:
        raise UsageError(f"there is no object {beyond[0]}: {options.params} gives {count}, numbered from 0")
    return numbered(None if options.only else min(options.number or count, count), options.only)


# ---------------------------------------------------------------- what is told


def tell_engine() -> None:
    """Say that views take longer where embree is missing."""
    from ..geometry.rays import best_engine

    if best_engine() != "embree":
        say(
            "views: embree is not installed, so NumPy casts the rays, which is slower; pip install 'artipg_dsl[rays]' brings it"
        )


def statistics(job: Job, manifest: Manifest) -> str:
    """How well the text of the category leads to valid objects: counts, and what failed with its line."""
    counts = manifest.get("counts") or job.counts()
    made, valid = counts["objects"], counts["first_valid"]
    if not made:
        return "nothing was left to sample"
    what = "steps of mutation" if job.request.mutations else "objects"
    lines = [f"{made} {what}, {100 * valid / made:.1f}% valid at first, {counts['attempts']} attempts"]
    if not counts.get("checked", False):
        lines.append("collisions were not checked")
    if "candidates" in counts:
        found = counts["candidates"]
        lines.append(
            f"resampled among {found['each']} attempts for each object: {100 * found['valid']:.1f}% valid, as good as "
            f"{found['effective']:.1f} of equal weight"
        )
    if "declined" in counts:
        lines.append(f"{counts['declined']} valid objects passed over by preference")
    if counts["failed"]:
        lines.append("  failed  repaired  rejected")
    repaired = counts.get("repaired", {})
    for reason, count in counts["failed"].items():
        good = min(repaired.get(reason, 0), count)
        lines.append(f"{count:>8}  {good:>8}  {count - good:>8}  {reason}")
    for reason, count in counts.get("not_preferred", {}).items():
        lines.append(f"{count:>8} not preferred  {reason}")
    return "\n".join(lines)
