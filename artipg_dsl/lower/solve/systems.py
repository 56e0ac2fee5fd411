"""Matched equations to explicit values: in the order of dependence, coupled ones together, by search where nothing else does."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Column, Expr
from ...graph.linear import Linear, LinearForm, Parts, combine, isolate, solve_block, tidy
from ...graph.matching import Matching, components
from ...graph.substitution import substitute
from ...records import dataclass
from ..expressions.context import Abort, Equation, Settled, Unknown
from ..expressions.env import Env
from .inline import inline
from .roots import numeric, start


@dataclass(frozen=True, slots=True, eq=False)
class Stated:
    """An equation of a block: its linear form (None: it has none), and the unknowns that it names."""

    equation: Equation
    form: LinearForm | None
    names: set[Column]


def solve_system(
    env: Env, unknowns: list[Unknown], stated: list[Stated], matching: Matching, guard: Expr
) -> tuple[dict[Column, Expr], dict[Column, Settled]]:
    """A value for each matched unknown (it may read others that are matched before it) where ``guard`` holds, and how."""
    definitions = env.context.program.definitions
    places = {u.column: k for k, u in enumerate(unknowns)}
    matched = {u: stated[e] for u, e in enumerate(matching.equation_of) if e >= 0}
    reads: list[set[int]] = [set() for _ in unknowns]
    for u, own in matched.items():
        reads[u] = {places[c] for c in own.names if c in places and places[c] != u and places[c] in matched}
    values: dict[Column, Expr] = {}
    told: dict[Column, Settled] = {}
    for group in components(list(matched), reads):
        searched = False
        columns = [unknowns[u].column for u in group]
        sides, rows = [matched[u].equation for u in group], [matched[u].form for u in group]
        known = [row for row in rows if row is not None]
        solution = solve_block(known, columns) if len(known) == len(rows) else None
        if solution is None:
            differences = [inline(E.sub(q.left, q.right), columns, definitions) for q in sides]
            solution = None if any(q.near for q in sides) else _eliminate(differences, columns)
            if solution is None and any(row is None for row in rows):
                solution = numeric(env, [unknowns[u] for u in group], sides, differences, guard)
                searched = solution is not None
                env.context.near.update((q.span, True) for q in sides if searched and q.near)
        if solution is None:
            raise _unsolved(env, [unknowns[u] for u in group], sides, rows)
        for u, column, side in zip(group, columns, sides, strict=True):
            values[column] = solution[column] if searched else tidy(solution[column])
            others = tuple(unknowns[v].name for v in group if v != u)
            begun = E.show(start(env, unknowns[u], columns, sides)) if searched else ""
            told[column] = Settled(guard, side, others, columns[0], begun)
    return values, told


def _unsolved(env: Env, unknowns: list[Unknown], equations: list[Equation], forms: list[LinearForm | None]) -> Abort:
    """Report equations that have no solution in closed form: linear ones that hang on one another alone, or others."""
    equations = sorted(equations, key=lambda q: q.span.start)
    listed = " and ".join(u.name for u in unknowns)
    linear = [form for form in forms if form is not None]
    left_over = None if len(linear) < len(forms) else remainder(linear, [u.column for u in unknowns])
    if left_over is E.ZERO:
        message = f"these equations are equivalent for {listed}: one more is needed"
        hint = "replace one of them by an equation for another face, or pass a size as an argument"
    elif left_over is not None and left_over.constant is not None:
        raise env.context.error(
            "contradictory",
            equations[-1].span,
            f"this equation contradicts the others: its two sides always differ by {abs(float(left_over.constant)) * 1000:.6g}mm",
            hint="drop or correct one of them",
            notes=tuple((q.span, "the other") for q in equations[:-1]),
        )
    elif len(linear) == len(forms):
        message = f"these equations only place {listed} relative to one another: nothing ties them to the rest"
        hint = "relate one of them to something already placed, such as a face of the root"
    else:
        message = f"this cannot be solved for {listed}"
        hint = "write the equation with the unknown alone on one side, or pass it as an argument"
    notes = tuple((q.span, "together with this") for q in equations[1:])
    return env.context.error("not-solvable", equations[0].span, message, hint=hint, notes=notes)


def remainder(forms: list[LinearForm], columns: list[Column]) -> Expr | None:
    """What is left of linear equations that depend on one another, once the columns are eliminated; None if that is open."""
    rows: list[Parts] = list(forms)
    for column in columns:
        pivot = next((row for row in rows if row[0].get(column, E.ZERO).constant not in (None, 0.0)), None)
        if pivot is None:
            continue
        factor = pivot[0][column]
        others = [row for row in rows if row is not pivot]
        rows = [
            combine(row, pivot, E.neg(E.div(row[0][column], factor))) if column in row[0] else row for row in others
        ]
    left = [tidy(rest) for terms, rest in rows if not terms]
    return left[0] if left else None


def _eliminate(differences: list[Expr], columns: list[Column]) -> dict[Column, Expr] | None:
    """Solve ``difference = 0`` one by one: the first unknown that can stand alone is put into the others."""
    if not differences:
        return {}
    for k, difference in enumerate(differences):
        for column in columns:
            value = alone(difference, column)
            if value is None:
                continue
            mapping = {E.col(column): value}
            rest = [substitute(d, mapping) for j, d in enumerate(differences) if j != k]
            found = _eliminate(rest, [c for c in columns if c is not column])
            if found is not None:
                return {column: substitute(value, {E.col(c): v for c, v in found.items()}), **found}
    return None


def alone(difference: Expr, column: Column) -> Expr | None:
    """The value of a column for which a difference is 0, in closed form."""
    linear = Linear(lambda c: c is column, {})
    form = linear.form(difference)
    if form is not None:
        factor = form[0].get(column)
        return None if factor is None else E.div(E.neg(form[1]), factor)
    if difference.op == "sub" and linear.reads(difference.args[0]) != linear.reads(difference.args[1]):
        left, right = difference.args
        return isolate(left, column, right, linear) if linear.reads(left) else isolate(right, column, left, linear)
    return isolate(difference, column, E.ZERO, linear)
