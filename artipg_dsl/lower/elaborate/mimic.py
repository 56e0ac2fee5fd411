"""``mimic``: a joint that follows another, by a factor and an offset."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.reference import Elsewhere, Reference
from ...semantics.meanings import Previous
from ...semantics.types import JointType
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
            path, factor, offset = followed(Evaluator(env), node)
            assert path is not None  # as semantics has seen
            leader = leader_of(links, env, path)
        except Abort:
            continue
        program.joints[number] = replace(program.joints[number], mimic=(leader, factor, offset))


class Followed(NamedTuple):
    """``factor`` times the joint that ``path`` names, plus ``offset``; a number alone has no path."""

    path: ast.Expr | None
    factor: Expr
    offset: Expr


def followed(ev: Evaluator, node: ast.Expr) -> Followed:
    """What ``mimic -fold``, ``mimic lead * fold / 3 + 10deg`` say of one joint, as semantics has seen."""
    if isinstance(node, ast.UnaryExpr):
        path, factor, offset = followed(ev, node.operand)
        return Followed(path, E.neg(factor), E.neg(offset)) if node.op == "-" else Followed(path, factor, offset)
    if isinstance(node, ast.BinaryExpr):
        left, right = followed(ev, node.left), followed(ev, node.right)
        path = left.path or right.path
        if node.op in ("*", "/"):
            led, number = (right, left) if left.path is None else (left, right)
            scale = E.mul if node.op == "*" else E.div
            if path is None:
                return Followed(None, E.ZERO, scale(left.offset, right.offset))
            return Followed(path, scale(led.factor, number.offset), scale(led.offset, number.offset))
        join = E.add if node.op == "+" else E.sub
        return Followed(path, join(left.factor, right.factor), join(left.offset, right.offset))
    if isinstance(ev.env.context.typed.type_of(node), JointType):
        return Followed(node, E.ONE, E.ZERO)
    return Followed(None, E.ZERO, ev.scalar(node))


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
