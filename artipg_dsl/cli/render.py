"""``apgc render``: a contact sheet of a folder of samples, or of fresh objects of a category."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import UsageError, UserError
from ..run.job import Job, open_job
from ..run.resume import reopen
from .messages import say
from .progress import Progress
from .sample import read_request, read_resolution


def run(options: argparse.Namespace) -> int:
    from ..geometry.resolution import SMOOTH
    from ..view.sheet import direction, write_sheet

    if Path(options.out).suffix.lower() != ".png":
        raise UsageError(
            f"the picture is a PNG, and {options.out} is not the name of one", "choose a name that ends in .png"
        )
    direction(options.view)
    job = open_wanted(options)
    with Progress("drawing") as progress:
        write_sheet(
            job.batch(),
            options.out,
            force=True,
            colour=options.colour,
            tile=options.tile,
            progress=progress,
            states="open" if options.open else "alternate",
            view=options.view,
            resolution=read_resolution(options) or SMOOTH,
        )
    say(f"drew {len(job.request.objects)} of {job.program.name} to {options.out}")
    return 0


def open_wanted(options: argparse.Namespace, *, every: bool = False) -> Job:
    """The job to take objects from; of a folder the first ones, or ``every`` one."""
    if not Path(options.program).is_dir():
        return open_job(read_request(options))
    if options.set or options.seed is not None:
        raise UsageError(
            f"the samples in {options.program} already have their seed and settings",
            "leave out --seed and --set, or name a category",
        )
    job = reopen(options.program)
    numbers = job.request.objects
    if options.only is None:
        return job.of(numbers[: options.number or (len(numbers) if every else options.default_number)])
    absent = sorted(set(options.only) - set(numbers.tolist()))
    if absent:
        raise UserError(
            f"there is no object {absent[0]} in {options.program}", f"its manifest lists {len(numbers)} objects"
        )
    return job.of(options.only)
