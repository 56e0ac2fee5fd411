"""``apgc sample``: annotated objects into a folder."""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from typing import TYPE_CHECKING

from ..errors import UsageError, UserError, plural
from ..export.remote import Place, Remote, is_same, place_of
from ..run.progress import Progress, took
from .messages import say
from .wanted import is_folder, open_wanted, read_request, read_strength, tell_frame

if TYPE_CHECKING:
    from ..export.content import Content
    from ..export.registry import Format
    from ..geometry.resolution import Resolution
    from ..run.job import Job
    from ..run.manifest import Manifest
    from ..run.output import Output
    from ..run.sharing import Workers


_REASONS = 3  # that are told unasked


def refuse_file(folder: Place) -> None:
    """Refuse a folder whose name, or that of one above it, is a file's: before the work, not after."""
    for place in () if isinstance(folder, Remote) else (folder, *folder.parents):
        if place.exists() and not place.is_dir():
            raise UserError(f"{place} is a file: a folder is needed there", "choose another output folder")


def run(options: argparse.Namespace) -> int:
    from ..export.registry import TABLES, choose_formats
    from ..export.write import ExportError
    from ..run.output import Output, refuse_idle

    begun = time.monotonic()
    try:
        named = options.format if not options.tables else ",".join(filter(None, [options.format, TABLES]))
        formats = bared(choose_formats(named, views=options.views is not None), options)
    except ExportError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None
    output = Output.of(formats, _read_content(options), options.memory)
    refuse_idle(output, "--")
    if options.variant is not None and not options.mutate:
        raise UsageError("--variant applies to mutants, and none are asked for", "add --mutate apa,dpa,cpa")
    strength = read_strength(options)
    if options.details is not None and not output.wearable:
        raise UsageError(
            "--details are worn by points and meshes, and none of the formats has any", "add points or glb to --format"
        )
    refuse_file(place_of(options.out))
    if options.views is not None:
        _warn_of_engine()
    with Progress(options.program) as progress:
        progress.stage("compiling")
        job = _open_job(options)
    tell_frame(job, formats, options.frame)
    if options.details is not None:
        from ..run.wearing import dress  # start-up: most objects wear none, and k-d trees load slowly

        output = replace(output, content=replace(output.content, details=dress(job, options.details, strength)))
    manifest, number = write(job, place_of(options.out), output, options)
    if options.params is not None:
        tell_repairs(job, manifest)
    if options.stats:
        print(show_statistics(job, manifest))
    share = "" if options.shard[1] == 1 else f", part {options.shard[0]} of {options.shard[1]}"
    say(f"{plural(number, 'object')} in {options.out}{share} {took(begun)}")
    return 0


def write(job: Job, out: Place, output: Output, options: argparse.Namespace) -> tuple[Manifest, int]:
    """Write the objects of a job, with progress; the manifest, and how many they are. Raises ExportError."""
    from ..run.dataset import number_of, write_dataset

    number = number_of(len(job.request.objects), output.shard, options.shard)
    with Progress(job.program.name) as progress:
        progress(0, number)
        progress.stage("drawing, checking and writing")
        manifest = write_dataset(
            job, out, output, force=options.force, part=options.shard, progress=progress, workers=read_workers(options)
        )
    return manifest, number


# ---------------------------------------------------------------- what is asked for


def _read_content(options: argparse.Namespace) -> Content:
    """What the files are to hold."""
    from ..run import output

    names = ("points", "surface", "spread", "per", "balance", "weights", "states", "motion", "views", "gripper")
    return output.read_content(
        **{name: getattr(options, name) for name in names}, tolerance=options.tolerance, triangles=options.triangles
    )


def read_workers(options: argparse.Namespace) -> Workers:
    """Who does the work, by the options that divide it."""
    from ..run.sharing import Workers

    return Workers(options.workers, options.memory, options.cluster)


def read_resolution(options: argparse.Namespace) -> Resolution | None:
    """How fine meshes are to be, where that is asked for."""
    from ..geometry.resolution import Resolution

    asked = options.tolerance, options.triangles
    return None if asked == (None, None) else Resolution(tolerance=options.tolerance, triangles=options.triangles)


def bared(formats: list[Format], options: argparse.Namespace) -> list[Format]:
    """The formats, without their meshes if that is asked for. Raises ExportError."""
    from ..export.registry import without_meshes
    from ..export.write import ExportError

    if not options.no_meshes:
        return formats
    if read_resolution(options):
        raise ExportError("--tolerance and --triangles are for meshes, and --no-meshes leaves them out", "choose one")
    return without_meshes(formats)


