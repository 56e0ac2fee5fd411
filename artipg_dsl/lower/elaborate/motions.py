"""``limit``: a user narrows a template's motion; ``close``: two points that stay together."""

from __future__ import annotations

from dataclasses import replace

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.primitive import Triple, triple
from ...graph.program import Closure
from ...graph.reference import Reference
from ...syntax import ast
from ..expressions.context import where
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..expressions.rows import has_row
from ..solve.guarded import lifted
from ..values.kinds import Frame, Line, Vec
from ..values.vectors import cross, direct, dot, minus, norm, place, plus, times
from .connect import carriers
from .joints import clears, ends
from .links import Links
from .paths import joints
from .ranges import PARALLEL, Quantity
from .statements import Meanings


def limit(links: Links, env: Env, statement: ast.LimitStmt) -> None:
    """Narrow the range of the joint (of each alternative that brings one); its rest value moves into the range."""
    program = links.context.program
    ev = Evaluator(env)
    beyond: list[tuple[bool, bool]] = []
    for number in joints(links, env, statement.joint):
        joint = program.joints[number]
        if joint.low is None or joint.high is None:
            raise links.context.error(
                "wrong-kind",
                statement.joint.span,
                f"a {joint.kind} joint has no range to limit",
                hint="limit a revolute or a prismatic joint, or make this one `revolute` with a `range`",
            )
        here = has_row(env.scope, joint.scope)
        if here is not E.TRUE and clears(ev, statement.range.high):
            raise links.context.error(
                "needs-clearance",
                statement.range.high.span,
                "`clearance` cannot be under a guard that the joint itself is not under",
                hint="put `clearance` in the joint's own range, or declare a joint in each branch",
            )
        low, high = (lifted(end, joint.scope) for end in ends(ev, statement.range, joint.kind, number))
        if _above(joint.low, high) or (_above(low, joint.high) and not clears(ev, statement.range.low)):
            raise links.context.error(
                "empty-range",
                statement.range.span,
                f"the joint `{joint.path}` has no value within this limit",
                hint="`limit` narrows the range that the joint has",
            )
        beyond.append((_above(joint.low, low), _above(high, joint.high)))
        low, high = E.maximum(joint.low, low), E.minimum(joint.high, high)
        if here is E.TRUE and low.constant is not None and low.constant == high.constant:
            raise links.context.error(
                "empty-range",
                statement.range.span,
                f"the joint `{joint.path}` cannot move: this limit leaves it a single value",
                hint="give it room; where it is locked, put the limit under a `when`, or attach the part by `connect`",
            )
        rest = E.minimum(E.maximum(joint.rest, low), high)
        low, high, rest = (
            E.where(here, new, old)
            for new, old in zip((low, high, rest), (joint.low, joint.high, joint.rest), strict=True)
        )
        program.joints[number] = replace(joint, low=low, high=high, rest=rest)

    for end, idle in zip((statement.range.low, statement.range.high), zip(*beyond, strict=True), strict=False):
        if all(idle) and not clears(ev, end):
            said = "this end of the limit has no effect: the joint goes no further"
            hint = "`limit` only narrows: widen the range of the joint"
            links.context.report.warning("always-true", end.span, said, hint=hint)


def _above(one: Expr, other: Expr) -> bool:
    """Whether a value is known to lie above another."""
    return one.constant is not None and other.constant is not None and one.constant > other.constant + 1e-9


def close(links: Links, env: Env, statement: ast.CloseStmt) -> None:
    """Record a loop: the two points, in the object's frame at joint values 0, and the links they lie on."""
    sides: list[tuple[Reference, Triple]] = []
    axes: list[Triple] = []
    for node in (statement.subject, statement.other):
        value = Evaluator(env).value(node)
        if isinstance(value, Frame):
            point = value.origin
        elif isinstance(value, Line):  # axes that coincide: where along them does not matter
            point = value.point
            axes.append(direct(links.world(env), value.direction))
        elif isinstance(value, Vec) and len(value.items) == 3:
            point = triple(value.items)
        else:
            raise Evaluator(env).impossible(node.span, "a port or a point", value)
        on = carriers(value, env.scope)
        sides.append((links.carried(on, node.span) if on else links.base(env), place(links.world(env), point)))
    (first, a), (second, b) = sides
    if links.is_one(env, (first, second)):
        hint = "name points of links that joints move against one another"
        message = (
            f"no joint moves `{statement.subject.span.words}` and `{statement.other.span.words}` against one another"
        )
        raise links.context.error("wrong-kind", statement.span, message, hint=hint)
    if len(axes) == 2:
        name, skew = "the sine of the angle between the axes of this `close`", cross(*axes)
        links.context.asked.append(Quantity(name, env.scope, norm(skew), PARALLEL, where(statement.span)))
    for along in axes[-1:]:
        links.context.axes[len(links.context.program.closures)] = along
        b = plus(b, times(along, dot(minus(a, b), along)))
    links.context.program.closures.append(Closure(env.scope, (first, second), (a, b), where(statement.span)))


MEANINGS: Meanings = {ast.LimitStmt: limit, ast.CloseStmt: close}
