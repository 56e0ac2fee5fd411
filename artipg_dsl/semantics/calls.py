"""Types of calls: built-in functions, constructors, curves, surfaces and the program's own functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean, given
from ..syntax import ast
from ..syntax.walk import walk
from . import paths
from .fold import is_unitless
from .guards import consistent
from .meanings import BuiltIn, Declared, Global
from .names import CONSTRUCTORS, DRIVES, FACES, FUNCTIONS
from .scope import Entry
from .types import (
    ANGLE,
    BOOL,
    BOX,
    COUNT,
    CURVE,
    DIRECTION,
    FRAME,
    LENGTH,
    LINE,
    NONE,
    PLANE,
    POINT,
    RATIO,
    SURFACE,
    UNKNOWN,
    Element,
    Joint,
    Part,
    Scalar,
    Slot,
    Type,
    Vec,
    dimension_of,
    fits,
    is_number,
    power,
)

if TYPE_CHECKING:
    from .checker import Checker, Context


def call(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    """The type of a call."""
    if isinstance(expr.function, ast.MemberExpr):
        return _method(ck, ctx, expr, expr.function)
    if not isinstance(expr.function, ast.NameExpr):
        for part in (expr.function, *(argument.value for argument in expr.arguments)):
            ck.infer(ctx, part)
        return ck.error(
            "wrong-type",
            expr.function.span,
            "only the name of a function can be called",
            hint="functions give numbers, places or curves, which take no arguments; with `*` one multiplies",
        )
    word = expr.function.name
    home = ctx.scope.home(word) if ctx.scope is not None else None
    own = [e for e in home.table[word] if _is_function(e.node)] if home is not None else []
    if home is not None and own:
        ck.mean(expr.function, Declared(word, home.depth))
        return _own(ck, ctx, expr, paths.sole(ck, ctx, own, expr.function.span))
    if word in _BUILT_IN:
        ck.mean(expr.function, BuiltIn(word))
        return _BUILT_IN[word](ck, ctx, expr)
    symbol = ctx.module.find(word)
    if symbol is not None and isinstance(symbol.decl, ast.FunctionDecl) and symbol.decl.parameters:
        ck.mean(expr.function, Global(symbol))
        arguments = _positional(ck, ctx, expr, len(symbol.decl.parameters), word)
        inside = type(ctx)(symbol.module)
        return _apply(ck, inside, expr, symbol.decl.parameters, symbol.decl.value, arguments, id(symbol.decl))
    for argument in expr.arguments:
        ck.infer(ctx, argument.value)
    if symbol is not None or (ctx.scope is not None and ctx.scope.find(word)):
        hint = f"a part is made by `part name : {word}(...)`" if symbol is not None else None
        return ck.error("wrong-type", expr.function.span, f"`{word}` is not a function", hint=hint)
    near = [n for n in ctx.names() if n in FUNCTIONS or n in CONSTRUCTORS]
    return ck.unknown(
        ctx.module,
        word,
        "unknown-function",
        expr.function.span,
        f"there is no function `{word}`",
        hint=did_you_mean(word, [*FUNCTIONS, *CONSTRUCTORS, *near, *ctx.names()]),
    )


def _is_function(node: ast.Stmt) -> bool:
    """Whether a declaration can be called."""
    return isinstance(node, ast.SurfaceDecl | ast.CurveDecl) or isinstance(node, ast.LetDecl) and bool(node.parameters)


def _positional(ck: Checker, ctx: Context, expr: ast.CallExpr, wanted: int, word: str) -> list[Type]:
    """The types of arguments that stand without names, in number ``wanted``."""
    kinds = [ck.infer(ctx, a.value) for a in expr.arguments]
    if len(kinds) != wanted:
        many = "one argument" if wanted == 1 else f"{wanted} arguments"
        ck.error("wrong-arguments", expr.span, f"`{word}` takes {many}, {given(len(kinds))}")
        return [UNKNOWN] * wanted
    return kinds


def _own(ck: Checker, ctx: Context, expr: ast.CallExpr, entry: Entry) -> Type:
    """A call of a ``let`` with parameters, a curve or a surface of the same body."""
    node = entry.node
    inside = ck.context(entry.scope)
    if isinstance(node, ast.LetDecl):
        arguments = _positional(ck, ctx, expr, len(node.parameters), entry.name)
        return _apply(ck, inside, expr, node.parameters, node.value, arguments, id(node))
    assert isinstance(node, ast.SurfaceDecl | ast.CurveDecl)
    ranges = [node.u_range, node.v_range] if isinstance(node, ast.SurfaceDecl) else [node.parameter_range]
    if len(expr.arguments) != len(ranges):
        _positional(ck, ctx, expr, len(ranges), entry.name)
        return UNKNOWN
    for argument, interval in zip(expr.arguments, ranges, strict=True):
        wanted = range_type(ck, inside, interval)
        ck.expect(ctx, argument.value, wanted, f"an argument of `{entry.name}`")
    if isinstance(node, ast.SurfaceDecl):
        return POINT
    kind = range_type(ck, inside, node.parameter_range)
    return _apply(ck, inside, expr, (node.parameter,), node.value, [kind], id(node))


def range_type(ck: Checker, ctx: Context, interval: ast.RangeExpr) -> Type:
    """The type of a value between the two ends of a range."""
    low, high = ck.infer(ctx, interval.low), ck.infer(ctx, interval.high)
    kind = high if isinstance(low, Scalar) and low.zero else low
    if kind == PLANE:
        return LENGTH
    return Scalar(kind.dimension) if isinstance(kind, Scalar) else kind


def _apply(
    ck: Checker,
    inside: Context,
    expr: ast.CallExpr,
    names: Sequence[str],
    value: ast.Expr,
    arguments: list[Type],
    identity: int,
) -> Type:
    """The type of a function's body for arguments of these types."""
    arguments = [Scalar(t.dimension) if isinstance(t, Scalar) and not t.zero else t for t in arguments]
    key = (identity, *arguments)
    if identity in ck.calling:
        return ck.error("circular-definition", expr.span, "this function is defined by itself")
    if key not in ck.calls:
        extra = dict(zip(names, arguments, strict=True))
        silent = inside.but(extra=extra, silent=True)
        ck.calling.append(identity)
        ck.calls[key] = UNKNOWN if UNKNOWN in arguments else ck.infer(silent, value)
        ck.calling.pop()
    return ck.calls[key]


