"""Operators on values: numbers, planes (coordinates along one axis), vectors and conditions."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.defined import PARTIAL, Defined, Sharp
from ...graph.expr import Expr
from ...semantics.meanings import Global, Word
from ...semantics.symbols import Symbol
from ...source import Span
from ...syntax import ast
from ..values.kinds import Box, Choice, Frame, Line, Look, Plane, Ref, Value, Vec
from ..values.vectors import AXES, sole_axis, times
from .members import At, fetch

if TYPE_CHECKING:
    from .evaluate import Evaluator

_ROUNDING = 1e-9  # so far may what is to lie in -1 .. 1 lie outside
OPERATIONS = {"+": E.add, "-": E.sub, "*": E.mul, "/": E.div, "^": E.power, "and": E.both, "or": E.either}


def _operate(ev: Evaluator, node: ast.BinaryExpr, a: Expr, b: Expr) -> Expr:
    """A binary operation on numbers; one that has no value whatever is drawn is refused."""
    if node.op == "/" and b.constant == 0:
        raise undefined(ev, node.span, f"`{node.span.words}` divides by zero")
    result = OPERATIONS[node.op](a, b)
    if node.op == "^" and b.constant is not None:
        power, base = b.constant, a.constant
        if base is not None and base < 0 and power != int(power):
            raise undefined(ev, node.span, f"{base:g} has no power {power:g}: a negative number only has whole powers")
        if base == 0 and power < 0:
            raise undefined(ev, node.span, f"`{node.span.words}` divides by zero: 0 has no negative power")
    return counted(ev, node.span, result, (a, b))


def applied(ev: Evaluator, node: ast.CallExpr, name: str, arguments: list[Expr]) -> Expr:
    """A function of numbers; one that has no value whatever is drawn is refused."""
    value = arguments[0].constant
    what = None
    if name == "mod" and arguments[1].constant == 0:
        what = f"`{node.span.words}` divides by zero"
    elif value is None:
        pass
    elif name == "log" and value <= 0:
        what = f"{value:g} has no logarithm: only numbers above 0 have one"
    elif name == "sqrt" and value < 0:
        what = f"{value:g} has no square root: negative numbers have none"
    elif name in ("asin", "acos") and abs(value) > 1:
        if abs(value) > 1 + _ROUNDING:
            what = f"`{name}` takes numbers from -1 to 1, but this is {value:g}"
        arguments = [E.const(1.0 if value > 0 else -1.0)]
    if what is not None:
        raise undefined(ev, node.span, what)
    return counted(ev, node.span, E.call(name, *arguments), tuple(arguments))


def counted(ev: Evaluator, span: Span, result: Expr, of: tuple[Expr, ...]) -> Expr:
    """The result of an operation, which is a number if what it is made ``of`` are numbers."""
    if result.constant is None:
        if result.op in PARTIAL:
            ev.env.context.operations.setdefault(result, span)
        return result
    if math.isfinite(result.constant):
        return result
    if all(a.constant is None or math.isfinite(a.constant) for a in of):
        raise undefined(ev, span, f"`{span.words}` is too large for a number")
    return result


def undefined(ev: Evaluator, span: Span, message: str) -> Exception:
    return ev.env.context.error(
        "undefined-value", span, message, hint="to avoid such values, use `a if c else b`, or a condition with `when`"
    )


def plane(ev: Evaluator, value: Frame | Plane, span: Span) -> Plane:
    """The coordinate plane of a face, in this environment's frame."""
    if isinstance(value, Plane):
        if value.axis is None:
            raise _tilted(ev, span)
        return value
    axis = sole_axis(value.out)
    if axis is None:
        raise _tilted(ev, span)
    return Plane(axis, value.origin[axis], value.on, value.out[axis])


def _flat(value: Frame | Plane) -> bool:
    return isinstance(value, Plane) or value.face


def _tilted(ev: Evaluator, span: Span) -> Exception:
    if any(sole_axis(row) is None for env in ev.env.chain() for row in env.frame.rotation):
        return ev.env.context.error(
            "plane-across-axes",
            span,
            "elements of the ring are turned against this face, so its plane is not a coordinate in theirs",
            hint="write a length in the frame of an element, such as `align rod.top = hub.size.z / 2`, or equate points "
            "with a part that the ring repeats",
        )
    return ev.env.context.error(
        "plane-across-axes",
        span,
        "this face is turned, so its plane is not a coordinate in the frame of this statement",
        hint="equate points instead (`align a.top.center = b.bottom.center`), or use `connect ... to` with frames; "
        "alternatives that lie along different axes count as turned",
    )


