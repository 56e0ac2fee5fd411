"""Checks of what a primitive is made of: surfaces, curves, the inside function, its box, pieces and operators."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnostics.suggest import any_of, suggest
from ..language import OPERATORS, Kind
from ..syntax import ast
from . import foreign
from .conditions import truth
from .declarations import check_range
from .ranges import range_type
from .symbols import Symbol
from .types import COUNT, CURVE, DIRECTION, LENGTH, LENGTH_DIM, POINT, SIZE, UNKNOWN, ScalarType, Type, VecType, fits

if TYPE_CHECKING:
    from .checker import Checker, Context


def check(ck: Checker, ctx: Context, stmt: ast.Stmt) -> None:
    """One statement that shapes a primitive."""
    match stmt:
        case ast.SurfaceDecl():
            _surface(ck, ctx, stmt)
        case ast.CurveDecl(parameter=name, parameter_range=interval, value=value):
            kind = _parameter(ck, ctx, interval, f"`{name}`")
            given = ck.infer(ctx.but(extra={name: kind}), value)
            if given not in (UNKNOWN, POINT) and not (
                isinstance(given, VecType) and given.dimension in (LENGTH_DIM, None)
            ):
                ck.mismatch(value, given, VecType(2, LENGTH_DIM), f"a point of the curve `{stmt.name}`")
        case ast.InsideDecl(parameter=name, value=value):
            ck.expect(ctx.but(extra={name: SIZE}), value, LENGTH, "`inside`")
        case ast.BoxDecl():
            for corner in ast.present(stmt.value, stmt.low, stmt.high):
                ck.expect(ctx, corner, SIZE, "the box")
        case ast.PieceDecl():
            _piece(ck, ctx, stmt)
        case ast.SolidDecl():
            _solid(ck, ctx, stmt)


def _parameter(ck: Checker, ctx: Context, interval: ast.RangeExpr, what: str) -> Type:
    kind = range_type(ck, ctx, interval)
    if kind != UNKNOWN and not isinstance(kind, ScalarType):
        ck.unfit(interval, kind, f"{what} must range over numbers", hint="write two numbers, as in `u in 0 .. 1`")
        return UNKNOWN
    check_range(ck, ctx, interval, kind, f"an end of the range of {what}")
    return kind


def _indexed(ck: Checker, ctx: Context, index: str | None, count: ast.Expr | None) -> Context:
    if count is not None:
        ck.expect(ctx, count, COUNT, "the number of copies")
    return ctx if index is None else ctx.but(extra={**ctx.extra, index: COUNT})


def _surface(ck: Checker, ctx: Context, stmt: ast.SurfaceDecl) -> None:
    ctx = _indexed(ck, ctx, stmt.index, stmt.index_count)
    u = _parameter(ck, ctx, stmt.u_range, f"`{stmt.u}`")
    v = _parameter(ck, ctx, stmt.v_range, f"`{stmt.v}`")
    place = ctx.but(extra={**ctx.extra, stmt.u: u, stmt.v: v})
    ck.expect(place, stmt.value, SIZE, f"a point of the surface `{stmt.name}`")
    if stmt.guard is not None:
        truth(ck, ctx, stmt.guard)


def _piece(ck: Checker, ctx: Context, stmt: ast.PieceDecl) -> None:
    ctx = _indexed(ck, ctx, stmt.index, stmt.count)
    for point in stmt.points:
        ck.expect(ctx, point, POINT, "a corner of a piece")
    if len(stmt.points) < 4:
        ck.error(
            "wrong-arguments",
            stmt.span,
            "a piece needs at least four corners",
            hint="write the corners of a convex body: four or more points, not all in one plane",
        )
    if stmt.guard is not None:
        truth(ck, ctx, stmt.guard)


def _solid(ck: Checker, ctx: Context, stmt: ast.SolidDecl) -> None:
    operator = OPERATORS.get(stmt.operator)
    if operator is None:
        meant = foreign.OPERATORS.get(stmt.operator) or suggest(stmt.operator, OPERATORS)
        hint = f"did you mean `{meant}`?" if meant else "there are " + ", ".join(OPERATORS)
        ck.error("unknown-function", stmt.span, f"there is no operator `{stmt.operator}`", hint=hint)
        return
    for argument in stmt.arguments:
        chain = argument.value.items if isinstance(argument.value, ast.VectorExpr) else (argument.value,)
        for curve in chain:  # one curve, or a chain of them in brackets
            ck.expect(ctx.but(making=curve), curve, CURVE, f"an argument of `{stmt.operator}`")
    if operator is not None:
        _whole(ck, stmt, operator)
    for end in ast.present(stmt.from_, stmt.to):
        ck.expect(ctx, end.value, LENGTH, f"`{end.word}`")
    levels = stmt.at
    if levels is not None and isinstance(levels.value, ast.VectorExpr):
        for level in levels.value.items:  # any number of them, so no vector
            ck.expect(ctx, level, LENGTH, "a level")
        levels = None
    for clause in ast.present(stmt.about, stmt.along, stmt.up, levels):
        kind = ck.infer(ctx, clause.value)
        if kind != CURVE and not fits(kind, DIRECTION):
            ck.mismatch(clause.value, kind, DIRECTION, f"what follows `{clause.word}`")


def _whole(ck: Checker, stmt: ast.SolidDecl, operator: Kind) -> None:
    """An operator has its arguments, the clauses that it needs, and none that it would not read."""
    given = {clause.word: clause for clause in ast.clauses(stmt)}
    for word, clause in given.items():
        if word not in operator.clauses:
            hint = "it takes " + ", ".join(f"`{w}`" for w in operator.clauses)
            ck.error("unknown-clause", clause.span, f"`{operator.name}` takes no `{word}`", hint=hint)
    lacking = [word for word in operator.needs if word not in given]
    if len(stmt.arguments) not in operator.arguments:
        few = "needs at least two sections" if stmt.arguments else "needs a curve"
        what = "takes one chain of curves, or an outer and an inner one" if len(stmt.arguments) > 1 else few
        hint = f"for example `{operator.example}`"
        ck.error("wrong-arguments", stmt.span, f"`{operator.name}` {what}", hint=hint)
    if lacking:
        hint = f"for example `{operator.example}`"
        ck.error("missing-clause", stmt.span, f"`{operator.name}` needs {any_of(lacking, 'and')}", hint=hint)


_ENDS = ("start", "end")


def check_whole(ck: Checker, symbol: Symbol) -> None:
    """A primitive is surfaces with an inside function and a box, or one solid."""
    body = symbol.body
    for word, kind in (("solid", ast.SolidDecl), ("inside", ast.InsideDecl), ("box", ast.BoxDecl)):
        spans = [s.span for s in body if isinstance(s, kind)]
        for span in spans[1:]:
            ck.error(
                "duplicate-name",
                span,
                f"a primitive has one `{word}`",
                notes=((spans[0], "the first one"),),
                hint="join the two into one",
            )
    for require in (s for s in body if isinstance(s, ast.RequireStmt)):
        if require.stable is not None or require.repair is not None:
            word = "stable" if require.repair is None else "repair"
            said = f"`{word}` is not allowed in a primitive: `require` limits its parameters"
            hint = "write the requirement in the category or template that uses it"
            ck.error("misplaced-statement", require.span, said, hint=hint)
    solids = [s for s in body if isinstance(s, ast.SolidDecl)]
    if solids:
        for curve in (s for s in body if isinstance(s, ast.CurveDecl | ast.LetDecl) and s.name in _ENDS):
            if isinstance(curve, ast.LetDecl) and curve.keyword != "curve":
                continue
            ck.error(
                "reserved-name",
                curve.name_span,
                f"the operator makes a surface `{curve.name}`, which could not be told from that of this curve",
                hint="choose another name for the curve, such as `skin`",
                notes=((solids[0].span, "this operator"),),
            )
        for own in (s for s in body if isinstance(s, ast.SurfaceDecl | ast.InsideDecl)):
            what = "inside (p)" if isinstance(own, ast.InsideDecl) else f"surface {own.name}"
            ck.error(
                "misplaced-statement",
                own.span,
                f"`{what}` has no effect: the operator makes the surfaces and `inside`",
                hint="leave it out, or give all surfaces, `inside` and `box` instead of a `solid`",
                notes=((solids[0].span, "this operator"),),
            )
        return
    lacking = [
        word
        for word, kind in (("surface", ast.SurfaceDecl), ("inside", ast.InsideDecl), ("box", ast.BoxDecl))
        if not any(isinstance(s, kind) for s in body)
    ]
    if lacking:
        ck.error(
            "incomplete-primitive",
            symbol.decl.name_span,
            f"the primitive `{symbol.name}` is missing {any_of(lacking, 'and')}",
            hint="give surfaces, `inside` and `box`, or a `solid`",
        )
