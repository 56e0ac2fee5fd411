"""``mimic``: a joint that follows another, by a factor."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..graph import expr as E
from ..graph.expr import Expr
from ..syntax import ast
from .env import Env
from .evaluate import Evaluator
from .place import root_name

if TYPE_CHECKING:
    from .links import Links


def resolve(links: Links) -> None:
    """Fill in which joint each ``mimic`` follows."""
    program = links.context.program
    names = {j.path: k for k, j in enumerate(program.joints)}
    for k, joint in enumerate(program.joints):
        if joint.mimic is None or len(joint.mimic) == 3:
            continue
        node, multiplier, offset, env = joint.mimic
        leader = k if root_name(node) == "previous" else leader_of(links, names, node, env)
        if leader is None:
            links.context.error("unknown-name", node.span, "there is no such joint to follow")
            continue
        program.joints[k] = replace(joint, mimic=(leader, multiplier, offset))


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


def leader_of(links: Links, names: dict[str, int], node: ast.Expr, env: Env) -> int | None:
    text = node.span.source.text[node.span.start : node.span.end]
    at: Env | None = env
    while at is not None:
        if at.path + text in names:
            return names[at.path + text]
        at = at.outer
    return next((k for path, k in names.items() if path.endswith("." + text)), None)
