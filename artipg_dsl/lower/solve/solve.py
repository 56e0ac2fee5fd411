"""Who yields: matches the equations of an environment with its unknowns, block by block and case by case.

A block is a set of unknowns that equations connect; an unrelated equation never changes who yields in another block.
Where equations of a block stand under guards, each combination of guards that can occur is a case of its own. Order of
preference (the rule of the language): unknowns without a domain are covered first, then positions (of two positions
that one equation could determine, the part declared later yields), then parameters of the parts' templates. A tie
between parameters is an error that offers ``derived``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import field, replace

from ...graph import expr as E
from ...graph.expr import Column, Expr, Scope
from ...graph.linear import Circle, Linear
from ...graph.matching import Matching, match
from ...graph.substitution import substitute
from ...records import dataclass
from ...source import Span
from ..expressions.context import Abort, Equation, Settled, Unknown
from ..expressions.env import Env
from .cases import TooManyCases, combinations, condition
from .ledger import condition as guard_in_words
from .recurrent import closed
from .settled import default, determined
from .systems import Stated, solve_system

_DEEPEST = 64  # definitions that read one another; more only where they go in a circle, which the plan reports
_RANK = {"size": 0, "derived": 0, "position": 1, "default": 2, "param": 3}
_MOUNTED = "a mount leaves nothing to equations: move it by `at y = ...`, `gap` or `sink`, or attach the part by its name alone"


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


# ---------------------------------------------------------------- guarded equations


def branches(env: Env, guard: Expr) -> list[tuple[Env, Expr]]:
    """An environment and the branches of its ``when``, theirs too, each with its guard as a condition of the first."""
    found = [(env, guard)]
    for held_where, branch in env.branches.items():
        held = guard if branch.scope is env.scope else E.both(guard, held_where)
        for inner, below in branches(branch, E.TRUE):
            found.append((inner, E.both(held, lifted(below, env.scope, E.FALSE))))
    return found


def lifted(value: Expr, to: Scope, absent: Expr = E.ZERO) -> Expr:
    """A value of a guarded table as one of the table around it; ``absent`` where the guard does not hold."""
    while value.scope is not None and not to.within(value.scope) and value.scope.kind == "guard":
        assert value.scope.parent is not None
        value = E.phi(value.scope.parent, [(value.scope, value)], absent)
    return value


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


# ---------------------------------------------------------------- blocks


@dataclass(slots=True, eq=False)
class Block:
    """Unknowns and equations that hang together."""

    env: Env
    unknowns: list[Unknown]
    stated: list[Stated]
    number: dict[Column, int]  # place of each unknown in the order of the text
    guards: dict[Column, Expr]  # where each unknown exists


@dataclass(slots=True, eq=False)
class Outcome:
    """How one case of a block came out: the value and the equation of each unknown that is determined."""

    condition: Expr
    exists: dict[Column, bool]
    values: dict[Column, Expr] = field(default_factory=dict)
    because: dict[Column, Equation] = field(default_factory=dict)
    told: dict[Column, Settled] = field(default_factory=dict)


def solve(env: Env, homes: list[tuple[Env, Expr]]) -> None:
    for block in blocks(env, homes):
        try:
            _settle_block(block, [outcome(block, case) for case in cases(block)])
        except Abort:
            continue
    for home, _ in homes:
        env.context.ledger.extend((u.part, u) for u in home.unknowns)


def blocks(env: Env, homes: list[tuple[Env, Expr]]) -> Iterator[Block]:
    """The connected blocks in the order of their first unknown; then equations that name none."""
    unknowns, equations, guards = gathered(env, homes)
    number = {u.column: k for k, u in enumerate(unknowns)}
    linear = Linear(lambda c: c in number, env.context.program.definitions)
    stated = [_stated(env, linear, equation) for equation in _once(env, equations)]
    for chosen, members in _connected(list(number), [s.names for s in stated], number):
        own = [stated[e] for e in chosen]
        yield Block(env, [unknowns[u] for u in members], _kept(env, linear, unknowns, members, own), number, guards)


def _once(env: Env, equations: list[Equation]) -> list[Equation]:
    """Without those that stand twice, which are told: as many as unknowns they would be solved as if each determined another."""
    found: dict[tuple[Expr, Expr, Expr], Equation] = {}
    for equation in equations:
        left, right = sorted((equation.left, equation.right), key=id)
        first = found.setdefault((left, right, equation.guard), equation)
        if first is not equation:
            env.context.report.warning(
                "redundant",
                equation.span,
                "this equation follows from the others",
                notes=((first.span, "states the same"),),
                hint="it can be dropped",
                trace=tuple(env.context.trace),
            )
    return list(found.values())


def _stated(env: Env, linear: Linear, equation: Equation) -> Stated:
    form = linear.form(E.sub(equation.left, equation.right))
    names = set(form[0]) if form is not None else linear.columns(equation.left) | linear.columns(equation.right)
    if form is not None:
        form = {c: lifted(v, env.scope) for c, v in form[0].items()}, lifted(form[1], env.scope)
    return Stated(equation, form, names)


def _kept(env: Env, linear: Linear, unknowns: list[Unknown], members: list[int], stated: list[Stated]) -> list[Stated]:
    """The equations of a block with the defaults of what they should not determine.

    The box of a cylinder has ``max(radius, top_radius)``, the latter by default the former. Where nothing else names it, to
    determine ``top_radius`` would make a cone of what is meant to be round, and ``radius`` could not be determined without it.
    """
    own = [unknowns[u] for u in members if unknowns[u].kind == "default"]
    defaults = {E.col(u.column): u.default for u in own if u.default is not None}
    if not defaults:
        return stated
    kept: dict[Expr, Expr] = {}
    found = []
    for one in stated:
        left, right = one.equation.left, one.equation.right
        pairs = [n.args for n in E.nodes(E.sub(left, right)) if n.op in ("max", "min")]
        default = {a: b for pair in pairs for a, b in (pair, pair[::-1]) if defaults.get(a) is b}
        if default:
            one = _stated(
                env, linear, replace(one.equation, left=substitute(left, default), right=substitute(right, default))
            )
        kept |= default
        found.append(one)
    named = any(one.names & {a.value for a in kept} for one in found)  # then it may well be determined
    always = all(one.equation.guard is E.TRUE for one in stated)  # else there are cases, each with fewer equations
    needed = any(linear.columns(b) for b in kept.values()) or (always and len(stated) > len(members) - len(kept))
    return found if needed and not named else stated


def gathered(env: Env, homes: list[tuple[Env, Expr]]) -> tuple[list[Unknown], list[Equation], dict[Column, Expr]]:
    """Unknowns in the order of the text, equations with their guards, and where each unknown exists."""
    guards: dict[Column, Expr] = {}
    equations: list[Equation] = []
    unknowns: list[Unknown] = []
    for home, guard in homes:
        for unknown in home.unknowns:
            exists = E.TRUE if unknown.part is None else lifted(unknown.part.exists, env.scope, E.FALSE)
            guards[unknown.column] = E.both(guard, exists)
            unknowns.append(unknown)
        for equation in home.equations:
            held = lifted(equation.guard, env.scope, E.FALSE)
            equations.append(replace(equation, guard=E.both(guard, held)))
    unknowns.sort(key=lambda u: (u.span if u.part is None else u.part.span).start)
    return unknowns, equations, guards


def _connected(
    columns: list[Column], incidence: list[set[Column]], number: dict[Column, int]
) -> Iterator[tuple[list[int], list[int]]]:
    """Equations and unknowns of each connected block."""
    root = {c: c for c in columns}

    def find(column: Column) -> Column:
        while root[column] is not column:
            root[column] = root[root[column]]
            column = root[column]
        return column

    for names in incidence:
        ordered = sorted(names, key=number.__getitem__)
        for other in ordered[1:]:
            a, b = sorted((find(ordered[0]), find(other)), key=number.__getitem__)
            root[b] = a
    groups: dict[Column | None, tuple[list[int], list[int]]] = {}
    for u, column in enumerate(columns):
        groups.setdefault(find(column), ([], []))[1].append(u)
    for e, names in enumerate(incidence):
        key = find(min(names, key=number.__getitem__)) if names else None
        groups.setdefault(key, ([], []))[0].append(e)
    yield from groups.values()


def cases(block: Block) -> Iterator[tuple[Expr, list[Stated], dict[Column, bool]]]:
    """The cases of a block: the condition, the equations that hold, and which unknowns exist."""
    equations = [s.equation for s in block.stated]
    guards = list(dict.fromkeys(q.guard for q in equations if q.guard is not E.TRUE))
    if not guards:
        yield E.TRUE, block.stated, {u.column: True for u in block.unknowns}
        return
    present = [block.guards[u.column] for u in block.unknowns]
    every = list(dict.fromkeys(g for g in [*guards, *present] if g is not E.TRUE))
    context = block.env.context
    try:
        found = combinations(every, context.draws)
    except TooManyCases:
        raise context.error(
            "too-many-cases",
            equations[-1].span,
            "the guards of these equations combine in too many ways",
            hint="move what they place into a template, or inside one `when`",
            notes=tuple((q.span, "one of the equations") for q in equations[:3]),
        ) from None
    for truth in found:
        values = dict(zip(every, truth, strict=True))
        holds = [s for s in block.stated if values.get(s.equation.guard, True)]
        exists = {u.column: values.get(block.guards[u.column], True) for u in block.unknowns}
        yield condition(every, truth), holds, exists


# ---------------------------------------------------------------- one case


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
    _surplus(env, unknowns, equations, matching, result.values, guard)
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
                        (unknown.span, f"and and so is {unknown.name}"),
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


def _surplus(
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
                f"this equation contradicts the others{guard}: its two sides always differ by {amount(rest.constant, length)}",
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


def amount(difference: float | None, length: bool) -> str:
    """A difference of two sides in words."""
    size = abs(difference or 0.0)
    return f"{round(size * 1000, 3):g}mm" if length else f"{size:.6g} (in metres or radians)"


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
        env.context.program.definitions[column] = closed(env.context, column, chosen(column.scope, solved))
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
