"""Names and paths: what ``door``, ``door.panel.front.center.z``, ``column[last]`` stand for, and whether they exist."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean
from ..source import Span
from ..syntax import ast
from .entries import narrowed
from .guards import TRUE, And, Atom, Condition, Or, consistent
from .names import DIRECTIONS, FACES, FUNCTIONS
from .scope import Entry, Scope, Variant
from .symbols import Symbol
from .types import (
    BASE,
    BOOL,
    BOX,
    COUNT,
    CURVE,
    DIRECTION,
    EDGE,
    FRAME,
    LENGTH,
    LINE,
    MATERIAL,
    PLANE,
    POINT,
    SIZE,
    SURFACE,
    UNKNOWN,
    Array,
    Element,
    Function,
    Named,
    Part,
    Scalar,
    Slot,
    Style,
    Type,
    Vec,
)  # fmt: skip

if TYPE_CHECKING:
    from .checker import Checker, Context

BOX_MEMBERS = (*FACES, "center", "size", "box")


def name(ck: Checker, ctx: Context, expr: ast.NameExpr) -> Type:
    """The type of a bare name."""
    word = expr.name
    if word in ctx.extra:
        return ctx.extra[word]
    entries = ctx.scope.find(word) if ctx.scope is not None else []
    if entries:
        return _use(ck, ctx, entries, expr.span)
    if ctx.scope is not None and word in BOX_MEMBERS:
        return _own_box(ck, ctx, word, expr.span)
    if word in DIRECTIONS:
        return DIRECTION
    if word in ("true", "false"):
        return BOOL
    if word == "base":
        return BASE
    if word == "previous":
        return _previous(ck, ctx, expr.span)
    symbol = ctx.module.find(word)
    if symbol is not None:
        return _symbol(ck, ctx, symbol, expr.span)
    if word in FUNCTIONS:
        return ck.error("wrong-type", expr.span, f"`{word}` is a function: it needs arguments in parentheses")
    return unknown_name(ck, ctx, word, expr.span)


def unknown_name(ck: Checker, ctx: Context, word: str, span: Span) -> Type:
    """Reports a name that nothing declares."""
    hint = did_you_mean(word, ctx.names())
    if hint is None and ctx.scope is not None:
        for scope in _below(ctx.scope.root):
            if word in scope.table and scope.repeat is not None:
                of = scope.repeat.name
                hint = f"`{word}` is declared inside the repeat `{of}`: write `{of}.{word}`"
                break
    return ck.error("unknown-name", span, f"there is no `{word}` here", hint=hint)


def _below(scope: Scope) -> list[Scope]:
    return [scope, *(deeper for inner in scope.inner.values() for deeper in _below(inner))]


def _use(ck: Checker, ctx: Context, entries: list[Entry], span: Span) -> Type:
    """A declared name: its type here, once its presence is ensured."""
    live = entries
    if len(entries) > 1:
        live = [e for e in entries if consistent(ctx.condition, ck.entry_condition(e))] or entries[:1]
    if len(live) > 1 and consistent(*(ck.entry_condition(e) for e in live)):
        live = live[:1]  # declared twice, which is reported where it is declared
    entry = live[0]
    kind = ck.entry_type(entry)
    if entry.kind == "repeat":
        return _repeat(ck, ctx, entry, span)
    wanted = [ck.entry_condition(e) for e in live]
    if not any(consistent(ctx.condition, w) for w in wanted):
        return ck.error(
            "optional-outside-when", span, f"`{entry.name}` never exists here: its guard excludes this one",
            notes=((entry.span, "declared here"),),
        )  # fmt: skip
    if isinstance(kind, Part):
        parts = [t for e in live if isinstance(t := ck.entry_type(e), Part)]
        kind = parts[0] if len(parts) == 1 else _either(parts)
        there = _present(kind)
        if there != TRUE:
            wanted = [And((w, there)) for w in wanted]
    demanded = wanted[0] if len(wanted) == 1 else Or(tuple(wanted))
    if demanded != TRUE:
        message, hint = _absent(entry, kind)
        ck.demand(ctx, demanded, span, message, hint)
    return narrowed(ctx, kind) if isinstance(kind, Part) else kind


def _either(parts: list[Part]) -> Part:
    """One part declared in exclusive branches."""
    domain = tuple(dict.fromkeys(v for p in parts for v in p.domain))
    return Part(tuple(v for v in domain if v is not None), "|".join(p.key for p in parts), domain)


def _present(part: Part) -> Condition:
    if None not in part.domain:
        return TRUE
    return Atom(part.key, frozenset(v for v in part.domain if v is not None), part.domain)


def _absent(entry: Entry, kind: Type) -> tuple[str, str]:
    if isinstance(kind, Part) and None in kind.domain:
        return (
            f"`{entry.name}` is optional: it may not be there",
            f"put this under `when {entry.name} {{ }}`",
        )
    return f"`{entry.name}` exists only under a guard", "put this under the same `when`"


def _repeat(ck: Checker, ctx: Context, entry: Entry, span: Span) -> Type:
    inside = ctx.scope is not None and any(s.repeat is entry.node for s in ctx.scope.chain())
    condition = ck.entry_condition(entry)
    if condition != TRUE and not inside:
        ck.demand(ctx, condition, span, f"`{entry.name}` exists only under a guard", "put this under the same `when`")
    if not inside and not ctx.many:
        return ck.error(
            "many-elements", span, f"`{entry.name}` stands for all elements of a repeat here",
            hint=f"name one, `{entry.name}[0]` or `{entry.name}[last]`, or reduce them with sum, min or max",
        )  # fmt: skip
    return Element(entry, entry.key, many=not inside)


def _own_box(ck: Checker, ctx: Context, word: str, span: Span) -> Type:
    """A bare face, ``center``, ``size`` or ``box``: of the template's own box."""
    scope = ctx.scope
    assert scope is not None
    owner = scope.owner
    ring = any(s.repeat is not None and s.repeat.form == "ring" for s in scope.chain())
    if owner.kind == "category" and not ring:
        return ck.error(
            "no-own-box", span, f"`{word}` without a part: a category has no box of its own",
            hint=f"name the part: `body.{word}`",
        )  # fmt: skip
    if owner.kind == "template" and "size" not in scope.root.table and not ring:
        return ck.error(
            "no-own-box", span, f"`{word}` of the template's own box, but {owner.name} derives its box from its parts",
            hint="name a part's face, or let the template take `param size : length[3]`",
        )  # fmt: skip
    if owner.kind == "primitive":
        return unknown_name(ck, ctx, word, span)
    return PLANE if word in FACES else POINT if word == "center" else BOX if word == "box" else SIZE


