"""Who yields: matches the equations of an environment with its unknowns, block by block and case by case.

Order of preference (the rule of the language): unknowns without a domain are covered first, then positions (of two positions
that one equation could determine, the part declared later yields), then parameters of the parts' templates. A tie
between parameters is an error that offers ``derived``.
"""

from __future__ import annotations

from dataclasses import field

from ...graph import expr as E
from ...graph.expr import Column, Expr, Scope
from ...graph.linear import Circle
from ...graph.matching import Matching, match
from ...records import dataclass
from ..expressions.context import Abort, Equation, Settled, Unknown
from ..expressions.env import Env
from .blocks import Block, blocks, cases
from .guarded import branches, lifted
from .ledger import condition as guard_in_words
from .recurrent import closed
from .settled import default, determined
from .surplus import judge_surplus
from .systems import Stated, solve_system

_RANK = {"size": 0, "derived": 0, "position": 1, "default": 2, "param": 3}


def settle(env: Env) -> None:
    """Solve this environment, its guarded branches with it, and the repeats inside."""
    homes = branches(env, E.TRUE)
    try:
        solve(env, homes)
    except Abort:
        pass
    except Circle as error:
        circular(env, error.columns)
    inside = {id(home) for home, _ in homes}
    for home, _ in homes:
        for inner in home.inner:
            if id(inner) not in inside:
                settle(inner)


def circular(env: Env, columns: list[Column]) -> None:
    """Report values that were settled one by one, each from the next (a size left open and a box made of it)."""
    names = []
    for column in columns[:4]:
        owner, _, axis = column.name.rpartition(".at.")
        names.append(f"the position of `{owner}` along {axis}" if owner else f"`{column.name}`")
    found = zip((env.context.spans.get(c) for c in columns), names, strict=False)
    spans = [(span, f"for {name}") for span, name in found if span is not None]
    env.context.error(
        "circular-definition",
        spans[0][0] if spans else env.symbol.decl.name_span,  # type: ignore[union-attr]
        f"{names[0]} depends on itself" + (f", by way of {' and '.join(names[1:])}" if names[1:] else ""),
        hint="pass one of these as an argument, or state an equation with something already determined",
        notes=tuple(spans[1:]),
    )


def solve(env: Env, homes: list[tuple[Env, Expr]]) -> None:
    for block in blocks(env, homes):
        try:
            _settle_block(block, [outcome(block, case) for case in cases(block)])
        except Abort:
            continue
    for home, _ in homes:
        env.context.ledger.extend((u.part, u) for u in home.unknowns)


# ---------------------------------------------------------------- one case


@dataclass(slots=True, eq=False)
class Outcome:
    """How one case of a block came out: the value and the equation of each unknown that is determined."""

    condition: Expr
    exists: dict[Column, bool]
    values: dict[Column, Expr] = field(default_factory=dict)
    because: dict[Column, Equation] = field(default_factory=dict)
    told: dict[Column, Settled] = field(default_factory=dict)


def outcome(block: Block, case: tuple[Expr, list[Stated], dict[Column, bool]]) -> Outcome:
    """Match and solve one case."""
    holds, chosen, exists = case
    env = block.env
    result = Outcome(holds, exists)
    unknowns = [u for u in block.unknowns if exists[u.column]]
    place = {u.column: k for k, u in enumerate(unknowns)}
    equations = [s.equation for s in chosen]
    edges: list[list[int]] = [[] for _ in unknowns]
    for e, stated in enumerate(chosen):
        for column in sorted(stated.names, key=block.number.__getitem__):
            if column in place:
                edges[place[column]].append(e)
    order = sorted(range(len(unknowns)), key=lambda k: _preference(unknowns[k], block.number[unknowns[k].column]))
    matching = match(edges, len(equations), order)
    guard = under(env, holds)
    _ties(env, unknowns, equations, matching, guard)
    for u, unknown in enumerate(unknowns):
        if matching.equation_of[u] >= 0:
            result.because[unknown.column] = equations[matching.equation_of[u]]
    result.values, result.told = solve_system(env, unknowns, chosen, matching, holds)
    judge_surplus(env, unknowns, equations, matching, result.values, guard)
    return result


def _preference(unknown: Unknown, index: int) -> tuple[int, int]:
    """Later positions yield first; all else in the order of the text."""
    return _RANK[unknown.kind], -index if unknown.kind == "position" else index


