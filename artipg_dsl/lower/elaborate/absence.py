"""Parts that may be absent, in statements that name them: a requirement holds trivially without them, an equation is void."""

from __future__ import annotations

from ...graph import expr as E
from ...graph.expr import Expr
from ...syntax import ast
from ...syntax.walk import children
from ..expressions.env import Env
from ..values.kinds import Ref
from .part import Component
from .place import begins


def presence(env: Env, node: ast.Node, known: frozenset[Component] = frozenset()) -> Expr:
    """Where the optional parts are there of which an expression reads members: of those that are not ``known`` to be there where the
    member is read, as behind `lid and` or in `a if lid else b`."""
    match node:
        case ast.IfExpr(then=then, condition=condition, otherwise=otherwise):
            branches = (then, known | _assured(env, condition)), (otherwise, known | _assured(env, condition, False))
            return E.all_of((presence(env, condition, known), *(presence(env, *branch) for branch in branches)))
        case ast.BinaryExpr(op="and" | "or", left=left, right=right):
            later = known | _assured(env, left, node.op == "and")
            return E.both(presence(env, left, known), presence(env, right, later))
        case ast.MemberExpr(obj=ast.NameExpr() as name) if (part := _part_named(env, name)) is not None:
            return E.TRUE if part in known else part.exists
    return E.all_of(presence(env, child, known) for child in children(node))


def _assured(env: Env, condition: ast.Expr, holds: bool = True) -> frozenset[Component]:
    """The parts that are there where a condition holds, or does not."""
    match condition:
        case ast.UnaryExpr(op="not", operand=operand):
            return _assured(env, operand, not holds)
        case ast.BinaryExpr(op="and" | "or", left=left, right=right):
            both = _assured(env, left, holds), _assured(env, right, holds)
            return both[0] | both[1] if (condition.op == "and") == holds else both[0] & both[1]
        case ast.NameExpr() | ast.IsExpr(subject=ast.NameExpr()) if holds:
            part = _part_named(env, condition.subject if isinstance(condition, ast.IsExpr) else condition)
            return frozenset() if part is None else frozenset((part,))
    return frozenset()


def _part_named(env: Env, node: ast.Expr) -> Component | None:
    """The part that a name stands for."""
    name = begins(env, node)
    value = None if name is None else env.find(name.name, name.depth)
    return value.branches[0].members[0][0] if isinstance(value, Ref) and len(value.branches) == 1 else None