def _previous(ck: Checker, ctx: Context, span: Span) -> Type:
    for scope in ctx.scope.chain() if ctx.scope is not None else ():
        if scope.repeat is not None and scope.parent is not None:
            ck.demand(
                ctx, scope.after_first, span, "`previous` does not exist for the first element",
                "put this under a guard such as `when i > 0 { }`",
            )  # fmt: skip
            entry = next(e for e in scope.parent.table[scope.repeat.name] if e.node is scope.repeat)
            return Element(entry, f"{entry.key}.previous")
    return ck.error("unknown-name", span, "`previous` has a meaning only inside a repeat")


def _symbol(ck: Checker, ctx: Context, symbol: Symbol, span: Span) -> Type:
    match symbol.kind:
        case "function":
            decl = symbol.decl
            assert isinstance(decl, ast.FunctionDecl)
            if decl.parameters:
                return ck.error("wrong-type", span, f"`{symbol.name}` is a function: it needs arguments in parentheses")
            return ck.infer(type(ctx)(symbol.module), decl.value)
        case "material":
            return MATERIAL
        case "template" | "role":
            return Style((Variant(symbol.name, symbol),), symbol.name)
    return ck.error("wrong-type", span, f"`{symbol.name}` is a {symbol.kind}, not a value")


def member(ck: Checker, ctx: Context, expr: ast.MemberExpr) -> Type:
    """The type of ``obj.name``."""
    obj = ck.infer(ctx, expr.obj)
    word, span = expr.name, expr.name_span
    match obj:
        case Part():
            return part_member(ck, ctx, obj, word, span, _text(expr.obj))
        case Element():
            return _element_member(ck, ctx, obj, word, span)
        case Slot():
            found = box_member(word)
        case Vec(size=size, dimension=dimension):
            found = None
            if word in DIRECTIONS[:size]:
                found = Scalar(dimension) if dimension is not None else LENGTH
        case Named():
            found = _place_member(obj, word)
        case Function():
            return ck.error("wrong-type", expr.span, f"`{obj.entry.name}` is a function: it needs arguments")
        case _:
            found = UNKNOWN if obj == UNKNOWN else None
    if found is None:
        known = _place_names(obj)
        hint = did_you_mean(word, known) or _list(known)
        return ck.error("unknown-member", span, f"{obj} has no `{word}`", hint=hint)
    return found


