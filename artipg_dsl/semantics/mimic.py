"""``mimic`` behind a joint: the value of another joint, times a factor, plus an offset."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..language import JOINTS
from ..syntax import ast
from ..syntax.walk import walk
from .expressions import arithmetic
from .types import ANGLE, LENGTH, UNKNOWN, JointType, ScalarType, Type, fits

if TYPE_CHECKING:
    from .checker import Checker, Context

_FORM = "write for example `mimic turn`, `mimic -2 * turn`, `mimic turn * (2cm / 90deg)` or `mimic turn + 10deg`"


def check_mimic(ck: Checker, ctx: Context, value: ast.Expr, wanted: Type) -> None:
    """``previous.open``, ``-other.turn``, ``2 * other.turn + 10deg``: of the dimension of the joint that follows, ``wanted``."""
    leaders, given = _formula(ck, ctx, value)
    if given == UNKNOWN and not leaders:
        return
    if not leaders:
        ck.unfit(value, given, "`mimic` must follow a joint")
    elif given != UNKNOWN and not fits(given, wanted):
        ck.error(
            "wrong-dimension",
            value.span,
            f"this joint's value is {wanted}, but what it follows here is {given}",
            hint=_factor(leaders[0], given, wanted),
        )


def _formula(ck: Checker, ctx: Context, value: ast.Expr) -> tuple[list[ast.Expr], Type]:
    """The joint in a formula, if there is one, and the type of the formula, where the joint is the number that is its value."""
    match value:
        case ast.UnaryExpr(op="+" | "-", operand=operand):
            return _formula(ck, ctx, operand)
        case ast.BinaryExpr(op="+" | "-" | "*" | "/", left=left, right=right):
            (before, one), (behind, two) = _formula(ck, ctx, left), _formula(ck, ctx, right)
            if behind and (before or value.op == "/"):
                ck.error(
                    "wrong-type", value.span, "`mimic` must follow one joint, by a factor and an offset", hint=_FORM
                )
                return [*before, *behind], UNKNOWN
            kind = UNKNOWN if UNKNOWN in (one, two) else arithmetic(ck, value, one, two)
            return [*before, *behind], kind
        case _:
            given = ck.infer(ctx.but(lenient=[], asked=True), value)
            if isinstance(given, JointType):
                return [value], _value_of(ck, value, given)
            if not isinstance(given, ScalarType) and given != UNKNOWN:
                ck.unfit(value, given, "`mimic` must follow a joint")
                given = UNKNOWN
            return [], given


def _value_of(ck: Checker, path: ast.Expr, joint: JointType) -> Type:
    """The dimension of a joint's value; unknown of a role's joint, which may be of any kind."""
    if any(isinstance(node, ast.IndexExpr) and not isinstance(node.obj, ast.NameExpr) for node in walk(path)):
        message = "`mimic` must follow a joint of one element of a repeat of this body"
        ck.error("many-elements", path.span, message, hint="as in `mimic row[0].open` or `mimic previous.open`")
        return UNKNOWN
    if joint.kind not in JOINTS:
        return UNKNOWN
    return LENGTH if JOINTS[joint.kind].slides else ANGLE


def _factor(leader: ast.Expr, given: Type, wanted: Type) -> str | None:
    if {given, wanted} != {ANGLE, LENGTH}:
        return None
    each, one = ("2cm", "90deg") if wanted == LENGTH else ("90deg", "2cm")
    return f"say how far it goes for how much of the other: `mimic {leader.span.words} * ({each} / {one})`"
