"""``apgc export``: files per object, or a folder in a layout of the field, of samples or of fresh objects of a category."""

from __future__ import annotations

import argparse
import time
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UsageError, plural
from ..export.remote import is_same, place_of
from ..run.progress import Progress, took
from .messages import say
from .sample import bared, read_resolution, read_workers, refuse_file
from .wanted import choose_details, open_wanted, tell_frame

if TYPE_CHECKING:
    from ..layouts.registry import Layout


def run(options: argparse.Namespace) -> int:
    from ..export.content import Content
    from ..export.registry import find_formats, object_formats
    from ..export.write import ExportError
    from ..geometry.resolution import STANDARD
    from ..run.dataset import add_formats, write_dataset
    from ..run.output import Output

    begun = time.monotonic()
    layout = _layout(options)
    if layout is not None:
        return _lay_out(options, layout, begun)
    try:
        formats = bared(find_formats(options.format), options)
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
    tell_frame(job, formats, options.frame)
    details = choose_details(options, job)
    written = True
    with Progress(job.program.name) as progress:
        if folder.is_dir() and is_same(out, folder):
            written = add_formats(
                job,
                out,
                formats,
                resolution=read_resolution(options),
                details=details,
                force=options.force,
                progress=progress,
                workers=read_workers(options),
            )
        else:
            content = Content(resolution=read_resolution(options) or STANDARD, details=details)
            output = Output.of(formats, content, options.memory)
            write_dataset(job, out, output, force=options.force, progress=progress, workers=read_workers(options))
    done = plural(len(job.request.objects), "object")
    names = ", ".join(entry.name for entry in formats)
    kept = "" if written else ", which were there: --force writes them again"
    say(f"{done} as {names} in {out}{kept} {took(begun)}")
    return 0


def _layout(options: argparse.Namespace) -> Layout | None:
    """The layout asked for, None where formats are. Raises UsageError."""
    from ..export.registry import FORMATS, OTHERS
    from ..layouts.registry import LAYOUTS

    names = [name.strip() for name in options.format.split(",")]
    found = [LAYOUTS[name] for name in names if name in LAYOUTS]
    for name in names:
        if name and name not in FORMATS and name not in LAYOUTS and name not in OTHERS:
            close = get_close_matches(name.lower(), (*FORMATS, *LAYOUTS), n=1)
            meant = f"did you mean {close[0]}? " if close else ""
            raise UsageError(
                f"unknown format {name!r}",
                f"{meant}the formats are {', '.join(FORMATS)}; the layouts are {', '.join(LAYOUTS)}",
            )
    if not found:
        if options.split is not None or options.map is not None:
            option = "--split" if options.split is not None else "--map"
            raise UsageError(f"{option} is for layouts", f"the layouts are {', '.join(LAYOUTS)}")
        return None
    if len(names) > 1:
        raise UsageError(f"{found[0].name} is a layout of its own folder", "export it without other formats")
    if options.no_meshes:
        raise UsageError(f"{found[0].name} always has its meshes", "leave out --no-meshes")
    if options.details is not None or options.bare:
        raise UsageError(
            f"{found[0].name} is made of the structure, and carries no details", "leave out --details and --bare"
        )
    if options.tolerance is not None or options.triangles is not None:
        raise UsageError(f"{found[0].name} has no meshes to choose for", "leave out --tolerance and --triangles")
    if options.cluster or options.memory is not None:
        raise UsageError(
            f"{found[0].name} is laid out on this machine, some objects at a time",
            "leave out --cluster and --memory; --workers divides the work",
        )
    return found[0]


def _wears_details(program: str) -> bool:
    """Whether this is a folder whose points wear details."""
    from ..run.resume import read_folder_manifest

    return place_of(program).is_dir() and "details" in read_folder_manifest(program)["identity"]


def _lay_out(options: argparse.Namespace, layout: Layout, begun: float) -> int:
    from ..layouts.entry import USUAL, read_shares
    from ..layouts.words import read_map
    from ..run.laying import find_cautions, find_taken, write_layout

    shares = USUAL if options.split is None else read_shares(options.split)
    own = None if options.map is None else read_map(options.map)
    if place_of(options.program).is_dir() and options.out is None:
        raise UsageError(f"{layout.name} is a folder of its own", "name one with -o")
    if _wears_details(options.program):
        raise UsageError(
            f"the points in {options.program} wear details, which {layout.name} does not carry",
            "make the folder again without --details",
        )
    out = place_of(options.out or "out")
    if not isinstance(out, Path):
        raise UsageError(
            f"{out} is not on this machine, where layouts are written", "lay it out in a folder, and copy that"
        )
    refuse_file(out)
    job = open_wanted(options, every=True)
    with Progress(job.program.name) as progress:
        entry = write_layout(
            job,
            out,
            layout,
            shares=shares,
            own=own,
            force=options.force,
            progress=progress,
            workers=options.workers,
            frame=options.frame,
        )
    taken = find_taken(out, layout, entry)
    counts = ", ".join(f"{len(at)} {split}" for split, at in entry.splits(taken).items())
    left = len(entry.numbers) - len(taken)
    but = f", {left} left out, for which {layout.name} has no form (docs/layouts.md)" if left else ""
    say(f"{plural(len(taken), 'object')} of {entry.category} as {layout.name} in {out}: {counts}{but} {took(begun)}")
    for words in find_cautions(out, layout):
        say(words)
    return 0
