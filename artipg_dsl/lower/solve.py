"""Who yields: matches the equations of an environment with its unknowns, block by block and case by case.

A block is a set of unknowns that equations connect; an unrelated equation never changes who yields in another block.
Where equations of a block stand under guards, each combination of guards that can occur is a case of its own. Order of
preference (the rule of the language): unknowns without a domain are covered first, then positions (of two positions
that one equation could determine, the part declared later yields), then parameters of the parts' templates. A tie
between parameters is an error that offers ``derived``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from ..graph import expr as E
from ..graph.expr import Column, Expr, Scope
from ..graph.linear import Form, Linear, combine, tidy
from ..graph.matching import Matching, match
from .cases import TooManyCases, combinations, condition
from .context import Abort, Equation, Unknown
from .env import Env
from .settled import default, determined
from .systems import solve_system

RANK = {"size": 0, "derived": 0, "position": 1, "default": 2, "param": 3}


def settle(env: Env) -> None:
    """Solve this environment and those inside it."""
    promote(env)
    try:
        solve(env)
    except Abort:
        pass
    for inner in env.inner:
        settle(inner)


# ---------------------------------------------------------------- guarded equations


def promote(env: Env) -> None:
    """Equations under ``when`` that name no unknown of the branch, but one of an environment around it, move there."""
    outer = around(env)
    for guard, branch in env.branches.items():
        promote(branch)
        own = {u.column for u in branch.unknowns}
        kept: list[Equation] = []
        for equation in branch.equations:
            if not names_any(env, equation, own) and names_any(env, equation, outer):
                held = lifted(equation.guard, env.scope, E.FALSE)
                env.equations.append(replace(equation, guard=E.both(guard, held)))
            else:
                kept.append(equation)
        branch.equations = kept


def around(env: Env) -> set[Column]:
    """The unknowns of an environment and of those whose branch it is."""
    found = {u.column for u in env.unknowns}
    if env.outer is not None and any(b is env for b in env.outer.branches.values()):
        found |= around(env.outer)
    return found


def names_any(env: Env, equation: Equation, columns: set[Column]) -> bool:
    linear = Linear(lambda c: c in columns, env.context.program.definitions)
    form = linear.form(E.sub(equation.left, equation.right))
    return bool(form[0] if form is not None else linear.columns(equation.left) | linear.columns(equation.right))


def lifted(value: Expr, to: Scope, absent: Expr = E.ZERO) -> Expr:
    """A value of a guarded table as one of the table around it; ``absent`` where the guard does not hold."""
    while value.scope is not None and not to.within(value.scope) and value.scope.kind == "guard":
        assert value.scope.parent is not None
        value = E.phi(value.scope.parent, [(value.scope, value)], absent)
    return value


# ---------------------------------------------------------------- blocks


@dataclass(slots=True, eq=False)
class Block:
    """Unknowns and equations that hang together; ``forms`` are the linear forms of the equations (None: not linear)."""

    env: Env
    unknowns: list[Unknown]
    equations: list[Equation]
    forms: list[Form | None]
    incidence: list[set[Column]]
    number: dict[Column, int]  # place of each unknown in the order of the text


@dataclass(slots=True, eq=False)
class Outcome:
    """How one case of a block came out: the value and the equation of each unknown that is determined."""

    condition: Expr
    exists: dict[Column, bool]
    values: dict[Column, Expr] = field(default_factory=dict)
    because: dict[Column, Equation] = field(default_factory=dict)


def solve(env: Env) -> None:
    for block in blocks(env):
        try:
            settle_block(block, [outcome(block, case) for case in cases(block)])
        except Abort:
            continue
    env.context.ledger.extend((u.part, u) for u in env.unknowns)


def blocks(env: Env) -> Iterator[Block]:
    """The connected blocks in the order of their first unknown; then equations that name none."""
    number = {u.column: k for k, u in enumerate(env.unknowns)}
    linear = Linear(lambda c: c in number, env.context.program.definitions)
    forms: list[Form | None] = []
    incidence: list[set[Column]] = []
    for equation in env.equations:
        form = linear.form(E.sub(equation.left, equation.right))
        names = set(form[0]) if form is not None else linear.columns(equation.left) | linear.columns(equation.right)
        if form is not None:
            form = {c: lifted(v, env.scope) for c, v in form[0].items()}, lifted(form[1], env.scope)
        forms.append(form)
        incidence.append(names)
    root = {c: c for c in number}

    def find(column: Column) -> Column:
        while root[column] is not column:
            root[column] = root[root[column]]
            column = root[column]
        return column

    for names in incidence:
        first, *others = sorted(names, key=number.__getitem__) or [None]
        for other in others:
            a, b = sorted((find(first), find(other)), key=number.__getitem__)  # type: ignore[arg-type]
            root[b] = a
    groups: dict[Column | None, tuple[list[Unknown], list[int]]] = {}
    for unknown in env.unknowns:
        groups.setdefault(find(unknown.column), ([], []))[0].append(unknown)
    for e, names in enumerate(incidence):
        key = find(min(names, key=number.__getitem__)) if names else None
        groups.setdefault(key, ([], []))[1].append(e)
    for unknowns, chosen in groups.values():
        yield Block(
            env, unknowns, [env.equations[e] for e in chosen], [forms[e] for e in chosen], [incidence[e] for e in chosen], number
        )


def cases(block: Block) -> Iterator[tuple[Expr, list[int], dict[Column, bool]]]:
    """The cases of a block: the condition, the equations that hold, and which unknowns belong to a part that exists."""
    guards = list(dict.fromkeys(q.guard for q in block.equations if q.guard is not E.TRUE))
    if not guards:
        yield E.TRUE, list(range(len(block.equations))), {u.column: True for u in block.unknowns}
        return
    present = list(dict.fromkeys(u.part.exists for u in block.unknowns if u.part is not None and u.part.exists is not E.TRUE))
    context = block.env.context
    every = list(dict.fromkeys([*guards, *present]))
    try:
        found = combinations(every, context.draws)
    except TooManyCases:
        raise context.error(
            "too-many-cases", block.equations[-1].span, "the guards of these equations can be combined in too many ways",
            hint="move what they place into a template, or under one `when`",
            notes=tuple((q.span, "one of the equations") for q in block.equations[:3]),
        ) from None  # fmt: skip
    for truth in found:
        values = dict(zip(every, truth, strict=True))
        holds = [e for e, q in enumerate(block.equations) if values.get(q.guard, True)]
        exists = {u.column: u.part is None or values.get(u.part.exists, True) for u in block.unknowns}
        yield condition(every, truth), holds, exists


# ---------------------------------------------------------------- one case


def outcome(block: Block, case: tuple[Expr, list[int], dict[Column, bool]]) -> Outcome:
    """Match and solve one case."""
    holds, chosen, exists = case
    env = block.env
    result = Outcome(holds, exists)
    unknowns = [u for u in block.unknowns if exists[u.column]]
    place = {u.column: k for k, u in enumerate(unknowns)}
    equations = [block.equations[e] for e in chosen]
    forms = [block.forms[e] for e in chosen]
    edges: list[list[int]] = [[] for _ in unknowns]
    for e, k in enumerate(chosen):
        for column in sorted(block.incidence[k], key=block.number.__getitem__):
            if column in place:
                edges[place[column]].append(e)
    order = sorted(range(len(unknowns)), key=lambda k: preference(unknowns[k], block.number[unknowns[k].column]))
    matching = match(edges, len(equations), order)
    ties(env, unknowns, equations, matching)
    for u, unknown in enumerate(unknowns):
        if matching.equation_of[u] >= 0:
            result.because[unknown.column] = equations[matching.equation_of[u]]
    result.values = solve_system(env, unknowns, equations, forms, matching)
    surplus(env, unknowns, equations, forms, matching, result.values)
    return result


def preference(unknown: Unknown, index: int) -> tuple[int, int]:
    """Later positions yield first; all else in the order of the text."""
    return RANK[unknown.kind], -index if unknown.kind == "position" else index


def ties(env: Env, unknowns: list[Unknown], equations: list[Equation], matching: Matching) -> None:
    for u, unknown in enumerate(unknowns):
        if matching.equation_of[u] >= 0 or unknown.kind != "param":
            continue
        for other in matching.exchangeable(u):
            if unknowns[other].kind == "param" and matching.equation_of[other] >= 0:
                equation = equations[matching.equation_of[other]]
                raise env.context.error(
                    "tie", equation.span,
                    f"this could determine {unknowns[other].name} or {unknown.name}: nothing says which of them yields",
                    hint="give one of them as an argument, or declare it `derived` in the scope of this equation",
                    notes=((unknowns[other].span, "one of the two"), (unknown.span, "the other")),
                )  # fmt: skip


def surplus(
    env: Env, unknowns: list[Unknown], equations: list[Equation], forms: list[Form | None], matching: Matching,
    values: dict[Column, Expr],
) -> None:  # fmt: skip
    """Equations that determine nothing: redundant (a lint), contradictory or too many (errors)."""
    definitions = {**env.context.program.definitions, **values}
    linear = Linear(lambda c: c not in definitions, definitions)
    for e in matching.free_equations:
        equation = equations[e]
        left, right = linear.form(equation.left), linear.form(equation.right)
        if left is not None and right is not None:
            coefficients, rest = combine(left, right, E.const(-1.0))
            rest = tidy(rest)
            if all(abs(1.0 if c.constant is None else c.constant) < 1e-12 for c in coefficients.values()) and rest.constant is not None:
                if abs(rest.constant) < 1e-9:
                    env.context.report.warning("redundant", equation.span, "this equation follows from the others")
                    continue
                raise env.context.error(
                    "contradictory", equation.span, "this equation contradicts the others: it can never hold"
                )
        users = [u for u in range(len(unknowns)) if e in matching.edges[u] and matching.equation_of[u] >= 0]
        raise env.context.error(
            "over-determined", equation.span, "this is one equation too many: what it names is determined already",
            hint="drop one of them, or leave a size open that it may determine",
            notes=tuple((equations[matching.equation_of[u]].span, f"determines {unknowns[u].name}") for u in users[:4]),
        )  # fmt: skip


# ---------------------------------------------------------------- all cases


def settle_block(block: Block, outcomes: list[Outcome]) -> None:
    """Put the cases together: one definition per unknown, drawn or default where no case determines it."""
    env = block.env
    for unknown in block.unknowns:
        column = unknown.column
        relevant = [o for o in outcomes if o.exists[column]]
        solved = [(o.condition, o.values[column]) for o in relevant if column in o.values]
        open_cases = [o.condition for o in relevant if column not in o.values]
        equations = list(dict.fromkeys(o.because[column] for o in relevant if column in o.because))
        unknown.reason = "; ".join(q.text for q in equations)
        if open_cases:
            near = [q for q, names in zip(block.equations, block.incidence, strict=True) if column in names]
            value = default(env, unknown, near, fresh=bool(solved))
            if not solved:
                continue
            solved += [(c, value) for c in open_cases]
        if not solved:  # the part exists in no case
            env.context.program.definitions[column] = E.ZERO
            continue
        determining = any_of(c for c, _ in solved if c not in open_cases)
        env.context.program.definitions[column] = chosen(env, solved)
        determined(env, unknown, determining if open_cases or len(relevant) < len(outcomes) else E.TRUE)


def any_of(conditions: Iterable[Expr]) -> Expr:
    result = E.FALSE
    for item in conditions:
        result = E.either(result, item)
    return result


def chosen(env: Env, solved: list[tuple[Expr, Expr]]) -> Expr:
    """One expression out of the values of the cases; cases with equal values are one."""
    groups: dict[Expr, Expr] = {}
    for holds, value in solved:
        value = lifted(value, env.scope)
        groups[value] = E.either(groups.get(value, E.FALSE), holds)
    result: Expr | None = None
    for value, holds in reversed(groups.items()):
        result = value if result is None else E.where(holds, value, result)
    assert result is not None
    return result
