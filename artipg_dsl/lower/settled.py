"""What becomes of an unknown once it is known whether equations determine it: centred, drawn, its default, a requirement."""

from __future__ import annotations

from ..graph import expr as E
from ..graph.expr import Expr
from ..graph.linear import tidy
from ..graph.program import Draw, Requirement
from .context import Equation, Unknown, where
from .env import Env
from .values import Box, squared, turn

SMALL = E.const(1e-4)  # the least size of something that equations determine, in metres


def default(env: Env, unknown: Unknown, near: list[Equation], *, fresh: bool) -> Expr:
    """The value where no equation determines an unknown; with ``fresh``, where only some cases do."""
    context = env.context
    definitions = context.program.definitions
    if unknown.kind == "position":
        value = tidy(centred(unknown))
        reason = "centred"
    elif unknown.kind == "default":
        assert unknown.default is not None
        value, reason = unknown.default, "default"
    elif unknown.draw is not None:
        return drawn(env, unknown, unknown.draw, fresh)
    else:
        hint = "state one more equation (align, fit), give it as an argument, or give it a domain to be drawn from"
        notes = tuple((q.span, "this names it, but determines something else") for q in near[:3])
        under = " where no equation under a guard does" if fresh else ""
        context.error("under-determined", unknown.span, f"nothing determines {unknown.name}{under}", hint=hint, notes=notes)
        value, reason = E.const(0.1), ""
    if not fresh:
        unknown.reason = reason
        definitions[unknown.column] = value
    return value


def drawn(env: Env, unknown: Unknown, draw: Draw, fresh: bool) -> Expr:
    """Draw it; where some cases determine it, what is drawn for the others is a column of its own."""
    context = env.context
    if draw not in context.draws:
        context.draws.append(draw)
    if not fresh:
        unknown.reason = "drawn"
        return E.col(draw.column)
    column = context.column(draw.column.scope, f"{draw.column.name} (drawn)", draw.column.kind, unknown.span)
    draw.column = column
    return E.col(column)


def centred(unknown: Unknown) -> Expr:
    """A free position: the part's box is centred on the box of its scope."""
    from .evaluate import Evaluator
    from .part import rotation_of

    part, axis = unknown.part, unknown.axis
    assert part is not None
    offset = turn(rotation_of(part), part.box().center)[axis]
    at: Env | None = part.env
    center: Expr = E.ZERO
    while at is not None:
        if at.element is not None and at.element.box is not None:
            box: Box = squared(Evaluator(part.env).here(at.element, at.element.box))  # type: ignore[assignment]
            center = box.center[axis]
            break
        at = at.outer
    return E.sub(center, offset)


def determined(env: Env, unknown: Unknown, guard: Expr) -> None:
    """The domain of a determined parameter is a requirement on those that determine it, where ``guard`` holds."""
    context = env.context
    value = E.col(unknown.column)
    name = unknown.name.strip("`")
    if unknown.draw is not None and unknown.kind in ("param", "derived", "default"):
        draw = unknown.draw
        if draw.column is unknown.column:
            context.draws = [d for d in context.draws if d is not draw]
        assert draw.low is not None and draw.high is not None
        for a, b, side in ((draw.low, value, "below"), (value, draw.high, "above")):
            context.program.requirements.append(
                Requirement(
                    unknown.column.scope, E.call("le", a, b), guard, f"{name} would lie {side} its domain", where(unknown.span), (a, b),
                    text=f"{name} in its domain",
                )  # fmt: skip
            )
    elif unknown.positive or unknown.kind == "size" and unknown.part is not None and ".size." in unknown.column.name:
        context.program.requirements.append(
            Requirement(
                unknown.column.scope, E.call("le", SMALL, value), guard, f"{name} would not be positive", where(unknown.span), (SMALL, value),
                text=f"{name} > 0",
            )  # fmt: skip
        )
