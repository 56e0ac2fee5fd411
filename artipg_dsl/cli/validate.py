"""``apgc validate``: which links of a category's objects collide or block one another, and how many first attempts hold."""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import NoObject, UsageError
from ..settings import split
from .sample import chosen

if TYPE_CHECKING:
    from ..job import Job
    from ..runtime.evidence import Evidence, Pair


def run(options: argparse.Namespace) -> int:
    job, numbers = wanted(options)
    found = examine(job, numbers, options.states)
    print(json.dumps(found, indent=1) if options.json else text(found))
    delivered = found["delivered"]
    return 0 if delivered is not None and not delivered["invalid"] else 1


def wanted(options: argparse.Namespace) -> tuple[Job, np.ndarray]:
    """The job and the objects: those of a folder of samples, or fresh ones."""
    from ..job import open_job, reopen

    if not Path(options.program).is_dir():
        return open_job(options.program, options.seed or 0, split(options.set)), chosen(options)
    if options.seed is not None or options.set:
        raise UsageError(f"the samples in {options.program} have their seed and values", "leave --seed and --set out")
    job, numbers = reopen(options.program)
    if options.only is not None:
        return job, numbers[np.isin(numbers, options.only)]
    return job, numbers[: options.number]


def examine(job: Job, numbers: np.ndarray, states: int) -> dict[str, Any]:
    """All evidence as plain data. ``drawn`` are objects that meet the requirements, ``delivered`` what is handed out."""
    from ..runtime.evidence import evidence
    from ..runtime.sample import Statistics

    free = replace(job, checked=False, statistics=Statistics())
    drawn = evidence(free.batch(numbers), 0)
    job = replace(job, statistics=Statistics())
    try:
        delivered: Evidence | None = evidence(job.batch(numbers), states)
        why = None
    except NoObject as error:
        delivered, why = None, error.message
    made = job.statistics
    return {
        "category": job.sampler.program.name,
        "seed": job.seed,
        "objects": len(numbers),
        "checked": job.checked,
        "first_valid": made.first_valid / max(made.objects, 1),
        "attempts": made.attempts,
        "drawn": asdict(drawn),
        "delivered": None if delivered is None else asdict(delivered),
        "exhausted": why,
        "kinds": {joint.path: joint.kind for joint in job.sampler.program.joints},
    }


def text(found: dict[str, Any]) -> str:
    """The evidence in lines."""
    from ..runtime.evidence import Pair

    drawn, delivered, kinds = found["drawn"], found["delivered"], found["kinds"]
    lines = [
        f"{found['category']}: {found['objects']} objects, seed {found['seed']}",
        f"first attempts valid  {100 * found['first_valid']:.1f}%   ({found['attempts']} attempts in all)",
    ]
    for pair in drawn["pairs"]:
        lines.append("    " + collision(Pair(**pair), found["objects"], kinds))
    lines.extend(others(drawn["faults"], found["objects"]))
    if delivered is None:
        return "\n".join([*lines, f"nothing delivered: {found['exhausted']}"])
    valid = found["objects"] - delivered["invalid"]
    lines.append(
        f"delivered valid       {100 * valid / found['objects']:.1f}%   (at rest and over {delivered['joints']} joints)"
    )
    for pair in delivered["pairs"]:
        lines.append("    " + collision(Pair(**pair), found["objects"], kinds))
    lines.extend(others(delivered["faults"], found["objects"]))
    lines.append(
        f"blocking              {len(delivered['blocking'])} pairs of links in {delivered['states']} random configurations each"
    )
    for pair in delivered["blocking"]:
        lines.append(
            f"    {pair['first']} and {pair['second']}: {100 * pair['objects'] / found['objects']:.1f}% of objects"
        )
    return "\n".join(lines)


def others(faults: list[tuple[str, int]], objects: int) -> list[str]:
    """What is wrong besides collisions, in lines."""
    return [f"    {words}: {100 * count / objects:.1f}% of objects" for words, count in faults]


def collision(pair: Pair, objects: int, kinds: dict[str, str]) -> str:
    if not pair.joint:
        when = "at rest"
    elif kinds[pair.joint] == "prismatic":
        when = f"while {pair.joint} slides"
    else:
        when = f"while {pair.joint} turns, at {math.degrees(pair.value):.1f} deg"
    return f"{pair.first} and {pair.second} collide {when}: {100 * pair.objects / objects:.1f}% of objects"
