"""``apgc bind``: the surface of real objects as details of the objects that were fitted to them."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

from ..errors import plural
from ..run.progress import Progress, took
from .messages import say


def run(options: argparse.Namespace) -> int:
    from ..fit.finding import find_files
    from ..run.binding import Binding
    from ..run.bindings import write_bindings
    from .sample import refuse_file

    begun = time.monotonic()
    out = Path(options.out)
    refuse_file(out)
    real = find_files(options.files) if options.files else []
    asked = Binding(options.points, options.assignment, not options.visible)
    with Progress(str(options.fitted)) as progress:
        progress.stage("binding")
        summary = write_bindings(
            Path(options.fitted), asked, out, real, force=options.force, workers=options.workers, progress=progress
        )
    print(json.dumps(summary, indent=1, ensure_ascii=False) if options.json else _table(summary))
    found, failed = summary["objects"], summary["failed"]
    lost = f", {plural(len(failed), 'object')} could not be bound" if failed else ""
    say(f"details of {plural(len(found), 'object')} in {out}{lost} {took(begun)}")
    return 0 if found else 1


def _table(summary: dict[str, Any]) -> str:
    """A line per object: how far the real surface is from the structure, bare and in its details, and what of it is covered."""
    lines = []
    for one in summary["objects"]:
        before, after = one["before"], one["after"]
        lines.append(
            f"{before['to_worn']:6.2f}% -> {after['to_worn']:.2f}%  covered {100 * after['covered_real']:3.0f}%  {one['name']}"
        )
    lines += [f"{'not bound':>15}  {one['name']}: {one['reason']}" for one in summary["failed"]]
    return "\n".join(lines)
