"""Who yields: matches the equations of an environment with its unknowns, and solves them.

Order of preference (the rule of the language): unknowns without a domain are covered first, then positions (of two
positions that one equation could determine, the part declared later yields), then parameters of the parts' templates.
A tie between parameters is an error that offers ``derived``.
"""

from __future__ import annotations

from ..graph import expr as E
from ..graph.expr import Column, Expr
from ..graph.linear import Linear, combine, isolate, solve_block, tidy
from ..graph.matching import Matching, components, match
from ..graph.program import Requirement
from .context import Abort, Equation, Unknown, where
from .env import Env
from .values import Box, squared, turn

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


def promote(env: Env) -> None:
    """Equations under ``when`` that name only unknowns of the environment around it belong to that one, guarded."""
    for guard, branch in env.branches.items():
        own = {u.column for u in branch.unknowns}
        outer = {u.column for u in env.unknowns if u.kind == "derived"}
        linear = Linear(lambda c, own=own, outer=outer: c in own or c in outer, env.context.program.definitions)  # type: ignore[misc]
        kept: list[Equation] = []
        for equation in branch.equations:
            names = linear.columns(equation.left) | linear.columns(equation.right)
            if names and not names & own:
                env.guarded.append((guard, branch.scope, equation))
            else:
                kept.append(equation)
        branch.equations = kept


def solve(env: Env) -> None:
    unknowns = env.unknowns
    if env.guarded:
        solve_guarded(env)
        unknowns = [u for u in unknowns if u.column not in env.context.program.definitions]
    columns = {u.column: k for k, u in enumerate(unknowns)}
    definitions = env.context.program.definitions
    linear = Linear(lambda c: c in columns, definitions)
    forms = []
    incidence: list[set[int]] = []
    for equation in env.equations:
        form = linear.form(E.sub(equation.left, equation.right))
        forms.append(form)
        names = set(form[0]) if form is not None else linear.columns(equation.left) | linear.columns(equation.right)
        incidence.append({columns[c] for c in names})
    edges: list[list[int]] = [[] for _ in unknowns]
    for e, names in enumerate(incidence):
        for u in names:
            edges[u].append(e)
    order = sorted(range(len(unknowns)), key=lambda k: preference(unknowns[k], k))
    result = match(edges, len(env.equations), order)
    ties(env, unknowns, result)
    for u, unknown in enumerate(unknowns):
        e = result.equation_of[u]
        unknown.reason = env.equations[e].text if e >= 0 else ""
    solve_matched(env, unknowns, result, forms, linear, columns)
    surplus(env, unknowns, result)
    for u, unknown in enumerate(unknowns):
        if result.equation_of[u] < 0:
            default(env, unknown, connected(env, unknowns, result, u))
        else:
            determined(env, unknown)
    env.context.ledger.extend((u.part, u) for u in unknowns)


def preference(unknown: Unknown, index: int) -> tuple[int, int]:
    """Later positions yield first; all else in the order of the text."""
    return RANK[unknown.kind], -index if unknown.kind == "position" else index


def ties(env: Env, unknowns: list[Unknown], result: Matching) -> None:
    for u, unknown in enumerate(unknowns):
        if result.equation_of[u] >= 0 or unknown.kind != "param":
            continue
        for other in result.exchangeable(u):
            if unknowns[other].kind == "param" and result.equation_of[other] >= 0:
                equation = env.equations[result.equation_of[other]]
                raise env.context.error(
                    "tie", equation.span,
                    f"this could determine {unknowns[other].name} or {unknown.name}: nothing says which of them yields",
                    hint="give one of them as an argument, or declare it `derived` in the scope of this equation",
                    notes=((unknowns[other].span, "one of the two"), (unknown.span, "the other")),
                )  # fmt: skip


