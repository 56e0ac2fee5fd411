"""``when`` behind a joint: comparisons of joints with values, all of which must hold for it to move."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..language import JOINTS
from ..syntax import ast
from ..syntax.walk import walk
from .mimic import sole_kind
from .types import ANGLE, LENGTH, UNKNOWN, JointType, ScalarType

if TYPE_CHECKING:
    from .checker import Checker, Context

_SIDES = (">", ">=", "<", "<=")
_FORM = "compare a joint with a value, as in `when door.open > 80deg`, several of them with `and` between"


def check_gate(ck: Checker, ctx: Context, value: ast.Expr) -> None:
    """``open > 80deg and lid.open > 60deg``: the joints on the left, values of their unit on the right."""
    match value:
        case ast.BinaryExpr(op="and", left=left, right=right):
            check_gate(ck, ctx, left)
            check_gate(ck, ctx, right)
        case ast.BinaryExpr(op=op, left=left, right=right) if op in _SIDES:
            _compared(ck, ctx, left, right)
        case _:
            ck.error("bad-gate", value.span, "this does not say which joint must be open, and how far", hint=_FORM)


def _compared(ck: Checker, ctx: Context, left: ast.Expr, right: ast.Expr) -> None:
    given = ck.infer(ctx.but(lenient=[], asked=True), left)
    if given == UNKNOWN:
        ck.infer(ctx, right)
        return
    if not isinstance(given, JointType):
        ck.error("bad-gate", left.span, f"a joint waits for another joint, but this is {given}", hint=_FORM)
        return
    if any(isinstance(node, ast.IndexExpr) and not isinstance(node.obj, ast.NameExpr) for node in walk(left)):
        message = "a joint must wait for a joint of one element of a repeat of this body"
        ck.error("many-elements", left.span, message, hint="as in `when row[0].open > 80deg`")
        return
    if not sole_kind(ck, left, given):
        return
    kind = None if given.kind is None else JOINTS.get(given.kind)
    if given.kind in ("ball", "fixed"):
        ck.error(
            "bad-gate",
            left.span,
            f"a {given.kind} joint has no value that says how far it is open",
            hint="wait for a revolute, prismatic or continuous joint",
        )
    elif kind is not None:
        ck.expect(ctx, right, LENGTH if given.kind == "prismatic" else ANGLE, "the value that a joint waits for")
    else:  # of a role: either
        found = ck.infer(ctx, right)
        if found != UNKNOWN and not (isinstance(found, ScalarType) and (found.zero or found in (LENGTH, ANGLE))):
            ck.mismatch(right, found, ANGLE, "the value that a joint waits for")
        elif found in (LENGTH, ANGLE):
            ck.measured[id(left)] = found
