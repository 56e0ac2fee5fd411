"""The blocks of an environment: unknowns and the equations that connect them, and the cases in which these hold.

An unrelated equation never changes who yields in another block. Where equations of a block stand under guards, each
combination of guards that can occur is a case of its own.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ...graph import expr as E
from ...graph.expr import Column, Expr
from ...graph.linear import Linear
from ...graph.substitution import substitute
from ...records import dataclass
from ..expressions.context import Equation, Unknown
from ..expressions.env import Env
from .cases import TooManyCases, combinations, condition
from .guarded import lifted
from .systems import Stated


@dataclass(slots=True, eq=False)
class Block:
    """Unknowns and equations that hang together."""

    env: Env
    unknowns: list[Unknown]
    stated: list[Stated]
    number: dict[Column, int]  # place of each unknown in the order of the text
    guards: dict[Column, Expr]  # where each unknown exists


def blocks(env: Env, homes: list[tuple[Env, Expr]]) -> Iterator[Block]:
    """The connected blocks in the order of their first unknown; then equations that name none."""
    unknowns, equations, guards = _gathered(env, homes)
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


def _gathered(env: Env, homes: list[tuple[Env, Expr]]) -> tuple[list[Unknown], list[Equation], dict[Column, Expr]]:
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