_PLACE: dict[Type, dict[str, Type]] = {
    PLANE: {**{face: EDGE for face in FACES}, "center": POINT, "origin": POINT, "out": DIRECTION, "up": DIRECTION},
    EDGE: {**{face: POINT for face in FACES}, "center": POINT, "origin": POINT, "along": DIRECTION},
    POINT: {axis: LENGTH for axis in DIRECTIONS},
    FRAME: {"origin": POINT, "out": DIRECTION, "up": DIRECTION},
    LINE: {"origin": POINT, "along": DIRECTION},
    BOX: {**{face: PLANE for face in FACES}, "center": POINT, "size": SIZE, "box": BOX},
}


def _place_member(obj: Named, word: str) -> Type | None:
    return _PLACE.get(obj, {}).get(word)


def box_member(word: str) -> Type | None:
    """Members that everything with a box has."""
    return _PLACE[BOX].get(word)


def _place_names(obj: Type) -> list[str]:
    if isinstance(obj, Vec):
        return list(DIRECTIONS[: obj.size])
    if isinstance(obj, Slot):
        return list(BOX_MEMBERS)
    return list(_PLACE.get(obj, {}))


def _list(names: list[str]) -> str | None:
    return "it has " + ", ".join(names) if names else None


def _element_member(ck: Checker, ctx: Context, obj: Element, word: str, span: Span) -> Type:
    entry = obj.entry
    inner = entry.scope.inner[id(entry.node)]
    found = [e for e in inner.table.get(word, []) if not e.private or e.kind == "index"]
    if found:
        target = found[0]
        if target.kind == "repeat":
            return _inner(ck, ctx, obj, target, span)
        kind = ck.entry_type(target)
        if isinstance(kind, Part):
            current = obj.key == entry.key and not obj.many
            part = Part(kind.variants, kind.key if current else f"{obj.key}.{word}", kind.domain, obj.many)
            wanted = And((ck.entry_condition(target), _present(part))) if current else _present(part)
            if wanted != TRUE and not obj.many:
                message, hint = _absent(target, kind)
                ck.demand(ctx, wanted, span, message, hint)
            return narrowed(ctx, part)
        return kind
    if word == "gap":
        if not obj.many and obj.key == entry.key:
            ck.demand(
                ctx, inner.after_first, span, f"`{entry.name}.gap` does not exist for the first element",
                f"put this under `when {entry.name}.gap {{ }}`",
            )  # fmt: skip
        return BOX
    kind = box_member(word)
    if kind is not None:
        return kind
    names = [*inner.table, *BOX_MEMBERS, "gap"]
    return ck.error(
        "unknown-member", span, f"an element of `{entry.name}` has no `{word}`", hint=did_you_mean(word, names)
    )


