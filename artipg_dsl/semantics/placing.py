"""``connect`` and ``joint``: their ends, the clauses that place, and what a joint's kind takes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from ..diagnostics.suggest import any_of, did_you_mean, suggest
from ..language import DIRECTIONS, FACES, JOINTS
from ..syntax import ast
from ..syntax.walk import path_root
from ..units import UNITS
from . import foreign
from .declarations import check_range
from .fold import components, constant
from .gates import check_gate
from .guards import conjunction
from .meanings import Clearance, Declared, Word
from .mimic import check_mimic
from .types import (
    ANGLE,
    BASE,
    BOX,
    COUNT,
    DIRECTION,
    EDGE,
    FRAME,
    LENGTH,
    LINE,
    PLANE,
    POINT,
    SURFACE,
    UNKNOWN,
    Boxed,
    PartType,
    ScalarType,
    Type,
    fits,
)

if TYPE_CHECKING:
    from .checker import Checker, Context

_UNITS = {  # of what turns, and of what slides
    "damping": (("Nms/rad", "Nms"), ("Ns/m",)),
    "friction": (("Nm",), ("N",)),
    "stiffness": (("Nm/rad",), ("N/m",)),
    "effort": (("Nm",), ("N",)),
    "velocity": (("rad/s",), ("m/s",)),
}
Given = TypeVar("Given", bound="ast.Clause[Any] | None")


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
    _end(ck, node.subject, kind, "what is connected")
    _begins(ck, ctx, node.subject, kind)
    _placing(ck, ctx, node, framed=True)
    if node.to is not None and isinstance(node.subject, ast.MemberExpr):
        _mounted(ck, (node.subject, kind), (node.to.value, ck.types.get(id(node.to.value), UNKNOWN)))
    _on_face(ck, node, node.subject, kind)
    if node.to is None and node.on is None and node.in_ is None and node.between is None:
        ck.error(
            "missing-clause",
            node.span,
            "`connect` needs a target: `to`, `on`, `in` or `between`",
            hint="as in `connect lid.bottom on body.top` or `connect handle.mount to door.front`",
        )
    else:
        _idle(ck, node, None if kind == UNKNOWN else node.to is not None and isinstance(node.subject, ast.MemberExpr))


def _begins(ck: Checker, ctx: Context, expr: ast.Expr, kind: Type) -> None:
    """What is connected begins with the name of a part: the body that declares it says where it goes."""
    meaning = ck.meanings.get(id(path_root(expr)))
    entries = ctx.scope.find(meaning.name) if isinstance(meaning, Declared) and ctx.scope is not None else ()
    if kind not in (UNKNOWN, BASE) and not any(entry.kind == "part" for entry in entries):
        message = "what is connected must begin with the name of a part of this body"
        ck.error("wrong-type", expr.span, message, hint="connect a part in the body that declares it, by its own name")


def _is_place(kind: Type) -> bool:
    return isinstance(kind, Boxed) or kind in (UNKNOWN, FRAME, PLANE, EDGE, LINE, POINT, SURFACE, BASE, BOX)


def _end(ck: Checker, expr: ast.Expr, kind: Type, what: str) -> None:
    """One end of a connection: a part, or a port, face, edge or line of one."""
    if not _is_place(kind):
        ck.unfit(
            expr,
            kind,
            f"{what} must be a part or one of its ports and faces",
            hint="name a part, or a face, port, edge or line of one",
        )


def _target(ck: Checker, expr: ast.Expr, kind: Type, word: str) -> None:
    """Where something is attached: `base` has no faces, so that a joint alone can name it."""
    _end(ck, expr, kind, f"what follows `{word}`")
    if kind == BASE:
        ck.error(
            "wrong-type",
            expr.span,
            "`base` is what the template is attached to: only the parent of a joint can be it",
            hint="what stays with it is the first part of the template, or attached to that",
        )


def _mounted(ck: Checker, *ends: tuple[ast.Expr, Type]) -> None:
    """The ends of a mount: one is laid on the other, so both have directions."""
    for expr, kind in ends:
        if isinstance(kind, Boxed) or kind in (POINT, SURFACE, BOX, BASE):
            ck.unfit(
                expr,
                kind,
                "what is mounted, and on what, must be a port, a face or a line",
                hint="name a face or a port of it; to attach a whole part, name two parts",
            )


def _on_face(ck: Checker, node: ast.Attaching, expr: ast.Expr, kind: Type) -> None:
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


def _placing(ck: Checker, ctx: Context, node: ast.Attaching, framed: bool) -> None:
    """The clauses that place. ``framed``: on a face or port or in a box, whose middle `at center` means."""
    ends = ctx.but(ends=True)
    for clause in ast.present(node.to, node.on):
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


def _idle(ck: Checker, node: ast.Attaching, mounted: bool | None) -> None:
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
    aims = isinstance(node, ast.JointDecl) and _aims(node.kind)
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


# ---------------------------------------------------------------- joints


def check_joint(ck: Checker, ctx: Context, node: ast.JointDecl) -> None:
    """A joint of a template or category; one of a role has no kind."""
    if node.kind is None or node.parent is None or node.child is None:
        return
    if node.kind not in JOINTS:
        assert node.kind_span is not None
        meant = foreign.JOINTS.get(node.kind) or suggest(node.kind, JOINTS)
        ck.error(
            "unknown-joint-kind",
            node.kind_span,
            f"there is no kind of joint `{node.kind}`",
            hint=f"did you mean `{meant}`?" if meant else f"there are {', '.join(JOINTS)}",
        )
    child, ctx = subject(ck, ctx, node.child)
    _end(ck, node.child, child, "what a joint moves")
    _begins(ck, ctx, node.child, child)
    parent = ck.infer(ctx.but(ends=True), node.parent)
    _end(ck, node.parent, parent, "the parent of a joint")
    assert ctx.scope is not None
    if child == BASE:
        ck.error(
            "wrong-type",
            node.child.span,
            "`base` is what the template is attached to, so a joint cannot move it",
            hint="turn the joint around: `joint name : kind base -> part`",
        )
    if parent == BASE and ctx.scope.owner.kind == "category":
        ck.error("wrong-type", node.parent.span, "`base` only exists in a template", hint="name the root part instead")
    named = isinstance(node.parent, ast.NameExpr) and (parent == BASE or isinstance(parent, Boxed))
    aims = named and _aims(node.kind) and node.to is None and node.on is None
    _placing(ck, ctx, node, framed=not aims)
    _on_face(ck, node, node.child, child)
    if node.on is node.in_ is None and isinstance(node.child, ast.MemberExpr) and not named:
        _mounted(ck, (node.child, child), (node.parent, parent))
    ported = isinstance(node.child, ast.MemberExpr | ast.IndexExpr) and (not named or node.to is not None)
    _idle(ck, node, None if UNKNOWN in (child, parent) else ported)
    _motion(ck, ctx, node, node.kind)
    if (kind := JOINTS.get(node.kind)) is not None:
        _axis(ck, node, parent, child)
        given = {clause.word for clause in ast.clauses(node)}
        for word in (word for word in ("range", "pitch") if word in kind.needs and word not in given):
            message = f"the {node.kind} joint `{node.name}` has no {word}"
            ck.error("missing-clause", node.span, message, hint=kind.example)


def _aims(kind: str | None) -> bool:
    """Whether a joint of this kind moves about a point, not about or along an axis."""
    return kind in JOINTS and not JOINTS[kind].axis


def _taken(ck: Checker, kind: str, clause: Given) -> Given:
    """The clause, if there is one and a joint of this kind takes it; that it takes none is an error."""
    if clause is None or kind not in JOINTS or clause.word in JOINTS[kind].clauses:
        return clause
    row, hint = JOINTS[kind], None
    if row.endless and clause.word == "range":
        hint = "a joint with limits is `revolute`"
    elif clause.word == "about" and row.slides:
        hint = f"a {kind} joint slides `along` a direction"
    elif clause.word == "along" and row.turns:
        hint = "it turns `about` an edge or a line"
    else:
        takers = [name for name, other in JOINTS.items() if clause.word in other.clauses]
        hint = f"leave it out, or make it {any_of(takers)}"
    code = "bad-axis" if clause.word in ("about", "along") else "unknown-clause"
    ck.error(code, clause.span, f"a {kind} joint takes no `{clause.word}`", hint=hint)
    return None  # type: ignore[return-value]


def _motion(ck: Checker, ctx: Context, node: ast.JointDecl, kind: str) -> None:
    """The clauses that say how a joint moves, each if its kind takes it."""
    row = JOINTS.get(kind)
    slides = row is not None and row.slides
    wanted = LENGTH if slides else ANGLE
    if (interval := _taken(ck, kind, node.range)) is not None:
        motion_range(ck, ctx, interval.value, wanted if row is not None else UNKNOWN)
        first, last = (components(end, ctx.module) for end in (interval.value.low, interval.value.high))
        if len(first) == 1 and first[0] is not None and first == last:
            ck.error(
                "empty-range",
                interval.value.span,
                "the joint cannot move: both ends of its range are the same",
                hint="give it room, or attach the part by `connect`",
            )
        if row is not None and row.tilts and next(iter(components(interval.value.low, ctx.module)), None) != 0.0:
            ck.error(
                "illegal-value",
                interval.value.low.span,
                "the range of a ball joint must begin at 0",
                hint="write `range 0deg .. 30deg`: the angle by which the joint tilts to any side",
            )
    if (rest := _taken(ck, kind, node.rest)) is not None:
        ck.expect(ctx, rest.value, wanted, "the rest of the joint")
        if interval is not None:
            ends = (interval.value.low, rest.value, interval.value.high)
            low, value, high = (next(iter(components(end, ctx.module)), None) for end in ends)
            if value is not None and (low is not None and value < low or high is not None and value > high):
                text = interval.value.span.text
                ck.error(
                    "illegal-value",
                    rest.value.span,
                    f"the rest value of the joint lies outside its range {text}",
                    hint="choose a rest value in the range, or widen the range",
                )
    for axis in ast.present(_taken(ck, kind, node.about), _taken(ck, kind, node.along)):
        axis_value(ck, axis.word, axis.value, ck.infer(ctx, axis.value))
    if (mimic := _taken(ck, kind, node.mimic)) is not None:
        check_mimic(ck, ctx, mimic.value, wanted)
        if node.rest is not None:
            message = "a joint that follows another takes no `rest`"
            ck.error("unknown-clause", node.rest.span, message, hint="it rests where its leader, at rest, puts it")
    if (when := _taken(ck, kind, node.when)) is not None:
        check_gate(ck, ctx, when.value)
        if node.mimic is not None:
            message = "a joint that follows another cannot wait for one: it moves whenever its leader does"
            ck.error("bad-gate", when.span, message, hint="put `when` on the joint that leads")
    if (pitch := _taken(ck, kind, node.pitch)) is not None:
        given = ck.infer(ctx, pitch.value)
        if not isinstance(given, ScalarType) and given != UNKNOWN:
            ck.mismatch(pitch.value, given, LENGTH, "the pitch")
    if (positions := _taken(ck, kind, node.positions)) is not None:
        _positions(ck, ctx, node, positions)
    if (stiffness := _taken(ck, kind, node.stiffness)) is not None:
        _spring(ck, node, stiffness)
    for physics in (node.damping, node.friction, node.stiffness, node.effort, node.velocity):
        if (number := _taken(ck, kind, physics)) is not None:
            given = ck.infer(ctx, number.value)
            units = _UNITS[number.word][slides]
            fitting = [ScalarType(UNITS[unit][1]) for unit in units]
            if given == UNKNOWN or isinstance(given, ScalarType) and (given.zero or given in fitting):
                continue
            if isinstance(given, ScalarType):
                text = number.value.span.text
                bare = isinstance(number.value, ast.NumberExpr) and not number.value.unit
                code, hint = (
                    ("missing-unit", f"write {text}{units[0]}")
                    if bare
                    else ("wrong-dimension", f"write a number in `{units[0]}`")
                )
                ck.error(
                    code,
                    number.value.span,
                    f"the `{number.word}` of a {kind} joint must be in {any_of(units)}",
                    hint=hint,
                )
            else:
                ck.unfit(
                    number.value, given, f"`{number.word}` must be a number", hint=f"write a number in `{units[0]}`"
                )


def _positions(ck: Checker, ctx: Context, node: ast.JointDecl, positions: ast.Clause[ast.Expr]) -> None:
    """In how many places a joint catches: two at least, and of a joint that moves by itself, between ends of its own."""
    ck.expect(ctx, positions.value, COUNT, "the number of positions")
    number = constant(positions.value, ctx.module)
    if number is not None and number < 2:
        ck.error(
            "illegal-value",
            positions.value.span,
            "a joint has at least two positions",
            hint="write 2 or more, or leave `positions` out: the joint then stays anywhere in its range",
        )
    if node.mimic is not None:
        message = "a joint that follows another has no positions of its own"
        ck.error("unknown-clause", positions.span, message, hint="put `positions` on the joint that leads")


def _spring(ck: Checker, node: ast.JointDecl, stiffness: ast.Clause[ast.Expr]) -> None:
    """What a spring draws back moves by itself and stays nowhere else."""
    if node.mimic is not None:
        message = "a joint that follows another has no spring of its own"
        ck.error("unknown-clause", stiffness.span, message, hint="put `stiffness` on the joint that leads")
    elif node.positions is not None:
        message = "a joint that catches in positions stays there, so no spring draws it back"
        ck.error("unknown-clause", stiffness.span, message, hint="leave out `positions` or `stiffness`")


def motion_range(ck: Checker, ctx: Context, interval: ast.RangeExpr, wanted: Type) -> None:
    """A range of motion; either end may be ``clearance``, the high one ``clearance all``."""
    values = interval.low, interval.high
    free = [_clears(ck, ctx, v) for v in values]
    plain = [v for v, is_free in zip(values, free, strict=True) if not is_free]
    if len(plain) == 2:
        check_range(ck, ctx, interval, wanted, "an end of the range of motion")
    else:
        for value in plain:
            ck.expect(ctx, value, wanted, "an end of the range of motion")


def _clears(ck: Checker, ctx: Context, end: ast.Expr) -> bool:
    """Whether an end of a range is ``clearance``, which a program may call something else."""
    word = end.value if isinstance(end, ast.AllExpr) else end
    if not isinstance(word, ast.NameExpr) or word.name != "clearance" or ctx.scope is None or ctx.scope.find(word.name):
        return False
    ck.mean(word, Clearance())
    return True


def _edge_of(face: ast.Expr) -> str:
    """An edge of a face."""
    if not isinstance(face, ast.MemberExpr) or face.name not in FACES:
        return "`door.left.back`"
    across = "left" if face.name in ("front", "back") else "back"
    return f"`{face.span.words}.{across}`"


def axis_value(ck: Checker, word: str, value: ast.Expr, kind: Type) -> None:
    if kind in (UNKNOWN, LINE, EDGE, FRAME) or (fits(kind, DIRECTION) if word == "along" else kind == DIRECTION):
        return
    if isinstance(kind, PartType):
        hint = "name an edge or a line of it, such as `door.left.back` or `hub.axis`"
        ck.error("bad-axis", value.span, "an axis must be an edge or a line, but this is a whole part", hint=hint)
    elif kind == PLANE:
        if word == "along":
            return
        ck.error(
            "bad-axis",
            value.span,
            "an axis must be an edge or a line, but this is a plane",
            hint=f"two adjacent faces share an edge: {_edge_of(value)}",
        )
    else:
        need = "a direction" if word == "along" else "an edge or a line"
        hint = (
            "for an axis through it, write `line(at = ..., along = ...)`"
            if word == "about"
            else "write x, -y or a vector"
        )
        ck.error("bad-axis", value.span, f"an axis must be {need}, but this is {kind}", hint=hint)


def _axis(ck: Checker, node: ast.JointDecl, parent: Type, child: Type) -> None:
    """A joint that turns or slides has an axis: a clause, or the ``out`` of the port it stands on."""
    word = JOINTS[node.kind].axis if node.kind is not None else ""
    if not word or UNKNOWN in (parent, child):
        return
    clause = node.about if word == "about" else node.along
    ends = (FRAME, PLANE, LINE, EDGE, SURFACE)
    placed = any(c is not None for c in (node.to, node.on, node.in_, node.at, node.between))
    if clause is None:
        if node.about is not None or node.along is not None:
            return
        if parent not in ends and child not in ends and node.to is node.on is None:
            hint = "add `about` an edge or a line" if word == "about" else "add `along` a direction"
            ck.error("bad-axis", node.span, f"the {node.kind} joint `{node.name}` has no axis", hint=hint)
        return
    value = clause.value
    if word == "about" and ck.types.get(id(value)) == DIRECTION:
        if parent not in (*ends, POINT) and child not in (*ends, POINT) and not placed:
            ck.error(
                "bad-axis",
                value.span,
                "a direction alone is not an axis: nothing says where it lies",
                hint="write `about line(at = ..., along = ...)`",
            )
