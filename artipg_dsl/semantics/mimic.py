"""``mimic`` behind a joint: a formula of the value of one other joint."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..language import JOINTS
from ..syntax import ast
from ..syntax.walk import walk
from .remedies import instead
from .types import ANGLE, LENGTH, SEVERAL, UNKNOWN, ElementType, JointType, ScalarType, Type, fits

if TYPE_CHECKING:
    from .checker import Checker, Context

_FORM = "write for example `mimic turn`, `mimic -2 * turn`, `mimic turn * (2cm / 90deg)` or `mimic 2cm * sin(turn)`"


def check_mimic(ck: Checker, ctx: Context, name: str, value: ast.Expr, wanted: Type) -> None:
    """``previous.open``, ``2 * other.turn + 10deg``, ``2cm * sin(turn)``: of the dimension of the joint ``name`` that follows, ``wanted``."""
    leaders = _leaders(ck, ctx, value)
    if not leaders:
        given = ck.infer(ctx.but(lenient=[], asked=True), value)
        if given != UNKNOWN:
            of_element = isinstance(given, ElementType)
            hint = f"name the joint: `{value.span.words}.{name}`" if of_element else _FORM
            ck.unfit(value, given, "`mimic` must follow a joint", hint=hint)
        return
    (path, joint), *others = leaders
    if any(other.span.words != path.span.words for other, _ in others):
        ck.error("wrong-type", value.span, "`mimic` must follow one joint", hint=_FORM)
        return
    stands = _value_of(ck, path, joint)
    if joint.kind is None and stands == UNKNOWN:
        stands = _fitting(ck, ctx, value, [node for node, _ in leaders], wanted)
    given = ck.infer(ctx.but(leads={id(node): stands for node, _ in leaders}), value)
    if given == UNKNOWN:
        return
    if not isinstance(given, ScalarType):
        ck.unfit(value, given, "what `mimic` computes must be a number", hint=instead(value, given, wanted))
    elif not fits(given, wanted):
        ck.error(
            "wrong-dimension",
            value.span,
            f"this joint's value is {wanted}, but what it follows here is {given}",
            hint=_factor(path, given, wanted),
        )


def _fitting(ck: Checker, ctx: Context, value: ast.Expr, leaders: list[ast.Expr], wanted: Type) -> Type:
    """What the joint of a role has to be for the formula to be ``wanted``: lowering, which sees the joint, holds it to that."""
    with ck.muted():
        found = [
            kind
            for kind in (LENGTH, ANGLE)
            if fits(given := ck.infer(ctx.but(leads={id(n): kind for n in leaders}), value), wanted)
            and given != UNKNOWN
        ]
    if len(found) != 1:  # either will do, or neither: then of what is as the joint that follows
        return UNKNOWN if found else wanted
    ck.measured.update((id(node), found[0]) for node in leaders)
    return found[0]


def _leaders(ck: Checker, ctx: Context, value: ast.Expr) -> list[tuple[ast.Expr, JointType]]:
    """The paths in a formula that name joints."""
    lenient, found = ctx.but(lenient=[], asked=True), []
    with ck.muted():
        for path in paths(value):
            kind = ck.infer(lenient, path)
            if isinstance(kind, JointType):
                found.append((path, kind))
    return found


def paths(value: ast.Node) -> Iterator[ast.Expr]:
    """The names in an expression, each with its members and indices."""
    if isinstance(value, ast.NameExpr | ast.MemberExpr | ast.IndexExpr):
        yield value
        return
    for name in value.__dataclass_fields__:
        inner = getattr(value, name)
        for node in inner if isinstance(inner, tuple) else (inner,):
            if isinstance(node, ast.Node):
                yield from paths(node)


def _value_of(ck: Checker, path: ast.Expr, joint: JointType) -> Type:
    """The dimension of a joint's value; unknown of what cannot be followed."""
    if any(isinstance(node, ast.IndexExpr) and not isinstance(node.obj, ast.NameExpr) for node in walk(path)):
        message = "`mimic` must follow a joint of one element of a repeat of this body"
        ck.error("many-elements", path.span, message, hint="as in `mimic row[0].open` or `mimic previous.open`")
        return UNKNOWN
    if joint.kind == "fixed":
        ck.error(
            "bad-mimic",
            path.span,
            "a fixed joint does not move, so nothing can follow it",
            hint="follow a joint that moves",
        )
    if not sole_kind(ck, path, joint) or joint.kind not in JOINTS or not JOINTS[joint.kind].moves:
        return UNKNOWN
    return LENGTH if JOINTS[joint.kind].slides else ANGLE


def sole_kind(ck: Checker, path: ast.Expr, joint: JointType) -> bool:
    """Whether a path names joints of one kind; an error where alternatives bring several, with values in units of their own."""
    if joint == SEVERAL:
        said = f"`{path.span.words}` is a joint of several kinds, whose values have units of their own"
        owner = path.obj.span.words if isinstance(path, ast.MemberExpr) else "PART"
        hint = f"put this under `when {owner} is TEMPLATE {{ }}`, which leaves one of them"
        ck.error("wrong-type", path.span, said, hint=hint)
    return joint != SEVERAL


def _factor(leader: ast.Expr, given: Type, wanted: Type) -> str:
    if {given, wanted} != {ANGLE, LENGTH}:
        return _FORM
    each, one = ("2cm", "90deg") if wanted == LENGTH else ("90deg", "2cm")
    return f"say how far it goes for how much of the other: `mimic {leader.span.words} * ({each} / {one})`"
