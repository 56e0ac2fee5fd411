"""``apgc sample``: annotated objects into a folder."""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError, UserError
from ..run.settings import split
from .messages import say
from .progress import Progress

if TYPE_CHECKING:
    from ..export.content import Content
    from ..geometry.resolution import Resolution
    from ..run.job import Job
    from ..sampling.mutate import Mutation


PLAIN = {"motion": False, "surface": "boundary", "spread": "random", "per": "object", "balance": None}


def chosen(options: argparse.Namespace) -> np.ndarray:
    """The numbers of the objects asked for."""
    if options.only is not None:
        return np.array(options.only, dtype=np.int64)
    return np.arange(options.number or options.default_number)


def in_the_way(folder: Path) -> None:
    """Refuse a folder whose name, or that of one above it, is a file's: before the work, not after."""
    for place in (folder, *folder.parents):
        if place.exists() and not place.is_dir():
            raise UserError(f"{place} is a file: a folder is needed there", "choose another output folder")


def held(options: argparse.Namespace) -> Content:
    """What the shards are to hold."""
    from ..annotate.camera_file import read_cameras
    from ..annotate.gripper import read_gripper
    from ..annotate.sampling import Sampling, read_weights
    from ..annotate.states import read_states
    from ..export.content import Content
    from ..geometry.resolution import STANDARD

    cameras = None if options.views is None else read_cameras(options.views)
    weights = read_weights(options.weights)
    how = Sampling(options.points, options.surface, options.spread, options.per, options.balance or "", weights)
    kind = how.surface, how.spread, how.per
    hand, meshes = read_gripper(options.gripper), resolution(options) or STANDARD
    return Content(
        how.count, read_states(options.states), options.motion, cameras, *kind, hand, meshes, how.balance, how.weights
    )


def resolution(options: argparse.Namespace) -> Resolution | None:
    """How fine meshes are to be, where that is asked for."""
    from ..geometry.resolution import Resolution

    asked = options.tolerance, options.triangles
    return None if asked == (None, None) else Resolution(tolerance=options.tolerance, triangles=options.triangles)


def mutation(options: argparse.Namespace) -> Mutation:
    """The mutation asked for. Raises UsageError."""
    from ..sampling.mutate import OPERATIONS, Mutation

    wanted = tuple(name.strip() for name in options.mutate.split(","))
    unknown = [name for name in wanted if name not in OPERATIONS]
    if unknown:
        raise UsageError(f"there is no operation `{unknown[0]}`", f"the operations are {', '.join(OPERATIONS)}")
    return Mutation(wanted, options.variant or 0)


def run(options: argparse.Namespace) -> int:
    from ..export.registry import choose
    from ..export.write import ExportError

    begun = time.monotonic()
    settings = split(options.set)
    try:
        formats = choose(options.format, views=options.views is not None)
    except ExportError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None
    content = held(options)
    asked = {name: getattr(options, name) for name in PLAIN}
    for name, value in asked.items():
        if value != PLAIN[name] and "points" not in [entry.name for entry in formats]:
            raise UsageError(f"--{name} is about points, which are not among the formats", "add points to --format")
    if resolution(options) and not any(entry.per_object for entry in formats):
        raise UsageError(
            "--tolerance and --triangles are about meshes, which none of the formats has",
            "add one such as glb to --format",
        )
    if options.variant is not None and not options.mutate:
        raise UsageError("--variant is about mutants, which are not asked for", "add --mutate apa,dpa,cpa")
    in_the_way(Path(options.out))
    if content.cameras is not None:
        tell_engine()
    job = opened(options, settings)
    if options.mutate:
        job = job.mutated(mutation(options))
    numbers = chosen(options) if job.values is None else among(options, len(job.values.records))
    with Progress(job.sampler.program.name) as progress:
        progress(0, len(numbers))
        manifest = job.write(
            options.out,
            numbers,
            formats,
            content=content,
            force=options.force,
            part=options.shard,
            progress=progress,
            workers=options.workers,
        )
    if options.stats:
        print(statistics(job, manifest))
    done = "1 object" if len(numbers) == 1 else f"{len(numbers)} objects"
    share = "" if options.shard[1] == 1 else f", part {options.shard[0]} of {options.shard[1]}"
    say(f"{done} in {options.out}{share} ({time.monotonic() - begun:.1f} s)")
    return 0


def opened(options: argparse.Namespace, settings: dict[str, str]) -> Job:
    """The job: objects that are drawn, or those of a file of values. Raises UsageError, UserError."""
    from ..run.job import SEQUENTIAL, open_job

    sampling = options.sampling
    if options.params is None:
        job = open_job(
            options.program,
            options.seed or 0,
            settings,
            checked=not options.unchecked,
            sampling=sampling,
            repair=options.repair,
        )
        return job
    from ..run.params import read_params

    if settings or sampling != SEQUENTIAL:
        raise UsageError("--params gives the values: --set and --sampling have no meaning beside it")
    job = open_job(options.program, options.seed or 0, checked=not options.unchecked)
    return replace(job, values=read_params(options.params, job.sampler.program))


def among(options: argparse.Namespace, count: int) -> np.ndarray:
    """The numbers of the objects asked for, of those that a file gives. Raises UsageError."""
    beyond = [n for n in options.only or () if n >= count]
    if beyond:
        raise UsageError(f"there is no object {beyond[0]}: {options.params} gives {count}, numbered from 0")
    return (
        np.array(options.only, dtype=np.int64)
        if options.only is not None
        else np.arange(min(options.number or count, count))
    )


def tell_engine() -> None:
    """Say that views take longer where embree is missing."""
    from ..geometry.rays import best_engine

    if best_engine() != "embree":
        say(
            "views: embree is not installed, so NumPy casts the rays, which is slower; pip install 'artipg_dsl[rays]' brings it"
        )


def statistics(job: Job, manifest: dict[str, Any]) -> str:
    """How well the text of the category leads to valid objects: counts, and what failed with its line."""
    counts = manifest.get("counts") or job.counts()
    made, valid = counts["objects"], counts["first_valid"]
    if not made:
        return "nothing was left to sample"
    what = "steps of mutation" if job.mutations else "objects"
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
