"""``mimic``: a joint that follows another, by a factor and an offset or by any formula of its value."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.program import LEAD
from ...graph.reference import Elsewhere, Reference, definitions_of
from ...graph.scopes import Scope
from ...graph.substitution import substitute
from ...semantics.meanings import Previous
from ...semantics.mimic import paths
from ...semantics.types import JointType
from ...syntax import ast
from ..expressions.context import Abort
from ..expressions.env import Element, Env
from ..expressions.evaluate import Evaluator
from .paths import joints

if TYPE_CHECKING:
    from .links import Links


def resolve(links: Links) -> None:
    """Fill in which joint each ``mimic`` follows, of the alternatives and branches of ``when`` that bring one of the name
    the one that is there, and how."""
    program, lead = links.context.program, E.var(LEAD)
    for number, (env, node) in links.mimics.items():
        led = [path for path in paths(node) if isinstance(links.context.typed.type_of(path), JointType)]
        try:
            formula = Evaluator(env, instead={id(path): lead for path in led}).scalar(node)
            leader = leader_of(links, env, led[0])
        except Abort:
            continue
        joint = program.joints[number]
        if not formula.reads & lead.reads:
            links.context.error(
                "bad-mimic",
                node.span,
                f"the joint `{joint.path}` would never move: its `mimic` is the same whatever `{led[0].span.words}` is",
                hint="give the factor a value other than 0, or attach the part by `connect`",
            )
            continue
        if _straight(formula, lead):
            straight = (leader, derive(formula, LEAD), substitute(formula, {lead: E.ZERO}))
            program.joints[number] = replace(joint, mimic=straight)
        else:
            program.joints[number] = replace(joint, mimic=(leader, E.ONE, E.ZERO), curve=formula)


def _straight(formula: E.Expr, lead: E.Expr) -> bool:
    """Whether a formula is a factor and an offset throughout: with branches it may only be that piece by piece."""
    stack = [formula]
    while stack:
        node = stack.pop()
        if node.reads & lead.reads and node is not lead:
            if node.op not in ("add", "sub", "mul", "div", "neg"):
                return False
            stack.extend(node.args)
    return not derive(formula, LEAD).reads & lead.reads


def refuse_chains(links: Links) -> None:
    """Refuse formulas that are more than a factor and an offset in chains of followers."""
    program = links.context.program
    for number, joint in enumerate(program.joints):
        leaders = [] if joint.mimic is None else [program.joints[k] for k in definitions_of(joint.mimic[0])]
        curved = next((leader for leader in leaders if leader.curve is not None), None)
        led = next((leader for leader in leaders if leader.mimic is not None), None)
        if curved is not None:
            message = f"nothing can follow `{curved.path}`, which follows another joint by a formula"
        elif led is not None and joint.curve is not None:
            message = f"`{led.path}` follows another joint: what follows it has a factor and an offset alone"
        else:
            continue
        hint = "let it follow the joint that moves by itself"
        links.context.error("bad-mimic", links.mimics[number][1].span, message, hint=hint)


def refuse_loops(links: Links) -> None:
    """Refuse such formulas where loops are closed."""
    for number, joint in enumerate(links.context.program.joints):
        if joint.curve is not None and links.context.program.closures:
            links.context.error(
                "bad-mimic",
                links.mimics[number][1].span,
                f"`{joint.path}` follows another joint by a formula: beside a closed loop, as `close` makes one, "
                "it can only by a factor and an offset",
                hint="write `mimic joint * factor + offset`; or drop `mimic` and `close` its link on one of the loop",
            )


def leader_of(links: Links, env: Env, node: ast.Expr) -> Reference:
    """The joints that a path names; ``previous`` and ``half[0]`` lead to another element."""
    leaders, ev, at = ordered(links, joints(links, env, node)), Evaluator(env), node
    homes = {k: links.context.program.joints[k].scope for k in leaders if isinstance(k, int)}
    while isinstance(at, ast.MemberExpr):
        at = at.obj
    meaning = env.context.meaning(at)
    if isinstance(at, ast.IndexExpr) and isinstance(repeat := ev.value(at.obj), Element):
        rank = ev.position(repeat, at.index)
        there = tuple(k for k, home in homes.items() if not _never(home, repeat.scope, rank))
        return (Elsewhere(env.scope, repeat.scope, rank, there or leaders),)
    if isinstance(meaning, Previous) and (element := env.element_at(meaning.depth)) is not None:
        return (Elsewhere(env.scope, element.scope, None, leaders),)
    if any(
        scope.kind == "repeat" for home in homes.values() for scope in home.ancestors() if not env.scope.within(scope)
    ):
        raise env.context.error(
            "many-elements",
            node.span,
            f"`{node.span.words}` is a joint of every element of a repeat",
            hint="name one: `row[0].open`, `row[last].open`, or inside the repeat `previous.open`",
        )
    return leaders


def _never(home: Scope, repeat: Scope, rank: E.Expr) -> bool:
    """Whether a guard around a table leaves the element of this rank without rows of it, as far as constants tell."""
    guards = [scope for scope in home.ancestors() if scope.kind == "guard" and scope.within(repeat)]
    at = {E.rank(repeat): rank}
    return any(scope.count is not None and substitute(scope.count, at).constant == 0 for scope in guards)


def ordered(links: Links, joints: list[int]) -> Reference:
    """Joints of one name, those that exist seldom first."""
    depth = {k: links.context.program.joints[k].scope.depth for k in joints}
    return tuple(sorted(joints, key=lambda k: -depth[k]))
