"""Equations that determine nothing: redundant (a lint), contradictory or too many (errors)."""

from __future__ import annotations

import re

from ...graph import expr as E
from ...graph.expr import Column, Expr
from ...graph.linear import Linear
from ...graph.matching import Matching
from ...graph.substitution import substitute
from ...source import Span
from ..expressions.context import Equation, Unknown
from ..expressions.env import Env

_DEEPEST = 64  # definitions that read one another; more only where they go in a circle, which the plan reports
_MOUNTED = "a mount leaves nothing to equations: move it by `at y = ...`, `gap` or `sink`, or attach the part by its name alone"


def judge_surplus(
    env: Env,
    unknowns: list[Unknown],
    equations: list[Equation],
    matching: Matching,
    values: dict[Column, Expr],
    guard: str,
) -> None:
    """Equations that determine nothing: redundant (a lint), contradictory or too many (errors)."""
    definitions = {**env.context.program.definitions, **values}
    for e in matching.free_equations:
        equation = equations[e]
        users = [u for u in range(len(unknowns)) if e in matching.edges[u] and matching.equation_of[u] >= 0]
        sources = {matching.equation_of[u]: f"determines {unknowns[u].name}" for u in users}
        notes = tuple((equations[k].span, why) for k, why in list(sources.items())[:4])
        mounts = _mounts(env, equation)
        notes += mounts
        difference = _written_out(E.sub(equation.left, equation.right), definitions)
        terms, rest = Linear(lambda c: True, {}).parts(difference)
        cancelled = all(f.constant is not None and abs(f.constant) < 1e-12 for f in terms.values())
        if cancelled and rest.constant is not None and abs(rest.constant) < 1e-9:
            env.context.report.warning(
                "redundant",
                equation.span,
                f"this equation follows from the others{guard}",
                notes=notes,
                hint="it can be dropped: the equations shown already determine the same"
                if notes
                else "it can be dropped",
                trace=tuple(env.context.trace),
            )
            continue
        if cancelled and rest.constant is not None:
            length = bool(mounts) or any(unknowns[u].kind == "position" for u in users)
            hint = "drop or correct one of them; `gap` is measured outwards from the face before it"
            if any(equations[k].span == equation.span for k in sources):  # both sides of what has a size of its own
                hint = "leave the size between the faces open (`_`, or no argument), or place one of them alone: `fit left`"
            if mounts and not users:
                hint = _MOUNTED
            raise env.context.error(
                "contradictory",
                equation.span,
                f"this equation contradicts the others{guard}: its two sides always differ by {_amount(rest.constant, length)}",
                hint=hint,
                notes=notes,
            )
        named = " and ".join(unknowns[u].name for u in users[:3])
        own = (d.column for d in env.context.draws if d.column.scope is env.scope)
        drawn = [c.name.removeprefix(env.path) for c in own if c in terms]
        hint = "drop one of these equations, or leave a size open (`_`, or no argument) that it may determine"
        if drawn:
            hint = f"drop one of these equations, or let `{drawn[0]}` follow from them by declaring it `derived`"
        said = (
            f"{named} {'are' if len(users) > 1 else 'is'} already determined"
            if users
            else "everything that it names is already fixed"
        )
        roots = [part.name for part in env.context.parts if part.declaration.root]
        if not users and roots and re.search(rf"\b{roots[0]}\b", equation.span.words):
            hint = f"`{roots[0]}` is the root, whose frame is the object's: place the other parts by it"
        if mounts and not users:
            hint = _MOUNTED
        message = f"this equation is one too many{guard}: {said}"
        raise env.context.error("over-determined", equation.span, message, hint=hint, notes=notes)


def _mounts(env: Env, equation: Equation) -> tuple[tuple[Span, str], ...]:
    """What fixes the whole pose of the parts that an equation names."""
    words = equation.span.words
    placed = {part.name: part.mounted for part in env.parts if part.mounted is not None}
    return tuple(
        (span, f"places all of `{name}`") for name, span in placed.items() if re.search(rf"(?<![.\w]){name}\b", words)
    )


def _written_out(node: Expr, definitions: dict[Column, Expr]) -> Expr:
    """An expression with all that is determined put in."""
    for _ in range(_DEEPEST):
        known = [c for c in E.leaves(node) if c in definitions]
        if not known:
            break
        node = substitute(node, {E.col(c): definitions[c] for c in known})
    return node


def _amount(difference: float, length: bool) -> str:
    """A difference of two sides in words."""
    size = abs(difference)
    return f"{round(size * 1000, 3):g}mm" if length else f"{size:.6g} (in metres or radians)"
