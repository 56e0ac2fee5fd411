"""Labels, fields, grasps, keypoints, symmetries and materials: their targets and their formulas."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from ..diagnostics.suggest import did_you_mean, suggest
from ..syntax import ast
from ..syntax.walk import path_root, put_together, walk
from ..units import UNITS
from . import paths
from .alternatives import unknown_material
from .declarations import check_range
from .entries import of_reference
from .fold import constant
from .guards import consistent
from .meanings import Declared, Global, Inner, Previous
from .names import warn_hidden
from .offers import missing
from .ranges import range_type
from .remedies import instead
from .symbols import Symbol
from .types import (
    BOOL,
    COUNT,
    DIRECTION,
    EDGE,
    FRAME,
    LENGTH,
    LENGTH_DIM,
    LINE,
    MATERIAL,
    NONE,
    PLANE,
    POINT,
    RATIO,
    SIZE,
    SURFACE,
    UNKNOWN,
    Boxed,
    JointType,
    PartType,
    ScalarType,
    SlotType,
    Type,
    VecType,
)

if TYPE_CHECKING:
    from .checker import Checker, Context

# u and v have the dimension of the surface that a point lies on
_FORMULA: Mapping[str, Type] = {"p": SIZE, "n": VecType(3, NONE), "u": UNKNOWN, "v": UNKNOWN, "size": SIZE}


_COMPARED = ("<", "<=", ">", ">=", "==", "!=")


def check(ck: Checker, ctx: Context, stmt: ast.Stmt) -> None:
    """One statement that says something about parts rather than making them."""
    match stmt:
        case ast.LabelStmt():
            _label(ck, ctx, stmt)
        case ast.FieldStmt():
            _field(ck, ctx, stmt)
        case ast.GraspStmt():
            _grasp(ck, ctx, stmt)
        case ast.KeypointStmt(target=at, at=place):
            kind, ctx = _place(ck, ctx, at)
            if not isinstance(kind, Boxed) and kind not in (UNKNOWN, FRAME, POINT, PLANE, EDGE, LINE, SURFACE):
                ck.unfit(
                    at,
                    kind,
                    "a keypoint must be on a part, a port or a point",
                    hint="name a part, a face or a port, and the place with `at [x, y, z]`",
                )
            if place is not None:
                ck.expect(formula(ctx), place, POINT, "the place of a keypoint")
                if not isinstance(kind, PartType | SlotType) and kind != UNKNOWN:
                    ck.error(
                        "unknown-clause",
                        place.span,
                        f"`at` has no effect here: `{at.span.words}` is no part but a place itself",
                        hint="name the part, as in `keypoint tip on body at [0, 0, size.z / 2]`, or leave out `at`",
                    )
            _twice(ck, ctx, stmt, "keypoint")
        case ast.SymmetryStmt(target=at, turn=turn, direction=direction):
            target(ck, ctx, at, "a symmetry belongs to", alone=True)
            if turn is not None:
                ck.expect(ctx, turn, COUNT, "the turns of a symmetry")
                if (turns := constant(turn, ctx.module)) is not None and turns < 2:
                    ck.error(
                        "illegal-value",
                        turn.span,
                        "a symmetry has at least two turns",
                        hint="write 2 or more, or `any`; without a symmetry, leave the statement out",
                    )
            ck.expect(ctx, direction, DIRECTION, "the axis of a symmetry")
        case ast.MaterialStmt():
            _material(ck, ctx, stmt)
        case _:
            raise TypeError(f"no rule for {type(stmt).__name__}")


def _twice(ck: Checker, ctx: Context, stmt: ast.KeypointStmt | ast.GraspStmt, kind: str) -> None:
    """Two keypoints or grasps of one name on one part could not be told apart, unless conditions exclude each other."""
    words = stmt.target.span.words
    before = ck.marks.setdefault((ctx.scope, kind, stmt.name, words), [])
    first = next((span for condition, span in before if consistent(condition, ctx.condition)), None)
    if first is not None:
        ck.error(
            "duplicate-name",
            stmt.name_span,
            f"there are two {kind}s `{stmt.name}` on `{words}`",
            hint=f"rename one of them, as in `{stmt.name}_left`",
            notes=((first, "the first of them"),),
        )
    before.append((ctx.condition, stmt.name_span))


def formula(ctx: Context) -> Context:
    """The place of a formula on a surface: ``p``, ``n``, ``u``, ``v`` and ``size`` are the target's own."""
    return ctx.but(extra={**ctx.extra, **_FORMULA})


