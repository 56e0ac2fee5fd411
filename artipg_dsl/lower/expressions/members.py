"""What stands after a dot: members of parts, boxes, frames, lines and elements, in the frame of the expression."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar, overload

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.program import Pose
from ...semantics.meanings import Feature, Inner
from ...source import Span
from ...syntax import ast
from ..values.carry import mapped, mapped_pose, merged, moved, united
from ..values.faces import FACES, around, corner_of, edge_of, extent, face_of, squared
from ..values.handed import Handed
from ..values.kinds import (
    Alternatives,
    Box,
    Choice,
    Edge,
    Face,
    Frame,
    InElement,
    Line,
    Look,
    Lying,
    Placed,
    Plane,
    Ports,
    Ref,
    Surface,
    Value,
    Vec,
)
from ..values.vectors import AXES, HERE, compose, inverse, place
from .context import Draft
from .env import Element, Env, Function, Hinge, pose_between
from .extents import raised

if TYPE_CHECKING:
    from ...semantics.symbols import Symbol
    from ..elaborate.part import Component
    from ..values.kinds import Carrier
    from .evaluate import Evaluator

K = TypeVar("K")


class At(Placed):
    """An element of a repeat named from outside (``post[last]``, ``previous``): values are fetched row by row."""

    __slots__ = ("element", "index", "inner")

    def __init__(self, element: Element, index: Expr | None, inner: Value):
        self.element, self.index, self.inner = element, index, inner

    def carried(self, pose: Pose) -> At:
        return At(self.element.carried(pose), self.index, self.inner)


def describe(value: Value) -> str:
    """What a value is, in words for a message."""
    match value:
        case Expr():
            return "a number"
        case Vec():
            return "a vector"
        case Frame():
            return "a face" if value.face else "a frame"
        case Plane():
            return "a plane"
        case Line():
            return "a line"
        case Box():
            return "a box"
        case Choice():
            return "a choice"
        case Look():
            return "a style of materials"
        case Alternatives():
            return "a style"
        case Ref():
            return f"the part `{value.name}`"
        case Surface():
            return "a surface"
        case Ports():
            return "an array of ports"
        case Element() | At():
            return "an element of a repeat"
        case Function():
            return "a function"
        case Handed():
            return "a path"
        case Hinge():
            return "a joint"
        case str():
            return "a text"


def own_box(ev: Evaluator) -> Box | None:
    """The template's own box in this environment's frame."""
    root = ev.env.root
    if root.box is None:
        return None
    pose = ev.env.pose_in(root)
    return root.box if pose is HERE else moved(root.box, inverse(pose))


def box_member(ev: Evaluator, box: Box, name: str) -> Value | None:
    straight = squared(box)
    if name in FACES:
        return face_of(straight, name)
    if name == "center":
        return Vec(place(straight.pose, straight.center), box.on, point=True)
    if name == "size":
        return Vec(straight.size)
    if name == "box":
        return box
    return None


def member(ev: Evaluator, value: Value, node: ast.MemberExpr) -> Value:
    """What stands after a dot, as the checker found: declared by somebody, or of the language."""
    match ev.env.context.meaning(node):
        case Inner() as meaning:
            found = inner(ev, value, meaning, node.name_span)
        case Feature(name):
            found = _feature(ev, value, name, node.name_span)
        case _:
            found = None
    if found is None and isinstance(value, Face | Edge):
        raise ev.env.context.error(
            "unknown-member",
            node.name_span,
            f"{describe(value)} has no `{node.name}`",
            hint="name it of the part itself: `part.right`, not `part.left.right`",
        )
    made = _surfaces(value) if found is None else ()
    if made:
        raise ev.env.context.error(
            "unknown-port",
            node.name_span,
            f"the solid of {describe(value)} has no surface `{node.name}`",
            hint=f"it has {', '.join(made)}",
        )
    if found is None:
        if isinstance(value, At):
            ev.env.refuse_circle(node.name, node.name_span)
        raise ev.env.context.internal(node.name_span, f"{describe(value)} has no `{node.name}`")
    return found


def _surfaces(value: Value) -> tuple[str, ...]:
    """The surfaces of a part that operators make of curves: which of them close it depends on the curves."""
    parts = [part for branch in value.branches for part, _ in branch.members] if isinstance(value, Ref) else []
    solids = [instance.solid for part in parts for instance in part.instances if instance.solid is not None]
    return solids[0].primitive.surfaces if solids else ()


def inner(ev: Evaluator, value: Value, meaning: Inner, span: Span) -> Value | None:
    """What the template of a part or the body of an element declares."""
    match value:
        case Ref():
            return declared(ev, value, meaning.name, meaning.without, span)
        case Element():
            found = within(ev, value, span).env.declared(meaning.name)
            return None if found is None else _from_env(ev, value.env, found)
        case At():
            home = type(ev)(value.element.env)
            found = inner(home, value.inner, meaning, span)
            return None if found is None else fetch(ev, value, found)
    return None


def _feature(ev: Evaluator, value: Value, name: str, span: Span) -> Value | None:
    """A member that the language gives: of a vector, a line, a frame, or of the box of what has one."""
    match value:
        case Vec():
            axis = AXES.index(name)
            return Plane(axis, value.items[axis], value.on) if value.point else value.items[axis]
        case Frame():
            return _frame_feature(value, name)
        case Line():
            return _line_feature(value, name)
        case Element(gap=gap) if name == "gap":
            within(ev, value, span)
            return None if gap is None else here(ev, value, gap)
        case At(inner=Element(gap=Box() as gap)) if name == "gap":
            return fetch(ev, value, gap)
        case Ref() if name == "size" and (size := declared(ev, value, name)) is not None:
            return size
        case Element():
            within(ev, value, span)
    box = ev.box_of(value, span)
    found = box_member(ev, box, name)
    return replace(found, on=box.on) if isinstance(value, Ref) and isinstance(found, Lying) else found


def _frame_feature(value: Frame, name: str) -> Value | None:
    match name:
        case "origin" | "center":
            return Vec(value.origin, value.on, point=True)
        case "out":
            return Vec(value.out)
        case "up":
            return Vec(value.up)
    return edge_of(value, name) if isinstance(value, Face) else None


def _line_feature(value: Line, name: str) -> Value | None:
    match name:
        case "origin" | "center":
            return Vec(value.point, value.on, point=True)
        case "along":
            return Vec(value.direction)
    return corner_of(value, name) if isinstance(value, Edge) else None


def within(ev: Evaluator, element: Element, span: Span) -> Element:
    """An element in whose repeat this stands."""
    if not ev.inside(element):
        raise ev.env.context.internal(span, f"`{element.name}` stands for all elements of a repeat here")
    return element


def here(ev: Evaluator, element: Element, box: Box) -> Box:
    """The box of an element around this environment, in this one's frame."""
    return _from_env(ev, element.env, box)


