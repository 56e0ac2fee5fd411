"""Checks of parameters and counts: domains, defaults, distributions."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, cast

from ..diagnostics.suggest import any_of, did_you_mean, given
from ..language import DISTRIBUTIONS
from ..syntax import ast
from ..syntax.walk import walk
from .entries import of_reference
from .fold import components, constant
from .meanings import Declared, Word
from .remedies import instead
from .symbols import ModuleScope
from .types import (
    BOOL,
    COUNT,
    CURVE,
    MATERIAL,
    RATIO,
    SIZE,
    STRING,
    UNKNOWN,
    ArrayType,
    ChoiceType,
    ScalarType,
    Type,
    VecType,
    fits,
)

if TYPE_CHECKING:
    from .checker import Checker, Context

TOLERANCE = 1e-9  # a default written in mm may stand at the end of a range written in cm
_TAIL = 6.0  # deviations beyond which a normal law has nothing left


def check_param(ck: Checker, ctx: Context, node: ast.ParamDecl) -> None:
    """Type, domain, default, distribution, step and test range of parameters."""
    with ck.muted():
        kind = of_reference(ck, ctx, node.type)
    if "size" in node.names and kind not in (SIZE, UNKNOWN):
        span = node.name_spans[node.names.index("size")]
        said = "`size` is the size of the box, so its type must be `length[3]`"
        ck.error("reserved-name", span, said, hint="for another size, choose another name, such as `width` or `tall`")
    what = f"`{node.names[0]}`"
    if node.domain is not None or node.positive or node.test is not None:
        if not isinstance(kind, ScalarType | VecType) and kind != UNKNOWN:
            span = node.domain.span if node.domain is not None else node.span
            ck.error("wrong-type", span, f"{what} is {kind}: only numbers can have a range", hint="leave the range out")
            return
    if not _taken(ck, ctx, node, kind, what):
        return
    _idle(ck, ctx, node, kind, what)
    if node.domain is not None:
        check_range(ck, ctx, node.domain, kind, f"an end of the range of {what}", ", ".join(node.names))
    if node.test is not None:
        check_range(ck, ctx, node.test, kind, f"an end of the test range of {what}")
    _drawn(ck, ctx, node, kind, what)
    if node.vary is not None:
        step = ck.infer(ctx, node.vary)
        base = ScalarType(kind.dimension) if isinstance(kind, VecType) and kind.dimension is not None else kind
        if not fits(step, RATIO) and not fits(step, base):
            ck.mismatch(node.vary, step, base, f"the step of {what}, unless it is a ratio,")
        share = constant(node.vary) if fits(step, RATIO) and not fits(RATIO, base) else None
        if share is not None and share > 1:
            ck.error(
                "illegal-value",
                node.vary.span,
                f"a step of {100 * share:g}% of {what} is more than the value itself",
                hint=f"write `vary {share:g}%`, or an amount with its unit",
            )
    _follows(ck, ctx, node)


def _taken(ck: Checker, ctx: Context, node: ast.ParamDecl, kind: Type, what: str) -> bool:
    """Whether there can be a parameter of this type here, with this default."""
    owner = ctx.scope.owner.kind if ctx.scope is not None else ""
    number = isinstance(kind, ScalarType | VecType) or kind == UNKNOWN
    if isinstance(kind, ArrayType) or kind == STRING:
        ck.unfit(
            node.type,
            kind,
            f"{what} must be one value that parts can be made from",
            hint="a parameter is a number, a vector, a choice, a switch, a place or a material: write `choice a | b` for words",
        )
    elif owner == "primitive" and not number and kind not in (BOOL, CURVE):
        hint = "choose between primitives in a template, or take a `bool`"
        ck.unfit(node.type, kind, "a primitive takes numbers, switches and curves", hint=hint)
    elif number or isinstance(kind, ChoiceType):
        return True
    elif kind not in (BOOL, MATERIAL):
        if owner == "category":
            ck.unfit(
                node.type,
                kind,
                "a parameter of a category is a number, an option, a switch or a material",
                hint="compute it of numbers: `let name = [x, y, z]`, or declare it in a template, where whoever uses that hands it in",
            )
        elif node.default is not None:
            said = f"{what} is {kind}, which has no default"
            ck.error("wrong-type", node.default.span, said, hint=f"pass it as an argument: `({node.names[0]} = ...)`")
        else:
            return True
    elif owner == "category" and node.default is None:  # nobody hands anything to a category
        drawn = "`choice yes | no`" if kind == BOOL else "`style name : material = oak | steel`"
        hint = f"write `= {'false' if kind == BOOL else 'oak'}`; for one that is drawn, {drawn}"
        ck.error("missing-value", node.span, f"{what} has no value", hint=hint)
    else:
        return True
    return False


def _idle(ck: Checker, ctx: Context, node: ast.ParamDecl, kind: Type, what: str) -> None:
    """Clauses about how a value is drawn, of one that is never drawn or not like this."""
    choice, out = isinstance(kind, ChoiceType), node.keyword == "out"
    drawn = (node.domain is not None or choice) and not out
    primitive = ctx.scope is not None and ctx.scope.owner.kind == "primitive"
    in_range = "for example `in 1cm .. 2cm`"
    if kind == BOOL:
        in_range = "a choice is drawn: `choice yes | no`"
    idle = (
        ("in", out and node.domain is not None, "an output is what the template makes it", "state a `require`"),
        ("~", node.distribution is not None and not drawn, "nothing is drawn without a range", in_range),
        (
            "vary",
            node.vary is not None and choice,
            "a choice has no steps",
            "leave it out: a step takes any other option",
        ),
        ("vary", node.vary is not None and not choice and not drawn, "nothing is drawn without a range", in_range),
        ("was", node.was is not None and not drawn, "nothing is drawn without a range", in_range),
        (
            "derived",
            node.derived and (choice or out or kind == BOOL),
            "equations determine numbers only",
            "leave it out",
        ),
        (
            "test",
            node.test is not None and not primitive,
            "primitives alone are tested over ranges",
            "write `in` for the range that is drawn from",
        ),
    )
    for word, here, why, hint in idle:
        if here and kind != UNKNOWN:
            ck.error("unknown-clause", node.span, f"`{word}` has no effect on {what}: {why}", hint=hint)


def _follows(ck: Checker, ctx: Context, node: ast.ParamDecl) -> None:
    """What a template takes is settled before its body, one parameter after the other: each may follow from those above it."""
    scope = ctx.scope
    if scope is None or scope.owner.kind == "category" or all(stated is not node for stated in scope.owner.body):
        return
    for said in ast.present(node.domain, node.default, node.distribution, node.vary):
        for name in walk(said):
            if not isinstance(name, ast.NameExpr) or not isinstance(ck.meanings.get(id(name)), Declared):
                continue
            found = next((entry for entry in scope.table.get(name.name, ()) if entry.scope is scope), None)
            if found is None or isinstance(found.node, ast.ParamDecl) and found.span.start < node.name_spans[0].start:
                continue
            if found.span.source is not node.span.source:
                continue  # of a role
            if isinstance(found.node, ast.ParamDecl):
                same = name.name in node.names
                message = f"`{name.name}` depends on itself" if same else f"`{name.name}` is declared below"
                hint = "a parameter can follow from those above it"
            else:
                message = f"a parameter cannot follow from `{name.name}`: the body of the template is made from its parameters"
                hint = f"write out what `{name.name}` is, or state with `require` what must hold between the two"
            ck.error("circular-definition", name.span, message, hint=hint)


def check_count(ck: Checker, ctx: Context, node: ast.CountDecl) -> None:
    what = f"`{node.name}`"
    check_range(ck, ctx, node.domain, COUNT, f"an end of the range of {what}", node.name)
    _drawn(ck, ctx, node, COUNT, what)


def _drawn(ck: Checker, ctx: Context, node: ast.ParamDecl | ast.CountDecl, kind: Type, what: str) -> None:
    """The default and the distribution."""
    ends = () if node.domain is None else (node.domain.low, node.domain.high)
    if node.default is not None and check_default(ck, ctx, node.default, kind, what, ends):
        _inside(ck, ctx, node.default, node.domain, f"the default of {what}")
        values = components(node.default, ctx.module)
        if isinstance(node, ast.ParamDecl) and node.positive and any(v is not None and v <= 0 for v in values):
            ck.error(
                "default-outside-range",
                node.default.span,
                f"the default of {what} is not above 0",
                hint="write a default above 0, or leave `> 0` out",
            )
    if isinstance(kind, ChoiceType) and isinstance(node, ast.ParamDecl) and len(node.type.values) == 1:
        said = f"{what} has one option: it always is `{node.type.values[0]}`"
        ck.warning("empty-range", node.type.span, said, hint="add another option behind `|`, or leave it out")
    if node.distribution is not None:
        _distribution(ck, ctx, node.distribution, kind, node.domain)
        if node.distribution.name == "values" and isinstance(kind, ChoiceType):
            _left_out(ck, ctx, node.distribution, kind, what.strip("`"))
        elif node.distribution.name == "values" and kind == COUNT and node.domain is not None:
            _ends_left_out(ck, ctx, node.distribution, node.domain, what.strip("`"))


def _left_out(ck: Checker, ctx: Context, law: ast.Distribution, kind: ChoiceType, name: str) -> None:
    """Warns of options of a choice that `values` does not list, and that no argument hands to a template."""
    listed = {argument.span.words for argument in law.arguments}
    if ctx.scope is None or not listed or not listed <= set(kind.values):
        return  # what is wrong is reported
    handed = _handed(ctx) if ctx.scope.owner.kind != "category" else ()
    left = [word for word in kind.values if word not in listed and word not in handed]
    if left:
        it = "it" if len(left) == 1 else "them"
        said = f"`{name}` is never {any_of(left)}: `{law.span.words}` leaves {it} out"
        ck.warning("excluded-value", law.span, said, hint=f"list {it}, or leave {it} out of the options")


def _ends_left_out(ck: Checker, ctx: Context, law: ast.Distribution, domain: ast.RangeExpr, name: str) -> None:
    """Warns of ends of a range that `values` does not list, and that no argument of the file hands to a template."""
    low, high = constant(domain.low, ctx.module), constant(domain.high, ctx.module)
    listed = [constant(argument.value, ctx.module) for argument in law.arguments]
    known = [value for value in listed if value is not None]
    if ctx.scope is None or len(known) < len(listed) or not known or any(value % 1.0 for value in known):
        return
    if any(isinstance(node, ast.Argument) and node.name == name for node in walk(ctx.module.tree.declarations)):
        return
    least, most = min(known), max(known)
    if (low is not None and least < low) or (high is not None and most > high):
        return  # what is wrong is reported
    left = [f"{end:g}" for end, near in ((low, least), (high, most)) if end is not None and end != near]
    if left:
        it = "it" if len(left) == 1 else "them"
        said = f"`{name}` is never {any_of(left)}: `{law.span.words}` leaves {it} out"
        ck.warning("excluded-value", law.span, said, hint=f"list {it}, or write the range `{least:g} .. {most:g}`")


def _handed(ctx: Context) -> set[str]:
    """The words that arguments of the file hand to templates."""
    values = (node.value for node in walk(ctx.module.tree.declarations) if isinstance(node, ast.Argument))
    return {name.name for value in values for name in walk(value) if isinstance(name, ast.NameExpr)}


def check_default(
    ck: Checker, ctx: Context, default: ast.Expr, kind: Type, what: str, beside: Iterable[ast.Expr] = ()
) -> bool:
    """Whether a default fits the type; a value of a choice is a bare word."""
    if isinstance(kind, ChoiceType) and isinstance(default, ast.NameExpr):
        if default.name not in kind.values:
            ck.error(
                "unknown-choice",
                default.span,
                f"`{default.name}` is not one of {', '.join(kind.values)}",
                hint=did_you_mean(default.name, kind.values) or instead(default, UNKNOWN, kind),
            )
        ck.mean(default, Word(default.name))
        return default.name in kind.values
    if isinstance(kind, ChoiceType):
        ck.error(
            "wrong-type",
            default.span,
            f"{what} must be one of the options {', '.join(kind.values)}, not an expression",
            hint="only an argument may depend on a condition: `Tray(shape = round if small else square)`",
        )
        return False
    place = ctx.but(holes=True) if isinstance(default, ast.VectorExpr) else ctx
    return fits(ck.expect(place, default, kind, what, beside), kind)


def _how_to_order(low: ast.Expr, high: ast.Expr) -> str:
    """What to write for a low end above the high one: mostly it is the unit of one that is wrong, where units differ."""
    if isinstance(low, ast.NumberExpr) and isinstance(high, ast.NumberExpr) and low.value < high.value:
        meant = [f"`{low.value:g}{unit} .. {high.value:g}{unit}`" for unit in (low.unit, high.unit)]
        return f"is one of the units wrong? Write {' or '.join(meant)}; else swap the ends"
    return "swap the ends"


def check_range(
    ck: Checker, ctx: Context, interval: ast.RangeExpr, kind: Type, what: str, lone: str | None = None
) -> None:
    """Both ends fit the type, and the low one is not above the high one; of the name ``lone``, which is drawn, it is below."""
    wanted = RATIO if kind == COUNT and not isinstance(interval.low, ast.NumberExpr) else kind
    fitting = True
    for end in (interval.low, interval.high):
        whole = wanted if not isinstance(end, ast.NumberExpr) else kind
        fitting &= fits(ck.expect(ctx, end, whole, what, (interval.low, interval.high)), whole)
    if not fitting:
        return
    lows, highs = components(interval.low, ctx.module), components(interval.high, ctx.module)
    if len(lows) == len(highs):
        for low, high in zip(lows, highs, strict=True):
            if low is not None and high is not None and low > high * (1 + TOLERANCE * (1 if high > 0 else -1)):
                ck.error(
                    "empty-range",
                    interval.span,
                    "the range is empty: its low end lies above its high end",
                    hint=_how_to_order(interval.low, interval.high)
                    if len(lows) == 1
                    else "swap the components of the two ends where the low one is larger",
                )
                return
        if lone is not None and None not in lows and lows == highs:
            ck.warning(
                "empty-range",
                interval.span,
                f"both ends of the range of `{lone}` are the same: it always has this value",
                hint="widen the range; for one fixed value, use `let`, or a default without a range",
            )


def _inside(ck: Checker, ctx: Context, value: ast.Expr, domain: ast.RangeExpr | None, what: str) -> None:
    """A constant default lies in the constant domain."""
    if domain is not None and outside(value, domain, ctx.module):
        message, notes = f"{what} lies outside its range {domain.span.text}", ((domain.span, "the range"),)
        ck.error(
            "default-outside-range",
            value.span,
            message,
            notes=notes,
            hint="choose a value in the range, or widen the range",
        )


def outside(
    value: ast.Expr, domain: ast.RangeExpr, module: ModuleScope, declared_in: ModuleScope | None = None
) -> bool:
    """Whether a value lies outside a range, as far as both are constant. The range may be declared in another module."""
    values, home = components(value, module), declared_in or module
    ends = components(domain.low, home), components(domain.high, home)
    if not len(values) == len(ends[0]) == len(ends[1]):
        return False
    for value_of, low, high in zip(values, *ends, strict=True):
        if value_of is None or (low is not None and high is not None and low > high):
            continue
        slack = TOLERANCE * max(abs(value_of), abs(low or 0), abs(high or 0))
        if (low is not None and value_of < low - slack) or (high is not None and value_of > high + slack):
            return True
    return False


def _distribution(ck: Checker, ctx: Context, node: ast.Distribution, kind: Type, domain: ast.RangeExpr | None) -> None:
    law = DISTRIBUTIONS.get(node.name)
    if law is None:
        ck.error(
            "unknown-distribution",
            node.span,
            f"there is no distribution `{node.name}`",
            hint=did_you_mean(node.name, DISTRIBUTIONS) or "there are " + ", ".join(DISTRIBUTIONS),
        )
        return
    for argument in node.arguments:
        if argument.name is not None:
            ck.error(
                "wrong-arguments",
                argument.span,
                "arguments of a distribution are given without names",
                hint=f"write `{node.name}(...)` with the values in order",
            )
    if isinstance(kind, ChoiceType):
        _options(ck, ctx, node, kind)
        return
    if len(node.arguments) not in law.arguments:
        ck.error(
            "wrong-arguments",
            node.span,
            f"`{node.name}` takes {law.example}, {given(len(node.arguments))}",
            hint=f"as in `~ {law.call}`",
        )
        return
    fitting, ends = True, () if domain is None else (domain.low, domain.high)
    for position, argument in enumerate(node.arguments):
        relative = node.name == "lognormal" and position == 1
        wanted = RATIO if relative or kind == COUNT and node.name != "values" else kind
        fits_here = fits(ck.expect(ctx, argument.value, wanted, f"an argument of `{node.name}`", ends), wanted)
        fitting &= fits_here
        value = constant(argument.value, ctx.module)
        if position == 1 and position in law.positive and value is not None and value <= 0:
            ck.error(
                "wrong-arguments",
                argument.span,
                "a deviation must be greater than 0",
                hint="write a deviation above 0; for one fixed value, use `let` or a default without a distribution",
            )
        if node.name == "values" and fits_here:
            _inside(ck, ctx, argument.value, domain, "a value of the distribution")
    if fitting:
        _reaches(ck, ctx, node, domain)


def _reaches(ck: Checker, ctx: Context, node: ast.Distribution, domain: ast.RangeExpr | None) -> None:
    """A law and a range that are written out have something in common."""
    arguments = [constant(a.value, ctx.module) for a in node.arguments]
    if domain is None or node.name == "values" or len(arguments) != 2 or None in arguments:
        return
    first, second = cast("list[float]", arguments)
    least, most = first, second
    if node.name != "uniform" and second <= 0 or node.name == "lognormal" and first <= 0:
        return  # no law at all
    if node.name == "normal":
        least, most = first - _TAIL * second, first + _TAIL * second
    elif node.name == "lognormal":
        least, most = first * math.exp(-_TAIL * second), first * math.exp(_TAIL * second)
    elif first > second:
        said = "the low end of the distribution lies above its high end"
        ck.error("empty-range", node.span, said, hint="swap the ends")
        return
    low, high = constant(domain.low, ctx.module), constant(domain.high, ctx.module)
    if low is not None and high is not None and (least > high or most < low):
        said = f"nothing of `{node.span.text}` lies in the range {domain.span.text}"
        ck.error(
            "empty-range",
            node.span,
            said,
            notes=((domain.span, "the range"),),
            hint="move the distribution into the range, or widen the range",
        )


def _options(ck: Checker, ctx: Context, node: ast.Distribution, kind: ChoiceType) -> None:
    """What weighs the words of a choice: ``values(round, round, oval)``."""
    if node.name != "values":
        hint = f"write `~ values({kind.values[0]}, {kind.values[0]}, {kind.values[-1]})`: an option listed twice is twice as likely"
        ck.error(
            "unknown-distribution", node.span, f"a choice is weighted with `values`, not with `{node.name}`", hint=hint
        )
        return
    if not node.arguments:
        ck.error(
            "wrong-arguments",
            node.span,
            f"`values` takes {DISTRIBUTIONS['values'].example}, {given(0)}",
            hint=f"write `values({kind.values[0]}, {kind.values[-1]})`",
        )
    for argument in node.arguments:
        if isinstance(argument.value, ast.NameExpr):
            check_default(ck, ctx, argument.value, kind, "a value of the distribution")
        else:
            ck.error(
                "wrong-type",
                argument.span,
                f"a value of this choice must be one of {', '.join(kind.values)}",
                hint="an option listed twice is twice as likely",
            )
