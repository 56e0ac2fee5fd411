"""``limit``: the joint that it names, and its range there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..language import JOINTS
from ..syntax import ast
from ..syntax.walk import path_root
from . import joints, placing
from .guards import TRUE, Condition, conjunction
from .mimic import sole_kind
from .presence import excludes, renamed
from .types import ANGLE, LENGTH, UNKNOWN, JointType, PartType, Type

if TYPE_CHECKING:
    from .checker import Checker, Context
    from .scope import Entry


def check_limit(ck: Checker, ctx: Context, node: ast.LimitStmt) -> None:
    """A range of a joint that a body states anew."""
    joint, interval = node.joint, node.range
    if _of_all(ck, ctx, joint):
        return
    kind, inside = placing.subject(ck, ctx, joint)
    if not isinstance(kind, JointType) and kind != UNKNOWN:
        ck.unfit(joint, kind, "`limit` must name a joint", hint="name a joint, as in `limit hinge.open 0deg .. 90deg`")
    wanted: Type = UNKNOWN
    if isinstance(kind, JointType) and sole_kind(ck, joint, kind):
        row = JOINTS.get(kind.kind or "")
        if row is not None and row.moves:
            wanted = LENGTH if row.slides else ANGLE
    joints.motion_range(ck, inside, interval, wanted)
    if isinstance(kind, JointType):
        _require_there(ck, ctx, joint)
        if kind.kind is None:
            ends = (ck.types.get(id(end)) for end in (interval.low, interval.high))
            ck.measured.update((id(joint), end) for end in ends if end in (LENGTH, ANGLE))


def _of_all(ck: Checker, ctx: Context, joint: ast.Expr) -> bool:
    """Whether a `limit` names the joints of all elements of a repeat, which is reported."""
    root = path_root(joint)
    entries = ctx.scope.find(root.name) if ctx.scope is not None and isinstance(root, ast.NameExpr) else []
    around = [scope.repeat for scope in ctx.scope.chain()] if ctx.scope is not None else []
    if root is joint or not entries or entries[0].kind != "repeat" or entries[0].node in around:
        return False
    name = joint.span.words.partition(".")[2]
    ck.error(
        "many-elements",
        joint.span,
        f"`{joint.span.words}` is a joint of each element of a repeat",
        hint=f"put `limit {name} ...` inside the repeat, for one element under a guard such as `when i == 0 {{ }}`",
    )
    return True


def _require_there(ck: Checker, ctx: Context, joint: ast.Expr) -> None:
    """Reports a joint that is never there under the guards around, or with the arguments of its part, since what it moves is not."""
    child: ast.Expr | None = None
    for entry, homes, given in _declarations(ck, ctx, joint):
        if not isinstance(entry.node, ast.JointDecl) or entry.node.child is None:
            return
        noted: list[Condition] = []
        child = entry.node.child
        ck.infer(ck.context(entry.scope).but(lenient=noted, ends=True, subject=True), child)
        known, own = conjunction((ctx.condition, given)), renamed(ck.entry_condition(entry), homes)
        if excludes(known, own) or not excludes(known, conjunction((own, renamed(conjunction(noted), homes)))):
            return  # the former is reported of the name itself
    if child is not None:
        why, hint = "guard around this statement excludes", "move this to where the joint exists, or change the guard"
        if ctx.condition == TRUE:
            why, hint = "arguments of its part exclude", "leave this out, or change the arguments"
        ck.error(
            "optional-outside-when",
            joint.span,
            f"`{joint.span.words}` never exists here: the {why} `{path_root(child).span.words}`",
            hint=hint,
            notes=((child.span, "what it moves"),),
        )


def _declarations(
    ck: Checker, ctx: Context, joint: ast.Expr
) -> Iterator[tuple[Entry, tuple[tuple[str, str], ...], Condition]]:
    """The declarations that a joint of this body, or of a part of it, may be of; for those of a part with its path within and outside,
    by which guards know it, and what its arguments say."""
    if isinstance(joint, ast.NameExpr) and ctx.scope is not None:
        yield from ((entry, (), TRUE) for entry in ctx.scope.find(joint.name))
    if isinstance(joint, ast.MemberExpr) and isinstance(part := ck.types.get(id(joint.obj)), PartType):
        for symbol in (variant.symbol for variant in part.variants if variant.symbol is not None):
            for entry in ck.scope_of(symbol).table.get(joint.name, ()):
                yield entry, ((symbol.name, part.key),), part.given
