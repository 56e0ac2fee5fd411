"""``apgc profile``: what the parts of a category cost, and where the time of a sample goes."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from ..run.progress import Progress
from .wanted import read_request

if TYPE_CHECKING:
    from ..quality.cost import Cost

_SHOWN = 20  # parts
_Result = TypeVar("_Result")


def run(options: argparse.Namespace) -> int:
    with Progress("profile") as progress:
        found = _examine(options, progress.stage)
    print(json.dumps(found, indent=1) if options.json else _text(found))
    return 0


def _examine(options: argparse.Namespace, stage: Callable[[str], None] = lambda _: None) -> dict[str, Any]:
    """Stages with their CPU seconds for the first object alone and then for all, and parts with their costs per object.

    The first object pays for what is found once: what surfaces and pieces are like, and the code for formulas.
    """
    from ..export.content import Content
    from ..export.registry import choose_formats
    from ..native.backend import told
    from ..quality.cost import measure_costs
    from ..run.job import open_job
    from ..validity.faults import find_faults

    spent: dict[str, list[float]] = {}

    def timed(name: str, work: Callable[[], _Result]) -> _Result:
        stage(name)
        begun = time.process_time()
        made = work()
        spent.setdefault(name, []).append(time.process_time() - begun)
        return made

    job = timed("compiling", lambda: open_job(read_request(options, checked=False)))
    for numbers in (job.request.objects[:1], None):
        batch = timed("drawing", partial(job.batch, numbers))
        timed("checking", partial(find_faults, batch))
        content = Content()
        for entry in choose_formats(None):
            if entry.shard:
                timed(f"writing {entry.name}", partial(entry.shard_bytes, batch, content))
    stage("making the pieces of each part")
    found: list[Cost] = measure_costs(batch, timed=True)
    return {
        "category": job.program.name,
        "objects": len(batch),
        "backend": told(),
        "compiling": spent.pop("compiling")[0],
        "stages": {name: {"first": first, "all": every} for name, (first, every) in spent.items()},
        "parts": [asdict(cost) for cost in found],
    }


def _text(found: dict[str, Any]) -> str:
    """The profile in lines."""
    number = found["objects"]
    lines = [f"{found['category']}: {number} objects as they are drawn, CPU time, backend {found['backend']}", ""]
    lines += [f"{'compiling':24}{found['compiling']:8.2f} s", ""]
    lines.append(f"{'':24}{'first object':>14}{'then an object':>18}")
    for name, seconds in found["stages"].items():
        lines.append(f"{name:24}{1e3 * seconds['first']:11.1f} ms{1e3 * seconds['all'] / number:15.2f} ms")
    lines += ["", f"{'per object':40}{'primitives':>12}{'pieces':>10}{'pairs':>12}{'shared':>10}{'ms':>10}"]
    parts = found["parts"]
    for cost in parts[:_SHOWN]:
        figures = f"{cost['primitives']:12.1f}{cost['pieces']:10.1f}{cost['pairs']:12.0f}{cost['shared']:10.0f}"
        figures += f"{1e3 * cost['seconds']:10.2f}"
        lines.append(f"{cost['part'][:39]:40}{figures}")
    if len(parts) > _SHOWN:
        lines.append(f"and {len(parts) - _SHOWN} more, with --json")
    lines += [
        "",
        "pairs: of pieces on different links, which the check tells apart; shared: pairs of primitives that may overlap, which",
        "`require stable` weighs; ms: to make the pieces again",
    ]
    return "\n".join(lines)
