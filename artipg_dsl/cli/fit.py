"""``apgc fit``: objects of a category that come nearest to real ones, meshes or point clouds."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ..errors import UsageError, UserError
from .messages import plural, say
from .progress import Progress, took

_SHOWN = 8  # labels of files


def run(options: argparse.Namespace) -> int:
    from ..fit.pose import Frame
    from ..fit.reading import find_files
    from ..run.fits import Asked, write_fits
    from ..run.job import open_program
    from .sample import refuse_file

    begun = time.monotonic()
    out = Path(options.out)
    refuse_file(out)
    frame = Frame(options.up, options.front, options.unit, options.normalised)
    paths = find_files(options.files, say)
    with Progress(options.program) as progress:
        progress.stage("compiling")
        sampler, source = open_program(options.program)
        words = read_words(options.map, sampler.program.vocabularies.get("semantic", ()))
        progress.stage("fitting")
        asked = Asked(
            source, out, frame, options.seed or 0, not options.unchecked, words, not options.plain, not options.at_rest
        )
        summary = write_fits(sampler, asked, paths, force=options.force, workers=options.workers, progress=progress)
    print(json.dumps(summary, indent=1, ensure_ascii=False) if options.json else _table(summary))
    found, failed = summary["objects"], summary["failed"]
    if found and "labels" in summary:
        tell_unmatched(options.map, dict(words), summary["labels"])
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
        + (f"  ({one['lost']})" if "lost" in one else "")
        for one in summary["objects"]
    ]
    lines += [f"     -   {'not read':<12}  {one['name']}: {one['reason']}" for one in summary["failed"]]
    return "\n".join(lines)


def tell_unmatched(name: str, words: Iterable[str], labels: Sequence[str]) -> None:
    """Say which names of a map file are those of no label of any file."""
    from ..diagnostics.suggest import any_of

    missing = [theirs for theirs in words if theirs not in labels]
    if missing:
        shown = any_of(labels[:_SHOWN], "and") + (f" and {len(labels) - _SHOWN} more" if labels[_SHOWN:] else "")
        has = f"their labels are {shown}" if labels else "they have none"
        say(f"warning: no file has a label {any_of(missing)}, as {name} says: {has}")


def read_words(name: str | None, known: tuple[str, ...]) -> tuple[tuple[str, str], ...]:
    """The pairs of a map file: their name, our word. Raises UserError, UsageError."""
    from ..diagnostics.suggest import did_you_mean
    from ..shapes import read_once

    if name is None:
        return ()
    try:
        found = json.loads(Path(name).read_text(encoding="utf-8-sig"), object_pairs_hook=read_once)
    except OSError as wrong:
        raise UserError(f"{name} cannot be read: {wrong.strerror or wrong}") from None
    except (json.JSONDecodeError, UnicodeDecodeError, RecursionError):
        raise UserError(f"{name} is not JSON", 'write {"their_name": "our_word"}') from None
    except ValueError as twice:
        raise UserError(f"{name}: {twice}", "leave one of them out") from None
    if not isinstance(found, dict) or not all(isinstance(word, str) for word in found.values()):
        raise UserError(f"{name} maps no names to words", 'write {"their_name": "our_word"}')
    for theirs, word in found.items():
        if word not in known:
            raise UsageError(
                f"{name}: `{theirs}` is to be `{word}`, which is no word of `semantic`", did_you_mean(word, known)
            )
    return tuple(found.items())
