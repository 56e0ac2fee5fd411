"""Names and paths: what ``door``, ``door.panel.front.center.z``, ``column[last]`` stand for, and whether they exist."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..diagnostics.suggest import any_of, did_you_mean
from ..language import DIRECTIONS, FACES, FUNCTIONS, WORDS
from ..source import Span
from ..syntax import ast
from ..units import UNITS
from . import conditions, foreign
from .entries import narrowed
from .fold import constant
from .guards import TRUE, And, Or, conjunction, consistent, implies
from .meanings import (
    Axis,
    Base,
    Constant,
    Current,
    Declared,
    Feature,
    Global,
    Inner,
    Last,
    Local,
    Meaning,
    OwnBox,
    Previous,
)
from .parts import BOX_MEMBERS, box_member, clashing, listed, part_member, place_member, place_names, shared
from .presence import declared, excludes, guarded, of_element, optional
from .scope import BodyScope, Entry, Variant
from .symbols import Symbol
from .types import (
    BASE,
    BOOL,
    BOX,
    COUNT,
    DIRECTION,
    LENGTH,
    MATERIAL,
    PLANE,
    POINT,
    RATIO,
    SIZE,
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


_NAMED = 3  # parts in a hint


def name(ck: Checker, ctx: Context, expr: ast.NameExpr) -> Type:
    """The type of a bare name."""
    word = expr.name
    if word in ctx.extra:
        ck.mean(expr, Local(word))
        return ctx.extra[word]
    home = ctx.scope.home(word) if ctx.scope is not None else None
    entries = home.table[word] if home is not None else []
    if word in DIRECTIONS and all(isinstance(e.node, ast.LetDecl) and e.node.parameters for e in entries):
        ck.mean(expr, Axis(DIRECTIONS.index(word)))
        return DIRECTION  # `y(u)` is called, `y` alone is the axis
    if home is not None:
        ck.mean(expr, _declared(ctx, word, home))
        return _use(ck, ctx, entries, expr.span)
    if ctx.scope is not None and word in BOX_MEMBERS:
        ck.mean(expr, OwnBox(word))
        return _own_box(ck, ctx, word, expr.span)
    if word in WORDS and (value := WORDS[word].value) is not None:
        ck.mean(expr, Constant(value))
        return BOOL if isinstance(value, bool) else RATIO
    if word == "base":
        ck.mean(expr, Base())
        return BASE
    if word == "previous":
        return _previous(ck, ctx, expr)
    symbol = ctx.module.find(word)
    if symbol is not None:
        ck.mean(expr, Global(symbol))
        return _symbol(ck, ctx, symbol, expr.span)
    if word in FUNCTIONS:
        return ck.error(
            "wrong-type",
            expr.span,
            f"`{word}` is a function: it needs arguments in parentheses",
            hint=_option(ck, ctx, word) or f"write `{FUNCTIONS[word][-1].call}`",
        )
    return _unknown_name(ck, ctx, word, expr.span)


def sole(ck: Checker, ctx: Context, entries: list[Entry], span: Span) -> Entry:
    """Of a style or a function that branches declare, the one that is there for sure; that none is gets reported."""
    there = (entry for entry in entries if implies(ctx.condition, ck.entry_condition(entry)))
    entry = next(there, None)
    if entry is None:
        entry = entries[0]
        message, hint = guarded(entry, span)
        ck.error("optional-outside-when", span, message, hint=hint)
    return entry


def _declared(ctx: Context, word: str, home: BodyScope) -> Meaning:
    """The meaning of a declared name: of a repeat around, its present element."""
    around = (scope for scope in ctx.scope.chain() if scope.parent is home) if ctx.scope is not None else ()
    inside = next((scope for scope in around if any(e.node is scope.repeat for e in home.table[word])), None)
    return Declared(word, home.depth) if inside is None else Current(inside.depth)


def _unknown_name(ck: Checker, ctx: Context, word: str, span: Span) -> Type:
    """Reports a name that nothing declares."""
    near = did_you_mean(word, [*ctx.names(), *(w.name for w in WORDS.values() if w.kind != "place")])
    parts = _within_parts(ck, ctx, word)
    owned = f"a part has it: write {any_of(parts[:_NAMED])}" if parts else None
    hint = (
        _option(ck, ctx, word)
        or _within_repeat(ctx, word)
        or " ".join(filter(None, (near, owned)))
        or foreign.NAMES.get(word)
        or _within_category(ck, ctx, word)
    )
    return ck.unknown(ctx.module, word, "unknown-name", span, f"there is no `{word}` here", hint)


def _option(ck: Checker, ctx: Context, word: str) -> str | None:
    """What to write for an option of a choice, which is a value only beside its choice."""
    for entry in (e for scope in ctx.scope.chain() for e in scope.entries) if ctx.scope is not None else ():
        if isinstance(entry.node, ast.ParamDecl) and word in entry.node.type.values:
            compared = f"{entry.name} == {word}"
            return f"an option stands only beside its choice: compare it, as in `{compared}`, or `let is_{word} = {compared}`"
    return None


def _within_repeat(ctx: Context, word: str) -> str | None:
    """Where to find a name that a repeat of this body declares."""
    for scope in ctx.scope.root.below() if ctx.scope is not None else ():
        if word in scope.table and scope.repeat is not None:
            around = [outer.repeat.name for outer in scope.chain() if outer.repeat is not None][::-1]
            if word == scope.repeat.index:
                return f"`{word}` is the index of the repeat `{around[-1]}` and only exists inside it"
            return f"`{word}` is declared inside the repeat `{around[-1]}`: write `{'.'.join([*around, word])}`"
    return None


def _within_category(ck: Checker, ctx: Context, word: str) -> str | None:
    """How a template gets a value that the category of its file declares."""
    category = next((symbol for symbol in ctx.module.own() if symbol.kind == "category"), None)
    owner = ctx.scope.root.owner if ctx.scope is not None else category
    if category is None or owner is None or owner.kind == "category" or not ck.scope_of(category).find(word):
        return None
    return (
        f"`{category.name}` declares it, and a {owner.kind} sees its own names only: "
        f"give `{owner.name}` a parameter, and hand it over: `{owner.name}({word} = {word})`"
    )


def _within_parts(ck: Checker, ctx: Context, word: str) -> list[str]:
    """What the parts of this body and of those around it declare by that name, as one writes it here."""
    found = []
    for entry in (e for scope in (ctx.scope.chain() if ctx.scope is not None else ()) for e in scope.entries):
        if isinstance(entry.node, ast.PartDecl):
            symbols = (ctx.module.find(alternative.name or "") for alternative in entry.node.alternatives)
            bodies = [ck.scope_of(symbol) for symbol in symbols if symbol is not None and symbol.body]
            if any(not inner.private for body in bodies for inner in body.table.get(word, ())):
                found.append(f"{entry.name}.{word}")
    return found


def _use(ck: Checker, ctx: Context, entries: list[Entry], span: Span) -> Type:
    """A declared name: its type here, once its presence is ensured."""
    live = entries
    if len(entries) > 1:
        live = [e for e in entries if consistent(ctx.condition, ck.entry_condition(e))] or entries[:1]
    if len(live) > 1 and consistent(*(ck.entry_condition(e) for e in live)):
        live = live[:1]  # declared twice, which is reported where it is declared
    entry = live[0]
    if all(e.kind == "slot" for e in live) and entry.name not in WORDS:  # such a name is reported where it is declared
        hint = "name what the slot binds"
        return ck.error(
            "wrong-type", span, f"`{entry.name}` is a slot of this template: it is read from outside only", hint=hint
        )
    kind = ck.entry_type(entry)
    if entry.kind == "repeat":
        return _repeat(ck, ctx, entry, span)
    wanted = [ck.entry_condition(e) for e in live]
    if not any(consistent(ctx.condition, w) for w in wanted):
        return ck.error(
            "optional-outside-when",
            span,
            f"`{entry.name}` never exists here: its guard excludes the one around this statement",
            notes=((entry.span, "declared here"),),
            hint=f"move this under the guard of `{entry.name}`, or change one of the guards",
        )
    if isinstance(kind, PartType):
        parts = [t for e in live if isinstance(t := ck.entry_type(e), PartType)]
        if len(parts) > 1:  # declared in exclusive branches
            kind = PartType.of((v for p in parts for v in p.domain), "|".join(p.key for p in parts))
        if kind.there != TRUE:
            wanted = [And((w, kind.there)) for w in wanted]
    demanded = wanted[0] if len(wanted) == 1 else Or(tuple(wanted))
    if demanded != TRUE:
        optional_part = isinstance(kind, PartType) and None in kind.domain
        message, hint = optional(entry.name) if optional_part else guarded(entry, span)
        if not isinstance(kind, ArrayType):
            ck.demand(ctx, demanded, span, message, hint, value=not isinstance(kind, Boxed | JointType))
    return narrowed(ctx, kind) if isinstance(kind, PartType) else shared(ck, live, span)


def _repeat(ck: Checker, ctx: Context, entry: Entry, span: Span) -> Type:
    inside = ctx.scope is not None and any(s.repeat is entry.node for s in ctx.scope.chain())
    condition = ck.entry_condition(entry)
    if condition != TRUE and not inside:
        ck.demand(ctx, condition, span, *guarded(entry, span))
    if not inside and not ctx.many:
        return ck.error(
            "many-elements",
            span,
            f"`{entry.name}` means all elements of a repeat here",
            hint=f"name one, `{entry.name}[0]` or `{entry.name}[last]`, or reduce them with sum, min or max",
        )
    return ElementType(entry, entry.key, many=not inside)


def _own_box(ck: Checker, ctx: Context, word: str, span: Span) -> Type:
    """A bare face, ``center``, ``size`` or ``box``: of the template's own box."""
    scope = ctx.scope
    assert scope is not None
    owner = scope.owner
    ring = any(s.repeat is not None and s.repeat.form == "ring" for s in scope.chain())
    if owner.kind == "category" and not ring:
        return ck.error(
            "no-own-box",
            span,
            f"`{word}` needs a part: a category has no box of its own",
            hint=f"name the part: `body.{word}`",
        )
    if owner.kind == "template" and "size" not in scope.root.table and not ring:
        return ck.error(
            "no-own-box",
            span,
            f"`{word}` needs the template's own box, but {owner.name} derives its box from its parts",
            hint="name the face of a part, or declare `param size : length[3]` in the template",
        )
    if owner.kind == "primitive":
        return _unknown_name(ck, ctx, word, span)
    return PLANE if word in FACES else POINT if word == "center" else BOX if word == "box" else SIZE


