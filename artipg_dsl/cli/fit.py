"""``apgc fit``: objects of a category that come nearest to real ones, meshes or point clouds."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

from ..errors import UserError, plural
from ..files import read_json
from ..run.progress import Progress, took
from .messages import say

_FORM = 'write {"their_name": "our_word"}'


def run(options: argparse.Namespace) -> int:
    from ..fit.finding import find_files
    from ..fit.pose import Frame
    from ..fit.sources import name_files
    from ..run.facts import read_facts
    from ..run.fits import Folder, write_fits
    from ..run.fitting import Asked, tell_unmatched
    from ..run.job import open_program
    from ..run.settings import split_settings
    from .sample import refuse_file

    begun = time.monotonic()
    out = Path(options.out)
    refuse_file(out)
    frame = Frame(options.up, options.front, options.unit, options.normalised)
    items = name_files(find_files(options.files, say))
    with Progress(options.program) as progress:
        progress.stage("compiling")
        sampler, source = open_program(options.program)
        words = read_words(options.map, sampler.program.vocabularies.get("semantic", ()))
        facts = read_facts(split_settings(options.set), options.facts, sampler.program, [item.name for item in items])
        progress.stage("fitting")
        asked = Asked(source, frame, options.seed or 0, not options.unchecked, words, not options.at_rest, facts)
        folder = Folder(out, pictures=not options.plain)
        summary, _, _ = write_fits(
            sampler,
            asked,
            folder,
            items,
            force=options.force,
            workers=options.workers,
            progress=progress,
            doing=lambda what: progress.stage(f"fitting {what}"),
        )
    print(json.dumps(summary, indent=1, ensure_ascii=False) if options.json else _table(summary))
    found, failed = summary["objects"], summary["failed"]
    if found and "labels" in summary:
        warn(tell_unmatched(dict(words), summary["labels"], options.map, "file"))
    good = [one for one in found if one["object"] is not None]
    far = len(found) - len(good)
    lost = f", {plural(far, 'object')} not among them: without a valid fit" if far else ""
    lost += f", {plural(len(failed), 'file')} could not be read" if failed else ""
    say(f"{plural(len(good), 'object')} in {out}{lost} {took(begun)}")
    return 0 if good else 1


def _table(summary: dict[str, Any]) -> str:
    """A line per file: what is said of it, and how far it is off."""
    lines = [
        f"{one['distance']:6.2f}%  {one['verdict']:<12}  {one['name']}"
        + ("" if one["valid"] else "  (not valid)")
        + "".join(f"  ({one[key]})" for key in ("lost", "doubt") if key in one)
        for one in summary["objects"]
    ]
    lines += [f"     -   {'not read':<12}  {one['name']}: {one['reason']}" for one in summary["failed"]]
    return "\n".join(lines)


def warn(text: str) -> None:
    """Say what a map names for nothing, if anything."""
    if text:
        say(f"warning: {text}")


def read_words(name: str | None, known: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """The pairs of a map file: their name, our word. Raises UserError, UsageError."""
    from ..run.fitting import check_words

    if name is None:
        return ()
    try:
        found = read_json(name, _FORM)
    except FileNotFoundError:
        raise UserError(f"there is no file {name}", _FORM) from None
    if not isinstance(found, dict) or not all(isinstance(word, str) for word in found.values()):
        raise UserError(f"{name} maps no names to words", _FORM)
    return check_words(found, known, name)