def _place(ck: Checker, ctx: Context, expr: ast.Expr) -> tuple[Type, Context]:
    """A target and the context of what stands beside it: absent, the statement is void."""
    noted: list[Any] = []
    kind = ck.infer(ctx.but(lenient=noted, many=True, subject=True), expr)
    return kind, ctx.given(*noted)


def target(ck: Checker, ctx: Context, expr: ast.Expr, rule: str, alone: bool = False) -> Context:
    """What a label lies on: parts, slots and surfaces, also through repeats. ``alone``: the statement takes one of them."""
    if named := put_together(expr):
        _refuse_joined(ck, ctx, expr, named, alone)
        return ctx
    kind, ctx = _place(ck, ctx, expr)
    if not isinstance(kind, Boxed) and kind not in (UNKNOWN, PLANE, SURFACE):
        ck.unfit(
            expr,
            kind,
            f"{rule} parts, slots or surfaces",
            hint="name a part, a slot or a surface; where on it, say with `where`",
        )
    elif kind == PLANE and isinstance(expr, ast.MemberExpr) and _is_surface(ck, expr):
        ck.mean(expr, Inner(expr.name))  # the surface of that name, not the face of the box
    elif kind == PLANE:
        ck.error(
            "wrong-type",
            expr.span,
            f"{rule} parts, slots or surfaces, but this is a face of a box",
            hint="name the part, and say where on it: `label affordance.push on door where p.x > 0`",
        )
    not_previous(ck, expr)
    return ctx


def _refuse_joined(ck: Checker, ctx: Context, expr: ast.Expr, named: list[ast.Expr], alone: bool) -> None:
    """Reports ``body and lid`` or ``[body, lid]`` as a target."""
    paths = [one for one in named if isinstance(one, ast.NameExpr | ast.MemberExpr | ast.IndexExpr)]
    for one in paths:
        _place(ck, ctx, one)
    if alone:
        said, hint = "this takes one target", f"state it of each by itself, first of `{named[0].span.words}`"
    elif len(paths) == len(named):
        said, hint = "targets are separated by commas", f"write `{', '.join(one.span.words for one in named)}`"
    else:
        said, hint = "a condition follows `where`", f"for example `on {named[0].span.words} where n.z > 0.5`"
    first = f"`{expr.op}` joins conditions" if isinstance(expr, ast.BinaryExpr) else "brackets make a vector of numbers"
    ck.error("wrong-type", expr.span, f"{first}; {said}", hint=hint)


def _is_surface(ck: Checker, expr: ast.MemberExpr) -> bool:
    """Whether what is called like a face may be a surface of a primitive, too."""
    owners = _made_of(ck, expr.obj, ck.types.get(id(expr.obj)))
    entries = (entry for symbol in owners for entry in ck.scope_of(symbol).table.get(expr.name, ()))
    return any(entry.kind == "surface" for entry in entries)


def _made_of(ck: Checker, expr: ast.Expr, kind: Type | None) -> Iterator[Symbol]:
    """What the parts that a path names are made of, those that a slot binds included."""
    if isinstance(kind, PartType):
        yield from (v.symbol for v in kind.variants if v.symbol is not None)
    if not isinstance(kind, SlotType) or not isinstance(expr, ast.MemberExpr):
        return
    for owner in _made_of(ck, expr.obj, ck.types.get(id(expr.obj))):
        for entry in (e for scope in ck.scope_of(owner).below() for e in scope.table.get(expr.name, ())):
            if not isinstance(entry.node, ast.SlotDecl):
                yield from _made_of(ck, expr, ck.entry_type(entry))
                continue
            inside = ck.context(entry.scope).but(lenient=[], many=True, subject=True)
            for bound in entry.node.targets:
                with ck.muted():
                    kind = ck.infer(inside, bound)
                yield from _made_of(ck, bound, kind)


_OF_TWO = "of two elements, write behind the repeat `row[0].post` and `row[1].post`, or `row.post` twice for any two"


