"""Types of declarations: what a name of a body stands for."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean
from ..language import TYPES
from ..syntax import ast
from . import conditions, foreign
from .fold import constant
from .guards import Condition, Or, implies, possible
from .meanings import Declared, Global
from .presence import given
from .scope import BodyScope, Entry, Variant
from .types import (
    COUNT,
    CURVE,
    DIMENSIONS,
    MATERIAL,
    PLACES,
    SIZE,
    SURFACE,
    UNKNOWN,
    ArrayType,
    ChoiceType,
    ElementType,
    FunctionType,
    JointType,
    PartType,
    ScalarType,
    SlotType,
    StyleType,
    Type,
    VecType,
)

if TYPE_CHECKING:
    from .checker import Checker, Context


def type_of(ck: Checker, entry: Entry) -> Type:
    """The type of an entry; of a part, with all its variants."""
    ctx = ck.context(entry.scope).given(ck.entry_condition(entry))
    match entry.node:
        case ast.ParamDecl(type=ref):
            kind = of_reference(ck, ctx, ref)
            return kind if entry.name != "size" or kind == SIZE else UNKNOWN  # that a box has another is reported there
        case ast.CountDecl():
            return COUNT
        case ast.LetDecl(parameters=parameters, value=value, keyword=keyword):
            if parameters:
                return FunctionType(entry)
            kind = ck.infer(ctx.but(making=value), value)
            if isinstance(kind, StyleType) and isinstance(meaning := ck.meanings.get(id(value)), Global):
                return ck.error(
                    "wrong-type",
                    value.span,
                    f"`{meaning.symbol.name}` is a {meaning.symbol.kind}, not a value",
                    hint="to choose once for several parts, use a style: `style chosen : Role = A | B`",
                )
            if keyword == "curve" and kind != CURVE and not isinstance(kind, VecType) and kind != UNKNOWN:
                return ck.unfit(
                    value,
                    kind,
                    f"`{entry.name}` is declared as a curve",
                    hint="write a path, or a formula in two or three components; a value of another kind is a `let`",
                )
            return kind
        case ast.PartDecl():
            domain = choices(ck, entry)
            if domain == (None,):
                return UNKNOWN  # `none` alone, which is reported where the part is declared
            part = PartType.of(domain, entry.key)
            return replace(part, given=given(ck, entry, part))
        case ast.StyleDecl(role=role):
            return MATERIAL if role == "material" else StyleType(choices(ck, entry), role)
        case ast.RepeatStmt():
            return COUNT if entry.kind == "index" else ElementType(entry, entry.key)
        case ast.SlotDecl(name=name):
            return SlotType(name)
        case ast.PortDecl():
            return _port(ck, ctx, entry, entry.node)
        case ast.JointDecl(kind=kind):
            return JointType(kind)
        case ast.SurfaceDecl():
            return SURFACE
        case ast.CurveDecl():
            return CURVE
    return UNKNOWN


def _port(ck: Checker, ctx: Context, entry: Entry, node: ast.PortDecl) -> Type:
    declared = node.type
    if declared is None:
        # the role says what type a port has
        _, role_port = ck.interface_of(entry.scope.owner).get(entry.name, (None, None))
        if isinstance(role_port, ast.PortDecl) and role_port is not node:
            declared = role_port.type
    if declared is not None:
        item = of_reference(ck, ctx, declared)
    elif node.value is not None:
        item = ck.infer(port_context(ctx, node), node.value)
    else:
        item = UNKNOWN
    return item if node.index is None else ArrayType(item, _bindings(ck, entry))


def _bindings(ck: Checker, entry: Entry) -> tuple[tuple[int | None, Condition], ...]:
    """The bindings of an indexed port: of which index (None: of any), and what holds where each stands."""
    found = []
    for binding in entry.scope.root.table[entry.name]:
        node = binding.node
        if isinstance(node, ast.PortDecl) and node.index is not None and node.value is not None:
            number = constant(node.index, entry.scope.owner.module)
            found.append((None if number is None else int(number), ck.entry_condition(binding)))
    return tuple(found)


def port_context(ctx: Context, node: ast.PortDecl) -> Context:
    """Where a port's value stands: in ``port socket[i] = ...`` a new name ``i`` runs over all of its indices."""
    index = node.index
    if isinstance(index, ast.NameExpr) and ctx.scope is not None and not ctx.scope.find(index.name):
        return ctx.but(extra={**ctx.extra, index.name: COUNT})
    return ctx