def solve_matched(env: Env, unknowns: list[Unknown], result: Matching, forms: list, linear: Linear, columns: dict[Column, int]) -> None:
    """Explicit assignments in the order of dependence; coupled ones as small linear systems."""
    matched = [u for u in range(len(unknowns)) if result.equation_of[u] >= 0]
    chosen = set(matched)
    reads: list[set[int]] = [set() for _ in unknowns]
    for u in matched:
        e = result.equation_of[u]
        form = forms[e]
        names = set(form[0]) if form is not None else linear.columns(env.equations[e].left) | linear.columns(env.equations[e].right)
        reads[u] = {columns[c] for c in names if columns[c] != u and columns[c] in chosen}
    definitions = env.context.program.definitions
    for block in components(matched, reads):
        rows = [forms[result.equation_of[u]] for u in block]
        names = [unknowns[u].column for u in block]
        solution = None
        if all(row is not None for row in rows):
            solution = solve_block(rows, names)
        elif len(block) == 1:
            equation = env.equations[result.equation_of[block[0]]]
            target = names[0]
            alone = Linear(lambda c, target=target: c is target, definitions)  # type: ignore[misc]
            left, right = equation.left, equation.right
            if alone.reads(left) and alone.reads(right):
                left, right = E.sub(left, right), E.ZERO
            elif alone.reads(right):
                left, right = right, left
            value = isolate(left, target, right, alone)
            solution = None if value is None else {target: value}
        if solution is None:
            equation = env.equations[result.equation_of[block[0]]]
            listed = ", ".join(unknowns[u].name for u in block)
            raise env.context.error(
                "not-solvable", equation.span, f"this cannot be solved for {listed} in closed form",
                hint="state the equation so that the unknown stands alone, or give the value as an argument",
                notes=tuple((env.equations[result.equation_of[u]].span, "together with this") for u in block[1:]),
            )  # fmt: skip
        for u in block:
            column = unknowns[u].column
            value = solution[column]
            rest = Linear(lambda c, block=tuple(names): c in block, definitions)  # type: ignore[misc]
            if rest.reads(value):
                value = E.substitute(value, {E.col(c): solution[c] for c in names if c is not column})
            definitions[column] = tidy(value)


def surplus(env: Env, unknowns: list[Unknown], result: Matching) -> None:
    """Equations that determine nothing: redundant (a lint), contradictory or too many (errors)."""
    definitions = env.context.program.definitions
    linear = Linear(lambda c: c not in definitions, definitions)
    for e in result.free_equations:
        equation = env.equations[e]
        left, right = linear.form(equation.left), linear.form(equation.right)
        if left is not None and right is not None:
            coefficients, rest = combine(left, right, E.const(-1.0))
            if all(abs(c.constant or 1.0) < 1e-12 for c in coefficients.values()) and rest.constant is not None:
                if abs(rest.constant) < 1e-9:
                    env.context.report.warning("redundant", equation.span, "this equation follows from the others")
                    continue
                raise env.context.error(
                    "contradictory", equation.span, "this equation contradicts the others: it can never hold"
                )
        others = culprits(env, unknowns, result, e)
        raise env.context.error(
            "over-determined", equation.span, "this is one equation too many: what it names is determined already",
            hint="drop one of them, or leave a size open that it may determine", notes=tuple(others),
        )  # fmt: skip


def culprits(env: Env, unknowns: list[Unknown], result: Matching, e: int) -> list:
    """The equations that use up the unknowns of equation ``e``."""
    names = [u for u in range(len(unknowns)) if e in result.edges[u] and result.equation_of[u] >= 0]
    return [(env.equations[result.equation_of[u]].span, f"determines {unknowns[u].name}") for u in names][:4]


def connected(env: Env, unknowns: list[Unknown], result: Matching, u: int) -> list[Equation]:
    return [env.equations[e] for e in result.edges[u]]


