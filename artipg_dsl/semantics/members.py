"""Members and elements: what ``door.panel.front.center.z`` and ``column[last]`` stand for, and whether they exist."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean
from ..language import DIRECTIONS, FACES
from ..source import Span
from ..syntax import ast
from ..units import UNITS
from . import conditions, foreign, paths
from .entries import narrowed
from .fold import constant
from .guards import TRUE, Or, conjunction
from .meanings import Feature, Inner, Last
from .parts import BOX_MEMBERS, box_member, clashing, listed, part_member, place_member, place_names
from .presence import declared, excludes, guarded, of_element, optional
from .scope import Entry
from .types import (
    BOX,
    COUNT,
    LENGTH,
    POINT,
    SURFACE,
    UNKNOWN,
    ArrayType,
    Boxed,
    ElementType,
    FunctionType,
    JointType,
    NamedType,
    PartType,
    ScalarType,
    SlotType,
    StyleType,
    Type,
    VecType,
)

if TYPE_CHECKING:
    from .checker import Checker, Context


def member(ck: Checker, ctx: Context, expr: ast.MemberExpr) -> Type:
    """The type of ``obj.name``."""
    obj = ck.infer(ctx, expr.obj)
    word, span = expr.name, expr.name_span
    if obj != UNKNOWN:
        declared_there = isinstance(obj, PartType) and word not in BOX_MEMBERS or _in_element(obj, word)
        if not declared_there:
            ck.mean_member(expr, Feature(word))
        elif not isinstance(obj, PartType):
            ck.mean_member(expr, Inner(word))
    match obj:
        case PartType():
            kind = part_member(ck, ctx, obj, word, span, expr.obj.span.words)
            if declared_there:
                ck.mean_member(expr, Inner(word, clashing(ck, obj, word), kind))
            return kind
        case ElementType():
            return _element_member(ck, ctx, obj, word, span, expr.obj.span.words)
        case SlotType():
            found = box_member(word)
        case VecType(size=size, dimension=dimension):
            found = None
            if word in DIRECTIONS[:size]:
                found = ScalarType(dimension) if dimension is not None else LENGTH
        case NamedType():
            found = place_member(obj, word)
        case FunctionType():
            return ck.error(
                "wrong-type",
                expr.span,
                f"`{obj.entry.name}` is a function: it needs arguments",
                hint=f"write `{obj.entry.name}(...)`",
            )
        case _:
            found = UNKNOWN if obj == UNKNOWN else None
    if found is None:
        known = place_names(obj)
        hint = (
            did_you_mean(word, known)
            or listed(known)
            or (
                "a style makes no part: name a part that it is the template of"
                if isinstance(obj, StyleType)
                else f"leave `.{word}` out: a part or a vector has members, a number none"
            )
        )
        if word in FACES and isinstance(expr.obj, ast.MemberExpr) and expr.obj.name in FACES:
            hint = "only adjacent faces share an edge, as in `left.back`"
        if isinstance(expr.obj, ast.NumberExpr) and word in UNITS:
            hint = f"a unit directly follows its number: write `{expr.obj.span.text.rstrip('.')}{word}`"
        return ck.error("unknown-member", span, f"{obj} has no `{word}`", hint=hint)
    return found


def _in_element(obj: Type, word: str) -> bool:
    """Whether the body of a repeat declares a name that others may use."""
    if not isinstance(obj, ElementType):
        return False
    inner = obj.entry.scope.inner[id(obj.entry.node)]
    return any(not e.private or e.kind == "index" for e in inner.table.get(word, ()))


def _element_member(ck: Checker, ctx: Context, obj: ElementType, word: str, span: Span, path: str) -> Type:
    entry = obj.entry
    inner = entry.scope.inner[id(entry.node)]
    found = [e for e in inner.table.get(word, []) if not e.private or e.kind == "index"]
    if found:
        target = found[0]
        there = of_element(obj, declared(ck, found))
        if target.kind == "repeat":
            ck.demand(ctx, there, span, *guarded(target, span, path), value=not ctx.subject)
            return _inner(ck, ctx, obj, target, span)
        kind = ck.entry_type(target)
        if isinstance(kind, ArrayType):
            return replace(kind, bound=tuple((k, of_element(obj, c)) for k, c in kind.bound))
        if there != TRUE:
            message, hint = guarded(target, span, path)
            followed = ctx.subject and isinstance(kind, Boxed | JointType)
            around = ctx.given(of_element(obj, ck.condition(inner.guards)))
            ck.demand(around, there, span, message, hint, ((target.span, "declared here"),), value=not followed)
        if isinstance(kind, PartType):
            current = obj.key == entry.key and not obj.many
            key = kind.key if current else f"{obj.key}.{word}"
            part = replace(kind, key=key, many=obj.many, given=of_element(obj, kind.given))
            message, hint = optional(f"{path}.{word}")
            if obj.many:
                hint = f"give each element a value inside the repeat, as in `let tall = {word}.size.z if {word} else 0cm`, and name that"
            ck.demand(ctx, part.there, span, message, hint, value=not ctx.subject)
            return narrowed(ctx, part)
        return kind
    if word == "gap":
        if not obj.many and obj.key == entry.key:
            ck.demand(
                ctx,
                inner.after_first,
                span,
                f"`{entry.name}.gap` does not exist for the first element",
                f"put this inside `when {entry.name}.gap {{ }}`",
            )
        return BOX
    own = box_member(word)
    if own is not None:
        return own
    names = [*inner.table, *BOX_MEMBERS, "gap"]
    ranked = obj.ranked if word in ("index", "rank", "number") else None
    meant = foreign.MEMBERS.get(word) or did_you_mean(word, names) or ranked or listed(names)
    return ck.error("unknown-member", span, f"an element of `{entry.name}` has no `{word}`", hint=meant)


def _inner(ck: Checker, ctx: Context, obj: ElementType, target: Entry, span: Span) -> Type:
    if obj.many or obj.key != obj.entry.key:  # of one named element, all of an inner repeat
        if not obj.many and not ctx.many:
            return ck.many_elements(target.name, span)
        return ElementType(target, f"{obj.key}.{target.name}", many=True, outer=obj)
    return paths.repeat(ck, ctx, target, span)


def index(ck: Checker, ctx: Context, expr: ast.IndexExpr) -> Type:
    """The type of ``obj[index]``: one element of a repeat, one of several ports."""
    obj = ck.infer(ctx.but(many=True), expr.obj)
    if isinstance(expr.index, ast.NameExpr) and expr.index.name == "last":
        ck.mean(expr.index, Last())
    else:
        ck.expect(ctx, expr.index, COUNT, "an index")
        if (number := constant(expr.index, ctx.module)) is not None and number < 0:
            hint = f"the last one is `{expr.obj.span.words}[last]`"
            return ck.error("illegal-value", expr.index.span, "elements are counted from 0", hint=hint)
    if isinstance(obj, ElementType):
        _refuse_missing(ck, ctx, obj, expr)
        return replace(obj, key=f"{obj.key}[{expr.index.span.words}]", many=False, index=expr.index)
    if isinstance(obj, ArrayType):
        return _port(ck, ctx, obj, expr)
    if obj == UNKNOWN:
        return UNKNOWN
    whole = expr.obj.span.words
    first, _, rest = whole.partition(".")
    if isinstance(obj, PartType) and obj.many and rest and "[" not in first:
        element = f"`{first}[{expr.index.span.words}].{rest}`"
        return ck.unfit(expr, obj, "only repeats and indexed ports take an index", f"the repeat takes it: {element}")
    hint = f"leave the index out: `{whole}`"
    if obj == SURFACE:
        hint = f"surfaces of a family are named together; a formula chooses among them: `on {whole} where n.x > 0.5`"
    elif obj == POINT or isinstance(obj, VecType):
        rank = constant(expr.index, ctx.module)
        names = "xyz"[: obj.size if isinstance(obj, VecType) else 3]
        named = names[int(rank)] if rank is not None and rank in range(len(names)) else names[0]
        hint = f"components have names: `{whole}.{named}`"
    return ck.unfit(expr, obj, "only repeats and indexed ports take an index", hint)


def _refuse_missing(ck: Checker, ctx: Context, obj: ElementType, expr: ast.IndexExpr) -> None:
    """Reports an element that the guard around a statement excludes, by the count of the repeat."""
    node, rank = obj.entry.node, constant(expr.index, ctx.module)
    if not isinstance(node, ast.RepeatStmt) or (count := node.count) is None:
        return
    if rank is None or obj.home is not None or obj.outer is not None or ctx.condition == TRUE:
        return
    above = ast.BinaryExpr(span=expr.span, op=">", left=count, right=expr.index)
    there = conditions.of(ck, ck.context(obj.entry.scope), above)
    if excludes(ctx.condition, there):
        ck.error(
            "optional-outside-when",
            expr.span,
            f"`{expr.span.words}` never exists here: the guard around this statement excludes it",
            hint=f"put this inside `when {count.span.words} > {rank:g} {{ }}`, or name another element",
            notes=((node.name_span, "elements are counted from 0"),),
        )


def _port(ck: Checker, ctx: Context, ports: ArrayType, expr: ast.IndexExpr) -> Type:
    """One of several ports: wherever a binding of that index stands, or, of an index that is computed, all of them."""
    number = constant(expr.index, ctx.module)
    own = [there for k, there in ports.bound if k is None or number is None or k == int(number)]
    wanted = conjunction(own) if number is None else TRUE if TRUE in own or not own else Or(tuple(own))
    if wanted != TRUE:
        ck.demand(
            ctx,
            wanted,
            expr.span,
            f"`{expr.span.words}` only exists under a guard",
            "put this inside the same `when`, or bind the port in every branch",
            value=True,
        )
    return ports.item