def unary(ev: Evaluator, node: ast.UnaryExpr) -> Value:
    value = ev.value(node.operand)
    if node.op == "not":
        return _other(ev, truth(ev, value, node.operand.span))
    if node.op == "+":
        return value
    if isinstance(value, Vec):
        return Vec(tuple(E.neg(c) for c in value.items), value.on)
    if isinstance(value, Line):
        return replace(value, direction=times(value.direction, E.const(-1.0)))
    if isinstance(value, Frame | Plane):
        return E.neg(plane(ev, value, node.span).coordinate)
    if isinstance(value, Expr):
        return E.neg(value)
    raise ev.impossible(node.operand.span, "a number or a vector", value)


def truth(ev: Evaluator, value: Value, span: Span) -> Expr:
    """A guard: predicates, and names of optional parts and gaps (true where they exist)."""
    if isinstance(value, Expr):
        return value
    if isinstance(value, Box):
        return value.exists
    if isinstance(value, Ref):
        branches = value.branches
        return branches[0].members[0][0].exists if len(branches) == 1 else E.TRUE
    if isinstance(value, At):
        return fetch(ev, value, truth(type(ev)(value.element.env), value.inner, span))
    raise ev.impossible(span, "a condition", value)


def binary(ev: Evaluator, node: ast.BinaryExpr) -> Value:
    if node.op in ("and", "or"):
        first = ev.condition(node.left)
        with ev.env.context.knowing(first if node.op == "and" else E.negate(first)):
            return OPERATIONS[node.op](first, ev.condition(node.right))
    if node.op in ("==", "!="):
        same = equal(ev, node)
        return same if node.op == "==" else _other(ev, same)
    left: Value
    right: Value
    left, right = ev.value(node.left), ev.value(node.right)
    if node.op in ("<", "<=", ">", ">="):
        a, b = number(ev, left, node.left.span), number(ev, right, node.right.span)
        if node.op in (">", ">="):
            a, b = b, a
        return E.call("lt" if node.op in ("<", ">") else "le", a, b)
    if isinstance(left, Plane) or isinstance(left, Frame) and left.face:
        left = plane(ev, left, node.left.span)
    if isinstance(right, Plane) or isinstance(right, Frame) and right.face:
        right = plane(ev, right, node.right.span)
    if isinstance(left, Plane) or isinstance(right, Plane):
        return _plane_arithmetic(ev, node, left, right)
    if isinstance(left, Frame) and isinstance(right, Vec):
        left = Vec(left.origin, left.on, point=True)
    if isinstance(left, Vec) or isinstance(right, Vec):
        return _vector_arithmetic(ev, node, left, right)
    return _operate(ev, node, number(ev, left, node.left.span), number(ev, right, node.right.span))


def _plane_arithmetic(ev: Evaluator, node: ast.BinaryExpr, left: Value, right: Value) -> Value:
    result = _operate(ev, node, number(ev, left, node.left.span), number(ev, right, node.right.span))
    match left, right:
        case Plane(), Plane():
            if left.axis != right.axis:
                raise across(ev, node.span, left, right, node.left.span, node.right.span)
            return result if node.op == "-" else Plane(left.axis, result, left.on + right.on)
        case (Plane() as face, _) | (_, Plane() as face) if node.op in "+-":
            return replace(face, coordinate=result)
        case _:
            return result


def across(ev: Evaluator, span: Span, left: Plane, right: Plane, a: Span, b: Span) -> Exception:
    """Report planes of different axes; ``a`` and ``b`` are the places of the two."""
    first, second = f"`{a.words}`", f"`{b.words}`"
    return ev.env.context.error(
        "plane-across-axes",
        span,
        f"{first} is a plane across {AXES[left.axis or 0]}, {second} one across {AXES[right.axis or 0]}:"
        " they share no coordinate",
        hint="front and back are planes across x, left and right across y, top and bottom across z",
    )


