"""Counts and choices of which requirements leave hardly any object."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..graph.defined import PARTIAL
from ..quality.excluded import find_excluded
from ..source import Span
from .seen import Seen

if TYPE_CHECKING:
    from ..lower.program import Lowering

_NAMED = 6  # requirements that a warning names


def warn_excluded(seen: Seen) -> None:
    """Name the values of counts and choices that requirements leave hardly any object."""
    told = {found.span for found in seen.report.diagnostics if found.code in ("impossible", "undefined-value")}
    for one in find_excluded(seen.batch):
        draw, column = seen.batch.program.draws[one.draw], seen.batch.program.draws[one.draw].column
        places = [_stated(seen, number) for number in one.requirements[:_NAMED]]
        spans = list(dict.fromkeys(span for span in places if span is not None))
        drawn = seen.lowering.context.spans.get(column)
        own = [drawn] if drawn is not None and drawn.source is seen.span.source else []
        if told.intersection(spans) or not (own or spans):
            continue
        value = f"`{draw.options[int(one.value)]}`" if draw.kind == "choice" else f"{one.value:.0f}"
        first = seen.batch.program.requirements[one.requirements[0]]
        it = f"`{' '.join((first.text or first.message).split())}` ({first.where})"
        if spans:
            it = "this requirement"
            if not spans[0].text.startswith("require"):  # that of a primitive, which an argument breaks
                it = f"what must hold here ({first.message})"
            if one.requirements[0] not in seen.lowering.context.stated:
                it = f"what must hold here ({first.message}{why_endless(seen.lowering, one.requirements[0])})"
        why = (
            f"{'all' if not one.kept else f'{one.tried - one.kept} of'} {one.tried} objects tried with it break {it}"
            if one.tried
            else f"{it} leaves it out"
        )
        chain = [(span, "and this one, perhaps") for span in spans[1:]] + [(span, "drawn here") for span in own]
        seen.report.warning(
            "excluded-value",
            (spans or own)[0],
            f"`{column.name}` is {'hardly ever' if one.kept else 'never'} {value}: {why}",
            hint="widen the ranges of what is required, or write `align` for an equation; "
            "if the value is not meant, leave it out of the range or the alternatives",
            notes=tuple(chain) if spans else (),
        )


def _stated(seen: Seen, requirement: int) -> Span | None:
    """Where a requirement is written, if that is in the file of the category."""
    stated = seen.lowering.context.stated.get(requirement)
    span = seen.line(seen.batch.program.requirements[requirement].where) if stated is None else stated[0]
    return span if span is not None and span.source is seen.span.source else None


def why_endless(lowering: Lowering, requirement: int) -> str:
    """The operation that may make the number infinite that a requirement is about."""
    if requirement not in lowering.context.endless:
        return ""
    span, op = lowering.context.endless[requirement]
    return f"; `{span.words}` has no value, or a very large one: {PARTIAL[op]}"
