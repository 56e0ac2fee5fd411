"""Members of parts: what templates, primitives and roles offer to those who name an instance of them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean
from ..language import DIRECTIONS, FACES, MEMBERS
from ..source import Span
from ..syntax import ast
from . import foreign
from .entries import narrowed
from .guards import TRUE, Atom, Condition, Not, Or, conjunction, consistent
from .presence import declared, excludes, guarded, optional, relevant, renamed
from .scope import BodyScope, Entry, Variant
from .symbols import Symbol, names_of
from .types import (
    BOOL,
    BOX,
    CURVE,
    FRAME,
    PLANE,
    SEVERAL,
    SURFACE,
    UNKNOWN,
    ArrayType,
    Boxed,
    ChoiceType,
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
    fits,
    named,
    sort_of,
)

if TYPE_CHECKING:
    from .checker import Checker, Context

PLACES = {named(of): {m.name: named(m.type) for m in members.values()} for of, members in MEMBERS.items()}
"""By type: what stands after a dot, and of which type it is."""

BOX_MEMBERS = tuple(PLACES[BOX])


def place_member(obj: NamedType, word: str) -> Type | None:
    return PLACES.get(obj, {}).get(word)


def box_member(word: str) -> Type | None:
    """Members that everything with a box has."""
    return PLACES[BOX].get(word)


def place_names(obj: Type) -> list[str]:
    if isinstance(obj, VecType):
        return list(DIRECTIONS[: obj.size])
    if isinstance(obj, SlotType):
        return list(BOX_MEMBERS)
    return list(PLACES.get(obj, {}))


def listed(names: list[str]) -> str | None:
    return "it has " + ", ".join(names) if names else None


def part_member(ck: Checker, ctx: Context, part: PartType, word: str, span: Span, path: str) -> Type:
    """A member of a part, written ``path``: every variant that is left must have it."""
    found: list[tuple[Variant, Type]] = []
    lacking: list[Variant] = []
    for variant in part.variants:
        if variant.symbol is None:
            return UNKNOWN
        kind = _symbol_member(ck, variant.symbol, word)
        if kind is None:
            lacking.append(variant)
        else:
            if len(live := _live(ck, ctx, part, variant.symbol, word)) > 1 and not isinstance(kind, PartType):
                kind = shared(ck, live, span)
            found.append((variant, _of_instance(part, variant.symbol, kind)))
    if lacking:
        instead = _lacking(ck, ctx, part, [v for v, _ in found], word, span, path)
        if instead is not None or not found:
            return instead or UNKNOWN
    if not found:
        return UNKNOWN
    kinds = [kind for _, kind in found]
    _demand_guards(ck, ctx, part, found, word, span, path)
    parts = [k for k in kinds if isinstance(k, PartType)]
    if len(parts) == len(kinds):
        given = conjunction((part.given, *(k.given for k in parts)) if len(parts) == 1 else (part.given,))
        whole = PartType.of((v for k in parts for v in k.domain), f"{part.key}.{word}", part.many, given)
        ck.demand(ctx, whole.there, span, *optional(f"{path}.{word}"), value=not ctx.subject)
        return narrowed(ctx, whole)
    first = kinds[0]
    if isinstance(first, ElementType):
        if not ctx.many:
            return ck.many_elements(word, span)
        return replace(first, key=f"{part.key}.{word}", many=True)
    if len(set(kinds)) == 1:
        return first
    return _common(ck, found, word, span, path)


def _live(ck: Checker, ctx: Context, part: PartType, symbol: Symbol, word: str) -> list[Entry]:
    """The declarations of a member in branches of its template that may be there for this instance."""
    found = []
    for entry in ck.scope_of(symbol).table.get(word, ()):
        there = renamed(ck.entry_condition(entry), ((symbol.name, part.key),))
        if consistent(ctx.given(relevant(there, part.given)).condition, there):
            found.append(entry)
    return found


def clashing(ck: Checker, part: PartType, word: str) -> frozenset[Symbol]:
    """The alternatives of a part that are not left and have something else under ``word`` than those that are: no value could be either's."""
    left = {v.symbol for v in part.variants if v.symbol is not None}
    kinds = {
        symbol: _symbol_member(ck, symbol, word)
        for v in part.domain
        if v is not None and (symbol := v.symbol) is not None
    }
    sorts = {sort_of(kind) for symbol, kind in kinds.items() if symbol in left}
    gone = ((symbol, kind) for symbol, kind in kinds.items() if symbol not in left and kind is not None)
    return frozenset(symbol for symbol, kind in gone if sort_of(kind) not in sorts)