@overload
def _from_env(ev: Evaluator, env: Env, value: Box) -> Box: ...
@overload
def _from_env(ev: Evaluator, env: Env, value: Value) -> Value: ...
def _from_env(ev: Evaluator, env: Env, value: Value) -> Value:
    """A value of an environment around this one, in this one's frame."""
    return moved(moved(value, pose_between(env, ev.env)), ev.pose)


@overload
def fetch(ev: Evaluator, at: At, inner: Expr) -> Expr: ...
@overload
def fetch(ev: Evaluator, at: At, inner: Box) -> Box: ...
@overload
def fetch(ev: Evaluator, at: At, inner: Value) -> Value: ...
def fetch(ev: Evaluator, at: At, inner: Value) -> Value:
    """A value of an element's rows in this environment's table, in the frame of the expression that names the element."""
    if isinstance(inner, Ref | Element | At):
        return At(at.element, at.index, inner)
    scope, index = at.element.scope, at.index
    if isinstance(inner, Lying):
        inner = replace(inner, on=in_element(at, inner.on, ev.env.scope))

    def there(e: Expr) -> Expr:
        if index is None:
            return E.previous(scope, e, E.ZERO) if e.scope is not None else e
        return E.element(scope, e, index) if _deep(e, scope) else e

    value = moved(mapped(inner, there), mapped_pose(at.element.env.frame, there))
    return moved(value if index is None else lift(ev, value, scope.parent), at.element.seen)


def in_element(at: At, on: tuple[Carrier, ...], scope: Scope) -> tuple[Carrier, ...]:
    """Parts that a value of an element lies on, as they are named from the rows of ``scope``."""
    repeat = at.element.scope
    inside = ((p, p.scope if isinstance(p, InElement) else p.env.scope) for p in on)
    return tuple(InElement(p, scope, repeat, at.index) if home.within(repeat) else p for p, home in inside)


