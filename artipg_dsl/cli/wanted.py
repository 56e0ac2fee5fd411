"""The objects that a command is about: of a program, or of a folder of samples."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from ..errors import UsageError, UserError
from ..run.settings import split_settings

if TYPE_CHECKING:
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
        **more,
    )


def open_wanted(options: argparse.Namespace, *, every: bool = False) -> Job:
    """The job to take objects from; of a folder the first ones, or ``every`` one."""
    from ..export.remote import place_of
    from ..run.job import open_job
    from ..run.resume import reopen

    if not place_of(options.program).is_dir():
        return open_job(read_request(options))
    if options.set or options.seed is not None:
        raise UsageError(
            f"the samples in {options.program} already have their seed and settings",
            "leave out --seed and --set, or name a category",
        )
    if options.prior is not None:
        raise UsageError(f"the samples in {options.program} are there already", "leave out --prior, or name a category")
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


def is_folder(program: str) -> bool:
    """Whether this is a folder of samples, and not a category, which a folder may be called by: ``./Chair`` is the folder."""
    from ..export.remote import place_of
    from ..run.manifest import NAME

    if not (place_of(program) / NAME).is_file():
        return False
    from ..session import categories  # start-up: what is sampled from a compiled program needs no parser

    return program not in categories()
