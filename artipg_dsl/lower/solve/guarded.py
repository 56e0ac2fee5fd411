"""What stands under ``when``: the branches of an environment, and values of a guarded table as those of the table around it."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ..expressions.env import Env


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
