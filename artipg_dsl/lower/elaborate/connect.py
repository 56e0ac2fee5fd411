"""Statements that place and attach: ``align``, ``connect``, ``joint``; and those that are noted for the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Scope
from ...graph.primitive import Triple
from ...records import dataclass
from ...semantics.guards import TRUE
from ...semantics.meanings import Base, Word
from ...source import Span
from ...syntax import ast
from ..expressions.context import Equation
from ..expressions.env import Element, Env
from ..expressions.evaluate import Evaluator
from ..expressions.members import At, in_element
from ..values.faces import FACES, face_of, squared
from ..values.kinds import Box, Frame, Plane, Ref, Value, Vec, carriers_of
from ..values.vectors import AXES, place, sole_axis
from .absence import presence
from .place import begins

if TYPE_CHECKING:
    from ..values.kinds import Carrier
    from .part import Component


@dataclass(slots=True, eq=False)
class Attachment:
    """How a part hangs on the rest: ``to`` are the parts (or None: the base) whose link carries it."""

    env: Env
    span: Span
    to: tuple[Carrier, ...]
    base: bool
    joint: ast.JointDecl | None = None


def statements(env: Env) -> None:
    """Process the statements of an environment and of those inside it."""
    for part in env.parts:
        with env.context.attempt(part.span):
            _ = part.pose
    for statement in env.statements:
        stated = len(env.equations)
        with env.context.attempt(statement.span):
            match statement:
                case ast.AlignStmt():
                    align(env, statement)
                case ast.ConnectStmt():
                    _goes_with(connect(env, statement), env.equations[stated:])
                case ast.JointDecl() if statement.kind is not None:
                    _goes_with(joint(env, statement), env.equations[stated:])
                case _:
                    pass
    for inner in env.inner:
        statements(inner)


def _goes_with(part: Component, equations: list[Equation]) -> None:
    """A statement goes with its subject: its equations hold where the part exists."""
    for equation in equations:
        equation.guard = E.both(equation.guard, part.exists)


def align(env: Env, statement: ast.AlignStmt) -> None:
    ev, stated = Evaluator(env), len(env.equations)
    for start in ast.value_of(statement.near) or ():
        _equate(ev, ev.value(start.left), ev.value(start.right), start.left.span, start.right.span, statement.span)
    starts = tuple((q.left, q.right) for q in env.equations[stated:])
    del env.equations[stated:]
    left, right = statement.left, statement.right
    _equate(ev, ev.value(left), ev.value(right), left.span, right.span, statement.span)
    ensured = env.context.typed.checker.subjects[id(left)] == TRUE  # by the guards around it
    there = E.TRUE if ensured else presence(env, left)
    for equation in env.equations[stated:]:
        equation.near, equation.guard = starts, E.both(equation.guard, there)
    if statement.near is not None:
        env.context.near.setdefault(statement.span, False)


def _equate(ev: Evaluator, a: Value, b: Value, left: Span, right: Span, span: Span) -> None:
    """One equation for planes and scalars, three for points."""
    if isinstance(a, Vec) and isinstance(b, Vec):
        for x, y in zip(a.items, b.items, strict=True):
            ev.env.equations.append(Equation(x, y, span, span.words))
        return
    if isinstance(a, Vec) or isinstance(b, Vec):
        raise ev.impossible(left if isinstance(b, Vec) else right, "a point", a if isinstance(b, Vec) else b)
    pa = ev.plane(a, left) if isinstance(a, Frame | Plane) else None
    pb = ev.plane(b, right) if isinstance(b, Frame | Plane) else None
    if pa is not None and pb is not None and pa.axis != pb.axis:
        raise ev.across(span, pa, pb, left, right)
    x = pa.coordinate if pa is not None else ev.number(a, left)
    y = pb.coordinate if pb is not None else ev.number(b, right)
    ev.env.equations.append(Equation(x, y, span, span.words))


def placing(env: Env, part: Component, subject: ast.Expr, statement: ast.Attaching) -> Value | None:
    """Equations of ``on``, ``in``, ``fit`` and ``at``; returns what the part is placed on, for its link."""
    ev = Evaluator(env)
    on, within, fit = statement.on, statement.in_, statement.fit
    gap = ev.scalar(statement.gap.value) if statement.gap is not None else E.ZERO
    target: Value | None = None
    if on is not None:
        target = ev.value(on.value)
        if statement.sink is not None:
            gap = E.sub(gap, ev.scalar(statement.sink.value))
        _on_plane(ev, subject, on.value, target, gap, on.span)
    elif within is not None:
        box = squared(ev.box(within.value))
        target = box
        own = named_box(ev, part, subject.span)
        for name in FACES if fit is None else _face_names(fit):
            _match_faces(ev, own, box, name, within.span, gap)
    if fit is not None and within is None:
        assert on is not None
        owner = _target_box(ev, on.value, fit.span)
        own = named_box(ev, part, subject.span)
        for name in _face_names(fit):
            _match_faces(ev, own, owner, name, fit.span, E.ZERO)
    mounted = statement.to is not None or statement.between is not None
    if statement.at is not None and not mounted and (on is not None or within is not None):
        fitted = {FACES[name][0] for name in _face_names(fit)} if fit is not None else set()
        _at_point(ev, subject, statement.at.value, target, fitted)
    return target


def named_box(ev: Evaluator, part: Component, span: Span) -> Box:
    """The box of what the name of a part stands for in an environment."""
    found = ev.env.find(part.name, part.env.depth)
    if found is None:
        raise ev.env.context.internal(span, f"`{part.name}` has no value here")
    return ev.box_of(found, span)


def _face_names(clause: ast.Clause[tuple[ast.Expr, ...]]) -> tuple[str, ...]:
    return tuple(v.name for v in clause.value if isinstance(v, ast.NameExpr) and v.name in FACES)


def _on_plane(ev: Evaluator, subject: ast.Expr, node: ast.Expr, target: Value, gap: E.Expr, span: Span) -> None:
    own = ev.value(subject)
    if not isinstance(target, Frame | Plane) or not isinstance(own, Frame | Plane):
        fine = isinstance(target, Frame | Plane)
        raise ev.impossible(subject.span if fine else node.span, "a face", own if fine else target)
    a, b = ev.plane(own, subject.span), ev.plane(target, node.span)
    if a.axis != b.axis:
        raise ev.across(span, a, b, subject.span, node.span)
    ev.env.equations.append(Equation(a.coordinate, E.add(b.coordinate, E.mul(gap, b.side)), span, span.words))


def _target_box(ev: Evaluator, node: ast.Expr, span: Span) -> Box:
    """The box whose face ``on`` names: ``body.bottom`` is a face of ``body``."""
    if isinstance(node, ast.MemberExpr) and node.name in FACES:
        return squared(ev.box(node.obj))
    if isinstance(node, ast.NameExpr) and node.name in FACES and (own := ev.own_box()) is not None:
        return squared(own)
    raise ev.env.context.internal(span, "`fit` has no face to read a box from")


def _match_faces(ev: Evaluator, own: Box, other: Box, name: str, span: Span, gap: E.Expr) -> None:
    a, b = (ev.plane(face_of(squared(box), name), span).coordinate for box in (own, other))
    right = E.sub(b, gap) if FACES[name][1] > 0 else E.add(b, gap)
    ev.env.equations.append(Equation(a, right, span, f"fit {name}"))


def _middle_of(box: Box) -> Triple:
    """The centre of a box in the frame of the statement."""
    return place(box.pose, box.center)


def _at_point(
    ev: Evaluator, subject: ast.Expr, places: tuple[ast.Argument, ...], target: Value | None, fitted: set[int]
) -> None:
    """``at center`` equates the two other coordinates of the centres, in a box those along which no face is ``fitted``;
    ``at y = ...`` one coordinate each.
    """
    own = ev.value(subject)
    origin = own.origin if isinstance(own, Frame) else _middle_of(ev.box(subject))
    normal = sole_axis(own.out) if isinstance(own, Frame) else None
    for argument in places:
        name, node = argument.name, argument.value
        if name in AXES:
            k = AXES.index(name)
            ev.env.equations.append(Equation(origin[k], ev.scalar(node), node.span, f"at {name}"))
        else:
            middle = isinstance(ev.env.context.meaning(node), Word)
            boxed = middle and isinstance(target, Box)
            if middle and isinstance(target, Box):
                other = _middle_of(target)
            else:
                other = target.origin if middle and isinstance(target, Frame) else ev.vector(node)
            for k in range(3):
                if k != normal and not (boxed and k in fitted):
                    ev.env.equations.append(Equation(origin[k], other[k], node.span, f"at {AXES[k]}"))


# ---------------------------------------------------------------- attachments


def connect(env: Env, statement: ast.ConnectStmt) -> Component:
    part = part_of(env, statement.subject)
    ev = Evaluator(env)
    with env.context.going_with(part.exists):
        if statement.between is not None:
            target: Value | None = ev.value(statement.between.value[0])
        elif statement.to is not None:
            target = ev.value(statement.to.value)
        else:
            target = placing(env, part, statement.subject, statement)
    carried = () if target is None else carriers(target, env.scope)
    part.attachments.append(Attachment(env, statement.span, carried, base=not carried))
    return part


def joint(env: Env, statement: ast.JointDecl) -> Component:
    assert statement.child is not None and statement.parent is not None
    part = part_of(env, statement.child)
    base = isinstance(env.context.meaning(statement.parent), Base)
    with env.context.going_with(part.exists):
        placing(env, part, statement.child, statement)
        carried = () if base else carriers(Evaluator(env).value(statement.parent), env.scope)
    part.attachments.append(Attachment(env, statement.span, carried, base=not carried, joint=statement))
    return part


def part_of(env: Env, node: ast.Expr) -> Component:
    """The part that a path begins with."""
    meaning = begins(env, node)
    value = env.find(meaning.name, meaning.depth) if meaning is not None else None
    if not isinstance(value, Ref):
        raise env.context.internal(node.span, "no part begins this path")
    return value.branches[0].members[0][0]


def carriers(value: Value, scope: Scope) -> tuple[Carrier, ...]:
    """The parts on which a value lies that is named from the rows of ``scope``."""
    if isinstance(value, At):
        return in_element(value, carriers(value.inner, value.element.scope), scope)
    if isinstance(value, Ref):
        return tuple(p for b in value.branches for p, _ in b.members)
    if isinstance(value, Element):
        return () if value.box is None else value.box.on
    return tuple(dict.fromkeys(carriers_of(value)))
