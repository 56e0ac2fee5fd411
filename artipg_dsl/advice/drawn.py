"""The few objects that are looked at, or why there are none."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..diagnostics import CompileError, Report
from ..errors import plural
from ..lower.solve.feasible import hint_of_size, of_part
from ..runtime.kernels import TooMany
from ..runtime.repairs import describe_cause
from ..sampling.statistics import Exhausted, Statistics
from ..source import Span
from .excluded import why_endless
from .seen import line_of

if TYPE_CHECKING:
    from ..lower.program import Lowering
    from ..runtime.batch import Batch

_OBJECTS = 8  # that are drawn, to see what floats, what collides and what their check takes

Draw = Callable[[np.ndarray, Statistics], "Batch"]
"""The objects of some numbers, unchecked, counting attempts. Raises CompileError, which it has told the report, and what sampling raises.
"""


def draw_some(draw: Draw, lowering: Lowering, span: Span, report: Report) -> Batch | None:
    """A few objects to look at; None where not all can be drawn, which is reported."""
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
