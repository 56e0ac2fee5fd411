"""Expressions of the text to values, in the frame and the table of one environment."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from ..graph import expr as E
from ..graph.expr import Expr, Scope, ScopeError
from ..graph.program import Pose
from ..semantics.units import UNITS
from ..source import Span
from ..syntax import ast
from . import builtins
from .context import text_of
from .env import Element, Env, Function
from .values import (
    AXES,
    FACES,
    HERE,
    Box,
    Choice,
    Edge,
    Face,
    Frame,
    Line,
    Plane,
    Ports,
    Ref,
    Surface,
    Value,
    Vec,
    baked,
    compose,
    corner_of,
    edge_of,
    extent,
    face_of,
    mapped,
    merged,
    minus,
    moved,
    place,
    sole_axis,
    squared,
    times,
    unit,
)
from .values import plus as vector_plus

if TYPE_CHECKING:
    from .part import Part

HALF = E.const(0.5)
OPERATIONS = {"+": E.add, "-": E.sub, "*": E.mul, "/": E.div, "^": E.power, "and": E.both, "or": E.either}


class At:
    """An element of a repeat named from outside (``post[last]``, ``previous``): values are fetched row by row."""

    __slots__ = ("element", "index", "inner")

    def __init__(self, element: Element, index: Expr | None, inner: Value):
        self.element, self.index, self.inner = element, index, inner


class Evaluator:
    """Evaluates in ``env``; ``local`` holds names that outrank everything (formula variables, function arguments)."""

    def __init__(self, env: Env, local: dict[str, Value] | None = None, pose: Pose = HERE):
        self.env = env
        self.local = local or {}
        self.pose = pose  # carries values of the environment into the frame of a formula (labels, grasps)

    # ------------------------------------------------------------ entry points by expected kind

    def scalar(self, node: ast.Expr) -> Expr:
        value = self.value(node)
        if isinstance(value, Choice):
            return value.code
        if isinstance(value, Plane):
            return value.coordinate
        if isinstance(value, Frame) and value.face:
            return self.plane(value, node.span).coordinate
        if isinstance(value, Box):
            return value.exists
        if not isinstance(value, Expr):
            raise self.wrong(node.span, "a number", value)
        return value

    def vector(self, node: ast.Expr) -> tuple[Expr, Expr, Expr]:
        """A point or direction as three scalars."""
        value = self.value(node)
        if isinstance(value, Frame):
            return value.origin
        if isinstance(value, Vec) and len(value.items) == 3:
            return value.items  # type: ignore[return-value]
        raise self.wrong(node.span, "a point or a vector of three", value)

    def direction(self, node: ast.Expr) -> tuple[Expr, Expr, Expr]:
        value = self.value(node)
        if isinstance(value, Frame):
            return value.out
        if isinstance(value, Line):
            return value.direction
        if isinstance(value, Vec) and len(value.items) == 3:
            return value.items  # type: ignore[return-value]
        raise self.wrong(node.span, "a direction such as x or -z", value)

    def frame(self, node: ast.Expr) -> Frame:
        value = self.value(node)
        if isinstance(value, Frame):
            return value
        raise self.wrong(node.span, "a frame (a port or a face)", value)

    def box(self, node: ast.Expr) -> Box:
        value = self.value(node)
        if isinstance(value, Ref):
            value = self.ref_box(value, node.span)
        if isinstance(value, Element) and value.box is not None:
            value = value.box
        if isinstance(value, Box):
            return value
        raise self.wrong(node.span, "a box", value)

    def wrong(self, span: Span, expected: str, value: Value) -> Exception:
        return self.env.context.error("wrong-kind", span, f"this is {describe(value)}, but {expected} is needed here")

    def plane(self, value: Frame | Plane, span: Span) -> Plane:
        """The coordinate plane of a face, in this environment's frame."""
        if isinstance(value, Plane):
            if value.axis is None:
                raise self.tilted(span)
            return value
        axis = sole_axis(value.out)
        if axis is None:
            raise self.tilted(span)
        return Plane(axis, value.origin[axis], value.on)

    def tilted(self, span: Span) -> Exception:
        return self.env.context.error(
            "plane-across-axes", span, "this face is turned: its plane is no coordinate of the frame of this statement",
            hint="equate points instead (`align a.top.center = b.bottom.center`), or use `connect ... to` with frames",
        )  # fmt: skip

    # ------------------------------------------------------------ dispatch

    def value(self, node: ast.Expr) -> Value:
        method = getattr(self, "_" + type(node).__name__, None)
        if method is None:
            raise self.env.context.error("wrong-kind", node.span, "this cannot stand here")
        try:
            return method(node)
        except ScopeError as error:
            raise self.env.context.mixed(error, node.span) from None

    def _NumberExpr(self, node: ast.NumberExpr) -> Value:
        factor = UNITS[node.unit][0] if node.unit else 1.0
        return E.const(node.value * factor)

    def _StringExpr(self, node: ast.StringExpr) -> Value:
        return node.value

    def _VectorExpr(self, node: ast.VectorExpr) -> Value:
        items: list[Expr] = []
        on: tuple = ()
        for k, item in enumerate(node.items):
            value = self.value(item)
            if isinstance(value, Frame) and value.face:
                value = self.plane(value, item.span)
            if isinstance(value, Plane):
                if value.axis != k:
                    raise self.env.context.error(
                        "plane-across-axes", item.span,
                        f"`{text_of(item.span)}` is a plane across {AXES[value.axis or 0]}, but stands where the"
                        f" {AXES[k]} coordinate goes",
                    )  # fmt: skip
                on += value.on
                value = value.coordinate
            if not isinstance(value, Expr):
                raise self.wrong(item.span, "a number", value)
            items.append(value)
        return Vec(tuple(items), on)

    def _UnaryExpr(self, node: ast.UnaryExpr) -> Value:
        value = self.value(node.operand)
        if node.op == "not":
            return E.negate(self.truth(value, node.operand.span))
        if node.op == "+":
            return value
        if isinstance(value, Vec):
            return Vec(tuple(E.neg(c) for c in value.items), value.on)
        if isinstance(value, Line):
            return replace(value, direction=times(value.direction, E.const(-1.0)))
        if isinstance(value, Frame | Plane):
            return E.neg(self.plane(value, node.span).coordinate)
        if isinstance(value, Expr):
            return E.neg(value)
        raise self.wrong(node.operand.span, "a number or a vector", value)

    def truth(self, value: Value, span: Span) -> Expr:
        """A guard: predicates, and names of optional parts and gaps (true where they exist)."""
        if isinstance(value, Expr):
            return value
        if isinstance(value, Box):
            return value.exists
        if isinstance(value, Ref):
            branches = value.branches
            return branches[0].members[0][0].exists if len(branches) == 1 else E.TRUE
        raise self.wrong(span, "a condition", value)

    def _BinaryExpr(self, node: ast.BinaryExpr) -> Value:
        if node.op in ("and", "or"):
            left, right = (self.truth(self.value(n), n.span) for n in (node.left, node.right))
            return OPERATIONS[node.op](left, right)
        if node.op in ("==", "!="):
            same = self.equal(node)
            return same if node.op == "==" else E.negate(same)
        left, right = self.value(node.left), self.value(node.right)
        if node.op in ("<", "<=", ">", ">="):
            a, b = self.number(left, node.left.span), self.number(right, node.right.span)
            if node.op in (">", ">="):
                a, b = b, a
            return E.call("lt" if node.op in ("<", ">") else "le", a, b)
        if isinstance(left, Frame | Plane) and not (isinstance(left, Frame) and not left.face):
            left = self.plane(left, node.left.span)
        if isinstance(right, Frame | Plane) and not (isinstance(right, Frame) and not right.face):
            right = self.plane(right, node.right.span)
        if isinstance(left, Plane) or isinstance(right, Plane):
            return self.plane_arithmetic(node, left, right)
        if isinstance(left, Frame) and isinstance(right, Vec):
            left = Vec(left.origin, left.on, point=True)
        if isinstance(left, Vec) or isinstance(right, Vec):
            return self.vector_arithmetic(node, left, right)
        return OPERATIONS[node.op](self.number(left, node.left.span), self.number(right, node.right.span))

    def plane_arithmetic(self, node: ast.BinaryExpr, left: Value, right: Value) -> Value:
        a = left.coordinate if isinstance(left, Plane) else self.number(left, node.left.span)
        b = right.coordinate if isinstance(right, Plane) else self.number(right, node.right.span)
        result = OPERATIONS[node.op](a, b)
        if isinstance(left, Plane) and isinstance(right, Plane):
            if left.axis != right.axis:
                raise self.across(node.span, left, right, node.left.span, node.right.span)
            if node.op == "-":
                return result
            return Plane(left.axis, result, left.on + right.on)
        plane = left if isinstance(left, Plane) else right
        return Plane(plane.axis, result, plane.on) if node.op in "+-" else result  # type: ignore[union-attr]

    def across(self, span: Span, left: Plane, right: Plane, a: Span, b: Span) -> Exception:
        """Report planes of different axes; ``a`` and ``b`` are the places of the two."""
        first, second = f"`{text_of(a)}`", f"`{text_of(b)}`"
        return self.env.context.error(
            "plane-across-axes", span,
            f"{first} is a plane across {AXES[left.axis or 0]}, {second} one across {AXES[right.axis or 0]}:"
            " they have no coordinate in common",
            hint="front and back are planes across x, left and right across y, top and bottom across z",
        )  # fmt: skip

    def vector_arithmetic(self, node: ast.BinaryExpr, left: Value, right: Value) -> Value:
        operation = OPERATIONS[node.op]
        if isinstance(left, Vec) and isinstance(right, Vec):
            if len(left.items) != len(right.items) or node.op not in "+-":
                raise self.wrong(node.span, "a sum or difference of vectors of one length", right)
            items = tuple(operation(a, b) for a, b in zip(left.items, right.items, strict=True))
            point = left.point and not (node.op == "-" and right.point) or (node.op == "+" and right.point)
            return Vec(items, left.on + right.on, point)
        if isinstance(left, Vec):
            factor = self.number(right, node.right.span)
            return Vec(tuple(operation(a, factor) for a in left.items), left.on)
        factor = self.number(left, node.left.span)
        return Vec(tuple(operation(factor, b) for b in right.items), right.on)  # type: ignore[union-attr]

    def number(self, value: Value, span: Span) -> Expr:
        if isinstance(value, Choice):
            return value.code
        if isinstance(value, Plane):
            return value.coordinate
        if isinstance(value, Frame) and value.face:
            return self.plane(value, span).coordinate
        if not isinstance(value, Expr):
            raise self.wrong(span, "a number", value)
        return value

    def equal(self, node: ast.BinaryExpr) -> Expr:
        for choice_node, option in ((node.left, node.right), (node.right, node.left)):
            if isinstance(option, ast.NameExpr) and not isinstance(choice_node, ast.NumberExpr):
                value = self.value(choice_node)
                if isinstance(value, Choice) and option.name in value.options:
                    return E.call("eq", value.code, E.const(float(value.options.index(option.name))))
        return E.call("eq", self.scalar(node.left), self.scalar(node.right))

    def _IfExpr(self, node: ast.IfExpr) -> Value:
        condition = self.truth(self.value(node.condition), node.condition.span)
        then, otherwise = self.value(node.then), self.value(node.otherwise)
        if isinstance(then, Frame | Plane) and isinstance(otherwise, Frame | Plane) and not isinstance(then, Frame):
            then, otherwise = self.plane(then, node.then.span), self.plane(otherwise, node.otherwise.span)
        if isinstance(then, Plane) and isinstance(otherwise, Plane):
            return Plane(then.axis, E.where(condition, then.coordinate, otherwise.coordinate), then.on + otherwise.on)
        if isinstance(then, Vec) and isinstance(otherwise, Vec):
            pairs = zip(then.items, otherwise.items, strict=True)
            return Vec(tuple(E.where(condition, a, b) for a, b in pairs), then.on + otherwise.on, then.point)
        return E.where(
            condition, self.number(then, node.then.span), self.number(otherwise, node.otherwise.span)
        )

    def _IsExpr(self, node: ast.IsExpr) -> Value:
        from .part import matches

        subject = self.value(node.subject)
        if not isinstance(subject, Ref) or len(subject.branches) != 1:
            raise self.wrong(node.subject.span, "a part", subject)
        part = subject.branches[0].members[0][0]
        return matches(part, node.type_name, node.type_span, self.env)

    # ------------------------------------------------------------ names, members, calls

    def _NameExpr(self, node: ast.NameExpr) -> Value:
        name = node.name
        if name in self.local:
            return self.local[name]
        value = self.env.find(name)
        if value is None:
            value = self.builtin(name)
        if value is None:
            symbol = self.env.module.find(name)
            if symbol is not None and symbol.kind == "function":
                value = self.module_function(symbol)
        if value is None:
            raise self.unknown(node)
        if isinstance(value, Element) and self.inside(value) and value.box is not None:
            return moved(value, self.pose) if self.pose is not HERE else value
        return moved(value, self.pose)

    def module_function(self, symbol: object) -> Value:
        declaration = symbol.decl  # type: ignore[attr-defined]
        home = Env(self.env.context, symbol.module, None, self.env.scope, "")  # type: ignore[attr-defined]
        if declaration.parameters:
            return Function(declaration.name, declaration.parameters, declaration.value, home)
        return Evaluator(home).value(declaration.value)

    def unknown(self, node: ast.NameExpr) -> Exception:
        return self.env.context.error("unknown-name", node.span, f"`{node.name}` is not known here")

    def builtin(self, name: str) -> Value | None:
        own = self.own_box()
        if name in AXES:
            return Vec(unit(AXES.index(name)))
        if name == "pi":
            return E.const(math.pi)
        if name in ("true", "false"):
            return E.const(name == "true")
        if name == "previous" and (element := self.nearest_element()) is not None:
            return At(element, None, element)
        if own is not None and name in (*FACES, "center", "box", "size"):
            return self.box_member(own, name)
        return None

    def own_box(self) -> Box | None:
        """The template's own box in this environment's frame."""
        root = self.env.root
        if root.box is None:
            return None
        from .values import inverse

        pose = self.env.to_root()
        return root.box if pose is HERE else moved(root.box, inverse(pose))  # type: ignore[return-value]

    def nearest_element(self) -> Element | None:
        env: Env | None = self.env
        while env is not None:
            if env.element is not None:
                return env.element
            env = env.outer
        return None

    def inside(self, element: Element) -> bool:
        env: Env | None = self.env
        while env is not None:
            if env is element.env:
                return True
            env = env.outer
        return False

    def box_member(self, box: Box, name: str) -> Value | None:
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

    def _MemberExpr(self, node: ast.MemberExpr) -> Value:
        return self.member(self.value(node.obj), node.name, node.name_span, node)

    def member(self, value: Value, name: str, span: Span, node: ast.MemberExpr | None = None) -> Value:
        found: Value | None = None
        if isinstance(value, Vec):
            if name in AXES and AXES.index(name) < len(value.items):
                axis = AXES.index(name)
                found = Plane(axis, value.items[axis], value.on) if value.point else value.items[axis]
        elif isinstance(value, Ref):
            found = self.ref_member(value, name, span)
        elif isinstance(value, Element):
            found = self.element_member(value, name, span)
        elif isinstance(value, At):
            found = self.at_member(value, name, span)
        elif isinstance(value, Box):
            found = self.box_member(value, name)
        elif isinstance(value, Frame):
            found = self.frame_member(value, name)
        elif isinstance(value, Line):
            found = self.line_member(value, name)
        if found is None:
            raise self.env.context.error("unknown-member", span, f"{describe(value)} has no `{name}`")
        return found

    def frame_member(self, value: Frame, name: str) -> Value | None:
        if name in ("origin", "center"):
            return Vec(value.origin, value.on, point=True)
        if name == "out":
            return Vec(value.out)
        if name == "up":
            return Vec(value.up)
        if isinstance(value, Face) and name in FACES:
            return edge_of(value, name)
        return None

    def line_member(self, value: Line, name: str) -> Value | None:
        if name in ("at", "origin", "center"):
            return Vec(value.point, value.on, point=True)
        if name == "to" and value.to is not None:
            return Vec(value.to, value.on, point=True)
        if name == "along":
            return Vec(value.direction)
        if isinstance(value, Edge) and name in FACES:
            return corner_of(value, name)
        return None

    def element_member(self, value: Element, name: str, span: Span) -> Value | None:
        if self.inside(value):
            if name == "gap":
                return value.gap
            if value.box is not None and (found := self.box_member(self.here(value, value.box), name)) is not None:
                return found
            inner = value.env.find(name)
            return inner if inner is None else self.from_env(value.env, inner)
        raise self.env.context.error(
            "many-elements", span, f"`{value.name}` stands for all elements of a repeat here",
            hint=f"name one, `{value.name}[0]` or `{value.name}[last]`, or reduce them with sum, min or max",
        )  # fmt: skip

    def here(self, element: Element, value: Value) -> Value:
        return self.from_env(element.env, value)

    def from_env(self, env: Env, value: Value) -> Value:
        """A value of an environment around this one, in this one's frame."""
        from .values import inverse

        chain = HERE
        at: Env | None = self.env
        while at is not None and at is not env:
            if at.frame is not HERE:
                chain = compose(at.frame, chain) if chain is not HERE else at.frame
            at = at.outer
        value = value if chain is HERE else moved(value, inverse(chain))
        return moved(value, self.pose)

    def at_member(self, value: At, name: str, span: Span) -> Value:
        within = Evaluator(value.element.env)
        boxed = name in FACES or name in ("center", "size", "box")
        if boxed and isinstance(value.inner, Ref):
            found = self.box_member(self.fetch(value, within.ref_box(value.inner, span)), name)  # type: ignore[arg-type]
        elif boxed and isinstance(value.inner, Element) and value.inner.box is not None:
            found = self.box_member(self.fetch(value, value.inner.box), name)  # type: ignore[arg-type]
        else:
            return self.fetch(value, within.member(value.inner, name, span))
        return found

    def fetch(self, at: At, inner: Value) -> Value:
        if isinstance(inner, Ref | Element | At):
            return At(at.element, at.index, inner)
        scope = at.element.scope
        if at.index is None:
            return mapped(inner, lambda e: E.previous(scope, e, E.ZERO) if e.scope is not None else e)
        value = mapped(inner, lambda e: E.element(scope, e, at.index) if _deep(e, scope) else e)  # type: ignore[arg-type]
        frame = at.element.env.frame
        if frame is not HERE:
            from .values import mapped_pose

            outer = mapped_pose(frame, lambda e: E.element(scope, e, at.index) if _deep(e, scope) else e)  # type: ignore[arg-type]
            value = moved(value, outer)
        return moved(value, self.pose)

    def _IndexExpr(self, node: ast.IndexExpr) -> Value:
        value = self.value(node.obj)
        if isinstance(value, Ports):
            return builtins.pick(value, self.scalar(node.index), self.env, node.span)
        if isinstance(value, At) and isinstance(value.inner, Element):
            inner = Evaluator(value.element.env)
            index = inner.position(value.inner, node.index)
            return At(value.element, value.index, At(value.inner, index, value.inner))
        if not isinstance(value, Element):
            raise self.wrong(node.obj.span, "a repeat", value)
        return At(value, self.position(value, node.index), value)

    def position(self, element: Element, index: ast.Expr) -> Expr:
        if isinstance(index, ast.NameExpr) and index.name == "last":
            return E.sub(element.count, E.ONE)
        return self.scalar(index)

    # ------------------------------------------------------------ parts

    def lift(self, value: Value, scope: Scope | None) -> Value:
        """A value of the rows of ``scope`` in this environment's table: as it is, or by the one row that exists."""
        while scope is not None and not self.env.scope.within(scope):
            if scope.kind != "guard" or scope.parent is None:
                break
            value = merged(scope.parent, [(scope, value)])
            scope = scope.parent
        return value

    def ref_member(self, ref: Ref, name: str, span: Span) -> Value | None:
        """A member of what a reference names, of whichever alternative exists; else of its box."""
        from .part import part_member

        results: list[tuple[Scope | None, Value]] = []
        for branch in ref.branches:
            if len(branch.members) != 1:
                continue
            part, outer = branch.members[0]
            found = part_member(part, name, span, self, ref.own)
            if found is not None:
                results.append((branch.scope, moved(found, outer)))
        if not results or len(results) < len(ref.branches):
            box = self.ref_box(ref, span)
            if (found := self.box_member(box, name)) is not None:
                return self.labelled(found, box)
            if not results:
                return None
        return moved(self.joined(name, results), ref.frame)

    def joined(self, name: str, results: list[tuple[Scope | None, Value]]) -> Value:
        """One value out of those of alternatives, in this environment's table."""
        if all(isinstance(v, Surface) for _, v in results):
            return Surface(tuple(b if b[0] is not None else (s, *b[1:]) for s, v in results for b in v.branches))  # type: ignore[union-attr]
        if len(results) == 1:
            scope, value = results[0]
            if not isinstance(value, Ref):
                return self.lift(value, scope)
            return replace(value, branches=tuple(replace(b, scope=b.scope or scope) for b in value.branches))
        if all(isinstance(v, Ref) for _, v in results):
            branches = [replace(b, scope=b.scope or s) for s, v in results for b in baked(v).branches]  # type: ignore[arg-type]
            return Ref(name, tuple(branches))
        parent = results[0][0].parent  # type: ignore[union-attr]
        return self.lift(merged(parent, results), parent)  # type: ignore[arg-type]

    def labelled(self, value: Value, box: Box) -> Value:
        return replace(value, on=box.on) if hasattr(value, "on") else value  # type: ignore[type-var]

    def ref_box(self, ref: Ref, span: Span) -> Box:
        """The box of what a reference names, in the frame of the environment that names it."""
        return moved(self.branch_box(ref, span), ref.frame)  # type: ignore[return-value]

    def branch_box(self, ref: Ref, span: Span) -> Box:
        """The box of what a reference names; for several parts, the axis-aligned box around them."""
        boxes: list[tuple[Scope | None, Box]] = []
        carriers: list = []
        for branch in ref.branches:
            held = [self.member_box(part, outer, ref.own, branch.scope) for part, outer in branch.members]
            carriers += [part for part, _ in branch.members if part not in carriers]
            if len(held) > 1:
                held = [extent(b) for b in held]  # type: ignore[arg-type]
                low = tuple(E.minimum(*(b.low[k] for b in held)) for k in range(3))
                high = tuple(E.maximum(*(b.high[k] for b in held)) for k in range(3))
                held = [Box(low, high)]  # type: ignore[arg-type]
            boxes.append((branch.scope, held[0]))  # type: ignore[arg-type]
        on = tuple(carriers)
        if len(boxes) == 1:
            return self.lift(replace(boxes[0][1], on=on), boxes[0][0])  # type: ignore[return-value]
        parent = boxes[0][0].parent  # type: ignore[union-attr]
        value = merged(parent, boxes)  # type: ignore[arg-type]
        return self.lift(replace(value, on=on), parent)  # type: ignore[return-value,type-var]

    def member_box(self, part: Part, outer: Pose, own: bool, scope: Scope | None) -> Value:
        """The box of one part of a reference; over all rows where the part stands in a repeat of its template."""
        from .part import raised

        box = moved(part.box(), outer if own else compose(outer, part.pose))
        target = scope if scope is not None else self.env.scope
        if part.env.scope.within(target) and part.env.scope is not target:
            return raised(extent(box), part.env.scope, target)  # type: ignore[arg-type]
        return box

    # ------------------------------------------------------------ calls

    def _CallExpr(self, node: ast.CallExpr) -> Value:
        if isinstance(node.function, ast.MemberExpr):
            return builtins.method(self, node)
        name = node.function.name  # type: ignore[union-attr]
        found = self.local.get(name) or self.env.find(name)
        if not isinstance(found, Function):
            symbol = self.env.module.find(name)
            if symbol is not None and symbol.kind == "function":
                found = self.module_function(symbol)
        if isinstance(found, Function):
            return self.apply(found, node)
        return builtins.function(self, node)

    def apply(self, function: Function, node: ast.CallExpr) -> Value:
        values = [self.value(a.value) for a in node.arguments]
        if len(values) != len(function.parameters):
            raise self.env.context.error(
                "wrong-arguments", node.span,
                f"`{function.name}` takes {len(function.parameters)} arguments, {len(values)} are given",
            )  # fmt: skip
        local = {**function.bindings, **dict(zip(function.parameters, values, strict=True))}
        return Evaluator(function.env, local).value(function.value)


def _deep(e: Expr, scope: Scope) -> bool:
    return e.scope is not None and e.scope.within(scope)


def describe(value: Value) -> str:
    """What a value is, in words for a message."""
    names = {
        Vec: "a vector", Frame: "a frame", Plane: "a plane", Line: "a line", Box: "a box", Choice: "a choice", Ref: "a part",
        Element: "an element of a repeat", At: "an element of a repeat", Function: "a function", str: "a text", Expr: "a number",
    }  # fmt: skip
    if isinstance(value, Ref):
        return f"the part `{value.name}`"
    if isinstance(value, Frame) and value.face:
        return "a face"
    return next((text for kind, text in names.items() if isinstance(value, kind)), "something else")


__all__ = ["At", "Evaluator", "describe", "minus", "vector_plus", "times", "HALF"]
