"""What becomes of an unknown once it is known whether equations determine it: centred, drawn, its default, a requirement."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.linear import tidy
from ...graph.program import Draw
from ..expressions.context import Draft, Equation, Unknown
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.faces import squared
from ..values.vectors import place, turn

SMALL = E.const(1e-4)  # the least size of something that equations determine, in metres


def default(
    env: Env, unknown: Unknown, near: list[tuple[Equation, str]], *, fresh: bool, guard: str = ""
) -> tuple[Expr, str]:
    """The value where no equation determines an unknown, and why; with ``fresh``, where only some cases do.

    ``near`` are the equations that name it, each with what it determines instead; ``guard`` says in words where.
    """
    context = env.context
    definitions = context.program.definitions
    if unknown.kind == "position":
        value = tidy(centred(unknown))
        reason = "centred"
        if not fresh and unknown.part is not None:
            context.centred.setdefault(unknown.part, set()).add(unknown.axis)
    elif unknown.kind == "default":
        assert unknown.default is not None
        value, reason = unknown.default, "default"
    elif unknown.draw is not None and (fresh or unknown.kind != "derived"):
        return drawn(env, unknown, unknown.draw, fresh), "drawn"
    else:
        if unknown.part is None or not unknown.part.unplaced:  # else its mount is at fault, which has been said
            _undetermined(context, unknown, near, guard if fresh else None)
        value, reason = E.const(0.1), ""
    if not fresh:
        definitions[unknown.column] = value
    return value, reason


def _undetermined(context: Draft, unknown: Unknown, near: list[tuple[Equation, str]], guard: str | None) -> None:
    """Report an unknown that nothing determines, with what names it; ``guard`` says where, if some cases determine it."""
    notes = tuple((q.span, f"this names it, but determines {what}") for q, what in near[:3] if what)
    if guard is not None:
        notes = tuple((q.span, "determines it, but only under a guard") for q, _ in near[:3])
    message = f"nothing determines {degree(unknown)}{guard or ''}"
    context.error("under-determined", unknown.span, message, hint=_remedy(unknown), notes=notes)


def degree(unknown: Unknown) -> str:
    """The degree of freedom in words: the size of a part along an axis, or a parameter."""
    owner, _, axis = unknown.name.strip("`").rpartition(".size.")
    return f"the size of `{owner}` along {axis} ({unknown.name})" if owner else unknown.name


def _remedy(unknown: Unknown) -> str:
    """What to write so that something determines it."""
    name = unknown.name.strip("`")
    owner, _, axis = name.rpartition(".size.")
    if unknown.kind == "derived":
        otherwise = "give it a range" if unknown.draw is None else "it is drawn from its range"
        return f"state an equation that determines it (`align ... = {name}`), or drop `derived` and {otherwise}"
    if owner:
        low, high = {"x": ("back", "front"), "y": ("right", "left"), "z": ("bottom", "top")}[axis]
        return (
            f"place its faces (`align {owner}.{high} = ...`, `align {owner}.{low} = ...`, or `fit {high}, {low}`),"
            " or give the size as an argument"
        )
    parameter = name.rpartition(".")[2]
    return f"pass it as an argument (`{parameter} = ...`), state an equation that names it, or give it a range (`in a .. b`)"


def drawn(env: Env, unknown: Unknown, draw: Draw, fresh: bool) -> Expr:
    """Draw it; where some cases determine it, what is drawn for the others is a column of its own."""
    context = env.context
    if draw not in context.draws:
        context.draws.append(draw)
    if not fresh:
        return E.col(draw.column)
    column = context.column(draw.column.scope, f"{draw.column.name} (drawn)", draw.column.kind, unknown.span)
    draw.column = column
    return E.col(column)


def centred(unknown: Unknown) -> Expr:
    """A free position: the part's box is centred on the box of its scope."""
    part, axis = unknown.part, unknown.axis
    assert part is not None
    offset = turn(part.rotation(), part.box().center)[axis]
    elements = (at.element for at in part.env.chain() if at.element is not None)
    around = next((element for element in elements if element.box is not None), None)
    if around is None or around.box is None:
        return E.neg(offset)
    box = squared(Evaluator(part.env).here(around, around.box))
    return E.sub(place(box.pose, box.center)[axis], offset)


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
        bounds = [
            (draw.low, value, f"{name} would lie below its domain"),
            (value, draw.high, f"{name} would lie above its domain"),
        ]
        text, must = f"{name} in its domain", "lie in its range"
    elif unknown.positive or unknown.kind == "size" and unknown.part is not None and ".size." in unknown.column.name:
        bounds, text, must = [(SMALL, value, f"{name} would not be positive")], f"{name} > 0", "be above 0"
    else:
        return
    for low, high, message in bounds:
        holds = E.call("le", low, high)
        number = context.require(unknown.column.scope, holds, unknown.span, message, guard, (low, high), text)
        context.settled[number] = unknown.span, degree(unknown), must
