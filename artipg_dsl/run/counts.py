"""What a run has counted, in words: attempts, what failed and where the program asks for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NotRequired, TypedDict

from ..errors import NoObject
from ..graph.program import Program
from ..runtime.repairs import Cause, describe_cause
from ..sampling.statistics import Exhausted, Statistics
from .schema import Count

_NARROW = "widen the ranges, or state what one value leaves to the next"
_TURNED = "leave room where it turns or slides, or turn its axis round: `lid.back.bottom` for `lid.bottom.back`"


class Candidates(TypedDict):
    each: Count
    valid: float
    effective: float


class Counts(TypedDict):
    """The statistics as the manifest keeps them."""

    checked: bool
    objects: Count
    first_valid: Count
    attempts: Count
    failed: dict[str, Count]
    repaired: NotRequired[dict[str, Count]]
    declined: NotRequired[Count]
    not_preferred: NotRequired[dict[str, Count]]
    candidates: NotRequired[Candidates]


def summarize(program: Program, made: Statistics, checked: bool) -> Counts:
    """The statistics of a run; ``checked``: collisions were looked for."""
    found: Counts = {
        "checked": checked,
        "objects": made.objects,
        "first_valid": made.first_valid,
        "attempts": made.attempts,
        "failed": count_in_words(program, made.failures()),
    }
    if made.repaired:
        found["repaired"] = count_in_words(program, made.repaired)
    if program.preferences and not made.candidates:  # else they are part of the weights
        found["declined"] = made.declined
        kept_not = ((program.preferences[k], count) for k, count in made.unkept.items())
        found["not_preferred"] = {f"{one.where}: prefer {one.text}": count for one, count in kept_not}
    if made.candidates:
        attempts = max(1, made.attempts)
        found["candidates"] = {
            "each": made.candidates,
            "valid": made.candidates_valid / attempts,
            "effective": made.effective * made.candidates / attempts,
        }
    return found


def count_in_words(program: Program, counted: Mapping[Cause, int]) -> dict[str, int]:
    """Counts of what failed, in words with its place in the text, the most frequent first."""
    found: dict[str, int] = {}
    for cause, count in counted.items():
        words = describe_cause(program, cause)
        found[words] = found.get(words, 0) + count
    return dict(sorted(found.items(), key=lambda item: (-item[1], item[0])))


def explain_exhausted(program: Program, error: Exhausted, fixed: bool) -> NoObject:
    """What the requirements leave nothing of, and which of them are to blame; ``fixed``: parameters were set."""
    shown = ", ".join(map(str, error.numbers[:3].tolist())) + (", ..." if len(error.numbers) > 3 else "")
    counted = "object" if len(error.numbers) == 1 else f"{len(error.numbers)} objects"
    shapes = {describe_cause(program, ("collision", key)): words for key, words in error.statistics.examples.items()}
    lines = [
        f"  {count:>8} times: {reason}" + (f"\n{'':17}{shapes[reason]}" if shapes.get(reason) else "")
        for reason, count in list(count_in_words(program, error.statistics.failures()).items())[:3]
    ]
    with_these = " with these settings" if fixed else ""
    return NoObject(
        (
            f"no valid {program.name} exists with these settings; "
            if error.hopeless
            else f"no valid {program.name} in {error.attempts} attempts{with_these} for {counted} {shown}; "
        )
        + "what failed most:\n"
        + "\n".join(lines),
        "set other values" if fixed else _TURNED if " collide while " in lines[0] else _NARROW,
    )