def _of_instance(part: PartType, symbol: Symbol, kind: Type) -> Type:
    """The type of a member as those see it who name it through an instance."""
    home = (symbol.name, part.key)
    match kind:
        case PartType(given=given) if given != TRUE:
            return replace(kind, given=renamed(given, (home,)))
        case ElementType():
            return replace(kind, home=home)
        case ArrayType(bound=bound):
            return replace(kind, bound=tuple((k, renamed(c, (home,))) for k, c in bound))
    return kind


def _demand_guards(
    ck: Checker, ctx: Context, part: PartType, found: list[tuple[Variant, Type]], word: str, span: Span, path: str
) -> None:
    """What a template declares under a guard is there where the guard holds for the instance."""
    wanted: list[Condition] = []
    first: Entry | None = None
    for variant, kind in found:
        assert variant.symbol is not None
        entries = [e for e in ck.scope_of(variant.symbol).table.get(word, ()) if not e.private]
        there = declared(ck, entries)
        if there == TRUE or isinstance(kind, ArrayType):  # of indexed ports each has guards of its own
            continue
        there = renamed(there, ((variant.symbol.name, part.key),))
        first = first or entries[0]
        wanted.append(
            there if len(part.domain) == 1 else Or((Not(Atom(part.key, frozenset((variant,)), part.domain)), there))
        )
    if first is not None:
        all_wanted = conjunction(wanted)
        if excludes(part.given, all_wanted):
            ck.error(
                "optional-outside-when",
                span,
                f"`{path}.{word}` never exists: the arguments of `{path}` exclude it",
                hint="leave this out, or change the arguments",
                notes=((first.span, "declared here"),),
            )
            return
        known = ctx.given(relevant(all_wanted, part.given))
        followed = ctx.subject and all(isinstance(kind, Boxed | JointType) for _, kind in found)
        message, hint = guarded(first, span, path)
        ck.demand(known, all_wanted, span, message, hint, ((first.span, "declared here"),), value=not followed)


def shared(ck: Checker, live: list[Entry], span: Span) -> Type:
    """One type for what branches of a ``when`` declare by one name, of which any may be there."""
    first, kind = live[0], ck.entry_type(live[0])
    for entry in live[1:]:
        other = ck.entry_type(entry)
        families = (FunctionType, StyleType, ArrayType, JointType, PartType, ElementType, SlotType)
        if isinstance(kind, families) and type(kind) is type(other):
            continue
        numbers = isinstance(kind, ScalarType) == isinstance(other, ScalarType)
        if numbers and fits(kind, other):
            first, kind = entry, other
        elif not (UNKNOWN in (kind, other) or numbers and fits(other, kind)):
            return ck.error(
                "wrong-type",
                span,
                f"`{entry.name}` is {kind} in one branch of a `when`, but {other} in another",
                hint="name it under a guard that leaves one of them, or give them two names",
                notes=((first.span, str(kind)), (entry.span, str(other))),
            )
    return kind


def _common(ck: Checker, found: list[tuple[Variant, Type]], word: str, span: Span, path: str) -> Type:
    """One type for what the variants call by the same name."""
    kinds = [kind for _, kind in found]
    if any(isinstance(k, SlotType | PartType | ElementType) for k in kinds):
        return SlotType(word)
    if all(k in (PLANE, FRAME) for k in kinds):
        return FRAME
    if all(isinstance(k, JointType) for k in kinds):
        return SEVERAL
    if (
        all(isinstance(k, ScalarType) for k in kinds)
        and len({k.dimension for k in kinds if isinstance(k, ScalarType)}) == 1
    ):
        return kinds[0]
    (first, one), (other, two) = found[0], next(pair for pair in found if pair[1] != found[0][1])
    said = f"`{path}.{word}` is {one} of {first.name}, but {two} of {other.name}"
    return ck.error(
        "wrong-type", span, said, hint=f"name it under a guard that leaves one: `when {path} is {first.name} {{ }}`"
    )