def of_reference(ck: Checker, ctx: Context, ref: ast.TypeRef) -> Type:
    """The type that a type name stands for."""
    if ref.values:
        return ChoiceType(ref.values)
    if ref.style:
        symbol = ctx.module.find(ref.name)
        if symbol is None or symbol.kind not in ("role", "template"):
            message, hint = f"there is no role `{ref.name}` here", did_you_mean(ref.name, ctx.module.named("role"))
            return ck.unknown(ctx.module, ref.name, "unknown-type", ref.span, message, hint)
        ck.mean(ref, Global(symbol))
        return StyleType((Variant(ref.name, symbol), None), ref.name)
    if ref.name == "count":
        return COUNT
    if ref.name in DIMENSIONS:
        dimension = DIMENSIONS[ref.name]
        return ScalarType(dimension) if ref.size is None else VecType(ref.size, dimension)
    if ref.name == "vec":
        return VecType(ref.size or 3, DIMENSIONS["ratio"])
    if ref.name in PLACES:
        return PLACES[ref.name] if ref.size is None else ArrayType(PLACES[ref.name])
    hint = foreign.TYPES.get(ref.name.lower()) or did_you_mean(ref.name, TYPES)
    symbol = ctx.module.find(ref.name)
    if symbol is not None and symbol.kind in ("role", "template"):
        hint = f"declare a part with `part`; pass in a choice with `style {ref.name}`"
    return ck.error("unknown-type", ref.span, f"there is no type `{ref.name}`", hint=hint)


def choices(ck: Checker, entry: Entry) -> tuple[Variant | None, ...]:
    """What a part or a style can be: variants, and None where it may be absent."""
    node = entry.node
    if not isinstance(node, ast.PartDecl | ast.StyleDecl):
        return ()
    found: list[Variant | None] = []
    for alternative in node.alternatives:
        for variant in of_alternative(ck, entry.scope, alternative):
            if variant not in found:
                found.append(variant)
    if None not in found and _can_lack(ck, entry, node.alternatives):
        found.append(None)
    return tuple(found)


def _can_lack(ck: Checker, entry: Entry, alternatives: tuple[ast.Alternative, ...]) -> bool:
    """Whether all alternatives carry a guard and the guards leave a case open."""
    guards = [a.guard for a in alternatives if a.guard is not None]
    if not guards or len(guards) < len(alternatives):
        return False
    known = ck.entry_condition(entry)
    ctx = ck.context(entry.scope).given(known)
    return not implies(ctx.condition, Or(tuple(conditions.of(ck, ctx, guard) for guard in guards)))


def of_alternative(ck: Checker, scope: BodyScope, alternative: ast.Alternative) -> tuple[Variant | None, ...]:
    """What one alternative stands for: a style stands for all that it chooses from."""
    if alternative.name is None:
        return (None,)
    home = scope.home(alternative.name)
    for entry in home.table[alternative.name] if home is not None else ():
        kind = ck.entry_type(entry)
        if home is not None and isinstance(kind, StyleType):
            ck.mean(alternative, Declared(alternative.name, home.depth))
            return kind.domain
    symbol = scope.owner.module.find(alternative.name)
    if symbol is not None:
        ck.mean(alternative, Global(symbol))
    return (Variant(alternative.name, symbol),)


def narrowed(ctx: Context, part: PartType) -> PartType:
    """The part with the variants that are left under what holds here."""
    if len(part.domain) < 2:
        return part
    left = possible(ctx.condition, part.key, part.domain)
    return replace(part, variants=tuple(v for v in part.domain if v is not None and v in left))
