"""Checks of declarations: names, domains, defaults, distributions, alternatives and their arguments."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnostics.suggest import did_you_mean, given
from ..language import DIRECTIONS, FACES, FUNCTIONS, OWN, TYPES, WORDS
from ..source import Span
from ..syntax import ast
from . import conditions, paths
from .entries import of_alternative, of_reference
from .fold import components, constant
from .guards import consistent
from .meanings import Declared, Global, Word
from .offers import missing
from .scope import Entry, Scope
from .symbols import Symbol, is_a
from .types import (
    ANGLE,
    COUNT,
    DIRECTION,
    MATERIAL,
    RATIO,
    SIZE,
    UNKNOWN,
    Choice,
    Named,
    Scalar,
    Style,
    Type,
    Vec,
    fits,
)

if TYPE_CHECKING:
    from .checker import Checker, Context

TOLERANCE = 1e-9  # a default written in mm may stand at the end of a range written in cm


def check_names(ck: Checker, scope: Scope) -> None:
    """Reserved names, and names declared twice where both can exist."""
    for name, entries in scope.table.items():
        for entry in entries:
            if entry.scope.owner is scope.owner and _is_own(scope, entry.node):
                why = _reserved(scope, entry.kind, entry.node, name)
                if why is not None:
                    hint = "choose another name"
                    ck.error("reserved-name", entry.span, f"`{name}` cannot be declared: it is {why}", hint=hint)
                    ck.set_aside(entry)
                elif (around := _repeat_of(scope, entry)) is not None:
                    ck.error(
                        "duplicate-name",
                        entry.span,
                        f"`{name}` is already the name of the repeat around it",
                        hint="rename one of them",
                        notes=((around.name_span, "the repeat"),),
                    )
                    ck.set_aside(entry)
        for position, entry in enumerate(entries):
            for earlier in entries[:position]:
                if earlier.node is entry.node or _shared(earlier.node, entry.node):
                    continue
                if consistent(ck.entry_condition(earlier), ck.entry_condition(entry)):
                    ck.error(
                        "duplicate-name",
                        entry.span,
                        f"`{name}` is declared twice",
                        hint="a name may be declared twice only under guards that exclude each other",
                        notes=((earlier.span, "first declared here"),),
                    )
                    break


def _is_own(scope: Scope, node: ast.Stmt) -> bool:
    """Not what a template takes over from its role: that is checked where it stands."""
    source = scope.owner.decl.span
    return source.source is node.span.source and source.start <= node.span.start < source.end


def _repeat_of(scope: Scope, entry: Entry) -> ast.RepeatStmt | None:
    """The repeat whose element an entry is called like."""
    repeat = scope.repeat
    return repeat if repeat is not None and entry.name == repeat.name and entry.scope is scope else None


def _shared(a: ast.Stmt, b: ast.Stmt) -> bool:
    """Indexed ports are bound one by one; a slot may bear the name of the part it binds."""
    if isinstance(a, ast.PortDecl) and isinstance(b, ast.PortDecl):
        return a.index is not None and b.index is not None
    return any(isinstance(x, ast.SlotDecl) and x.targets and isinstance(y, ast.PartDecl) for x, y in ((a, b), (b, a)))


def _reserved(scope: Scope, kind: str, node: ast.Stmt, name: str) -> str | None:
    """Why a name may not be declared in this body, or None."""
    if name in FACES and kind != "surface" and not (scope.owner.kind == "category" and kind == "part"):
        return "a face of the box that every part has"
    if name in OWN and not (name == "size" and kind == "param"):
        return "a member that every part has"
    called = isinstance(node, ast.LetDecl) and node.parameters
    if called:  # `x` alone stays the axis
        if name in FUNCTIONS:
            return "a built-in function"
        return "a word of the language" if name in WORDS and name not in DIRECTIONS else None
    if kind == "surface" or kind == "curve" and name == "base":
        return None  # reached after a dot
    if kind in ("port", "slot", "curve", "joint"):
        return "a word of the language" if name in WORDS else None
    if (
        name in TYPES and not TYPES[name].free and kind != "part"
    ):  # `part frame` is no riddle: a type name alone says nothing
        return "a type name"
    if name in WORDS and not (name == "base" and scope.owner.kind == "category"):
        return "a word of the language"
    return None


# ---------------------------------------------------------------- parameters and counts


def check_param(ck: Checker, ctx: Context, node: ast.ParamDecl) -> None:
    """Type, domain, default, distribution, step and test range of parameters."""
    with ck.muted():
        kind = of_reference(ck, ctx, node.type)
    if "size" in node.names and kind not in (SIZE, UNKNOWN):
        span = node.name_spans[node.names.index("size")]
        ck.error("reserved-name", span, "`size` is the size of the box, so its type must be `length[3]`")
    what = f"`{node.names[0]}`"
    if node.domain is not None or node.positive or node.test is not None:
        if not isinstance(kind, Scalar | Vec) and kind != UNKNOWN:
            span = node.domain.span if node.domain is not None else node.span
            ck.error("wrong-type", span, f"{what} is {kind}: only numbers can have a range")
            return
    if node.domain is not None:
        check_range(ck, ctx, node.domain, kind, f"an end of the range of {what}")
    if node.test is not None:
        check_range(ck, ctx, node.test, kind, f"an end of the test range of {what}")
    if node.default is not None:
        if _default(ck, ctx, node.default, kind, what):
            _inside(ck, ctx, node.default, node.domain, what)
    if node.distribution is not None:
        _distribution(ck, ctx, node.distribution, kind, node.domain)
    if node.vary is not None:
        step = ck.infer(ctx, node.vary)
        base = Scalar(kind.dimension) if isinstance(kind, Vec) and kind.dimension is not None else kind
        if not fits(step, RATIO) and not fits(step, base):
            ck.mismatch(node.vary, step, base, f"the step of {what} is a ratio or")


def check_count(ck: Checker, ctx: Context, node: ast.CountDecl) -> None:
    what = f"`{node.name}`"
    check_range(ck, ctx, node.domain, COUNT, f"an end of the range of {what}")
    if node.default is not None:
        if _default(ck, ctx, node.default, COUNT, what):
            _inside(ck, ctx, node.default, node.domain, what)
    if node.distribution is not None:
        _distribution(ck, ctx, node.distribution, RATIO, node.domain)


def _default(ck: Checker, ctx: Context, default: ast.Expr, kind: Type, what: str) -> bool:
    """Whether a default fits the type; a value of a choice is a bare word."""
    if isinstance(kind, Choice) and isinstance(default, ast.NameExpr):
        if default.name not in kind.values:
            ck.error(
                "unknown-choice",
                default.span,
                f"`{default.name}` is not one of {', '.join(kind.values)}",
                hint=did_you_mean(default.name, kind.values),
            )
        ck.mean(default, Word(default.name))
        return default.name in kind.values
    given = ck.expect(ctx.but(holes=True) if isinstance(default, ast.VectorExpr) else ctx, default, kind, what)
    return fits(given, kind)


def check_range(ck: Checker, ctx: Context, interval: ast.RangeExpr, kind: Type, what: str) -> None:
    """Both ends fit the type, and the low one is not above the high one."""
    wanted = RATIO if kind == COUNT and not isinstance(interval.low, ast.NumberExpr) else kind
    for end in (interval.low, interval.high):
        ck.expect(ctx, end, wanted if not isinstance(end, ast.NumberExpr) else kind, what)
    lows, highs = components(interval.low, ctx.module), components(interval.high, ctx.module)
    if len(lows) == len(highs):
        for low, high in zip(lows, highs, strict=True):
            if low is not None and high is not None and low > high * (1 + TOLERANCE * (1 if high > 0 else -1)):
                ck.error(
                    "empty-range",
                    interval.span,
                    "the range is empty: its low end lies above its high end",
                    hint="swap the ends" if len(lows) == 1 else None,
                )
                return


def _inside(ck: Checker, ctx: Context, default: ast.Expr, domain: ast.RangeExpr | None, what: str) -> None:
    """A constant default lies in the constant domain."""
    if domain is None:
        return
    values = components(default, ctx.module)
    ends = components(domain.low, ctx.module), components(domain.high, ctx.module)
    if not len(values) == len(ends[0]) == len(ends[1]):
        return
    for value, low, high in zip(values, *ends, strict=True):
        if value is None or (low is not None and high is not None and low > high):
            continue
        slack = TOLERANCE * max(abs(value), abs(low or 0), abs(high or 0))
        if (low is not None and value < low - slack) or (high is not None and value > high + slack):
            text = domain.span.source.text[domain.span.start : domain.span.end]
            ck.error(
                "default-outside-range",
                default.span,
                f"the default of {what} lies outside its range {text}",
                notes=((domain.span, "the range"),),
            )
            return


_DISTRIBUTIONS = ("uniform", "normal", "lognormal", "values")


def _distribution(ck: Checker, ctx: Context, node: ast.Distribution, kind: Type, domain: ast.RangeExpr | None) -> None:
    if node.name not in _DISTRIBUTIONS:
        ck.error(
            "unknown-distribution",
            node.span,
            f"there is no distribution `{node.name}`",
            hint=did_you_mean(node.name, _DISTRIBUTIONS) or "there are " + ", ".join(_DISTRIBUTIONS),
        )
        return
    for argument in node.arguments:
        if argument.name is not None:
            ck.error("wrong-arguments", argument.span, "arguments of a distribution are given without names")
    if isinstance(kind, Choice):
        _options(ck, ctx, node, kind)
        return
    count = len(node.arguments)
    texts = {"normal": "a mean and a deviation", "lognormal": "a median and a relative deviation"}
    if node.name in texts and count != 2:
        ck.error("wrong-arguments", node.span, f"`{node.name}` takes {texts[node.name]}, {given(count)}")
        return
    if node.name == "uniform" and count not in (0, 2):
        ck.error("wrong-arguments", node.span, f"`uniform` takes no arguments, or two ends; {given(count)}")
        return
    if node.name == "values" and not count:
        ck.error("wrong-arguments", node.span, "`values` needs at least one value")
    for position, argument in enumerate(node.arguments):
        wanted = RATIO if node.name == "lognormal" and position == 1 else kind
        ck.expect(ctx, argument.value, wanted, f"an argument of `{node.name}`")
        value = constant(argument.value, ctx.module)
        if node.name in texts and position == 1 and value is not None and value <= 0:
            ck.error("wrong-arguments", argument.span, "a deviation must be greater than 0")
        if node.name == "values":
            _inside(ck, ctx, argument.value, domain, "a value of the distribution")


def _options(ck: Checker, ctx: Context, node: ast.Distribution, kind: Choice) -> None:
    """What weighs the words of a choice: ``values(round, round, oval)``."""
    if node.name != "values":
        hint = f"write `~ values({kind.values[0]}, {kind.values[0]}, {kind.values[-1]})`: an option listed twice is twice as likely"
        ck.error(
            "unknown-distribution", node.span, f"a choice is weighted with `values`, not with `{node.name}`", hint=hint
        )
        return
    if not node.arguments:
        ck.error("wrong-arguments", node.span, "`values` needs at least one value")
    for argument in node.arguments:
        if isinstance(argument.value, ast.NameExpr):
            _default(ck, ctx, argument.value, kind, "a value of the distribution")
        else:
            ck.error(
                "wrong-type",
                argument.span,
                f"a value of this choice must be one of {', '.join(kind.values)}",
                hint="an option listed twice is twice as likely",
            )


# ---------------------------------------------------------------- parts and styles


def check_part(ck: Checker, ctx: Context, node: ast.PartDecl) -> None:
    """Role, alternatives, arguments and placements of a part."""
    role = _role(ck, ctx, node, node.role, node.role_span) if node.role is not None else None
    for placement in node.placements:
        check_placement(ck, ctx, placement)
    if role is not None:
        check_arguments(ck, ctx, node.arguments, [role])
    _alternatives(ck, ctx, node.alternatives, role, node.role)
    if node.role is not None or len(node.alternatives) > 1:
        alone = f"write `part {node.name} : STYLE`; other alternatives, and `none`, go into the style"
        _no_style(ck, ctx, node.alternatives, alone)
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
    _no_style(ck, ctx, node.alternatives, "name its templates here, one by one")


def unknown_material(ck: Checker, ctx: Context, name: str, span: Span) -> None:
    materials = [s.name for s in ctx.module.names.values() if s.kind == "material"]
    hint = missing(name, materials, "material") or f"declare it: `material {name} {{ ... }}`"
    ck.unknown(ctx.module, name, "unknown-material", span, f"there is no material `{name}` here", hint)


def _role(ck: Checker, ctx: Context, node: ast.Stmt, name: str, span: Span | None) -> Symbol | None:
    symbol = ctx.module.find(name)
    assert span is not None
    if symbol is None or symbol.kind not in ("role", "template"):
        roles = [s.name for s in ctx.module.names.values() if s.kind == "role"]
        hint = missing(name, roles, "role", "template")
        ck.unknown(ctx.module, name, "unknown-template", span, f"there is no role `{name}` here", hint)
        return None
    ck.mean(node, Global(symbol))
    return symbol


def _no_style(ck: Checker, ctx: Context, alternatives: tuple[ast.Alternative, ...], hint: str) -> None:
    """A style is no alternative among others."""
    for alternative in alternatives:
        if isinstance(ck.meanings.get(id(alternative)), Declared):
            message = f"`{alternative.name}` is a style: it cannot be combined with a role or other alternatives"
            ck.error("wrong-kind", alternative.name_span, message, hint=hint)


def _alternatives(
    ck: Checker, ctx: Context, alternatives: tuple[ast.Alternative, ...], role: Symbol | None, role_name: str | None
) -> None:
    assert ctx.scope is not None
    _unweighed(ck, alternatives)
    for alternative in alternatives:
        _weight(ck, ctx, alternative)
        if alternative.guard is not None:
            conditions.truth(ck, ctx, alternative.guard)
        for placement in alternative.placements:
            check_placement(ck, ctx, placement)
        if alternative.name is None:
            continue
        styles = [e for e in ctx.scope.find(alternative.name) if isinstance(ck.entry_type(e), Style)]
        style = bool(styles)
        if styles:
            paths.sole(ck, ctx, styles, alternative.name_span)
        variants = [v for v in of_alternative(ck, ctx.scope, alternative) if v is not None]
        symbols = [v.symbol for v in variants if v.symbol is not None]
        if not style and (not symbols or symbols[0].kind not in ("template", "primitive")):
            _bad_alternative(ck, ctx, alternative, symbols[0] if symbols else None)
            continue
        wrong = [s for s in symbols if role is not None and not is_a(s, role) and not is_a(role, s)]
        if wrong:
            ck.error(
                "wrong-role",
                alternative.name_span,
                f"`{wrong[0].name}` cannot be an alternative here: it does not have the role {role_name}",
                notes=((wrong[0].decl.name_span, f"`{wrong[0].name}` is declared here"),),
            )
        check_arguments(ck, ctx, alternative.arguments, symbols)


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
        ck.error("unknown-template", alternative.name_span, f"`{alternative.name}` is a {symbol.kind}, not a template")
        return
    offered = [s.name for s in ctx.module.names.values() if s.kind in ("template", "primitive")]
    offered += [e.name for scope in ctx.scope.chain() for e in scope.entries if e.kind in ("style", "param")]
    ck.unknown(
        ctx.module,
        alternative.name,
        "unknown-template",
        alternative.name_span,
        f"there is no template, primitive or style `{alternative.name}` here",
        hint=missing(alternative.name, offered, "template", "primitive"),
    )


def _weight(ck: Checker, ctx: Context, alternative: ast.Alternative) -> None:
    if alternative.weight is not None:
        ck.expect(ctx, alternative.weight, RATIO, "a weight")
        value = constant(alternative.weight, ctx.module)
        if value is not None and value < 0:
            ck.error("wrong-arguments", alternative.weight.span, "a weight cannot be negative")


def _unweighed(ck: Checker, alternatives: tuple[ast.Alternative, ...]) -> None:
    """A weight says how often one alternative is taken before others: a sole one has none."""
    if len(alternatives) == 1 and (weight := alternatives[0].weight) is not None:
        ck.error(
            "unknown-clause",
            weight.span,
            "a weight has no effect without another alternative",
            hint="add another alternative, such as `| none weight 0.5`; a style has weights of its own",
        )


def check_placement(ck: Checker, ctx: Context, placement: ast.Placement) -> None:
    ck.expect(ctx, placement.direction, DIRECTION, f"the axis after `{'about' if placement.angle else 'along'}`")
    if placement.angle is not None:
        ck.expect(ctx, placement.angle, ANGLE, "the angle after `turned`")


def check_arguments(ck: Checker, ctx: Context, given: tuple[ast.Argument, ...], symbols: list[Symbol]) -> None:
    """Arguments of a role or a template: each names a parameter and fits its type."""
    seen: set[str] = set()
    for argument in given:
        if argument.name is None:
            ck.error(
                "wrong-arguments",
                argument.span,
                "an argument of a template or primitive needs its name",
                hint="as in `Cuboid(size = [1cm, 2cm, 3cm])`",
            )
            ck.infer(ctx.but(holes=True), argument.value)
            continue
        if argument.name in seen:
            ck.error("wrong-arguments", argument.span, f"`{argument.name}` is given twice")
        seen.add(argument.name)
        wanted: Type = UNKNOWN
        for symbol in symbols:
            kind = _parameter(ck, symbol, argument.name)
            if kind is None:
                offered = parameters(ck, symbol)
                ck.error(
                    "unknown-argument",
                    argument.span,
                    f"{symbol.name} has no parameter `{argument.name}`",
                    hint=did_you_mean(argument.name, offered)
                    or ("it has " + ", ".join(offered) if offered else "it has none"),
                )
                break
            wanted = kind
        _argument(ck, ctx, argument, wanted)


def _argument(ck: Checker, ctx: Context, argument: ast.Argument, wanted: Type) -> None:
    value = argument.value
    if isinstance(wanted, Choice) and isinstance(value, ast.NameExpr):
        if ctx.scope is None or not ctx.scope.find(value.name):
            _default(ck, ctx, value, wanted, f"`{argument.name}`")
            return
    place = ctx
    if isinstance(value, ast.VectorExpr):
        place = ctx.but(holes=True, component=wanted.dimension if isinstance(wanted, Vec) else None)
    given = ck.infer(place, value)
    if isinstance(wanted, Style):
        symbol = meaning.symbol if isinstance(meaning := ck.meanings.get(id(value)), Global) else None
        if symbol is not None and symbol.kind == "role":
            ck.error(
                "wrong-arguments",
                value.span,
                f"`{symbol.name}` is a role: it cannot be passed as a value",
                hint="a `style` parameter takes the name of a template or of a style: `style chosen : Role = A | B`",
            )
        elif isinstance(given, Style):
            role = next((v.symbol for v in wanted.domain if v is not None), None)
            for variant in given.domain:
                if variant is not None and variant.symbol is not None and role is not None:
                    if not is_a(variant.symbol, role):
                        ck.error("wrong-role", value.span, f"`{variant.name}` does not have the role {wanted.role}")
                        return
        elif given != UNKNOWN:
            ck.mismatch(value, given, wanted, f"`{argument.name}`")
        return
    if isinstance(wanted, Named) and wanted == MATERIAL and given == MATERIAL:
        return
    if not fits(given, wanted):
        ck.mismatch(value, given, wanted, f"`{argument.name}`")


def _parameter(ck: Checker, symbol: Symbol, name: str) -> Type | None:
    entries = [e for e in ck.scope_of(symbol).table.get(name, []) if e.kind in ("param", "count")]
    return ck.entry_type(entries[0]) if entries else None


def parameters(ck: Checker, symbol: Symbol) -> list[str]:
    """The names that may be given as arguments."""
    return [e.name for e in ck.scope_of(symbol).entries if e.kind in ("param", "count")]
