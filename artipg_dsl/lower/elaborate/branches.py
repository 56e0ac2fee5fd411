"""Branches of `a if c else b` that no object takes, since the ranges of what c compares decide it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...graph.defined import Defined, Sharp
from ...graph.depend import nodes_behind

if TYPE_CHECKING:
    from ..expressions.context import Draft


def warn(context: Draft, own: object) -> None:
    """Report the conditions in the file ``own`` that never or always hold, wherever they are asked.

    What no draw decides is not told: a template that is used once is written for other arguments, too.
    """
    intervals = Sharp(context.program.draws, context.program.definitions)
    defined, drawn = Defined(intervals), {draw.column for draw in context.program.draws}
    for node, conditions in context.branched.values():
        if node.span.source is not own:
            continue
        if all(intervals.of(known)[1] <= 0.0 for known in conditions):
            word, idle = "never", node.then
        elif all(intervals.of(known)[0] >= 1.0 and defined.certain(known) for known in conditions):
            word, idle = "always", node.otherwise
        else:
            continue
        behind = (nodes_behind(context.program, [known]) for known in conditions)
        if not all(any(part.op == "col" and part.value in drawn for part in parts) for parts in behind):
            continue
        context.report.warning(
            "dead-branch",
            node.condition.span,
            f"`{node.condition.span.words}` {word} holds: `{idle.span.words}` is never used",
            hint="correct the condition, or widen the ranges of what it compares; else write the other value alone",
        )