# ---------------------------------------------------------------- numbers


def _unary(rule: Callable[[Scalar], Scalar | None], what: str) -> Callable[[Checker, Context, ast.CallExpr], Type]:
    def check(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
        word = expr.function.name
        (kind,) = _positional(ck, ctx, expr, 1, word)
        if kind == UNKNOWN:
            return UNKNOWN
        kind = LENGTH if kind == PLANE else kind
        found = rule(kind) if isinstance(kind, Scalar) else None
        if found is None:
            hint = None
            if word in ("sin", "cos", "tan") and kind in (RATIO, COUNT):
                hint = "angles carry a unit: multiply by 1rad or 1turn"
            code = "wrong-dimension" if isinstance(kind, Scalar) else "wrong-type"
            return ck.error(code, expr.arguments[0].span, f"`{word}` takes {what}, but this is {kind}", hint=hint)
        return found

    return check


def _same(ck: Checker, ctx: Context, expr: ast.CallExpr, kinds: list[Type]) -> Type:
    """One type for arguments that must agree."""
    found: Type | None = None
    first: ast.Argument | None = None
    for argument, kind in zip(expr.arguments, kinds, strict=True):
        if kind == UNKNOWN:
            return UNKNOWN
        if not is_number(kind):
            word = expr.function.name
            return ck.error("wrong-type", argument.span, f"`{word}` takes numbers, but this is {kind}")
        kind = LENGTH if kind == PLANE else kind
        if dimension_of(kind) is None:
            found = found or kind
        elif found is None or (isinstance(found, Scalar) and found.zero):
            found, first = kind, argument
        elif dimension_of(kind) != dimension_of(found):
            if first is not None and is_unitless(first.value):
                ck.mismatch(first.value, found, kind, "this argument")
            else:
                ck.mismatch(argument.value, kind, found, "this argument")
            return UNKNOWN
        elif isinstance(kind, Scalar) and not kind.count:
            found = kind
    return found or UNKNOWN


def _several(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    """``hypot`` and, with several arguments, ``min`` and ``max``."""
    word = expr.function.name
    if not expr.arguments:
        return ck.error("wrong-arguments", expr.span, f"`{word}` needs arguments")
    return _same(ck, ctx, expr, [ck.infer(ctx, a.value) for a in expr.arguments])


def _extremum(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    return _reduce(ck, ctx, expr) if len(expr.arguments) == 1 else _several(ck, ctx, expr)


def _reduce(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    """A reduction over the elements of a repeat: ``sum(cell.size.z)``."""
    word = expr.function.name
    if len(expr.arguments) != 1:
        return ck.error("wrong-arguments", expr.span, f"`{word}` over the elements of a repeat takes one argument")
    argument = expr.arguments[0]
    kind = ck.infer(ctx.but(many=True), argument.value)
    _one_repeat(ck, ctx, argument.value)
    if kind == UNKNOWN:
        return UNKNOWN
    if not is_number(kind):
        return ck.error("wrong-type", argument.span, f"`{word}` takes a number of each element, but this is {kind}")
    if not _mentions_many(ck, argument.value):
        return ck.error(
            "wrong-arguments",
            argument.span,
            f"`{word}` with one argument reduces over the elements of a repeat",
            hint="name a repeat in it, as in `sum(cell.size.z)`, or give several arguments",
        )
    return LENGTH if kind == PLANE else kind


def _one_repeat(ck: Checker, ctx: Context, expr: ast.Expr) -> None:
    """What is reduced is one repeat: those of exclusive branches have nothing in common but their name."""
    for node in walk(expr):
        home = ctx.scope.home(node.name) if isinstance(node, ast.NameExpr) and ctx.scope is not None else None
        if not isinstance(node, ast.NameExpr) or home is None:
            continue
        repeats = [e for e in home.table[node.name] if e.kind == "repeat"]
        if sum(consistent(ctx.condition, ck.entry_condition(e)) for e in repeats) > 1:
            ck.error(
                "many-elements",
                node.span,
                f"`{node.name}` is another repeat in each branch of a `when`",
                hint="reduce each within its own branch",
                notes=tuple((e.span, "one of them") for e in repeats),
            )


def _mentions_many(ck: Checker, expr: ast.Expr) -> bool:
    match expr:
        case ast.NameExpr():
            return getattr(ck.types.get(id(expr)), "many", False)
        case ast.MemberExpr(obj=obj):
            return getattr(ck.types.get(id(expr)), "many", False) or _mentions_many(ck, obj)
        case ast.IndexExpr(obj=obj):
            return isinstance(obj, ast.MemberExpr) and _mentions_many(ck, obj.obj)
        case ast.UnaryExpr(operand=operand):
            return _mentions_many(ck, operand)
        case ast.BinaryExpr(left=left, right=right):
            return _mentions_many(ck, left) or _mentions_many(ck, right)
        case ast.IfExpr(then=a, condition=b, otherwise=c):
            return any(_mentions_many(ck, e) for e in (a, b, c))
        case ast.CallExpr(arguments=arguments):
            return any(_mentions_many(ck, a.value) for a in arguments)
    return False


def _number(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    (kind,) = _positional(ck, ctx.but(many=True), expr, 1, "number")
    for argument in expr.arguments:
        _one_repeat(ck, ctx, argument.value)
    if kind != UNKNOWN and not isinstance(kind, Element | Slot | Part):
        ck.error("wrong-type", expr.arguments[0].span, f"`number` counts the elements of a repeat, but this is {kind}")
    return COUNT


def _atan2(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    kinds = _positional(ck, ctx, expr, 2, "atan2")
    if len(expr.arguments) == 2:
        _same(ck, ctx, expr, kinds)
    return ANGLE


def _mod(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    kinds = _positional(ck, ctx, expr, 2, "mod")
    return _same(ck, ctx, expr, kinds) if len(expr.arguments) == 2 else UNKNOWN


# ---------------------------------------------------------------- places and curves


Shape = dict[str, tuple[Type, bool]]  # parameter -> (type, required)


def _named(result: Type, shape: Shape) -> Callable[[Checker, Context, ast.CallExpr], Type]:
    def check(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
        arguments(ck, ctx, expr, expr.function.name, shape)
        return result

    return check


def arguments(ck: Checker, ctx: Context, expr: ast.CallExpr, word: str, shape: Shape) -> set[str]:
    """Checks arguments, by name or in order, against parameters; the names that were given."""
    given: set[str] = set()
    order = list(shape)
    for position, argument in enumerate(expr.arguments):
        name = argument.name
        if name is None and position < len(order):
            name = order[position]
        if name is None or name not in shape:
            what = f"`{word}` has no argument `{name}`" if name else f"`{word}` takes {len(order)} arguments at most"
            hint = did_you_mean(name, order) if name else None
            ck.error("unknown-argument", argument.span, what, hint=hint or "it takes " + ", ".join(order))
            ck.infer(ctx, argument.value)
            continue
        if name in given:
            ck.error("wrong-arguments", argument.span, f"`{name}` is given twice")
        given.add(name)
        ck.expect(ctx, argument.value, shape[name][0], f"`{name}` of `{word}`")
    missing = [n for n, (_, required) in shape.items() if required and n not in given]
    if missing:
        ck.error("missing-argument", expr.span, f"`{word}` needs {' and '.join(f'`{n}`' for n in missing)}")
    return given


def _line(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    if len(expr.arguments) == 1 and expr.arguments[0].name is None:
        return CURVE if ck.expect(ctx, expr.arguments[0].value, LENGTH, "the length of a line") else CURVE
    given = arguments(ck, ctx, expr, "line", {"at": (POINT, True), "along": (DIRECTION, False), "to": (POINT, False)})
    if "at" in given and ("along" in given) == ("to" in given):
        ck.error("wrong-arguments", expr.span, "`line` needs either `along` (a direction) or `to` (a point)")
    return LINE


def _box(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    arguments(ck, ctx, expr, "box", {face: (LENGTH, False) for face in FACES})
    return BOX


def _polygon(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    for argument in expr.arguments:
        ck.expect(ctx, argument.value, Vec(2, LENGTH.dimension), "a corner of a polygon")
    if len(expr.arguments) < 3:
        ck.error("wrong-arguments", expr.span, "a polygon has at least three corners")
    return CURVE


def _offset(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    kinds = _positional(ck, ctx, expr, 2, "offset")
    if UNKNOWN in kinds:
        return UNKNOWN
    curve, distance = kinds
    if curve != CURVE and not isinstance(curve, Vec):
        return ck.error("wrong-type", expr.arguments[0].span, f"`offset` takes a curve, but this is {curve}")
    if not fits(distance, LENGTH):
        ck.mismatch(expr.arguments[1].value, distance, LENGTH, "the distance")
    return curve


def _from(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    arguments(ck, ctx, expr, "from", {"at": (POINT, True), "along": (DIRECTION, True)})
    return CURVE


def chain(ck: Checker, ctx: Context, expr: ast.ChainExpr) -> Type:
    """``from(point, direction)`` followed by straight and bent pieces."""
    for number, piece in enumerate(expr.pieces):
        assert isinstance(piece.function, ast.NameExpr)
        word = piece.function.name
        if (word == "from") != (number == 0) or word not in ("from", "line", "arc"):
            ck.error(
                "wrong-type",
                piece.span,
                f"`{word}` cannot stand here in a path",
                hint="a path is `from(point, direction)`, then `line(length)` and `arc(radius, angle, towards)`",
            )
        ck.infer(ctx, piece)
    return CURVE


def _lowest(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    kinds = _positional(ck, ctx, expr, 2, "lowest")
    part, direction = kinds
    if part != UNKNOWN and not isinstance(part, Part | Slot | Element):
        ck.error("wrong-type", expr.arguments[0].span, f"`lowest` reads the extent of a part, but this is {part}")
    if not fits(direction, DIRECTION):
        ck.mismatch(expr.arguments[1].value, direction, DIRECTION, "the second argument")
    return LENGTH


def _drive(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    """``pushes(open)``: what a force on the surface does to a joint, in the formula of a label."""
    assert isinstance(expr.function, ast.NameExpr)
    word = expr.function.name
    if "n" not in ctx.extra:
        return ck.error(
            "wrong-type",
            expr.span,
            f"`{word}` asks about a point of a surface: it stands in formulas of labels and fields",
            hint=f"as in `label affordance.push on door.panel where {word}(open)`",
        )
    (kind,) = _positional(ck, ctx.but(lenient=[], asked=True, many=True), expr, 1, word)
    if not isinstance(kind, Joint) and kind != UNKNOWN:
        ck.error("wrong-type", expr.arguments[0].span, f"`{word}` takes a joint, but this is {kind}")
    return BOOL


def _method(ck: Checker, ctx: Context, expr: ast.CallExpr, function: ast.MemberExpr) -> Type:
    obj = ck.infer(ctx, function.obj)
    if obj == UNKNOWN:
        return UNKNOWN
    if function.name == "at" and (obj in (SURFACE, PLANE) or isinstance(obj, Slot | Part)):
        for argument in expr.arguments:
            kind = ck.infer(ctx, argument.value)
            name = argument.name
            if name not in (None, "u", "v", "x", "y", "z"):
                ck.error("unknown-argument", argument.span, f"`at` takes u, v, x, y and z, not `{name}`")
            elif name in ("x", "y", "z") and not fits(kind, LENGTH):
                ck.mismatch(argument.value, kind, LENGTH, f"`{name}` of `at`")
        if not 1 <= len(expr.arguments) <= 2:
            ck.error("wrong-arguments", expr.span, "`at` needs two values, as in `wall.at(0.25turn, z = h)`")
        return FRAME
    for argument in expr.arguments:
        ck.infer(ctx, argument.value)
    return ck.error("unknown-function", function.name_span, f"{obj} has no function `{function.name}`")


def _angle_in(kind: Scalar) -> Scalar | None:
    return RATIO if kind.zero or kind.dimension == ANGLE.dimension else None


def _ratio_in(result: Scalar) -> Callable[[Scalar], Scalar | None]:
    return lambda kind: result if kind.dimension == NONE else None


_BUILT_IN: dict[str, Callable[[Checker, Context, ast.CallExpr], Type]] = {
    **{word: _unary(_angle_in, "an angle") for word in ("sin", "cos", "tan")},
    **{word: _unary(_ratio_in(ANGLE), "a ratio") for word in ("asin", "acos", "atan")},
    **{word: _unary(_ratio_in(RATIO), "a ratio") for word in ("exp", "log")},
    **{word: _unary(_ratio_in(COUNT), "a ratio") for word in ("floor", "ceil", "round")},
    "sqrt": _unary(lambda kind: Scalar(power(kind.dimension, Fraction(1, 2))), "a number"),
    "abs": _unary(lambda kind: kind, "a number"),
    "sign": _unary(lambda kind: COUNT, "a number"),
    "hypot": _several,
    "min": _extremum,
    "max": _extremum,
    "sum": _reduce,
    "number": _number,
    "atan2": _atan2,
    "mod": _mod,
    "lowest": _lowest,
    **dict.fromkeys(DRIVES, _drive),
    "frame": _named(FRAME, {"at": (POINT, True), "out": (DIRECTION, True), "up": (DIRECTION, True)}),
    "line": _line,
    "box": _box,
    "from": _from,
    "arc": _named(CURVE, {"radius": (LENGTH, True), "angle": (ANGLE, True), "towards": (DIRECTION, False)}),
    "circle": _named(CURVE, {"radius": (LENGTH, True)}),
    "rectangle": _named(CURVE, {"width": (LENGTH, True), "height": (LENGTH, True)}),
    "polygon": _polygon,
    "offset": _offset,
}