def not_previous(ck: Checker, expr: ast.Expr, of_two: bool = False) -> None:
    """A statement about parts means them in every element; `previous` is no part of its own."""
    first = path_root(expr)
    if isinstance(ck.meanings.get(id(first)), Previous):
        ck.error(
            "wrong-type",
            first.span,
            "`previous` is not allowed here: the statement applies to the part in every element",
            hint=_OF_TWO if of_two else "omit `previous`, or give the number of an element: `post[0]`, `post[last]`",
        )


def _targets(ck: Checker, ctx: Context, targets: tuple[ast.Expr, ...], rule: str) -> Context:
    there = [target(ck, ctx, expr, rule).condition for expr in targets]
    return ctx.given(*there)


def _word(ck: Checker, ctx: Context, vocabulary: str, word: str) -> str:
    """A hint: the nearest word that there is, and how to have this one."""
    others = [name for name, words in ck.vocabularies.items() if word in words and ctx.module.find(name) is not None]
    if others:
        return f"did you mean `{others[0]}.{word}`?"
    own = f"`vocabulary {vocabulary} {{ {word} }}`"
    symbol = ctx.module.names.get(vocabulary)
    brought = symbol is not None and symbol.module is not ctx.module
    add = f"to add a word of your own: {own}" + (f", and remove `{vocabulary}` from `use`" if brought else "")
    near = did_you_mean(word, ck.vocabularies[vocabulary])
    return f"{near} {add}" if near else add


def _label(ck: Checker, ctx: Context, stmt: ast.LabelStmt) -> None:
    words = ck.vocabularies.get(stmt.vocabulary)
    if words is None:
        ck.unknown(
            ctx.module,
            stmt.vocabulary,
            "unknown-vocabulary",
            stmt.label_span,
            f"there is no vocabulary `{stmt.vocabulary}`",
            hint=missing(stmt.vocabulary, ck.vocabularies, "vocabulary")
            or f"declare it: `vocabulary {stmt.vocabulary} {{ {stmt.label} }}`",
        )
    elif stmt.label not in words:
        ck.error(
            "unknown-label",
            stmt.label_span,
            f"the vocabulary `{stmt.vocabulary}` has no word `{stmt.label}`",
            hint=_word(ck, ctx, stmt.vocabulary, stmt.label),
        )
    elif (symbol := ctx.module.find(stmt.vocabulary)) is not None and symbol.kind == "vocabulary":
        ck.mean(stmt, Global(symbol))
    if stmt.joint is not None:
        _acted(ck, ctx, stmt.joint, stmt.vocabulary)
    place = formula(_targets(ck, ctx, stmt.targets, "a label lies on"))
    _condition(ck, place, stmt.where)
    if stmt.value is not None:
        ck.expect(place, stmt.value, RATIO, "the degree of a label")
        if stmt.vocabulary == "semantic":
            ck.error(
                "wrong-type",
                stmt.value.span,
                "a `semantic` label says what a part is, so it has no degree",
                hint="say where it holds with `where`, or write a `field`",
            )
        _relative(ck, stmt.value)


def _acted(ck: Checker, ctx: Context, joint: ast.Expr, vocabulary: str) -> None:
    """The joint that a label is ``for``."""
    if vocabulary == "semantic":
        ck.error(
            "wrong-type",
            joint.span,
            "a `semantic` label says what a part is, so it takes no `for`",
            hint="`for` goes with labels of actions: `label affordance.lift for raise on lid`",
        )
    kind = ck.infer(ctx.but(lenient=[], asked=True, many=True), joint)
    if not isinstance(kind, JointType) and kind != UNKNOWN:
        ck.unfit(
            joint, kind, "`for` must name a joint", hint="name the joint that carries the target, as in `for open`"
        )


def _field(ck: Checker, ctx: Context, stmt: ast.FieldStmt) -> None:
    kind = of_reference(ck, ctx, stmt.type)
    if (
        not isinstance(kind, ScalarType)
        and kind not in (BOOL, UNKNOWN)
        and not (isinstance(kind, VecType) and kind.size == 3)
    ):
        ck.unfit(
            stmt.type,
            kind,
            "a field must hold a number, a vector of three or a truth value",
            hint="for example `ratio`, `length`, `vec`, `length[3]` or `bool`",
        )
        kind = UNKNOWN
    place = formula(_targets(ck, ctx, stmt.targets, "a field lies on"))
    _condition(ck, place, stmt.where)
    if not (kind == VecType(3, NONE) and ck.infer(place, stmt.value) == DIRECTION):  # a direction is a unit vector
        ck.expect(place, stmt.value, kind, "the field")
    _relative(ck, stmt.value)


