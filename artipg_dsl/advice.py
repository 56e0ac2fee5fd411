"""What a program says that is legal and perhaps not meant: told by its text, and by a few of its objects (see ``examined``)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from .diagnostics import CompileError, Report
from .errors import plural
from .examined import Examined, how_to_place, why_endless
from .measured import line_of, place_of
from .source import Span

if TYPE_CHECKING:
    from .lower.program import Lowering
    from .runtime.batch import Batch
    from .sampling.statistics import Statistics
    from .semantics.check import TypedProgram

_OBJECTS = 8  # that are drawn, to see what floats, what collides and what their check takes
_NAMED = 6  # parts that a warning names

Draw = Callable[[np.ndarray, "Statistics"], "Batch"]
"""The objects of some numbers, unchecked, counting attempts. Raises CompileError, which it has told the report, and what sampling raises.
"""


def advise(typed: TypedProgram, lowering: Lowering | None, draw: Draw, report: Report) -> None:
    """Report names and places that nothing reads, ranges in two units, parts that nothing places, float, or collide at rest, what no object is
    free of, surface without a semantic label, parts without a material, whose mass is a guess, and what makes checks slow or
    wrong."""
    from .lower.elaborate.idle import warn_idle_places  # start-up
    from .lower.elaborate.unlabelled import warn_unlabelled  # start-up
    from .semantics.mixed import warn_mixed  # start-up
    from .semantics.unused import warn_unused  # start-up

    if not report.failed:
        warn_unused(typed, report)
        warn_mixed(typed, report)
    if typed.category is None or lowering is None:
        return
    span = typed.category.decl.name_span
    for part in lowering.unplaced():
        report.warning(
            "unplaced",
            part.span,
            f"nothing places `{part.name}`: it is centred along x, y and z",
            hint=f"place it {how_to_place(part)}; if the centre is meant, write `align {part.name}.center = ...`",
        )
    warn_idle_places(lowering)
    batch = _drawn(draw, lowering, span, report)
    if batch is not None:
        Examined(batch, lowering, span, report).warn()
    warn_unlabelled(lowering, span)
    _warn_of_materials(lowering, span, report)


def _drawn(draw: Draw, lowering: Lowering, span: Span, report: Report) -> Batch | None:
    """A few objects to look at; None where not all can be drawn, which is reported."""
    from .lower.solve.feasible import hint_of_size, of_part  # start-up
    from .runtime.kernels import TooMany  # start-up
    from .runtime.repairs import describe_cause  # start-up
    from .sampling.statistics import Exhausted, Statistics  # start-up

    counted = Statistics()
    try:
        batch = draw(np.arange(_OBJECTS), counted)
        _warn_of_undefined(lowering, counted, report)
        return batch
    except CompileError:
        return None
    except TooMany as error:
        report.error("none-drawn", span, f"no object can be drawn: {error}", hint="bound the counts of its repeats")
    except Exhausted as error:
        program = lowering.program
        worst = max(error.statistics.failures().items(), key=lambda item: item[1])[0]
        requirement = program.requirements[worst[1]] if worst[0] == "requirement" else None
        part = None if requirement is None else of_part(lowering.context, requirement.message)
        hint = "widen the ranges, or state what one value leaves to the next"
        if requirement is not None and "==" in requirement.text:
            hint = (
                "what is drawn never equals a number: give the value itself, or write `align` and declare it `derived`"
            )
        elif requirement is not None and part is not None:
            hint = hint_of_size(lowering.context, part, requirement.message) or hint
        elif requirement is not None:
            hint = lowering.context.remedies.get(worst[1], hint)
        here = None if requirement is None else line_of(span.source, requirement.where)
        report.error(
            "none-drawn",
            here or span,
            f"no valid `{program.name}` in {plural(error.attempts, 'attempt')} at an object; what failed most: "
            + (describe_cause(program, worst) if requirement is None or here is None else requirement.message)
            + (why_endless(lowering, worst[1]) if worst[0] == "requirement" else ""),
            hint=hint,
        )
    return None


def _warn_of_undefined(lowering: Lowering, counted: Statistics, report: Report) -> None:
    """Name the operations that were given numbers of which they have no value."""
    seen: set[Span] = set()
    for (kind, number), count in counted.failures().items():
        if kind != "requirement" or number not in lowering.context.undefined:
            continue
        span, why = lowering.context.undefined[number]
        if span not in seen:
            seen.add(span)
            report.warning(
                "undefined-value",
                span,
                f"`{span.words}` has no value in {count} of {plural(counted.attempts, 'attempt')} at an object: {why}",
                hint="narrow the ranges of what it is made of, or avoid such values by `a if c else b`",
            )


def _warn_of_materials(lowering: Lowering, span: Span, report: Report) -> None:
    program = lowering.program
    bare = list(dict.fromkeys(program.parts[site.part].path for site in program.sites if not site.materials))
    if not bare:
        return
    named = ", ".join(f"`{path}`" for path in bare[:_NAMED])
    more = f" and {len(bare) - _NAMED} more" if len(bare) > _NAMED else ""
    what = f"the parts {named}{more} have" if len(bare) > 1 else f"the part {named} has"
    place = place_of(lowering, bare[0], span)
    report.warning(
        "missing-material",
        place or span,
        f"{what} no material",
        hint=f"write for example `material oak on {place.text if place else 'body'}`; the default is 700 kg/m3 and light grey",
    )