def _open_job(options: argparse.Namespace) -> Job:
    """The job: objects that are drawn, or those of a file of values, or mutants of them. Raises UsageError, UserError."""
    from ..run import job as jobs
    from ..sampling.mutation import Mutation, read_operations

    if is_folder(options.program):
        return _open_folder(options)
    step = Mutation(read_operations(options.mutate), options.variant or 0) if options.mutate else None
    asked = read_request(
        options, checked=not options.unchecked, sampling=options.sampling, repair=options.repair, values=options.params
    )
    job = jobs.open_job(asked, values=options.params or "values")
    return job if step is None else job.mutated(step)


def _open_folder(options: argparse.Namespace) -> Job:
    """The job of the objects of a folder, as they are. Raises UsageError, UserError."""
    for name in ("mutate", "params", "unchecked", "repair"):
        if getattr(options, name):
            hint = (
                "apgc mutate makes mutants of them" if name == "mutate" else f"leave out --{name}, or name a category"
            )
            raise UsageError(f"the samples in {options.program} are there already: --{name} does not apply", hint)
    if options.sampling != "sequential":
        raise UsageError(f"the samples in {options.program} are there already", "leave out --sampling")
    if is_same(place_of(options.out), place_of(options.program)):
        raise UsageError(f"{options.out} holds the samples themselves", "name another folder with -o")
    return open_wanted(options, every=True)


# ---------------------------------------------------------------- what is told


def _warn_of_engine() -> None:
    """Say that views take longer where embree is missing."""
    from ..geometry.rays import best_engine

    if best_engine() != "embree":
        say("views: NumPy casts the rays, which is slow; pip install 'artipg_dsl[rays]' installs embree")


def tell_repairs(job: Job, manifest: Manifest) -> None:
    """Say that objects, or the originals of mutants, are not as their values were given, where that is so."""
    counts, where = manifest.get("counts"), "see `repairs` in the annotation"
    if job.request.mutations:
        counts, where = job.count_originals(), "`apgc sample --params` shows which"
    repaired = counts.get("repaired", {}) if counts else {}
    if not counts or not repaired:
        return
    number, made = counts["objects"] - counts["first_valid"], counts["objects"]
    what = plural(made, "original" if job.request.mutations else "object")
    say(f"values of {number} of {what} were changed to make them valid: {where}")
    for reason, count in list(repaired.items())[:_REASONS]:
        say(f"  {plural(count, 'time')}: {reason}")
    if len(repaired) > _REASONS:
        say(f"  and {plural(len(repaired) - _REASONS, 'other reason')}: --stats lists them")


def show_statistics(job: Job, manifest: Manifest) -> str:
    """How well the text of the category leads to valid objects: counts, and what failed with its line."""
    counts = manifest.get("counts") or job.counts()
    if counts is None:
        return "these objects were counted together with others"
    made, valid = counts["objects"], counts["first_valid"]
    if not made:
        return "nothing was left to do"
    what = plural(made, "mutation" if job.request.mutations else "object")
    lines = [f"{what}, {100 * valid / made:.1f}% valid on the first attempt, {plural(counts['attempts'], 'attempt')}"]
    if job.request.prior is not None:
        lines.append(f"drawn by the prior {job.request.prior.show()}")
    if job.request.turned:
        lines.append(f"turned by {job.request.turned} degrees about z")
    if not counts.get("checked", False):
        lines.append("links were not checked for collisions")
    if "candidates" in counts:
        found = counts["candidates"]
        lines.append(
            f"resampled among {found['each']} attempts for each object: {100 * found['valid']:.1f}% valid, worth "
            f"{found['effective']:.1f} of equal weight"
        )
    if "declined" in counts:
        lines.append(f"{plural(counts['declined'], 'valid object')} passed over by preference")
    if "near_duplicates" in counts:
        lines.append(f"{plural(counts['near_duplicates'], 'near-duplicate')} left out")
    if counts["failed"]:
        lines.append("  failed  repaired  rejected")
    repaired = counts.get("repaired", {})
    for reason, count in counts["failed"].items():
        good = min(repaired.get(reason, 0), count)
        lines.append(f"{count:>8}  {good:>8}  {count - good:>8}  {reason}")
    for reason, count in counts.get("not_preferred", {}).items():
        lines.append(f"{count:>8} not preferred  {reason}")
    return "\n".join(lines)