def _lacking(
    ck: Checker, ctx: Context, part: PartType, having: list[Variant], word: str, span: Span, path: str
) -> Type | None:
    """Some variants lack a member: fine where the statement goes with it (None, or the role's type), else an error."""
    promised = _optional_in_role(ck, part, word)
    if ctx.subject and ctx.lenient is not None and (having or promised is not None):
        if having:
            ctx.lenient.append(Atom(part.key, frozenset(having), part.domain))
        return None if having else promised
    if having:
        names, has = " and ".join(v.name for v in having), "has" if len(having) == 1 else "have"
        return ck.error(
            "optional-outside-when",
            span,
            f"only {names} {has} `{word}`, the other alternatives do not",
            hint=f"put this inside `when {path} is {having[0].name} {{ }}`",
        )
    what = " or ".join(dict.fromkeys(v.name for v in part.variants))
    if promised is not None:
        return ck.error(
            "optional-outside-when",
            span,
            f"`{word}` is optional in the role, and {what} does not bind it",
            hint=f"bind `{word}` in the template, or leave this out",
        )
    symbols = [v.symbol for v in part.variants if v.symbol is not None]
    offered = sorted(
        {n for symbol in symbols for n in _member_names(ck, symbol) if not ctx.ends or _is_place(ck, symbol, n)}
    )
    code, missing = ("unknown-port", f"port or part `{word}`") if ctx.ends else ("unknown-member", f"`{word}`")
    return ck.error(
        code,
        span,
        f"{what} has no {missing}",
        hint=foreign.MEMBERS.get(word)
        or did_you_mean(word, offered)
        or listed(
            [*own, "and the faces of its box"]
            if (own := [n for n in offered if n not in BOX_MEMBERS])
            else list(BOX_MEMBERS)
        ),
    )


def _optional_in_role(ck: Checker, part: PartType, word: str) -> Type | None:
    """The type of what a role of the part offers as optional under this name."""
    for variant in part.variants:
        role, decl = ck.interface_of(variant.symbol).get(word, (None, None)) if variant.symbol else (None, None)
        if role is not None and getattr(decl, "optional", False):
            return _symbol_member(ck, role, word)
    return None


def _member_names(ck: Checker, symbol: Symbol) -> list[str]:
    """What a part of this template, primitive or role offers to others."""
    scope = ck.scope_of(symbol)
    own = [entry.name for entry in scope.entries if not entry.private]
    role = [] if symbol.kind == "role" else [n for n in ck.interface_of(symbol)]
    made = [n for n in _MADE if symbol.kind == "primitive" and _made(symbol, n) is not None]
    return [*dict.fromkeys([*own, *role, *made]), *BOX_MEMBERS]


def _is_place(ck: Checker, symbol: Symbol, word: str) -> bool:
    """Whether a member can be an end of a connection: no number, no formula."""
    kind = _symbol_member(ck, symbol, word)
    return (
        word != "size"
        and kind not in (BOOL, CURVE)
        and not isinstance(kind, ScalarType | VecType | ChoiceType | FunctionType)
    )


def _symbol_member(ck: Checker, symbol: Symbol, word: str) -> Type | None:
    """The type of a member of an instance of ``symbol``; None where it has none."""
    entries = [e for e in ck.scope_of(symbol).table.get(word, []) if not e.private]
    if entries:
        entry = entries[0]
        kind = ck.entry_type(entry)
        if entry.kind == "surface" and word in FACES:
            return PLANE
        if symbol.kind == "primitive" and kind == CURVE and not isinstance(entry.node, ast.ParamDecl):
            return SURFACE  # surfaces bear the names of the curves that make them
        if isinstance(kind, PartType) and len(entries) > 1:
            kinds = [k for e in entries if isinstance(k := ck.entry_type(e), PartType)]
            return PartType.of((v for k in kinds for v in k.domain), kind.key)
        return kind
    if symbol.kind == "primitive":
        made = _made(symbol, word)
        if made is not None:
            return made
    if symbol.kind == "template" and word in ck.interface_of(symbol):
        role, decl = ck.interface_of(symbol)[word]
        if not getattr(decl, "optional", False) or word in _names_in_repeats(ck.scope_of(symbol)):
            return _symbol_member(ck, role, word)
    return box_member(word)


def _names_in_repeats(scope: BodyScope) -> set[str]:
    """Names that the repeats of a template declare: a part in a repeat binds the slot of its name."""
    return {name for inner in scope.below() if inner is not scope for name in inner.table}


_MADE = ("start", "end", "rim")


def _made(symbol: Symbol, word: str) -> Type | None:
    """What an operator supplies: along a path the ports ``start`` and ``end``, every solid surfaces of those names."""
    for stmt in symbol.body:
        if isinstance(stmt, ast.SolidDecl) and word in _MADE:
            return FRAME if _along_path(symbol, stmt) and word != "rim" else SURFACE
    return None


def _along_path(symbol: Symbol, solid: ast.SolidDecl) -> bool:
    """Whether a solid goes along one of its primitive's curves, not along an axis."""
    curves = {
        name
        for stmt in symbol.body
        for name in names_of(stmt)
        if isinstance(stmt, ast.CurveDecl)
        or isinstance(stmt, ast.LetDecl)
        and isinstance(stmt.value, ast.ChainExpr)
        or isinstance(stmt, ast.ParamDecl)
        and stmt.type.name == "curve"
    }
    along = solid.along.value if solid.along is not None else None
    return isinstance(along, ast.NameExpr) and along.name in curves
