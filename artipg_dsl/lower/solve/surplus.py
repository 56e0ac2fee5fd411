"""Equations that determine nothing: redundant (a lint), contradictory or too many (errors)."""

from __future__ import annotations

import re

from ...graph import expr as E
from ...graph.expr import Column, Expr
from ...graph.linear import Linear
from ...graph.matching import Matching
from ...graph.substitution import substitute
from ...records import dataclass
from ...source import Span
from ..expressions.context import Abort, Equation, Unknown
from ..expressions.env import Env

_DEEPEST = 64  # definitions that read one another; more only where they go in a circle, which the plan reports
_NAMED = 3  # unknowns that an error names
_SHOWN = 4  # equations that a finding shows
_MOUNTED = "a mount leaves nothing to equations: move it by `at y = ...`, `gap` or `sink`, or attach the part by its name alone"


def judge_surplus(
    env: Env,
    unknowns: list[Unknown],
    equations: list[Equation],
    matching: Matching,
    values: dict[Column, Expr],
    guard: str,
) -> None:
    """Report each equation that determines nothing: a lint if it follows from the others, else an error."""
    definitions = {**env.context.program.definitions, **values}
    for e in matching.free_equations:
        users = [u for u in range(len(unknowns)) if e in matching.edges[u] and matching.equation_of[u] >= 0]
        surplus = _Surplus(
            env,
            guard,
            equations[e],
            [unknowns[u] for u in users],
            [(equations[matching.equation_of[u]].span, f"determines {unknowns[u].name}") for u in users],
        )
        difference = _written_out(E.sub(surplus.equation.left, surplus.equation.right), definitions)
        terms, rest = Linear(lambda c: True, {}).parts(difference)
        cancelled = all(f.constant is not None and abs(f.constant) < 1e-12 for f in terms.values())
        if not cancelled or rest.constant is None:
            raise surplus.too_many(terms)
        if abs(rest.constant) >= 1e-9:
            raise surplus.contradictory(rest.constant)
        surplus.warn_redundant()


@dataclass(frozen=True, slots=True)
class _Surplus:
    """An equation that determines nothing, the unknowns in it, and the equations that determine these, with what to say of them."""

    env: Env
    guard: str
    equation: Equation
    unknowns: list[Unknown]
    others: list[tuple[Span, str]]

    def warn_redundant(self) -> None:
        notes, context = self.notes(), self.env.context
        context.report.warning(
            "redundant",
            self.equation.span,
            f"this equation follows from the others{self.guard}",
            notes=notes,
            hint="it can be dropped: the equations shown already determine the same" if notes else "it can be dropped",
            trace=tuple(context.trace),
        )

    def contradictory(self, difference: float) -> Abort:
        mounts = self.mounts()
        length = bool(mounts) or any(unknown.kind == "position" for unknown in self.unknowns)
        hint = "drop or correct one of them; `gap` is measured outwards from the face before it"
        if self.equation.span in [span for span, _ in self.others]:  # both sides of what has a size of its own
            hint = "leave the size between the faces open (`_`, or no argument), or place one of them alone: `fit left`"
        if mounts and not self.unknowns:
            hint = _MOUNTED
        return self.env.context.error(
            "contradictory",
            self.equation.span,
            f"this equation contradicts the others{self.guard}: its two sides always differ by {_amount(difference, length)}",
            hint=hint,
            notes=self.notes(),
        )

    def too_many(self, terms: dict[Column, Expr]) -> Abort:
        """The equation is one too many; ``terms`` are the numbers in it, with their factors."""
        context, scope, path = self.env.context, self.env.scope, self.env.path
        hint = "drop one of these equations, or leave a size open (`_`, or no argument) that it may determine"
        own = (draw.column for draw in context.draws if draw.column.scope is scope)
        drawn = [column.name.removeprefix(path) for column in own if column in terms]
        if drawn:
            hint = f"drop one of these equations, or let `{drawn[0]}` follow from them by declaring it `derived`"
        said = "everything that it names is already fixed"
        if self.unknowns:
            named = " and ".join(unknown.name for unknown in self.unknowns[:_NAMED])
            said = f"{named} {'are' if len(self.unknowns) > 1 else 'is'} already determined"
        elif self.mounts():
            hint = _MOUNTED
        elif root := next((part.name for part in context.parts if part.declaration.root), None):
            if re.search(rf"\b{root}\b", self.equation.span.words):
                hint = f"`{root}` is the root, whose frame is the object's: place the other parts by it"
        message = f"this equation is one too many{self.guard}: {said}"
        return context.error("over-determined", self.equation.span, message, hint=hint, notes=self.notes())

    def notes(self) -> tuple[tuple[Span, str], ...]:
        return (*self.others[:_SHOWN], *self.mounts())

    def mounts(self) -> tuple[tuple[Span, str], ...]:
        """What fixes the whole pose of the parts that the equation names."""
        placed = {part.name: part.mounted for part in self.env.parts if part.mounted is not None}
        return tuple(
            (span, f"places all of `{name}`")
            for name, span in placed.items()
            if re.search(rf"(?<![.\w]){name}\b", self.equation.span.words)
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
