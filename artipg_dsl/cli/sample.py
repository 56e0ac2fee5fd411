"""``apgc sample``: annotated objects into a folder."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError, UserError
from ..settings import split
from .messages import say
from .progress import Progress

if TYPE_CHECKING:
    from ..export.content import Content
    from ..geometry.resolution import Resolution
    from ..job import Job
    from ..runtime.mutate import Mutation


PLAIN = {"motion": False, "surface": "boundary", "spread": "random", "per": "object"}


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
    from ..annotate.sampling import Sampling
    from ..annotate.states import read_states
    from ..export.content import Content
    from ..geometry.resolution import STANDARD

    cameras = None if options.views is None else read_cameras(options.views)
    how = Sampling(options.points, options.surface, options.spread, options.per)
    kind = how.surface, how.spread, how.per
    hand, meshes = read_gripper(options.gripper), resolution(options) or STANDARD
    return Content(how.count, read_states(options.states), options.motion, cameras, *kind, hand, meshes)


def resolution(options: argparse.Namespace) -> Resolution | None:
    """How fine meshes are to be, where that is asked for."""
    from ..geometry.resolution import Resolution

    asked = options.tolerance, options.triangles
    return None if asked == (None, None) else Resolution(tolerance=options.tolerance, triangles=options.triangles)


def mutation(options: argparse.Namespace) -> Mutation:
    """The mutation asked for. Raises UsageError."""
    from ..runtime.mutate import OPERATIONS, Mutation

    wanted = tuple(name.strip() for name in options.mutate.split(","))
    unknown = [name for name in wanted if name not in OPERATIONS]
    if unknown:
        raise UsageError(f"there is no operation `{unknown[0]}`", f"the operations are {', '.join(OPERATIONS)}")
    return Mutation(wanted, options.variant)


def run(options: argparse.Namespace) -> int:
    from ..export.registry import choose
    from ..export.write import ExportError
    from ..job import open_job

    begun = time.monotonic()
    settings = split(options.set)
    try:
        formats = choose(options.format, views=options.views is not None)
    except ExportError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None
    content = held(options)
    asked = {"motion": options.motion, "surface": options.surface, "spread": options.spread, "per": options.per}
    for name, value in asked.items():
        if value != PLAIN[name] and "points" not in [entry.name for entry in formats]:
            raise UsageError(f"--{name} is about points, which are not among the formats", "add points to --format")
    if resolution(options) and not any(entry.per_object for entry in formats):
        raise UsageError("--tolerance and --triangles are about meshes, which none of the formats has", "add one such as glb to --format")
    in_the_way(Path(options.out))
    if content.cameras is not None:
        tell_engine()
    job = open_job(options.program, options.seed or 0, settings, checked=not options.unchecked, sampling=options.sampling)
    if options.mutate:
        job = job.mutated(mutation(options))
    numbers = chosen(options)
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
        )
    if options.stats:
        print(statistics(job, manifest))
    done = "1 object" if len(numbers) == 1 else f"{len(numbers)} objects"
    share = "" if options.shard[1] == 1 else f", part {options.shard[0]} of {options.shard[1]}"
    say(f"{done} in {options.out}{share} ({time.monotonic() - begun:.1f} s)")
    return 0


def tell_engine() -> None:
    """Say that views take longer where embree is missing."""
    from ..geometry.rays import best_engine

    if best_engine() != "embree":
        say("views: embree is not installed, so NumPy casts the rays, which is slower; pip install 'artipg_dsl[rays]' brings it")


def statistics(job: Job, manifest: dict[str, Any]) -> str:
    """How well the text of the category leads to valid objects: counts, and what failed with its line."""
    counts = manifest.get("counts") or job.counts()
    made, valid = counts["objects"], counts["first_valid"]
    if not made:
        return "nothing was left to sample"
    lines = [f"{made} objects, {100 * valid / made:.1f}% valid at first, {counts['attempts']} attempts"]
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
    for reason, count in counts["failed"].items():
        lines.append(f"{count:>8} failed  {reason}")
    for reason, count in counts.get("not_preferred", {}).items():
        lines.append(f"{count:>8} not preferred  {reason}")
    return "\n".join(lines)
