"""Values that need themselves in the row before: ``x = previous.x + d`` in closed form, as a running sum."""

from __future__ import annotations

from collections.abc import Sequence

from ...graph import expr as E
from ...graph.expr import Column, Expr, Scope
from ...graph.linear import Linear
from ...graph.substitution import substitute
from ..expressions.context import Draft, Equation
from .inline import inline


def closed(context: Draft, column: Column, value: Expr, equations: Sequence[Equation] = ()) -> Expr:
    """The value of ``column``, which ``equations`` determine, without ``previous`` of itself. Raises Abort where the recurrence is of
    another kind, or there is none."""
    if column not in deep(value, context.program.definitions):
        return value
    value = inline(value, [column], context.program.definitions, through=True)
    steps = [node for node in E.nodes(value) if node.op == "previous" and column in E.leaves(node)]
    if not steps:
        stated = equations[0].span if equations else context.spans[column]
        said = f"this would determine `{column.name}`, on which what it names depends already"
        hint = "leave it out, or pass the value as an argument: other statements say where this part is"
        raise context.error("circular-definition", stated, said, hint=hint)
    scope: Scope = steps[0].value
    before = Column(scope, f"{column.name} before")
    mapping: dict[Expr, Expr] = {}
    for node in steps:
        form = Linear(lambda c: c is column, {}).form(node.args[0])
        if node.value is not scope or form is None or form[0].get(column) is not E.ONE:
            raise refused(context, column)
        mapping[node] = E.add(E.col(before), E.previous(scope, form[1], node.args[1]))
    form = Linear(lambda c: c is before, {}).form(substitute(value, mapping))
    if form is None or column in E.leaves(form[1]) or not _carried_on(form[0].get(before, E.ZERO), scope):
        raise refused(context, column)
    return E.add(E.scan(scope, form[1]), form[1])


def _carried_on(factor: Expr, scope: Scope) -> bool:
    """Whether the row before counts with factor 1 in every row but the first (where it is 0 anyway)."""
    first = E.call("eq", E.rank(scope), E.ZERO)
    if factor.op == "where":
        condition, then, otherwise = factor.args
        return condition is first and otherwise is E.ONE or condition is E.negate(first) and then is E.ONE
    if factor.op == "phi":
        pairs = zip(factor.value, factor.args[:-1], strict=True)
        return all(value is E.ONE or value is E.ZERO and child.count is first for child, value in pairs)
    return factor is E.ONE


def deep(value: Expr, definitions: dict[Column, Expr]) -> set[Column]:
    """All columns on which a value depends, through definitions and through ``previous``."""
    found: set[Column] = set()
    stack = [value]
    while stack:
        for column in E.leaves(stack.pop()):
            if column not in found:
                found.add(column)
                if column in definitions:
                    stack.append(definitions[column])
    return found


def refused(context: Draft, column: Column) -> Exception:
    return context.error(
        "recurrence",
        context.spans[column],
        f"`{column.name}` depends on itself in the element before in a way that is not a sum",
        hint="write it as `previous.x` plus something, or in terms of the element's index",
    )