def _vector_arithmetic(ev: Evaluator, node: ast.BinaryExpr, left: Value, right: Value) -> Value:
    operation = partial(_operate, ev, node)
    match left, right:
        case Vec(), Vec():
            if len(left.items) != len(right.items) or node.op not in "+-":
                raise ev.impossible(node.span, "a sum or difference of vectors of one length", right)
            items = tuple(operation(a, b) for a, b in zip(left.items, right.items, strict=True))
            point = left.point and not (node.op == "-" and right.point) or (node.op == "+" and right.point)
            return Vec(items, left.on + right.on, point)
        case Vec(), _:
            factor = number(ev, right, node.right.span)
            return Vec(tuple(operation(a, factor) for a in left.items), left.on)
        case _, Vec():
            factor = number(ev, left, node.left.span)
            return Vec(tuple(operation(factor, b) for b in right.items), right.on)
    raise ev.impossible(node.span, "a vector", left)


def number(ev: Evaluator, value: Value, span: Span) -> Expr:
    match value:
        case Expr():
            return value
        case Choice():
            return value.code
        case Plane():
            return value.coordinate
        case Frame(face=True):
            return plane(ev, value, span).coordinate
        case _:
            raise ev.impossible(span, "a number", value)


def equal(ev: Evaluator, node: ast.BinaryExpr) -> Expr:
    for subject, option in ((node.left, node.right), (node.right, node.left)):
        match ev.env.context.meaning(option):
            case Word(name) | Global(Symbol(name=name, kind="material")):
                one = ev.value(subject)
                if isinstance(one, Choice | Look):
                    return one.chosen(name)
                raise ev.impossible(subject.span, "a choice", one)
    left, right = ev.value(node.left), ev.value(node.right)
    if isinstance(left, Choice) and isinstance(right, Choice) and left.options != right.options:
        return _same_option(left, right)
    sides = ((left, node.left.span), (right, node.right.span))
    return E.call("eq", *(value.exists if isinstance(value, Box) else number(ev, value, span) for value, span in sides))


def _other(ev: Evaluator, same: Expr) -> Expr:
    """The opposite of a condition; that two values are not equal does not hold either where one of them has no value."""
    if same.op != "eq" or all(node.op not in PARTIAL for node in E.nodes(same)):
        return E.negate(same)
    context = ev.env.context
    if Defined(Sharp(context.draws, context.program.definitions)).certain(same):
        return E.negate(same)
    left, right = same.args
    return E.either(E.call("lt", left, right), E.call("lt", right, left))


def _same_option(left: Choice, right: Choice) -> Expr:
    """That two choices with options of their own are at the same one; their numbers say nothing."""
    shared = dict.fromkeys(name for name in left.options if name in right.options)
    return E.any_of(E.both(left.chosen(name), right.chosen(name)) for name in shared)


def condition_of(ev: Evaluator, node: ast.IfExpr) -> Expr:
    """The condition of ``a if c else b``; it is remembered."""
    condition = ev.condition(node.condition)
    ev.env.context.branched.setdefault(id(node), (node, []))[1].append(condition)
    return condition


def conditional(ev: Evaluator, node: ast.IfExpr) -> Value:
    condition = condition_of(ev, node)
    if condition.op == "const":  # what is never reached need not have a value
        return ev.value(node.then if condition.constant else node.otherwise)
    with ev.env.context.knowing(condition):
        then = ev.value(node.then)
    with ev.env.context.knowing(E.negate(condition)):
        otherwise = ev.value(node.otherwise)
    if isinstance(then, Frame | Plane) and isinstance(otherwise, Frame | Plane) and _flat(then) and _flat(otherwise):
        then, otherwise = plane(ev, then, node.then.span), plane(ev, otherwise, node.otherwise.span)
    if isinstance(then, Plane) and isinstance(otherwise, Plane):
        if then.axis != otherwise.axis:
            raise across(ev, node.span, then, otherwise, node.then.span, node.otherwise.span)
        return Plane(then.axis, E.where(condition, then.coordinate, otherwise.coordinate), then.on + otherwise.on)
    if isinstance(then, Vec) and isinstance(otherwise, Vec):
        pairs = zip(then.items, otherwise.items, strict=True)
        return Vec(tuple(E.where(condition, a, b) for a, b in pairs), then.on + otherwise.on, then.point)
    code = E.where(condition, number(ev, then, node.then.span), number(ev, otherwise, node.otherwise.span))
    return Choice(code, then.options) if isinstance(then, Choice) else code
