"""``apgc validate``: which links of a category's objects collide or block one another, and how many first attempts hold."""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

from ..errors import UserError, plural
from ..language import JOINTS
from ..run.progress import Progress
from .wanted import open_wanted

_SHOWN = 12  # of what meshes share


def run(options: argparse.Namespace) -> int:
    from ..run.evidence import examine

    with Progress("validating") as progress:
        progress.stage("compiling")
        job = open_wanted(options)
    if not job.request.numbers:
        raise UserError("there is no object to validate", "sample at least one")
    with Progress("validating") as progress:
        found = examine(job, options.states, options.meshes, options.workers, progress, progress.stage)
    print(json.dumps(found, indent=1) if options.json else _text(found))
    delivered, meshes = found["delivered"], found["meshes"]
    sound = delivered is not None and not delivered["invalid"]
    return 0 if sound and (meshes is None or meshes["all"] == meshes["objects"]) else 1


def _text(found: dict[str, Any]) -> str:
    """The evidence in lines."""
    drawn, delivered, kinds = found["drawn"], found["delivered"], found["kinds"]
    lines = [
        f"{found['category']}: {plural(found['objects'], 'object')}, seed {found['seed']}",
        f"first attempts valid  {100 * found['first_valid']:.1f}%   ({plural(found['attempts'], 'attempt')} in all)",
    ]
    for pair in drawn["pairs"]:
        lines += _collision(pair, found["objects"], kinds)
    lines.extend(_others(drawn["faults"], found["objects"]))
    if delivered is None:
        return "\n".join([*lines, f"nothing delivered: {found['exhausted']}"])
    valid = found["objects"] - delivered["invalid"]
    lines.append(
        f"delivered valid       {100 * valid / found['objects']:.1f}%   (at rest and over {plural(delivered['joints'], 'joint')})"
    )
    for pair in delivered["pairs"]:
        lines += _collision(pair, found["objects"], kinds)
    lines.extend(_others(delivered["faults"], found["objects"]))
    lines.append(
        f"blocking              {plural(len(delivered['blocking']), 'pair')} of links in {delivered['states']} random configurations each"
    )
    for pair in delivered["blocking"]:
        lines.append(
            f"    {pair['first']} and {pair['second']}: {100 * pair['objects'] / found['objects']:.1f}% of objects"
        )
    lines.append(
        f"in every state        {100 * (found['objects'] - delivered['blocked']) / found['objects']:.1f}%   (the pieces that collide)"
    )
    if found["meshes"] is not None:
        lines += _meshes_text(found["meshes"])
    return "\n".join(lines)


def _meshes_text(seen: dict[str, Any]) -> list[str]:
    """What the meshes share, in lines: the deepest first."""
    shares = [f"{100 * seen[key] / seen['objects']:.1f}%" for key in ("rest", "sweeps", "all")]
    lines = [
        f"in every state        {shares[2]}   (the meshes that are seen; at rest {shares[0]}, and while each joint moves "
        f"{shares[1]}, and in {seen['states']} random configurations {shares[2]})"
    ]
    for touch in sorted(seen["touches"], key=lambda touch: -touch["depth"])[:_SHOWN]:
        values = ", ".join(f"{name} at {value:.4g}" for name, value in touch["values"].items()) or "at rest"
        (one, two), (part, other) = touch["links"], touch["parts"]
        at = ", ".join(f"{x:.4g}" for x in touch["at"])
        lines.append(f"    object {touch['object']}: {one} and {two} share {1e3 * touch['depth']:.3g} mm")
        lines.append(f"        `{part}` and `{other}` about ({at}) m, {values}")
    if len(seen["touches"]) > _SHOWN:
        lines.append(f"    and {len(seen['touches']) - _SHOWN} more, with --json")
    return lines


def _others(faults: list[tuple[str, int, str]], objects: int) -> list[str]:
    """What is wrong besides collisions, and of one object how, in lines."""
    lines = []
    for words, count, example in faults:
        lines.append(f"    {words}: {100 * count / objects:.1f}% of objects")
        lines += [f"        {example}"] * bool(example)
    return lines


def _collision(pair: dict[str, Any], objects: int, kinds: dict[str, str]) -> list[str]:
    """Two links that collide, and of one object the parts, the value of the joint and the place, in lines."""
    from ..validity.contact import Contact, contact_in_words, tenths

    kind, joint = kinds.get(pair["joint"], ""), pair["joint"]
    if not joint:
        when = "at rest"
    elif kind in JOINTS and JOINTS[kind].slides:
        when = f"while {joint} slides"
    elif pair["example"] is not None:  # it tells where they first meet
        when = f"while {joint} turns"
    else:
        when = f"while {joint} turns, at {tenths(math.degrees(pair['value']))} deg"
    share = f"{100 * pair['objects'] / objects:.1f}% of objects"
    lines = [f"    {pair['first']} and {pair['second']} collide {when}: {share}"]
    if pair["example"] is not None:
        lines.append("        " + contact_in_words(kind, Contact(**pair["example"])))
    return lines
