"""``when`` behind a joint: it moves only while others are open."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.program import Gate, Joint, Program
from ...graph.reference import definitions_of
from ...language import JOINTS
from ...syntax import ast
from ..expressions.context import Abort
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from .mimic import leader_of
from .ranges import Legal, Quantity

if TYPE_CHECKING:
    from .links import Links

_MEETS = Legal(
    1e-6, 2e4, "the joint that it waits for must be able to meet both", remedy="leave a range between the two values"
)
_OPENS = Legal(
    1e-6, 1e4, "the joint that it waits for must reach that value", remedy="name a value within the range of that joint"
)


def resolve(links: Links) -> None:
    """Fill in which joints each ``when`` waits for, and refuse those that do not move by themselves."""
    program = links.context.program
    for number, (env, node) in links.gates.items():
        try:
            found = tuple(_gates(links, env, node))
        except Abort:
            continue
        program.joints[number] = replace(program.joints[number], gates=found)


def _gates(links: Links, env: Env, node: ast.Expr) -> Iterator[Gate]:
    assert isinstance(node, ast.BinaryExpr)  # as semantics has seen
    if node.op == "and":
        yield from _gates(links, env, node.left)
        yield from _gates(links, env, node.right)
        return
    leaders = leader_of(links, env, node.left)
    program = links.context.program
    for k in definitions_of(leaders):
        if program.joints[k].mimic is not None or k in links.mimics:
            raise env.context.error(
                "bad-gate",
                node.left.span,
                f"`{node.left.span.words}` follows another joint, so nothing can wait for it",
                hint="wait for the joint that leads it",
            )
    value = Evaluator(env).scalar(node.right)
    low, high = (value, None) if node.op in (">", ">=") else (None, value)
    yield Gate(leaders, low, high, node.span.words)


def refuse_loops(links: Links) -> None:
    """In a closed loop joints determine one another, so that none of an object with one can rest by itself."""
    program = links.context.program
    for number, joint in enumerate(program.joints) if program.closures else ():
        if joint.gates:
            message = f"the joint `{joint.path}` cannot wait for another: the object has a closed loop of joints"
            links.context.error("bad-gate", links.gates[number][1].span, message, hint="drop `when`, or `close`")


def quantities(program: Program, joint: Joint) -> Iterator[Quantity]:
    """How far the joints that a joint waits for go beyond what it waits for, where their ranges are known in its table."""
    yield from _room(program, joint)
    for gate in joint.gates:
        for k in gate.joint:
            leader = program.joints[k] if isinstance(k, int) else None
            if leader is None or not joint.scope.within(leader.scope) or leader.clearance:
                continue
            name = f"the range beyond `{gate.text}`, for the joint `{joint.path}`,"
            opens = replace(_OPENS, unit=unit_of(leader))
            if gate.low is not None and leader.high is not None:
                yield Quantity(name, joint.scope, E.sub(leader.high, gate.low), opens, joint.where)
            if gate.high is not None and leader.low is not None:
                yield Quantity(name, joint.scope, E.sub(gate.high, leader.low), opens, joint.where)


def unit_of(joint: Joint) -> str:
    """The unit of the values of a joint."""
    return "m" if JOINTS[joint.kind].slides else "rad"


def _room(program: Program, joint: Joint) -> Iterator[Quantity]:
    """What gates that name one joint leave between them: it must be able to open both at once."""
    for above in joint.gates:
        for below in joint.gates:
            if above.low is not None and below.high is not None and above.joint == below.joint:
                name = f"the range between `{above.text}` and `{below.text}`, for the joint `{joint.path}`,"
                leader = next((program.joints[k] for k in above.joint if isinstance(k, int)), None)
                meets = _MEETS if leader is None else replace(_MEETS, unit=unit_of(leader))
                yield Quantity(name, joint.scope, E.sub(below.high, above.low), meets, joint.where)