def _previous(ck: Checker, ctx: Context, expr: ast.NameExpr) -> Type:
    for scope in ctx.scope.chain() if ctx.scope is not None else ():
        if scope.repeat is not None and scope.parent is not None:
            ck.demand(
                ctx,
                scope.after_first,
                expr.span,
                "`previous` does not exist for the first element",
                "put this inside a guard such as `when i > 0 { }`",
            )
            ck.mean(expr, Previous(scope.depth))
            entry = next(e for e in scope.parent.table[scope.repeat.name] if e.node is scope.repeat)
            return ElementType(entry, f"{entry.key}.previous", shift=1)
    return ck.error(
        "unknown-name",
        expr.span,
        "`previous` only exists inside a repeat",
        hint="move this into the repeat; from outside, name an element: `row[0]`, `row[last]`",
    )


def _symbol(ck: Checker, ctx: Context, symbol: Symbol, span: Span) -> Type:
    match symbol.kind:
        case "function":
            decl = symbol.decl
            assert isinstance(decl, ast.FunctionDecl)
            if decl.parameters:
                return ck.error(
                    "wrong-type",
                    span,
                    f"`{symbol.name}` is a function: it needs arguments in parentheses",
                    hint=f"write `{symbol.name}({', '.join(decl.parameters)})`",
                )
            if id(decl) in ck.calling:
                return ck.error(
                    "circular-definition",
                    span,
                    f"`{symbol.name}` is defined by itself",
                    hint="give one of them a value that names none of the others",
                )
            ck.calling.append(id(decl))
            kind = ck.infer(type(ctx)(symbol.module), decl.value)
            ck.calling.pop()
            return kind
        case "material":
            return MATERIAL
        case "template" | "role":
            return StyleType((Variant(symbol.name, symbol),), symbol.name)
    return ck.error(
        "wrong-type",
        span,
        f"`{symbol.name}` is a {symbol.kind}, not a value",
        hint="make a part of it: `part name : TEMPLATE(...)`, and name that"
        if symbol.kind == "primitive"
        else "name a parameter, a part or a `let`",
    )


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
            or f"leave `.{word}` out: a part or a vector has members, a number none"
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
    meant = foreign.MEMBERS.get(word) or did_you_mean(word, names) or ranked
    return ck.error("unknown-member", span, f"an element of `{entry.name}` has no `{word}`", hint=meant)


def _inner(ck: Checker, ctx: Context, obj: ElementType, target: Entry, span: Span) -> Type:
    if obj.many or obj.key != obj.entry.key:  # of one named element, all of an inner repeat
        if not obj.many and not ctx.many:
            return ck.many_elements(target.name, span)
        return ElementType(target, f"{obj.key}.{target.name}", many=True, outer=obj)
    return _repeat(ck, ctx, target, span)


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
