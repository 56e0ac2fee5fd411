"""``connect``, and what ``joint`` has in common with it: ends, and the clauses that place."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..diagnostics.suggest import any_of, did_you_mean
from ..language import DIRECTIONS, FACES, JOINTS
from ..syntax import ast
from ..syntax.walk import path_root, put_together
from .guards import conjunction
from .meanings import Declared, Word
from .types import BASE, BOX, DIRECTION, EDGE, FRAME, LENGTH, LINE, PLANE, POINT, SURFACE, UNKNOWN, Boxed, Type, fits

if TYPE_CHECKING:
    from .checker import Checker, Context


def subject(ck: Checker, ctx: Context, expr: ast.Expr) -> tuple[Type, Context]:
    """What a statement goes with: without it the statement is void, so the rest may take its presence for granted."""
    noted: list[Any] = []
    kind = ck.infer(ctx.but(lenient=noted, ends=True, subject=True), expr)
    ck.subjects[id(expr)] = conjunction(noted)
    return kind, ctx.given(*noted)


def check_connect(ck: Checker, ctx: Context, node: ast.ConnectStmt) -> None:
    if isinstance(node.subject, ast.BinaryExpr) and node.subject.op in ("and", "or"):
        said = f"`{node.subject.op}` joins conditions; what is connected is one part"
        hint = "write one `connect` for each part; further faces of one follow `fit` or are equations of `align`"
        ck.error("wrong-type", node.subject.span, said, hint=hint)
        return
    kind, ctx = subject(ck, ctx, node.subject)
    check_end(ck, node.subject, kind, "what is connected")
    check_begins(ck, ctx, node.subject, kind)
    check_place(ck, ctx, node, framed=True)
    if node.to is not None and isinstance(node.subject, ast.MemberExpr):
        check_mounted(ck, (node.subject, kind), (node.to.value, ck.types.get(id(node.to.value), UNKNOWN)))
    elif node.to is not None and isinstance(node.subject, ast.NameExpr) and _is_half(ck, node.subject, node.to.value):
        return
    check_on_face(ck, node, node.subject, kind)
    if node.to is None and node.on is None and node.in_ is None and node.between is None:
        ck.error(
            "missing-clause",
            node.span,
            "`connect` needs a target: `to`, `on`, `in` or `between`",
            hint="as in `connect lid.bottom on body.top` or `connect handle.mount to door.front`",
        )
    else:
        refuse_idle(
            ck, node, None if kind == UNKNOWN else node.to is not None and isinstance(node.subject, ast.MemberExpr)
        )


def check_begins(ck: Checker, ctx: Context, expr: ast.Expr, kind: Type) -> None:
    """What is connected begins with the name of a part: the body that declares it says where it goes."""
    meaning = ck.meanings.get(id(path_root(expr)))
    entries = ctx.scope.find(meaning.name) if isinstance(meaning, Declared) and ctx.scope is not None else ()
    if kind not in (UNKNOWN, BASE) and not any(entry.kind == "part" for entry in entries):
        message = "what is connected must begin with the name of a part of this body"
        ck.error("wrong-type", expr.span, message, hint="connect a part in the body that declares it, by its own name")


def _is_place(kind: Type) -> bool:
    return isinstance(kind, Boxed) or kind in (UNKNOWN, FRAME, PLANE, EDGE, LINE, POINT, SURFACE, BASE, BOX)


def check_end(ck: Checker, expr: ast.Expr, kind: Type, what: str) -> None:
    """One end of a connection: a part, or a port, face, edge or line of one."""
    if not _is_place(kind):
        ck.unfit(
            expr,
            kind,
            f"{what} must be a part or one of its ports and faces",
            hint="name a part, or a face, port, edge or line of one",
        )


def _several(ck: Checker, ctx: Context, expr: ast.Expr, word: str) -> bool:
    """Whether ``body.top and post.top`` or ``[body.top, post.top]`` stands where one place does, which is reported."""
    named = put_together(expr)
    if not named:
        return False
    if isinstance(expr, ast.VectorExpr):
        with ck.muted():
            kinds = [ck.infer(ctx, item) for item in named]
        faces = (PLANE,) if word == "on" or len(named) != 3 else ()  # three planes are a point
        if not any(isinstance(kind, Boxed) or kind in (FRAME, EDGE, LINE, SURFACE, *faces) for kind in kinds):
            return False
    ck.error(
        "wrong-type",
        expr.span,
        f"a part is attached once: one place follows `{word}`",
        hint=f"write `{word} {named[0].span.words}`; where else it is, say with `at`, `fit` or `align`",
    )
    return True


def _target(ck: Checker, expr: ast.Expr, kind: Type, word: str) -> None:
    """Where something is attached: `base` has no faces, so that a joint alone can name it."""
    check_end(ck, expr, kind, f"what follows `{word}`")
    if kind == BASE:
        ck.error(
            "wrong-type",
            expr.span,
            "`base` is what the template is attached to: only the parent of a joint can be it",
            hint="what stays with it is the first part of the template, or attached to that",
        )


def check_mounted(ck: Checker, *ends: tuple[ast.Expr, Type]) -> None:
    """The ends of a mount: one is laid on the other, so both have directions."""
    for expr, kind in ends:
        if isinstance(kind, Boxed) or kind in (POINT, SURFACE, BOX, BASE):
            ck.unfit(
                expr,
                kind,
                "what is mounted, and on what, must be a port, a face or a line",
                hint="name a face or a port of it; to attach a whole part, name two parts",
            )


def _is_half(ck: Checker, part: ast.NameExpr, target: ast.Expr) -> bool:
    """Whether a whole part is attached to a place, where it would not be placed, which is reported: two parts are attached, or two
    places mounted."""
    kind = ck.types.get(id(target), UNKNOWN)
    if kind not in (FRAME, PLANE, EDGE, LINE, POINT, SURFACE, BOX):
        return False
    root, words = path_root(target).span.words, target.span.words
    if kind == BOX:
        meant = f"write `connect {part.name} in {words}`"
    elif kind == POINT:
        meant = f"write `connect {part.name} to {root}` and `align {part.name}.center = {words}`"
    else:
        word = "on" if kind == PLANE else "to"
        meant = f"name a face or a port of it, too, as in `connect {part.name}.bottom {word} {words}`"
    only = f"; to attach it alone, write `connect {part.name} to {root}`" if isinstance(target, ast.MemberExpr) else ""
    message = f"`{part.name}` is a whole part: `to` attaches it to another part and does not place it"
    ck.unfit(target, kind, message, hint=f"to place it there, {meant}{only}")
    return True


def check_on_face(ck: Checker, node: ast.Attaching, expr: ast.Expr, kind: Type) -> None:
    """``on`` equates two planes; ``fit`` with it reads the box whose face is named."""
    if node.on is None:
        return
    target = node.on.value
    for end, found, face in ((expr, kind, "bottom"), (target, ck.types.get(id(target), UNKNOWN), "top")):
        if _is_place(found) and found not in (PLANE, FRAME, UNKNOWN):
            boxed = isinstance(found, Boxed) or found == BOX
            hint = f"name one of its faces, as in `{end.span.words}.{face}`" if boxed else "name a face or a port"
            ck.unfit(end, found, "`on` lays a face on a face", hint=hint)
    if node.fit is not None and not (isinstance(target, ast.MemberExpr | ast.NameExpr) and target.name in FACES):
        ck.error(
            "wrong-type",
            node.fit.span,
            "`fit` needs a face of a box behind `on`, as in `on body.front fit left`",
            hint="name the part's face, or place the sides with `align`",
        )


def check_place(ck: Checker, ctx: Context, node: ast.Attaching, framed: bool) -> None:
    """The clauses that place. ``framed``: on a face or port or in a box, whose middle `at center` means."""
    ends = ctx.but(ends=True)
    for clause in ast.present(node.to, node.on):
        if _several(ck, ends, clause.value, clause.word):
            continue
        _target(ck, clause.value, ck.infer(ends, clause.value), clause.word)
    for value in ast.value_of(node.between) or ():
        kind = ck.infer(ends, value)
        _target(ck, value, POINT if fits(kind, POINT) else kind, "between")
    if node.in_ is not None:
        kind = ck.infer(ends, node.in_.value)
        if not isinstance(kind, Boxed) and kind not in (BOX, UNKNOWN):
            ck.unfit(
                node.in_.value,
                kind,
                "`in` needs a box",
                hint="name a part, or a port that is a box, such as `body.inner`",
            )
    for clause in ast.present(node.gap, node.sink):
        ck.expect(ctx, clause.value, LENGTH, f"the `{clause.word}`")
    if node.facing is not None:
        ck.expect(ctx, node.facing.value, DIRECTION, "what follows `facing`")
    for value in ast.value_of(node.fit) or ():
        if not isinstance(value, ast.NameExpr) or value.name not in FACES:
            near = did_you_mean(value.name, FACES) if isinstance(value, ast.NameExpr) else None
            near = "separate them by commas: `fit left, right`" if isinstance(value, ast.BinaryExpr) else near
            ck.error(
                "wrong-type", value.span, "`fit` takes the names of faces", hint=near or f"there are {', '.join(FACES)}"
            )
    for argument in ast.value_of(node.at) or ():
        _at(ck, ctx, argument.name, argument.value, framed)
        if node.in_ is not None and node.fit is None and isinstance(ck.meanings.get(id(argument.value)), Word):
            ck.error(
                "unknown-clause",
                argument.value.span,
                "`at center` has no effect here: `in` without `fit` fits all six faces",
                hint="name the faces to fit, as in `connect cup in tray fit bottom at center`",
            )


_WITH = {
    "at": ("to", "on", "in"),
    "fit": ("on", "in"),
    "gap": ("to", "on", "in", "between"),
    "sink": ("to", "on", "between"),
    "facing": ("between",),
}
"""The clauses that say more of a place, and what each goes with."""


def refuse_idle(ck: Checker, node: ast.Attaching, mounted: bool | None) -> None:
    """Refuse clauses that would say nothing. ``mounted``: a port or face stands on another; None where that is not known."""
    ways = sorted((c for c in (node.to, node.on, node.in_, node.between) if c is not None), key=lambda c: c.span.start)
    for extra in ways[1:]:
        message = f"`{ways[0].word}` and `{extra.word}` both say where this goes"
        ck.error("unknown-clause", extra.span, message, hint="keep only one")
    if node.turned is not None:
        hint = "turn a part where it is declared: `part handle : BarHandle turned 20deg about x`"
        ck.error("unknown-clause", node.turned.span, "a part cannot be turned where it is connected", hint=hint)
    if isinstance(node, ast.JointDecl) and node.to is not None and mounted is False:
        hint = f"name a port or a face of the part: `joint {node.name} : {node.kind} base -> leaf.hinge to frame.side`"
        ck.error("unknown-clause", node.to.span, "`to` has no effect here: a whole part is not placed by it", hint=hint)
    way = ways[0].word if ways and (ways[0] is not node.to or mounted) else "to" if mounted else ""
    aims = isinstance(node, ast.JointDecl) and aims_at_point(node.kind)
    for clause in (node.at, node.fit, node.gap, node.sink, node.facing):
        if clause is None or mounted is None or way in _WITH[clause.word] or clause is node.at and not way and aims:
            continue
        if way or clause is node.facing or clause is node.fit:
            ck.error(
                "unknown-clause",
                clause.span,
                f"`{clause.word}` goes with {any_of(_WITH[clause.word])}",
                hint="leave it out, or place the part by " + any_of(_WITH[clause.word]),
            )
        else:
            ck.error(
                "unknown-clause",
                clause.span,
                f"`{clause.word}` has no effect here: attaching a whole part does not place it",
                hint="name a face or a port of the part, as in `connect lid.bottom on body.top`, or place it with `align`",
            )


def _at(ck: Checker, ctx: Context, name: str | None, value: ast.Expr, framed: bool) -> None:
    if name in DIRECTIONS:
        ck.expect(ctx, value, LENGTH, f"the coordinate `{name}`")
    elif name in ("u", "v"):
        ck.infer(ctx, value)
    elif name:
        ck.error(
            "unknown-argument",
            value.span,
            f"`at` takes coordinates x, y and z, not `{name}`",
            hint=did_you_mean(name, DIRECTIONS) or "write `at x = ..., z = ...`, or `at center`",
        )
    elif framed and isinstance(value, ast.NameExpr) and value.name == "center":
        ck.mean(value, Word("center"))
    else:
        kind = ck.infer(ctx, value)
        if kind not in (UNKNOWN, FRAME, EDGE, LINE, PLANE) and not fits(kind, POINT):
            ck.unfit(value, kind, "`at` needs `center`, coordinates or a point", hint="write `at y = ..., z = ...`")


def aims_at_point(kind: str | None) -> bool:
    """Whether a joint of this kind moves about a point, not about or along an axis."""
    return kind in JOINTS and not JOINTS[kind].axis