def under(env: Env, holds: Expr) -> str:
    """The guard of a case in words, behind what goes wrong under it."""
    if holds is E.TRUE:
        return ""
    return f" where {guard_in_words(holds, {d.column: d.options for d in env.context.draws if d.kind == 'choice'})}"


def _ties(env: Env, unknowns: list[Unknown], equations: list[Equation], matching: Matching, guard: str) -> None:
    for u, unknown in enumerate(unknowns):
        if matching.equation_of[u] >= 0 or unknown.kind != "param":
            continue
        for other in matching.exchangeable(u):
            if unknowns[other].kind == "param" and matching.equation_of[other] >= 0:
                spans = [equations[e].span for e in _path_between(matching, u, other)]
                last = max(spans, key=lambda s: s.start)
                argument = unknown.name.strip("`").rsplit(".", 1)[-1]
                raise env.context.error(
                    "tie",
                    last,
                    f"this could determine {unknowns[other].name} or {unknown.name}{guard}: nothing says which",
                    hint=f"pass one of the two as an argument (`{argument} = ...`), such as a parameter of this scope; if it is"
                    " declared `derived`, it still follows from the equations",
                    notes=(
                        (unknowns[other].span, f"{unknowns[other].name} is drawn unless it is determined"),
                        (unknown.span, f"and so is {unknown.name}"),
                        *((s, "together with this") for s in spans if s is not last),
                    ),
                )


def _path_between(matching: Matching, start: int, goal: int) -> list[int]:
    """The equations through which one unknown could take the place of another, the shortest way."""
    before: dict[int, tuple[int, int]] = {}
    queue = [start]
    for at in queue:
        for equation in matching.edges[at]:
            other = matching.unknown_of[equation]
            if other >= 0 and other != start and other not in before:
                before[other] = at, equation
                queue.append(other)
    path = []
    while goal != start:
        goal, equation = before[goal]
        path.append(equation)
    return path


# ---------------------------------------------------------------- all cases


def _settle_block(block: Block, outcomes: list[Outcome]) -> None:
    """Put the cases together: one definition per unknown, drawn or default where no case determines it."""
    env = block.env
    for unknown in block.unknowns:
        column = unknown.column
        relevant = [o for o in outcomes if o.exists[column]]
        solved = [(o.condition, o.values[column]) for o in relevant if column in o.values]
        open_cases = [o.condition for o in relevant if column not in o.values]
        equations = list(dict.fromkeys(o.because[column] for o in relevant if column in o.because))
        unknown.reason = "; ".join(q.text for q in equations)
        unknown.settled = [o.told[column] for o in relevant if column in o.told]
        if open_cases:
            naming = (s.equation for s in block.stated if column in s.names)
            near = [(q, _determined_by(block, outcomes, q)) for q in naming]
            value, reason = default(env, unknown, near, fresh=bool(solved), guard=under(env, E.any_of(open_cases)))
            unknown.settled.append(Settled(E.any_of(open_cases), reason=reason))
            if not solved:
                unknown.reason = reason
                continue
            solved += [(c, value) for c in open_cases]
        if not solved:  # the part exists in no case
            env.context.program.definitions[column] = E.ZERO
            continue
        determining = E.any_of(c for c, _ in solved if c not in open_cases)
        env.context.program.definitions[column] = closed(env.context, column, chosen(column.scope, solved), equations)
        determined(env, unknown, determining if open_cases or len(relevant) < len(outcomes) else E.TRUE)


def _determined_by(block: Block, outcomes: list[Outcome], equation: Equation) -> str:
    """The unknown that an equation determines, in words; empty where it determines none."""
    chosen = {column for o in outcomes for column, q in o.because.items() if q is equation}
    return next((u.name for u in block.unknowns if u.column in chosen), "")


def chosen(scope: Scope, solved: list[tuple[Expr, Expr]]) -> Expr:
    """One expression out of the values of the cases; cases with equal values are one."""
    groups: dict[Expr, Expr] = {}
    for holds, value in solved:
        value = lifted(value, scope)
        groups[value] = E.either(groups.get(value, E.FALSE), holds)
    result: Expr | None = None
    for value, holds in reversed(groups.items()):
        result = value if result is None else E.where(holds, value, result)
    assert result is not None
    return result
