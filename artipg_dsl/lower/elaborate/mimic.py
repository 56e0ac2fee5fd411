"""``mimic``: a joint that follows another, by a factor."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.reference import Elsewhere, Reference
from ...semantics.meanings import Previous
from ...syntax import ast
from ..expressions.context import Abort
from ..expressions.env import Element, Env
from ..expressions.evaluate import Evaluator
from .paths import joints

if TYPE_CHECKING:
    from .links import Links


def resolve(links: Links) -> None:
    """Fill in which joint each ``mimic`` follows: of the alternatives and branches of ``when`` that bring one of the name,
    the one that is there."""
    program = links.context.program
    for number, (env, node) in links.mimics.items():
        try:
            path, factor = followed(Evaluator(env), node)
            leader = leader_of(links, env, path)
        except Abort:
            continue
        program.joints[number] = replace(program.joints[number], mimic=(leader, factor, E.ZERO))


def followed(ev: Evaluator, node: ast.Expr) -> tuple[ast.Expr, Expr]:
    """The joint and the factor of ``mimic fold``, ``mimic -fold``, ``mimic 2 * fold``, ``mimic fold / 3``."""
    if isinstance(node, ast.UnaryExpr) and node.op in ("-", "+"):
        leader, factor = followed(ev, node.operand)
        return leader, E.neg(factor) if node.op == "-" else factor
    if isinstance(node, ast.BinaryExpr) and node.op == "*":
        constant = node.left if isinstance(node.left, ast.NumberExpr | ast.UnaryExpr) else node.right
        leader, factor = followed(ev, node.right if constant is node.left else node.left)
        return leader, E.mul(factor, ev.scalar(constant))
    if isinstance(node, ast.BinaryExpr) and node.op == "/":
        leader, factor = followed(ev, node.left)
        return leader, E.div(factor, ev.scalar(node.right))
    return node, E.ONE


def leader_of(links: Links, env: Env, node: ast.Expr) -> Reference:
    """The joints that a path names; ``previous`` and ``half[0]`` lead to another element."""
    leaders, ev, at = ordered(links, joints(links, env, node)), Evaluator(env), node
    while isinstance(at, ast.MemberExpr):
        at = at.obj
    meaning = env.context.meaning(at)
    if isinstance(at, ast.IndexExpr) and isinstance(repeat := ev.value(at.obj), Element):
        return (Elsewhere(env.scope, repeat.scope, ev.position(repeat, at.index), leaders),)
    if isinstance(meaning, Previous) and (element := env.element_at(meaning.depth)) is not None:
        return (Elsewhere(env.scope, element.scope, None, leaders),)
    homes = (links.context.program.joints[k].scope for k in leaders if isinstance(k, int))
    if any(scope.kind == "repeat" for home in homes for scope in home.ancestors() if not env.scope.within(scope)):
        raise env.context.error(
            "many-elements", node.span, f"`{node.span.words}` is a joint of every element of a repeat"
        )
    return leaders


def ordered(links: Links, joints: list[int]) -> Reference:
    """Joints of one name, those that exist seldom first."""
    depth = {k: links.context.program.joints[k].scope.depth for k in joints}
    return tuple(sorted(joints, key=lambda k: -depth[k]))
