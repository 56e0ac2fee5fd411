"""Names: what ``door`` stands for, and whether it exists."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnostics.suggest import any_of, did_you_mean, suggest
from ..language import DIRECTIONS, FACES, FUNCTIONS, WORDS
from ..source import Span
from ..syntax import ast
from ..units import UNITS
from . import foreign
from .entries import narrowed
from .guards import TRUE, And, Or, consistent, implies
from .meanings import Axis, Base, Constant, Current, Declared, Global, Local, Meaning, OwnBox, Previous
from .parts import BOX_MEMBERS, shared
from .presence import guarded, optional
from .scope import BodyScope, Entry, Variant
from .symbols import Symbol, lacks_role, parent_of
from .types import (
    BASE,
    BOOL,
    BOX,
    DIRECTION,
    MATERIAL,
    PLANE,
    POINT,
    RATIO,
    SIZE,
    ArrayType,
    Boxed,
    ElementType,
    JointType,
    PartType,
    StyleType,
    Type,
)

if TYPE_CHECKING:
    from .checker import Checker, Context


_IN_LABEL = (
    "in a formula on a surface `p` is the point, `n` the outward normal and `size` the size of what the label is on"
)
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
            hint=_option(ctx, word) or f"write `{FUNCTIONS[word][-1].call}`",
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
    words = [w.name for w in WORDS.values() if w.kind != "place"]
    values = [name for name in ctx.names() if (found := ctx.module.find(name)) is None or found.kind != "vocabulary"]
    near = did_you_mean(word, [*values, *words])
    parts = _within_parts(ck, ctx, word)
    owned = f"a part has it: write {any_of(parts[:_NAMED])}" if parts else None
    hint = (
        _option(ctx, word)
        or _within_repeat(ctx, word)
        or _within_role(ck, ctx, word)
        or " ".join(filter(None, (near, owned)))
        or _near_in_repeat(ctx, word)
        or (_IN_LABEL if {"p", "n"} <= ctx.extra.keys() else None)
        or foreign.NAMES.get(word)
        or (f"a unit directly follows its number: `1{word}`" if word in UNITS and _in_formula(span) else None)
        or _within_category(ck, ctx, word)
    )
    return ck.unknown(ctx.module, word, "unknown-name", span, f"there is no `{word}` here", hint)


def _in_formula(span: Span) -> bool:
    """Whether a word stands behind a number or an operator, where a unit may have been meant; `turn` is also a good name."""
    before = span.source.text[: span.start].rstrip()[-1:]
    return before.isdigit() or before in ("*", "/")


def _option(ctx: Context, word: str) -> str | None:
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


def _near_in_repeat(ctx: Context, word: str) -> str | None:
    """The nearest name that a repeat of this body declares."""
    names = {name for scope in (ctx.scope.root.below() if ctx.scope is not None else ()) for name in scope.table}
    near = suggest(word, names)
    told = None if near is None else _within_repeat(ctx, near)
    return None if told is None else f"did you mean `{near}`? {told}"


def _within_role(ck: Checker, ctx: Context, word: str) -> str | None:
    """How a template without a role gets what roles of its file declare."""
    owner = ctx.scope.root.owner if ctx.scope is not None else None
    if owner is None or owner.kind != "template" or parent_of(owner) is not None:
        return None
    for symbol in ctx.module.names.values():
        if symbol.kind == "role" and word in ck.interface_of(symbol):
            return f"the role `{symbol.name}` declares it, which `{owner.name}` does not play: `template {owner.name} : {symbol.name}`"
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
        return repeat(ck, ctx, entry, span)
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


def repeat(ck: Checker, ctx: Context, entry: Entry, span: Span) -> Type:
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
    boxless = owner.kind == "template" and "size" not in scope.root.table and not ring
    if boxless and not lacks_role(owner) and ck.is_first(owner):
        hint = "name the face of a part, or declare `param size : length[3]` in the template"
        if isinstance(owner.decl, ast.TemplateDecl) and owner.decl.role is None:
            hint += ", or let it play a role that passes a size in"
        return ck.error(
            "no-own-box",
            span,
            f"`{word}` needs the template's own box, but {owner.name} derives its box from its parts",
            hint=hint,
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
