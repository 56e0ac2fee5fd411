"""``apgc export``: files per object, of a folder of samples or of fresh objects of a category."""

from __future__ import annotations

import argparse
import time

from ..errors import UsageError
from ..export.remote import is_same, place_of
from .messages import plural, say
from .progress import Progress
from .sample import read_resolution, refuse_file
from .wanted import open_wanted


def run(options: argparse.Namespace) -> int:
    from ..export.content import Content
    from ..export.registry import find_formats, object_formats
    from ..export.write import ExportError
    from ..geometry.resolution import STANDARD
    from ..run.dataset import add_formats, write_dataset
    from ..run.output import Output

    begun = time.monotonic()
    try:
        formats = find_formats(options.format)
    except ExportError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None
    for entry in formats:
        if not entry.per_object:
            known = ", ".join(object_formats())
            raise UsageError(f"{entry.name} is written by `apgc sample`", f"export writes {known}")
    folder = place_of(options.program)
    out = place_of(options.out or (options.program if folder.is_dir() else "out"))
    refuse_file(out)
    job = open_wanted(options, every=True)
    with Progress(job.program.name) as progress:
        if folder.is_dir() and is_same(out, folder):
            add_formats(
                job,
                out,
                formats,
                resolution=read_resolution(options),
                force=options.force,
                progress=progress,
                workers=options.workers,
                memory=options.memory,
            )
        else:
            output = Output.of(formats, Content(resolution=read_resolution(options) or STANDARD))
            write_dataset(
                job, out, output, force=options.force, progress=progress, workers=options.workers, memory=options.memory
            )
    done = plural(len(job.request.objects), "object")
    names = ", ".join(entry.name for entry in formats)
    say(f"{done} as {names} in {out} ({time.monotonic() - begun:.1f} s)")
    return 0
