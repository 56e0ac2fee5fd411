"""Statements under guards, seen from the rows of what they speak of: where the guards hold."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Expr, Scope, ScopeError
from ...graph.formula import row_values
from ...graph.substitution import substitute
from ..expressions.env import Env
from ..solve.guarded import lifted


def shown(value: Expr, to: Scope) -> Expr:
    """A value of a statement, or a formula, as one of the rows of ``to``: what a ``when`` around the statement declares is
    carried out of it. Raises ScopeError where it reads what each element of a repeat has of its own and ``to`` is not in it.
    """
    carried: dict[Expr, Expr] = {}
    for row in row_values([value]):
        if row.scope is None or to.within(row.scope):
            continue
        carried[row] = lifted(row, to, E.FALSE if E.truth(row) else E.ZERO)
        table = carried[row].scope
        if table is not None and not to.within(table):
            raise ScopeError(table, _common(table, to))
    return substitute(value, carried) if carried else value


def _common(scope: Scope, other: Scope) -> Scope:
    """The nearest table around both."""
    return next(table for table in other.ancestors() if scope.within(table))


def is_alone(env: Env, scope: Scope) -> bool:
    """Whether a table has at most one row for each row in which a statement in ``env`` stands."""
    return all(s.kind != "repeat" or env.scope.within(s) for s in scope.ancestors())
