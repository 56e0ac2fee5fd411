"""Types of calls, and of the program's own functions, curves and surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean, given
from ..language import FUNCTIONS
from ..syntax import ast
from . import foreign, functions, paths
from .meanings import Declared, Global
from .ranges import range_type
from .scope import Entry
from .types import CURVE, POINT, UNKNOWN, ScalarType, Type

if TYPE_CHECKING:
    from .checker import Checker, Context


def call(ck: Checker, ctx: Context, expr: ast.CallExpr) -> Type:
    """The type of a call."""
    if isinstance(expr.function, ast.MemberExpr):
        return functions.method(ck, ctx, expr, expr.function)
    if not isinstance(expr.function, ast.NameExpr):
        for part in (expr.function, *(argument.value for argument in expr.arguments)):
            ck.infer(ctx, part)
        return ck.error(
            "wrong-type",
            expr.function.span,
            "only the name of a function can be called",
            hint="the result of a function cannot be called; to multiply, write `*`",
        )
    word = expr.function.name
    home = ctx.scope.home(word) if ctx.scope is not None else None
    own = [e for e in home.table[word] if _is_function(e.node)] if home is not None else []
    if home is not None and own:
        ck.mean(expr.function, Declared(word, home.depth))
        return _own(ck, ctx, expr, paths.sole(ck, ctx, own, expr.function.span))
    if word in FUNCTIONS:
        return functions.built_in(ck, ctx, expr, FUNCTIONS[word])
    symbol = ctx.module.find(word)
    if symbol is not None and isinstance(symbol.decl, ast.FunctionDecl) and symbol.decl.parameters:
        ck.mean(expr.function, Global(symbol))
        arguments = _positional(ck, ctx, expr, len(symbol.decl.parameters), word)
        inside = type(ctx)(symbol.module)
        return _apply(ck, inside, expr, symbol.decl.parameters, symbol.decl.value, arguments, id(symbol.decl))
    for argument in expr.arguments:
        ck.infer(ctx, argument.value)
    if symbol is not None or (ctx.scope is not None and ctx.scope.find(word)):
        hint = (
            f"to make a part, write `part name : {word}(...)`"
            if symbol is not None
            else f"to multiply, write `{word} * (...)`"
            if isinstance(ck.infer(ctx, expr.function), ScalarType)
            else f"write `{word}` alone"
        )
        return ck.error("wrong-type", expr.function.span, f"`{word}` is not a function", hint=hint)
    return ck.unknown(
        ctx.module,
        word,
        "unknown-function",
        expr.function.span,
        f"there is no function `{word}`",
        hint=foreign.FUNCTIONS.get(word.lower())
        or did_you_mean(word, [*FUNCTIONS, *ctx.names()])
        or f"declare it: `let {word}(a) = ...`",
    )


def _is_function(node: ast.Stmt) -> bool:
    """Whether a declaration can be called."""
    return isinstance(node, ast.SurfaceDecl | ast.CurveDecl) or isinstance(node, ast.LetDecl) and bool(node.parameters)


def _positional(ck: Checker, ctx: Context, expr: ast.CallExpr, wanted: int, word: str) -> list[Type]:
    """The types of arguments that stand without names, in number ``wanted``."""
    kinds = [ck.infer(ctx, a.value) for a in expr.arguments]
    if len(kinds) != wanted:
        many = "one argument" if wanted == 1 else f"{wanted} arguments"
        ck.error(
            "wrong-arguments",
            expr.span,
            f"`{word}` takes {many}, {given(len(kinds))}",
            hint="write the arguments in the order of its declaration"
            if len(kinds) < wanted
            else "leave out what is too many",
        )
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
    arguments = [ScalarType(t.dimension) if isinstance(t, ScalarType) and not t.zero else t for t in arguments]
    key = (identity, *arguments)
    if identity in ck.calling:
        return ck.error(
            "circular-definition",
            expr.span,
            "this function is defined in terms of itself",
            hint="write the steps out, or let a repeat add them up: `sum(row.w)`",
        )
    if key not in ck.calls:
        extra = dict(zip(names, arguments, strict=True))
        silent = inside.but(extra=extra, silent=True)
        ck.calling.append(identity)
        ck.calls[key] = UNKNOWN if UNKNOWN in arguments else ck.infer(silent, value)
        ck.calling.pop()
    return ck.calls[key]


def chain(ck: Checker, ctx: Context, expr: ast.ChainExpr) -> Type:
    """``from(point, direction)`` followed by straight and bent pieces."""
    for number, piece in enumerate(expr.pieces):
        assert isinstance(piece.function, ast.NameExpr)
        word = piece.function.name
        if (word == "from") != (number == 0) or word not in ("from", "line", "arc"):
            ck.error(
                "wrong-type",
                piece.span,
                f"`{word}` is not allowed here in a path",
                hint="a path is written `from(point, direction)`, then `line(length)` and `arc(radius, angle, towards)`",
            )
        kind = ck.infer(ctx.but(making=expr), piece)
        if kind not in (CURVE, UNKNOWN):
            ck.unfit(
                piece,
                kind,
                "a piece of a path is needed here",
                hint="a path is written `from(point, direction) line(length) arc(radius, angle, towards)`",
            )
    return CURVE