def _inner(ck: Checker, ctx: Context, obj: Element, target: Entry, span: Span) -> Type:
    if obj.many:
        return Element(target, f"{obj.key}.{target.name}", many=True)
    if obj.key != obj.entry.key:  # of one named element, all of an inner repeat
        if not ctx.many:
            return ck.error(
                "many-elements", span, f"`{target.name}` stands for all elements of a repeat here",
                hint=f"name one: `{target.name}[0]` or `{target.name}[last]`",
            )  # fmt: skip
        return Element(target, f"{obj.key}.{target.name}", many=True)
    return _repeat(ck, ctx, target, span)


def _text(expr: ast.Expr) -> str:
    return " ".join(expr.span.source.text[expr.span.start : expr.span.end].split())


def part_member(ck: Checker, ctx: Context, part: Part, word: str, span: Span, path: str) -> Type:
    """A member of a part, written ``path``: every variant that is left must have it."""
    found: list[tuple[Variant, Type]] = []
    lacking: list[Variant] = []
    for variant in part.variants:
        if variant.symbol is None:
            return UNKNOWN
        kind = symbol_member(ck, variant.symbol, word)
        if kind is None:
            lacking.append(variant)
        else:
            found.append((variant, kind))
    if lacking:
        instead = _lacking(ck, ctx, part, [v for v, _ in found], word, span, path)
        if instead is not None or not found:
            return instead or UNKNOWN
    if not found:
        return UNKNOWN
    kinds = [kind for _, kind in found]
    parts = [k for k in kinds if isinstance(k, Part)]
    if len(parts) == len(kinds):
        domain = tuple(dict.fromkeys(v for k in parts for v in k.domain))
        whole = Part(tuple(v for v in domain if v is not None), f"{part.key}.{word}", domain, part.many)
        there = _present(whole)
        if there != TRUE and not part.many:
            hint = f"put this under `when {path}.{word} {{ }}`"
            ck.demand(ctx, there, span, f"`{word}` is optional: it may not be there", hint)
        return narrowed(ctx, whole)
    first = kinds[0]
    if isinstance(first, Element):
        if not ctx.many:
            return ck.error(
                "many-elements", span, f"`{word}` stands for all elements of a repeat here",
                hint=f"name one: `{word}[0]` or `{word}[last]`",
            )  # fmt: skip
        return Element(first.entry, f"{part.key}.{word}", many=True)
    if len(set(kinds)) == 1:
        return first
    return _common(kinds, word)


def _common(kinds: list[Type], word: str) -> Type:
    """One type for what the variants call by the same name."""
    if any(isinstance(k, Slot | Part | Element) for k in kinds):
        return Slot(word)
    if all(k in (PLANE, FRAME) for k in kinds):
        return FRAME
    return kinds[0] if all(isinstance(k, Scalar) for k in kinds) else UNKNOWN


def _lacking(
    ck: Checker, ctx: Context, part: Part, having: list[Variant], word: str, span: Span, path: str
) -> Type | None:
    """Some variants lack a member: fine where the statement goes with it (None, or the role's type), else an error."""
    promised = _optional_in_role(ck, part, word)
    if ctx.subject and ctx.lenient is not None and (having or promised is not None):
        if having:
            ctx.lenient.append(Atom(part.key, frozenset(having), part.domain))
        return None if having else promised
    if having:
        names = " and ".join(v.name for v in having)
        return ck.error(
            "optional-outside-when", span, f"only {names} has `{word}`, the other alternatives have not"
            if len(having) == 1 else f"only {names} have `{word}`, the other alternatives have not",
            hint=f"put this under `when {path} is {having[0].name} {{ }}`",
        )  # fmt: skip
    if promised is not None:
        what = " or ".join(dict.fromkeys(v.name for v in part.variants))
        return ck.error("optional-outside-when", span, f"`{word}` is optional in the role, and {what} does not bind it")
    offered = sorted({n for v in part.variants if v.symbol is not None for n in member_names(ck, v.symbol)})
    what = " or ".join(dict.fromkeys(v.name for v in part.variants))
    code, missing = ("unknown-port", f"port or part `{word}`") if ctx.ends else ("unknown-member", f"`{word}`")
    return ck.error(
        code, span, f"{what} has no {missing}",
        hint=did_you_mean(word, offered) or _list([n for n in offered if n not in BOX_MEMBERS]),
    )  # fmt: skip