@overload
def lift(ev: Evaluator, value: Box, scope: Scope | None) -> Box: ...
@overload
def lift(ev: Evaluator, value: Value, scope: Scope | None) -> Value: ...
def lift(ev: Evaluator, value: Value, scope: Scope | None) -> Value:
    """A value of the rows of ``scope`` in this environment's table: as it is, or by the one row that exists."""
    while scope is not None and not ev.env.scope.within(scope):
        if scope.kind != "guard" or scope.parent is None:
            break
        value = merged(scope.parent, [(scope, value)])
        scope = scope.parent
    return value


def declared(
    ev: Evaluator, ref: Ref, name: str, without: frozenset[Symbol] = frozenset(), span: Span | None = None
) -> Value | None:
    """What the templates of a reference declare under a name: of whichever alternative exists, ``without`` some."""
    results: list[tuple[Scope | None, Value]] = []
    for branch in ref.branches:
        if len(branch.members) != 1:
            continue
        part, outer = branch.members[0]
        found = part.member(name, ref.own, without, span)
        if found is not None:
            results.append((branch.scope, moved(found, outer)))
    if not results or name == "size" and len(results) < len(ref.branches):
        return None
    return moved(_joined(ev, name, results, span), ref.frame)


def _joined(ev: Evaluator, name: str, results: list[tuple[Scope | None, Value]], span: Span | None) -> Value:
    """One value out of those of alternatives, in this environment's table."""
    if len(results) == 1 and isinstance(ref := results[0][1], Ref):  # with a frame of its own, still to be carried
        return replace(ref, branches=tuple(replace(b, scope=b.scope or results[0][0]) for b in ref.branches))
    if (whole := united(name, results)) is not None:
        return whole
    if len(results) == 1:
        return lift(ev, results[0][1], results[0][0])
    refuse_repeats(ev.env.context, name, (value for _, value in results), span)
    parent, values = parted(results)
    return lift(ev, merged(parent, values), parent)


def refuse_repeats(context: Draft, name: str, values: Iterable[Value], span: Span | None) -> None:
    """Refuse to name the repeats of several alternatives as one: each has a table of its own."""
    if span is not None and any(isinstance(value, Placed) for value in values):
        raise context.error(
            "many-elements",
            span,
            f"`{name}` is a different repeat in each alternative",
            hint="name it under `when PART is TEMPLATE { }`, or let each template provide what is read: `out` and `let`",
        )


def parted(values: Sequence[tuple[Scope | None, K]]) -> tuple[Scope, list[tuple[Scope, K]]]:
    """Values of alternatives, each in its own table, and the table that they part."""
    own = [(scope, value) for scope, value in values if scope is not None]
    parent = own[0][0].parent
    assert parent is not None and len(own) == len(values)
    return parent, own


def ref_box(ev: Evaluator, ref: Ref) -> Box:
    """The box of what a reference names, in the frame of the environment that names it."""
    return moved(_branch_box(ev, ref), ref.frame)


def _branch_box(ev: Evaluator, ref: Ref) -> Box:
    """The box of what a reference names; for several parts, the axis-aligned box around them."""
    boxes: list[tuple[Scope | None, Box]] = []
    carriers: list[Component] = []
    for branch in ref.branches:
        held = [_member_box(ev, part, outer, ref.own, branch.scope) for part, outer in branch.members]
        carriers += [part for part, _ in branch.members if part not in carriers]
        if len(held) > 1:
            held = [around(held)]
        boxes.append((branch.scope, held[0]))
    on = tuple(carriers)
    if len(boxes) == 1:
        return lift(ev, replace(boxes[0][1], on=on), boxes[0][0])
    parent, values = parted(boxes)
    return lift(ev, replace(merged(parent, values), on=on), parent)


def _member_box(ev: Evaluator, part: Component, outer: Pose, own: bool, scope: Scope | None) -> Box:
    """The box of one part of a reference; over all rows where the part stands in a repeat of its template."""
    box = moved(part.box(), outer if own else compose(outer, part.pose))
    target = scope if scope is not None else ev.env.scope
    if part.env.scope.within(target) and part.env.scope is not target:
        return raised(extent(box), part.env.scope, target)
    return box


def _deep(e: Expr, scope: Scope) -> bool:
    return e.scope is not None and e.scope.within(scope)