def default(env: Env, unknown: Unknown, near: list[Equation]) -> None:
    """What becomes of an unknown that no equation determines."""
    definitions = env.context.program.definitions
    if unknown.kind == "position":
        unknown.reason = "centred"
        definitions[unknown.column] = tidy(centred(env, unknown))
    elif unknown.kind == "default":
        unknown.reason = "default"
        assert unknown.default is not None
        definitions[unknown.column] = unknown.default
    elif unknown.kind == "param":
        unknown.reason = "drawn"
    elif unknown.draw is not None:
        unknown.reason = "drawn"
        env.context.draws.append(unknown.draw)
    else:
        hint = "state one more equation (align, fit), give it as an argument, or give it a domain to be drawn from"
        notes = tuple((q.span, "this names it, but determines something else") for q in near[:3])
        env.context.error("under-determined", unknown.span, f"nothing determines {unknown.name}", hint=hint, notes=notes)
        definitions[unknown.column] = E.const(0.1)


def centred(env: Env, unknown: Unknown) -> Expr:
    """A free position: the part's box is centred on the box of its scope."""
    from .evaluate import Evaluator
    from .part import rotation_of

    part, axis = unknown.part, unknown.axis
    assert part is not None
    offset = turn(rotation_of(part), part.box().center)[axis]
    at: Env | None = env
    center: Expr = E.ZERO
    while at is not None:
        if at.element is not None and at.element.box is not None:
            box: Box = squared(Evaluator(env).here(at.element, at.element.box))  # type: ignore[assignment]
            center = box.center[axis]
            break
        at = at.outer
    return E.sub(center, offset)


def determined(env: Env, unknown: Unknown) -> None:
    """The domain of a determined parameter is a requirement on those that determine it."""
    context = env.context
    value = E.col(unknown.column)
    name = unknown.name.strip("`")
    if unknown.draw is not None and unknown.kind in ("param", "derived", "default"):
        context.draws = [d for d in context.draws if d is not unknown.draw]
        low, high = unknown.draw.low, unknown.draw.high
        assert low is not None and high is not None
        for a, b, side in ((low, value, "below"), (value, high, "above")):
            context.program.requirements.append(
                Requirement(
                    env.scope, E.call("le", a, b), E.TRUE, f"{name} would lie {side} its domain", where(unknown.span), (a, b),
                    text=f"{name} in its domain",
                )  # fmt: skip
            )
    elif unknown.positive or unknown.kind == "size" and unknown.part is not None and ".size." in unknown.column.name:
        small = E.const(1e-4)
        context.program.requirements.append(
            Requirement(
                env.scope, E.call("le", small, value), E.TRUE, f"{name} would not be positive", where(unknown.span), (small, value),
                text=f"{name} > 0",
            )  # fmt: skip
        )


def solve_guarded(env: Env) -> None:
    """``derived`` parameters that different branches of ``when`` determine: one value per branch."""
    definitions = env.context.program.definitions
    for unknown in [u for u in env.unknowns if u.kind == "derived"]:
        values: list[tuple[Expr, object, Expr]] = []
        for guard, scope, equation in env.guarded:
            alone = Linear(lambda c, u=unknown: c is u.column, definitions)  # type: ignore[misc]
            form = alone.form(E.sub(equation.left, equation.right))
            if form is None or unknown.column not in form[0]:
                continue
            value = E.div(E.neg(form[1]), form[0][unknown.column])
            unknown.reason = equation.text
            values.append((guard, scope, value))
        if not values:
            continue
        result: Expr | None = None
        for guard, scope, value in reversed(values):
            lifted = value if value.scope is None or env.scope.within(value.scope) else E.phi(env.scope, [(scope, value)])  # type: ignore[list-item]
            result = lifted if result is None else E.where(guard, lifted, result)
        covered = E.FALSE
        for guard, _, _ in values:
            covered = E.either(covered, guard)
        if covered is not E.TRUE and not any(E.negate(g) in [v[0] for v in values] for g, _, _ in values):
            raise env.context.error(
                "under-determined", unknown.span, f"{unknown.name} is determined under some guards only",
                hint="add an `else` branch with an equation for it",
            )  # fmt: skip
        definitions[unknown.column] = result  # type: ignore[assignment]
        if unknown.draw is not None:
            determined(env, unknown)
        env.context.ledger.append((None, unknown))
