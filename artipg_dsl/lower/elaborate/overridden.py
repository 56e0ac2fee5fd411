"""Warns of what is said of a part and never counts, since a later statement of the same body says something else of it."""

from __future__ import annotations

from ...graph.expr import TRUE, Expr
from ...records import dataclass
from ...source import Span
from ...syntax import ast
from ..expressions.context import Draft
from ..expressions.env import Env


@dataclass(frozen=True, slots=True, eq=False)
class Said:
    """What a statement says of one thing that its ``target`` names, where ``holds`` is true; ``full`` if nothing can add to it."""

    words: str
    statement: ast.Stmt
    target: ast.Expr
    holds: Expr
    full: bool


def note(env: Env, about: tuple[object, ...], said: Said) -> None:
    """Note what is said in a body ``about`` one thing: of two with equal keys the later counts where both hold."""
    env.context.said.setdefault((id(env.root), *about), []).append(said)


def warn(context: Draft, own: object) -> None:
    """Report the targets of statements in the file ``own`` that later statements take from them wherever they are."""
    taken: dict[int, list[tuple[Said, Said | None]]] = {}
    for several in context.said.values():
        for place, one in enumerate(several):
            taken.setdefault(id(one.target), []).append((one, _later(one, several[place + 1 :])))
    for pairs in taken.values():
        one, other = pairs[0]
        if other is None or any(later is None for _, later in pairs) or one.statement.span.source is not own:
            continue
        said = f"has no effect: a later statement says {other.words}"
        if one.words == other.words:
            again = not isinstance(one.statement, ast.FieldStmt)
            said = "is said again further down" if again else "has no effect: a later statement says otherwise"
        notes: tuple[tuple[Span, str], ...] = ((other.statement.span, "this one counts"),)
        context.report.warning(
            "overridden",
            one.target.span,
            f"{one.words} on `{one.target.span.words}` {said}",
            hint="leave one of them out, or put the later one under the `when` in which it is meant"
            if one.holds is other.holds
            else "of two that hold, the later counts: write the one that holds everywhere first",
            notes=notes,
        )


def _later(one: Said, others: list[Said]) -> Said | None:
    """The last of some statements that hold wherever another one does."""
    return next((o for o in reversed(others) if o.full and (o.holds is TRUE or o.holds is one.holds)), None)
