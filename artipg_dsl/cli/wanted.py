"""The objects that a command is about: of a program, or of a folder of samples."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import UsageError, UserError, plural
from ..run.settings import split_settings
from .messages import say

if TYPE_CHECKING:
    from ..details.dressing import Dressing
    from ..export.registry import Format
    from ..run.job import Job
    from ..run.request import Request


def read_request(options: argparse.Namespace, program: str | None = None, **more: Any) -> Request:
    """The objects asked for: of a program, by a seed, with the values that are set. Raises UsageError, UserError."""
    from ..run import request

    only = options.only
    number = None if only else options.number or (None if more.get("values") else options.default_number)
    return request.read_request(
        program or options.program,
        seed=options.seed or 0,
        n=number,
        numbers=only,
        settings=split_settings(options.set),
        prior=options.prior,
        frame=options.frame,
        **more,
    )


def open_wanted(options: argparse.Namespace, *, every: bool = False) -> Job:
    """The job to take objects from; of a folder the first ones, or ``every`` one."""
    from ..export.remote import place_of
    from ..run.job import open_job
    from ..run.resume import reopen

    unchecked = getattr(options, "unchecked", False)
    if not place_of(options.program).is_dir():
        _require_any(options.program)
        return open_job(read_request(options, checked=not unchecked))
    if options.set or options.seed is not None:
        raise UsageError(
            f"the samples in {options.program} already have their seed and settings",
            "leave out --seed and --set, or name a category",
        )
    if options.prior is not None:
        raise UsageError(f"the samples in {options.program} are there already", "leave out --prior, or name a category")
    if options.frame is not None:
        raise UsageError(f"the samples in {options.program} lie as they do", "leave out --frame, or name a category")
    if unchecked:
        raise UsageError(
            f"the samples in {options.program} are there already", "leave out --unchecked, or name a category"
        )
    job = reopen(options.program)
    numbers = job.request.objects
    if options.number is not None and options.number > len(numbers):
        say(f"{options.program} has {plural(len(numbers), 'object')}, not {options.number}")
    if options.only is None:
        return job.of(numbers[: options.number or (len(numbers) if every else options.default_number)])
    absent = sorted(set(options.only) - set(numbers.tolist()))
    if absent:
        raise UserError(
            f"there is no object {absent[0]} in {options.program}", f"its manifest lists {len(numbers)} objects"
        )
    return job.of(options.only)


def _require_any(program: str) -> None:
    """Raises UserError for a name that is neither that of a folder nor of a program, nor near one."""
    from ..diagnostics.suggest import suggest
    from ..session import categories

    path, shipped = Path(program), [name.lower() for name in categories()]
    if path.name != program or path.suffix or program == "-" or program.lower().replace("_", "") in shipped:
        return
    if not os.path.exists(path) and not os.path.exists(f"{program}.apg") and not suggest(program, categories()):
        raise UserError(
            f"there is neither a folder nor a category `{program}`",
            "give a folder of samples, an .apg file, or a shipped category: apgc categories lists them",
        )


def tell_frame(job: Job, formats: Sequence[Format], asked: str | None) -> None:
    """Say where objects do not lie as those of the data set that a format follows, unless the frame was ``asked`` for."""
    from ..run.frame import read_frame

    for name in dict.fromkeys(entry.frame for entry in formats if entry.frame):
        degrees = read_frame(name).of(job.program.name)
        if asked is None and degrees != job.request.turned:
            say(
                f"{job.program.name} of the data set lie turned by {degrees} degrees: drawn with --frame {name}, these do, too"
            )


def read_strength(options: argparse.Namespace) -> float:
    """The strength of details. Raises UsageError where there are none."""
    if options.detail_strength is None:
        return 1.0
    if options.details is None:
        raise UsageError("--detail-strength scales details, and there are none", "add --details DIR")
    return float(options.detail_strength)


def choose_details(options: argparse.Namespace, job: Job) -> Dressing | None:
    """The details that meshes of the objects of a job wear: those that are named, else those that the points of their folder wear, with
    ``--bare`` none. Raises UsageError, UserError."""
    from ..export.remote import place_of
    from ..run.output import Output
    from ..run.resume import read_folder_manifest

    strength = read_strength(options)
    if options.bare:
        if options.details is not None:
            raise UsageError("--bare shows the structure, without details", "leave out --bare or --details")
        return None
    folder = options.program if place_of(options.program).is_dir() else None
    worn = Output.from_manifest(read_folder_manifest(folder)["identity"], folder).content.details if folder else None
    if options.details is None:
        return worn
    return wear(options.details, strength, job)


def wear(folder: str, strength: float, job: Job) -> Dressing:
    """How the objects of a job, or the mutants of these, wear the details in a folder; who borrows them, or goes bare, is told. Raises
    UserError."""
    from ..details.store import find_bare  # start-up: k-d trees load slowly
    from ..run.wearing import dress

    dressing = dress(job, folder, strength)
    if dressing.borrowed:
        say(f"the details in {folder} were bound to other objects than these, which borrow them")
        return dressing
    bare = find_bare(dressing, job.program, job.originals)
    if len(bare):
        say(
            f"warning: {folder} has no details of {len(bare)} of {len(job.originals)} objects, "
            f"of {bare[0]} for one: what is made of them is bare"
        )
    return dressing


def is_folder(program: str) -> bool:
    """Whether this is a folder of samples, and not a category, which a folder may be called by: ``./Chair`` is the folder."""
    from ..export.remote import place_of
    from ..run.manifest import NAME

    if not (place_of(program) / NAME).is_file():
        return False
    from ..session import categories  # start-up: what is sampled from a compiled program needs no parser

    return program not in categories()