def _optional_in_role(ck: Checker, part: Part, word: str) -> Type | None:
    """The type of what a role of the part offers as optional under this name."""
    for variant in part.variants:
        role, decl = ck.interface_of(variant.symbol).get(word, (None, None)) if variant.symbol else (None, None)
        if role is not None and getattr(decl, "optional", False):
            return symbol_member(ck, role, word)
    return None


def member_names(ck: Checker, symbol: Symbol) -> list[str]:
    """What a part of this template, primitive or role offers to others."""
    scope = ck.scope_of(symbol)
    own = [entry.name for entry in scope.entries if not entry.private]
    role = [] if symbol.kind == "role" else [n for n in ck.interface_of(symbol)]
    return [*dict.fromkeys([*own, *role]), *BOX_MEMBERS]


def symbol_member(ck: Checker, symbol: Symbol, word: str) -> Type | None:
    """The type of a member of an instance of ``symbol``; None where it has none."""
    entries = [e for e in ck.scope_of(symbol).table.get(word, []) if not e.private]
    if entries:
        entry = entries[0]
        kind = ck.entry_type(entry)
        if entry.kind == "surface" and word in FACES:
            return PLANE
        if symbol.kind == "primitive" and kind == CURVE and not isinstance(entry.node, ast.ParamDecl):
            return SURFACE  # surfaces bear the names of the curves that make them
        if isinstance(kind, Part) and (entry.guards or len(entries) > 1):
            kinds = [k for e in entries if isinstance(k := ck.entry_type(e), Part)]
            domain = tuple(dict.fromkeys((*(v for k in kinds for v in k.domain), None)))
            return Part(tuple(v for v in domain if v is not None), kind.key, domain)
        return kind
    if symbol.kind == "primitive":
        made = _made(symbol, word)
        if made is not None:
            return made
    if symbol.kind == "template" and word in ck.interface_of(symbol):
        role, decl = ck.interface_of(symbol)[word]
        if not getattr(decl, "optional", False) or word in _names_in_repeats(ck.scope_of(symbol)):
            return symbol_member(ck, role, word)
    return box_member(word)


def _names_in_repeats(scope: Scope) -> set[str]:
    """Names that the repeats of a template declare: a part in a repeat binds the slot of its name."""
    return {name for inner in _below(scope)[1:] for name in inner.table}


def _made(symbol: Symbol, word: str) -> Type | None:
    """What an operator supplies: a sweep has ports ``start`` and ``end``, every solid surfaces of those names."""
    for stmt in symbol.body:
        if isinstance(stmt, ast.SolidDecl) and word in ("start", "end", "rim"):
            return FRAME if stmt.operator == "sweep" and word != "rim" else SURFACE
    return None


def index(ck: Checker, ctx: Context, expr: ast.IndexExpr) -> Type:
    """The type of ``obj[index]``: one element of a repeat, one of several ports."""
    obj = ck.infer(ctx.but(many=True), expr.obj)
    if not (isinstance(expr.index, ast.NameExpr) and expr.index.name == "last"):
        ck.expect(ctx, expr.index, COUNT, "an index")
    if isinstance(obj, Element):
        return Element(obj.entry, f"{obj.key}[]")
    if isinstance(obj, Array):
        return obj.item
    if obj == UNKNOWN:
        return UNKNOWN
    return ck.error("wrong-type", expr.span, f"only elements of repeats and indexed ports have an index; this is {obj}")
