"""What a run has counted, in words: attempts, what failed and where the program asks for it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import NotRequired, TypedDict

import numpy as np

from ..diagnostics.suggest import any_of
from ..errors import NoObject, plural
from ..graph.depend import draws_behind
from ..graph.program import Program
from ..runtime.repairs import Cause, describe_cause
from ..sampling.statistics import Exhausted, Statistics
from .schema import Count
from .settings import Value

_NARROW = "widen the ranges, or state what one value leaves to the next"
_SHOWN = "leave a gap between links, and let each come near what holds it; `apgc render --unchecked` draws objects as they are"
_LOOSE = (
    "bring the part to what carries it, or write `allow floating`; `apgc render --unchecked` draws objects as they are"
)
_FALLEN = "broaden what it stands on, or bring its weight over that: with `require stable open` also while its joints are open"
_KEPT = "a mutant keeps what its operations do not change: let them change more by --ops and --parts, or state what a value leaves to the next"
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
    near_duplicates: NotRequired[Count]


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
    if made.near_duplicates:
        found["near_duplicates"] = made.near_duplicates
    return found


def count_in_words(program: Program, counted: Mapping[Cause, int]) -> dict[str, int]:
    """Counts of what failed, in words with its place in the text, the most frequent first."""
    found: dict[str, int] = {}
    for cause, count in counted.items():
        words = describe_cause(program, cause)
        found[words] = found.get(words, 0) + count
    return dict(sorted(found.items(), key=lambda item: (-item[1], item[0])))


def explain_exhausted(
    program: Program,
    error: Exhausted,
    given: Mapping[int, float],
    settings: Mapping[str, Value],
    without: Callable[[Collection[str]], float],
) -> NoObject:
    """Why there is no valid object: what failed most, and which settings take part in it.

    ``given``: the values that were set, by the index of their draw; ``settings``: the same by name, for words. ``without``
    tells which share of the objects is valid where some settings are left out.
    """
    fixed = bool(settings)
    numbers = np.unique(error.numbers).tolist()  # mutants are told by their originals, which may have several
    shown = ", ".join(map(str, numbers[:3])) + (", ..." if len(numbers) > 3 else "")
    counted = "object" if len(numbers) == 1 else plural(len(numbers), "object")
    shapes = {describe_cause(program, ("collision", key)): words for key, words in error.statistics.examples.items()}
    lines = [
        f"  {count:>8} time{'' if count == 1 else 's'}: {reason}"
        + (f"\n{'':17}{shapes[reason]}" if shapes.get(reason) else "")
        for reason, count in list(count_in_words(program, error.statistics.failures()).items())[:3]
    ]
    with_these = " with these settings" if fixed else ""
    tries = plural(error.attempts, "attempt")
    return NoObject(
        (
            f"no valid {program.name} exists with these settings; "
            if error.hopeless
            else f"no valid {program.name} in {tries}{with_these} for {counted} {shown}; "
        )
        + "what failed most:\n"
        + "\n".join(lines),
        _KEPT if error.mutants else _advise(program, error.statistics, given, settings, without, lines[0]),
    )


def _advise(
    program: Program,
    made: Statistics,
    given: Mapping[int, float],
    settings: Mapping[str, Value],
    without: Callable[[Collection[str]], float],
    first: str,
) -> str:
    """What to try: other values for the settings that what failed most depends on, or else wider ranges; ``first``: what did."""
    worst = sorted(made.failures().items(), key=lambda item: -item[1])[:3]
    solids = bool(worst) and all(kind in ("collision", "solid") for (kind, _), _ in worst)
    if settings and not solids:
        return _blame(program, worst, given, settings)
    if settings and without(settings) > 0.0:  # solids depend on nearly all values: only a trial tells which matter
        shares = {name: share for name in settings if (share := without([name])) > 0.0}
        if not shares:
            return "set other values: no single setting is to blame"
        shown = any_of([f"{name}={_text(program, name, settings[name])}" for name in shares])
        tell = "choose another value" + ("" if len(shares) == 1 else " for one of them")
        return f"without {shown}, {100 * max(shares.values()):.0f} % of the first attempts are valid: {tell}"
    if worst and worst[0][0] in {("solid", f"{one.where}: {one.message}") for one in program.stable}:
        return _FALLEN
    if " touches nothing else " in first:
        return _LOOSE
    if " collide while " in first:
        return _TURNED
    return _SHOWN if solids else _NARROW


def _blame(
    program: Program, worst: Sequence[tuple[Cause, int]], given: Mapping[int, float], settings: Mapping[str, Value]
) -> str:
    """The settings that what failed most depends on."""
    behind = {k for cause, _ in worst for k in _draws_of(program, cause) if k in given}
    names = dict.fromkeys(program.draws[k].column.name for k in sorted(behind))
    if not names:
        return "set other values: no single setting is to blame"
    shown = any_of([f"{name}={_text(program, name, settings[name])}" for name in names if name in settings])
    return f"these failures depend on {shown.replace(' or ', ' and ')}: choose another value" + (
        "" if len(names) == 1 else " for one of them"
    )


def _draws_of(program: Program, cause: Cause) -> list[int]:
    """The draws that a failure depends on; none of collisions and faults of solids, which are tried out."""
    kind, about = cause
    if kind == "requirement":
        one = program.requirements[about]
        return draws_behind(program, (one.condition, one.guard))
    if kind in ("domain", "absent"):
        return [about]
    if kind != "draw":
        return []
    draw = program.draws[about]
    numbers = {k for b in draw.bounds for k in (b.requirement, *b.also)}
    numbers |= {limit.requirement for limit in draw.limits} | {union.requirement for union in draw.unions}
    return [about, *(k for n in sorted(numbers) for k in _draws_of(program, ("requirement", n)))]


def _text(program: Program, name: str, value: Value) -> str:
    """A setting as it is written after ``--set``, lengths in centimetres and angles in degrees."""
    unit = next((d.unit for d in program.draws if d.column.name == name), "")
    if isinstance(value, float) and unit in ("m", "rad"):
        return f"{value * 100:.6g}cm" if unit == "m" else f"{math.degrees(value):.6g}deg"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
