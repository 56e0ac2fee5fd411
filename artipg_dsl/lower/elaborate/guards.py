"""Statements under guards, seen from the rows of what they speak of: where the guards hold."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Expr, Scope


def held(scope: Scope, to: Scope) -> Expr:
    """Whether a row of ``to`` has one in ``scope``: whether the guards between hold, in any element of the repeats between."""
    found = E.TRUE
    while not to.within(scope):
        assert scope.parent is not None and scope.count is not None
        if scope.kind == "repeat":
            found = E.reduce("any", scope, found)
        elif found.scope is not None and found.scope.within(scope):
            found = E.phi(scope.parent, [(scope, found)], E.FALSE)
        else:
            found = E.both(scope.count, found)
        scope = scope.parent
    return found
