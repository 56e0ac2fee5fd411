"""Checks of parts and styles: their alternatives, the weights and placements of these, and the arguments handed in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean
from ..source import Span
from ..syntax import ast
from . import conditions, foreign, paths
from .declarations import check_default, outside
from .entries import of_alternative
from .fold import constant
from .guards import Not, conjunction
from .meanings import Declared, Global
from .offers import missing, module_of
from .presence import declared, guarded, relevant, renamed, told
from .scope import Entry
from .symbols import Symbol, is_a, lacks_role
from .types import (
    ANGLE,
    COUNT,
    DIRECTION,
    MATERIAL,
    RATIO,
    UNKNOWN,
    ChoiceType,
    NamedType,
    StyleType,
    Type,
    VecType,
    fits,
)

if TYPE_CHECKING:
    from .checker import Checker, Context

_SHOWN = 3  # parameters in a hint
_HANDED = "(handed)"  # how guards call the choices of a template of which there are only the arguments


def check_part(ck: Checker, ctx: Context, node: ast.PartDecl) -> None:
    """Role, alternatives, arguments and placements of a part."""
    role = _role(ck, ctx, node, node.role, node.role_span) if node.role is not None else None
    for placement in node.placements:
        _check_placement(ck, ctx, placement)
    if role is not None:
        _check_arguments(ck, ctx, node.arguments, [role])
    _alternatives(ck, ctx, node.alternatives, role, node.role, node.arguments)
    if node.role is not None or len(node.alternatives) > 1:
        alone = f"write `part {node.name} : STYLE`; other alternatives, and `none`, go into the style"
        _no_style(ck, node.alternatives, alone)
    if all(alternative.name is None for alternative in node.alternatives):
        ck.error(
            "wrong-kind",
            node.name_span,
            f"`{node.name}` has no alternative but `none`",
            hint="add a template, as in `Cuboid | none`",
        )


def check_style(ck: Checker, ctx: Context, node: ast.StyleDecl) -> None:
    """A style of a role, or of a material."""
    if node.role == "material":
        for alternative in node.alternatives:
            symbol = ctx.module.find(alternative.name) if alternative.name else None
            if symbol is None or symbol.kind != "material":
                unknown_material(ck, ctx, alternative.name or "none", alternative.name_span)
            else:
                ck.mean(alternative, Global(symbol))
            _weight(ck, ctx, alternative)
            if alternative.guard is not None:
                conditions.truth(ck, ctx, alternative.guard)
            for extra in (*alternative.arguments, *alternative.placements)[:1]:
                ck.error(
                    "unknown-clause",
                    extra.span,
                    "a material takes no arguments and cannot be turned",
                    hint="for another look, declare another material: `material dark_oak { ... }`",
                )
        _unweighed(ck, node.alternatives)
        return
    _alternatives(ck, ctx, node.alternatives, _role(ck, ctx, node, node.role, node.role_span), node.role)
    _no_style(ck, node.alternatives, "name its templates here, one by one")


def unknown_material(ck: Checker, ctx: Context, name: str, span: Span) -> None:
    styles = (e.name for scope in ctx.scope.chain() for e in scope.entries if e.kind == "style") if ctx.scope else ()
    hint = (
        missing(name, [*styles, *ctx.module.named("material")], "material")
        or f"declare it: `material {name} {{ ... }}`"
    )
    if ctx.scope is not None and any(entry.kind == "style" for entry in ctx.scope.find(name)):
        said = f"`{name}` is a style, which cannot be one of several alternatives"
        ck.error(
            "unknown-material",
            span,
            said,
            hint=f"name its materials here, one by one; `steel when {name} == steel` follows it",
        )
        return
    if name == "none":
        hint = "what has no material of its own takes that of the part around it: put the `material` statement under a `when`"
    ck.unknown(ctx.module, name, "unknown-material", span, f"there is no material `{name}` here", hint)


def _role(ck: Checker, ctx: Context, node: ast.Stmt, name: str, span: Span | None) -> Symbol | None:
    symbol = ctx.module.find(name)
    assert span is not None
    if symbol is None or symbol.kind not in ("role", "template"):
        if symbol is not None or module_of(name, "primitive", "material") is not None:
            said, instead = _no_role(symbol, node, name)
            ck.error("unknown-template", span, said, hint=instead)
            return None
        hint = missing(name, ctx.module.named("role"), "role", "template")
        ck.unknown(ctx.module, name, "unknown-template", span, f"there is no role `{name}` here", hint)
        return None
    ck.mean(node, Global(symbol))
    return symbol


def _no_role(symbol: Symbol | None, node: ast.Stmt, name: str) -> tuple[str, str]:
    """Message and hint for a name of something else where a role is expected: what to write instead."""
    kind = symbol.kind if symbol is not None else "primitive" if module_of(name, "primitive") else "material"
    said = f"`{name}` is a {kind}, not a role"
    if kind == "material":
        return said, f"a style of materials is `style NAME : material = {name} | ...`"
    alternatives = getattr(node, "alternatives", ())
    text = " | ".join(alternative.span.words for alternative in alternatives) or f"{name}(...)"
    if isinstance(node, ast.PartDecl):
        return said, f"primitives need no role: write `part {node.name} : {text}`"
    return said, (
        f"a style draws among templates of a role: declare `role Kind {{ slot body }}` and, for each shape, "
        f"`template Plain : Kind {{ part body : {name}(...) }}`; for a single part, write the alternatives there: `part NAME : {text}`"
    )


def _no_style(ck: Checker, alternatives: tuple[ast.Alternative, ...], hint: str) -> None:
    """A style is no alternative among others."""
    for alternative in alternatives:
        if isinstance(ck.meanings.get(id(alternative)), Declared):
            message = f"`{alternative.name}` is a style: it cannot be combined with a role or other alternatives"
            ck.error("wrong-kind", alternative.name_span, message, hint=hint)


def _alternatives(
    ck: Checker,
    ctx: Context,
    alternatives: tuple[ast.Alternative, ...],
    role: Symbol | None,
    role_name: str | None,
    outer: tuple[ast.Argument, ...] = (),
) -> None:
    assert ctx.scope is not None
    _unweighed(ck, alternatives)
    for alternative in alternatives:
        _weight(ck, ctx, alternative)
        if alternative.guard is not None:
            conditions.truth(ck, ctx, alternative.guard)
        for placement in alternative.placements:
            _check_placement(ck, ctx, placement)
        if alternative.name is None:
            continue
        styles = [e for e in ctx.scope.find(alternative.name) if isinstance(ck.entry_type(e), StyleType)]
        style = bool(styles)
        if styles:
            paths.sole(ck, ctx, styles, alternative.name_span)
        variants = [v for v in of_alternative(ck, ctx.scope, alternative) if v is not None]
        symbols = [v.symbol for v in variants if v.symbol is not None]
        if not style and (not symbols or symbols[0].kind not in ("template", "primitive")):
            _bad_alternative(ck, ctx, alternative, symbols[0] if symbols else None)
            continue
        wrong = [s for s in symbols if role is not None and not is_a(s, role) and not is_a(role, s)]
        if wrong and not lacks_role(wrong[0]):
            ck.error(
                "wrong-role",
                alternative.name_span,
                f"`{wrong[0].name}` cannot be an alternative here: it does not have the role {role_name}",
                notes=((wrong[0].decl.name_span, f"`{wrong[0].name}` is declared here"),),
                hint=f"choose a template of that role, or make one of it: `template Name : {role_name} {{ part ... }}`",
            )
        _check_arguments(ck, ctx, alternative.arguments, symbols, outer)


def _bad_alternative(ck: Checker, ctx: Context, alternative: ast.Alternative, symbol: Symbol | None) -> None:
    assert alternative.name is not None and ctx.scope is not None
    if symbol is not None and symbol.kind == "role":
        playing = [s.name for s in ctx.module.names.values() if s.kind == "template" and is_a(s, symbol)]
        ck.error(
            "unknown-template",
            alternative.name_span,
            f"`{alternative.name}` is a role: a part needs one of its templates",
            hint="name the alternatives: `= " + " | ".join(playing) + "`" if playing else None,
        )
        return
    if symbol is not None:
        ck.error(
            "unknown-template",
            alternative.name_span,
            f"`{alternative.name}` is a {symbol.kind}, not a template",
            hint="name a template or a primitive; what it declares can be used by its own name",
        )
        return
    if any(ck.entry_type(entry) == UNKNOWN for entry in ctx.scope.find(alternative.name)):
        return  # what is wrong with it is reported where it is declared
    offered = ctx.module.named("template", "primitive")
    offered += [e.name for scope in ctx.scope.chain() for e in scope.entries if e.kind in ("style", "param")]
    ck.unknown(
        ctx.module,
        alternative.name,
        "unknown-template",
        alternative.name_span,
        f"there is no template, primitive or style `{alternative.name}` here",
        hint=missing(alternative.name, offered, "template", "primitive") or foreign.ABSENT.get(alternative.name),
    )


def _weight(ck: Checker, ctx: Context, alternative: ast.Alternative) -> None:
    if alternative.weight is not None:
        ck.expect(ctx, alternative.weight, RATIO, "a weight")
        value = constant(alternative.weight, ctx.module)
        if value is not None and value < 0:
            ck.error(
                "wrong-arguments",
                alternative.weight.span,
                "a weight cannot be negative",
                hint="write 0 or more; an alternative of weight 0 is never drawn",
            )


def _unweighed(ck: Checker, alternatives: tuple[ast.Alternative, ...]) -> None:
    """A weight says how often one alternative is taken before others: a sole one has none."""
    if len(alternatives) == 1 and (weight := alternatives[0].weight) is not None:
        ck.error(
            "unknown-clause",
            weight.span,
            "a weight has no effect without another alternative",
            hint="add another alternative, such as `| none weight 0.5`; a style has weights of its own",
        )


def _check_placement(ck: Checker, ctx: Context, placement: ast.Placement) -> None:
    ck.expect(ctx, placement.direction, DIRECTION, f"the axis after `{'about' if placement.angle else 'along'}`")
    if placement.angle is not None:
        ck.expect(ctx, placement.angle, ANGLE, "the angle after `turned`")


def _check_arguments(
    ck: Checker,
    ctx: Context,
    given: tuple[ast.Argument, ...],
    symbols: list[Symbol],
    outer: tuple[ast.Argument, ...] = (),
) -> None:
    """Arguments of a role or a template: each names a parameter that is there and fits its type. ``outer``: those of the role."""
    seen: set[str] = set()
    for argument in given:
        if argument.name is None:
            ck.error(
                "wrong-arguments",
                argument.span,
                "an argument of a template or primitive needs its name",
                hint=_by_name(ck, symbols),
            )
            ck.infer(ctx.but(holes=True), argument.value)
            continue
        if argument.name in seen:
            ck.error("wrong-arguments", argument.span, f"`{argument.name}` is given twice", hint="keep one of the two")
        seen.add(argument.name)
        wanted: Type = UNKNOWN
        known = True
        for symbol in symbols:
            kind = _parameter(ck, symbol, argument.name)
            if kind is None:
                offered = parameters(ck, symbol)
                ck.error(
                    "unknown-argument",
                    argument.span,
                    f"{symbol.name} has no parameter `{argument.name}`",
                    hint=_meant(argument.name, offered)
                    or ("it has " + ", ".join(offered) if offered else "it has none"),
                )
                known = False
                break
            wanted = kind
            _stands(ck, ctx, symbol, argument, (*outer, *given))
        if known:  # what the value of another should be, nobody can tell
            _argument(ck, ctx, argument, wanted)
            for symbol in symbols:
                _within_range(ck, ctx, symbol, argument, wanted)


def _meant(name: str, offered: list[str]) -> str | None:
    """What to write instead of an argument that there is not."""
    parameter, told = foreign.SIZES.get(name, ("", None))
    if parameter in offered:
        return told
    return did_you_mean(name, offered) or foreign.ARGUMENTS.get(name)


def _by_name(ck: Checker, symbols: list[Symbol]) -> str:
    """How the arguments of a template are written."""
    names = parameters(ck, symbols[0])[:_SHOWN] if symbols else []
    if not names:
        return "as in `Cuboid(size = [1cm, 2cm, 3cm])`"
    written = [f"{name} = {'[1cm, 2cm, 3cm]' if name == 'size' else '...'}" for name in names]
    return f"as in `{symbols[0].name}({', '.join(written)})`"


def _stands(
    ck: Checker, ctx: Context, symbol: Symbol, argument: ast.Argument, told_by: tuple[ast.Argument, ...]
) -> None:
    """What a template declares under a guard is handed in where the other arguments ensure it: else it would be lost."""
    assert ctx.scope is not None and argument.name is not None
    entries = ck.scope_of(symbol).table[argument.name]
    wanted = renamed(declared(ck, entries), ((symbol.name, _HANDED),))
    known = relevant(wanted, conjunction(told(ck, ctx.scope, _HANDED, symbol, told_by)))
    message, _ = guarded(entries[0], argument.span)
    hint = f"hand in what ensures that as well, or declare `{argument.name}` above the `when`"
    notes = ((entries[0].span, "declared here"),)
    ck.demand(ctx.given(known), wanted, argument.span, message, hint, notes, value=True, handed=True)


def _within_range(ck: Checker, ctx: Context, symbol: Symbol, argument: ast.Argument, wanted: Type) -> None:
    """A number that its template never draws is perhaps one with the wrong unit."""
    assert argument.name is not None
    if not fits(ck.types.get(id(argument.value), UNKNOWN), wanted):
        return  # what is wrong is reported
    ranges = []
    for entry in ck.scope_of(symbol).table[argument.name]:
        domain = entry.node.domain if isinstance(entry.node, ast.ParamDecl | ast.CountDecl) else None
        if domain is None or not outside(argument.value, domain, ctx.module, ck.context(entry.scope).module):
            return
        ranges.append(domain.span)
    ck.warning(
        "argument-outside-range",
        argument.span,
        f"`{symbol.name}` has `{argument.name}` in {' or '.join(span.text for span in ranges)}",
        hint=f"{'is it right' if wanted == COUNT else 'is the unit right'}? If the value is meant, widen the range",
        notes=tuple((span, "declared here") for span in ranges),
    )


def _option(ck: Checker, ctx: Context, value: ast.Expr, wanted: ChoiceType, what: str) -> None:
    """The value of a choice: one of its options, a choice that is declared here, or `a if c else b` of these."""
    match value:
        case ast.IfExpr():
            conditions.truth(ck, ctx, value.condition)
            known = conditions.of(ck, ctx, value.condition)
            _option(ck, ctx.given(known), value.then, wanted, what)
            _option(ck, ctx.given(Not(known)), value.otherwise, wanted, what)
        case ast.NameExpr() if ctx.scope is None or not ctx.scope.find(value.name):
            check_default(ck, ctx, value, wanted, what)
        case _:
            ck.expect(ctx, value, wanted, what)


def _argument(ck: Checker, ctx: Context, argument: ast.Argument, wanted: Type) -> None:
    value = argument.value
    if isinstance(wanted, ChoiceType):
        _option(ck, ctx, value, wanted, f"`{argument.name}`")
        return
    place = ctx
    if isinstance(value, ast.VectorExpr):
        place = ctx.but(holes=True, component=wanted.dimension if isinstance(wanted, VecType) else None)
    given = ck.infer(place, value)
    if isinstance(wanted, StyleType):
        symbol = meaning.symbol if isinstance(meaning := ck.meanings.get(id(value)), Global) else None
        if symbol is not None and symbol.kind == "role":
            ck.error(
                "wrong-arguments",
                value.span,
                f"`{symbol.name}` is a role: it cannot be passed as a value",
                hint="a `style` parameter takes the name of a template or of a style: `style chosen : Role = A | B`",
            )
        elif isinstance(given, StyleType):
            role = next((v.symbol for v in wanted.domain if v is not None), None)
            for variant in given.domain:
                if variant is not None and variant.symbol is not None and role is not None:
                    if not is_a(variant.symbol, role):
                        ck.error(
                            "wrong-role",
                            value.span,
                            f"`{variant.name}` does not have the role {wanted.role}",
                            hint=f"take alternatives of the role {wanted.role} only",
                        )
                        return
        elif given != UNKNOWN:
            ck.mismatch(value, given, wanted, f"`{argument.name}`")
        return
    if isinstance(wanted, NamedType) and wanted == MATERIAL and given == MATERIAL:
        return
    if not fits(given, wanted):
        ck.mismatch(value, given, wanted, f"`{argument.name}`")


def _parameter(ck: Checker, symbol: Symbol, name: str) -> Type | None:
    entries = [e for e in ck.scope_of(symbol).table.get(name, []) if _given_by_user(e)]
    return ck.entry_type(entries[0]) if entries else None


def parameters(ck: Checker, symbol: Symbol) -> list[str]:
    """The names that may be given as arguments."""
    return list(dict.fromkeys(entry.name for entry in taken(ck, symbol)))


def taken(ck: Checker, symbol: Symbol) -> list[Entry]:
    """The declarations that an argument may give a value."""
    return [entry for entry in ck.scope_of(symbol).entries if _given_by_user(entry)]


def _given_by_user(entry: Entry) -> bool:
    """Whether an argument may give it: an output is the template's own."""
    return entry.kind in ("param", "count") and getattr(entry.node, "keyword", None) != "out"
