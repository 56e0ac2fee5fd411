"""``apgc render``: a contact sheet of a folder of samples, or of fresh objects of a category."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..run.progress import Progress
from .messages import say
from .sample import read_resolution
from .wanted import choose_details, open_wanted


def run(options: argparse.Namespace) -> int:
    from ..export.write import require_place
    from ..run.painting import paint_with
    from ..view.sheet import Sheet, read_direction, write_sheet

    require_place(Path(options.out), options.force)
    read_direction(options.view)
    job = open_wanted(options)
    details = choose_details(options, job)
    if details is not None and options.colour == "affordance" and options.details is None:
        say("affordances are drawn on the structure")
        details = None
    sheet = Sheet(
        colour=options.colour,
        tile=options.tile,
        states="open" if options.open else "alternate",
        view=options.view,
        resolution=read_resolution(options),
        details=details,
    )
    with Progress("drawing") as progress:
        painting = paint_with(options.workers)
        write_sheet(job.batch(), options.out, sheet, force=options.force, paint_all=painting, progress=progress)
    say(f"drew {len(job.request.objects)} of {job.program.name} to {options.out}")
    return 0
