"""Conditions on rows: whether they have rows in another table, whether one of several conditions holds."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Expr, Scope


def has_row(scope: Scope, to: Scope, found: Expr = E.TRUE) -> Expr:
    """Whether a row of ``to``, or of what is around both, has one in ``scope`` for which ``found`` holds: whether the guards between
    hold, in any element of the repeats between."""
    while not to.within(scope):
        assert scope.parent is not None and scope.count is not None
        own = found.scope is not None and found.scope.within(scope)
        if scope.kind == "repeat":
            found = E.reduce("any", scope, found) if own else E.both(found, E.reduce("any", scope, E.TRUE))
        elif own:
            found = E.phi(scope.parent, [(scope, found)], E.FALSE)
        else:
            found = E.both(scope.count, found)
        scope = scope.parent
    return found


def either_of(*conditions: Expr) -> Expr:
    """That one of several conditions holds, without those from which another follows, as from ``a and b`` follows ``a``."""
    cases = {
        frozenset(terms): terms
        for c in conditions
        for case in _terms(c, "or")
        for terms in [list(dict.fromkeys(_terms(case, "and")))]
    }
    return E.any_of(E.all_of(terms) for case, terms in cases.items() if not any(other < case for other in cases))


def _terms(condition: Expr, op: str) -> list[Expr]:
    """What a condition joins by ``and``, or by ``or``."""
    return [term for arg in condition.args for term in _terms(arg, op)] if condition.op == op else [condition]