def _condition(ck: Checker, place: Context, where: ast.Expr | None) -> None:
    if where is None:
        return
    kind = ck.infer(place, where)
    if kind not in (BOOL, UNKNOWN):
        ck.unfit(where, kind, "`where` needs a condition", hint=instead(where, kind, BOOL))
    _relative(ck, where)


def _relative(ck: Checker, expr: ast.Expr) -> None:
    """Warns of lengths written into the comparisons of a formula: what holds for one size is wrong for another."""
    for compared in walk(expr):
        if not isinstance(compared, ast.BinaryExpr) or compared.op not in _COMPARED:
            continue
        for number in walk(compared):
            if isinstance(number, ast.NumberExpr) and number.value and _is_length(number.unit):
                ck.warning(
                    "absolute-tolerance",
                    number.span,
                    "a fixed length in a label does not scale with the part",
                    hint="write a fraction of `size` (`p.z > 0.45 * size.z`), or name a parameter of the part",
                )


def _is_length(unit: str) -> bool:
    return unit in UNITS and UNITS[unit][1] == LENGTH_DIM


def _grasp(ck: Checker, ctx: Context, stmt: ast.GraspStmt) -> None:
    ctx = target(ck, ctx, stmt.target, "a grasp lies on", alone=True)
    _twice(ck, ctx, stmt, "grasp")
    place = formula(ctx)
    if stmt.range is not None and stmt.parameter is not None:
        kind = range_type(ck, place, stmt.range)
        check_range(ck, place, stmt.range, kind, f"an end of the range of `{stmt.parameter}`")
        place = place.but(extra={**place.extra, stmt.parameter: kind})
        if ctx.scope is not None and (hidden := ctx.scope.find(stmt.parameter)):
            warn_hidden(ck, stmt.parameter, stmt.name_span, hidden[0], "in the grasp")
    wanted: tuple[tuple[ast.Clause[ast.Expr] | None, Type], ...] = (
        (stmt.at, POINT),
        (stmt.approach, DIRECTION),
        (stmt.close, DIRECTION),
        (stmt.opening, LENGTH),
        (stmt.quality, RATIO),
        *((measure, LENGTH) for measure in stmt.hand),
    )
    for clause, kind in wanted:
        if clause is not None:
            ck.expect(place, clause.value, kind, f"`{clause.word}` of a grasp")
    for clause in stmt.unknown:
        ck.error(
            "unknown-clause",
            clause.span,
            f"`grasp` takes no `{clause.word}`",
            hint=did_you_mean(clause.word, ast.clause_words(ast.GraspStmt)),
        )
    needed = {"at": stmt.at, "approach": stmt.approach, "close": stmt.close, "opening": stmt.opening}
    meant = {suggest(clause.word, needed) for clause in stmt.unknown}
    missing = [f"`{word}`" for word, clause in needed.items() if clause is None and word not in meant]
    if missing:
        hint = "for example `grasp hold on knob { at [0, 0, 0]  approach -x  close y  opening size.y }`"
        ck.error("missing-clause", stmt.name_span, f"the grasp lacks {' and '.join(missing)}", hint=hint)


def _material(ck: Checker, ctx: Context, stmt: ast.MaterialStmt) -> None:
    for expr in stmt.targets:
        target(ck, ctx, expr, "a material lies on")
    home = ctx.scope.home(stmt.material) if ctx.scope is not None else None
    if home is not None:
        ck.mean(stmt, Declared(stmt.material, home.depth))
        kind = ck.entry_type(paths.sole(ck, ctx, home.table[stmt.material], stmt.material_span))
        if kind not in (MATERIAL, UNKNOWN):
            ck.error(
                "wrong-type",
                stmt.material_span,
                f"`{stmt.material}` is not a material but {kind}",
                hint="name a `material`, or a `style NAME : material = oak | steel`",
            )
        return
    symbol = ctx.module.find(stmt.material)
    if symbol is None or symbol.kind != "material":
        unknown_material(ck, ctx, stmt.material, stmt.material_span)
    else:
        ck.mean(stmt, Global(symbol))
