"""``joint``: what its kind takes, how it moves, and about or along what."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

from ..diagnostics.suggest import any_of, suggest
from ..language import FACES, JOINTS, Kind
from ..syntax import ast
from ..syntax.walk import walk
from ..units import UNITS
from . import foreign, placing
from .declarations import check_range
from .fold import components, constant
from .gates import check_gate
from .meanings import Clearance
from .mimic import check_mimic
from .types import (
    ANGLE,
    BASE,
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

_MANY_DEGREES = 720.0
_UNITS = {  # of what turns, and of what slides
    "damping": (("Nms/rad", "Nms"), ("Ns/m",)),
    "friction": (("Nm",), ("N",)),
    "stiffness": (("Nm/rad",), ("N/m",)),
    "effort": (("Nm",), ("N",)),
    "velocity": (("rad/s",), ("m/s",)),
}
Given = TypeVar("Given", bound="ast.Clause[Any] | None")


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
    child, ctx = placing.subject(ck, ctx, node.child)
    placing.check_end(ck, node.child, child, "what a joint moves")
    placing.check_begins(ck, ctx, node.child, child)
    parent = ck.infer(ctx.but(ends=True), node.parent)
    placing.check_end(ck, node.parent, parent, "the parent of a joint")
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
    aims = named and placing.aims_at_point(node.kind) and node.to is None and node.on is None
    placing.check_place(ck, ctx, node, framed=not aims)
    placing.check_on_face(ck, node, node.child, child)
    if node.on is node.in_ is None and isinstance(node.child, ast.MemberExpr) and not named:
        placing.check_mounted(ck, (node.child, child), (node.parent, parent))
    ported = isinstance(node.child, ast.MemberExpr | ast.IndexExpr) and (not named or node.to is not None)
    placing.refuse_idle(ck, node, None if UNKNOWN in (child, parent) else ported)
    _motion(ck, ctx, node, node.kind)
    if (kind := JOINTS.get(node.kind)) is not None:
        _axis(ck, node, parent, child)
        given = {clause.word for clause in ast.clauses(node)}
        for word in (word for word in ("range", "pitch") if word in kind.needs and word not in given):
            message = f"the {node.kind} joint `{node.name}` has no {word}"
            ck.error("missing-clause", node.span, message, hint=kind.example)


def _taken(ck: Checker, kind: str, clause: Given) -> Given:
    """The clause, if there is one and a joint of this kind takes it; that it takes none is an error."""
    if clause is None or kind not in JOINTS or clause.word in JOINTS[kind].clauses:
        return clause
    row, hint = JOINTS[kind], None
    if row.endless and clause.word == "range":
        hint = "a joint with limits is `revolute`"
    elif clause.word == "about" and row.slides:
        hint = f"a {kind} joint slides `along` a direction"
    elif clause.word == "about" and row.tilts:
        hint = "it tilts about a point: write `at` and the point, or name a port: `rod.top -> cap.bottom`"
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
        _range(ck, ctx, interval.value, wanted, row)
    if (rest := _taken(ck, kind, node.rest)) is not None:
        fitting = fits(ck.expect(ctx, rest.value, wanted, "the rest of the joint"), wanted)
        if interval is not None and fitting:
            _rest(ck, ctx, rest.value, interval.value)
    for axis in ast.present(_taken(ck, kind, node.about), _taken(ck, kind, node.along)):
        axis_value(ck, axis.word, axis.value, ck.infer(ctx, axis.value))
    if (mimic := _taken(ck, kind, node.mimic)) is not None:
        check_mimic(ck, ctx, node.name, mimic.value, wanted)
        if node.rest is not None and not _of_previous(mimic.value):  # whose first element leads
            message = "a joint that follows another takes no `rest`"
            ck.error("unknown-clause", node.rest.span, message, hint="it rests where its leader, at rest, puts it")
    if (when := _taken(ck, kind, node.when)) is not None:
        check_gate(ck, ctx, when.value)
        if node.mimic is not None:
            message = "a joint that follows another cannot wait for one: it moves whenever its leader does"
            ck.error("bad-gate", when.span, message, hint="put `when` on the joint that leads")
    if (pitch := _taken(ck, kind, node.pitch)) is not None:
        ck.expect(ctx, pitch.value, LENGTH, "the pitch")
    if (positions := _taken(ck, kind, node.positions)) is not None:
        _positions(ck, ctx, node, positions)
    if (stiffness := _taken(ck, kind, node.stiffness)) is not None:
        _spring(ck, node, stiffness)
    for physics in (node.damping, node.friction, node.stiffness, node.effort, node.velocity):
        if (number := _taken(ck, kind, physics)) is not None:
            given = ck.infer(ctx, number.value)
            if row is not None and given != UNKNOWN:
                _physics(ck, number, given, kind, _UNITS[number.word][slides])


def _of_previous(mimic: ast.Expr) -> bool:
    """Whether a joint of a repeat follows that of the element before."""
    return any(isinstance(node, ast.NameExpr) and node.name == "previous" for node in walk(mimic))


def _range(ck: Checker, ctx: Context, interval: ast.RangeExpr, wanted: Type, row: Kind | None) -> None:
    """The range of a joint, whose kind is None if there is no such kind."""
    motion_range(ck, ctx, interval, wanted if row is not None else UNKNOWN)
    first, last = (components(end, ctx.module) for end in (interval.low, interval.high))
    if len(first) == 1 and first[0] is not None and first == last:
        ck.error(
            "empty-range",
            interval.span,
            "the joint cannot move: both ends of its range are the same",
            hint="give it room, or attach the part by `connect`",
        )
    if row is not None and row.tilts and next(iter(first), None) != 0.0:
        ck.error(
            "illegal-value",
            interval.low.span,
            "the range of a ball joint must begin at 0",
            hint="write `range 0deg .. 30deg`: the angle by which the joint tilts to any side",
        )


def _rest(ck: Checker, ctx: Context, rest: ast.Expr, interval: ast.RangeExpr) -> None:
    """A joint rests in its range, as far as both are known."""
    ends = (interval.low, rest, interval.high)
    low, value, high = (next(iter(components(end, ctx.module)), None) for end in ends)
    if low is not None and high is not None and low > high:
        return  # which is told already
    if value is not None and (low is not None and value < low or high is not None and value > high):
        ck.error(
            "illegal-value",
            rest.span,
            f"the rest value of the joint lies outside its range {interval.span.text}",
            hint="choose a rest value in the range, or widen the range",
        )


def _physics(ck: Checker, number: ast.Clause[ast.Expr], given: Type, kind: str, units: tuple[str, ...]) -> None:
    """A number in one of the units that a clause takes of such a joint."""
    if not isinstance(given, ScalarType):
        hint = f"write a number in `{units[0]}`"
        ck.unfit(number.value, given, f"`{number.word}` must be a number", hint=hint)
        return
    if given.zero or given in [ScalarType(UNITS[unit][1]) for unit in units]:
        return
    bare = isinstance(number.value, ast.NumberExpr) and not number.value.unit
    code, hint = "wrong-dimension", f"write a number in `{units[0]}`"
    if bare:
        code, hint = "missing-unit", f"write {number.value.span.text}{units[0]}"
    message = f"the `{number.word}` of a {kind} joint must be in {any_of(units)}"
    ck.error(code, number.value.span, message, hint=hint)


def _positions(ck: Checker, ctx: Context, node: ast.JointDecl, positions: ast.Clause[ast.Expr]) -> None:
    """In how many places a joint catches: two at least, and of a joint that moves by itself, between ends of its own."""
    fitting = fits(ck.expect(ctx, positions.value, COUNT, "the number of positions"), COUNT)
    number = constant(positions.value, ctx.module) if fitting else None
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
    for value in plain if wanted == ANGLE else ():
        for number in (node for node in walk(value) if isinstance(node, ast.NumberExpr) and node.unit == "deg"):
            if number.value > _MANY_DEGREES:
                ck.warning(
                    "far-motion",
                    number.span,
                    f"{number.span.text} are more than two turns",
                    hint=f"is the unit right? What turns many times is measured in turns: {number.value / 360:.3g}turn",
                )
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
    """What a joint turns ``about`` or slides ``along``."""
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
