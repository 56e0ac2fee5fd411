"""Arguments beside the ranges that templates declare: one that lies outside takes effect, and is told."""

from __future__ import annotations

from collections.abc import Mapping

from ...graph.defined import Sharp
from ...graph.expr import Expr
from ...records import dataclass
from ...semantics.meanings import Constant, Declared, Global
from ...semantics.symbols import Symbol
from ...source import Span
from ...syntax import ast
from ...syntax.walk import walk
from ...units import SI_UNITS
from ..expressions.context import Draft
from ..expressions.env import Env
from ..solve.feasible import plain
from ..values.kinds import Value, Vec
from .draws import component_of

_NEAR = 1e-6  # of the numbers: rounding takes nothing out of a range


@dataclass(frozen=True, slots=True, eq=False)
class Handed:
    """An argument, ``span``, for the parameter ``name`` of ``owner``: its components, and the ``ends`` of the range of each, which is
    declared at ``declared``; without ends it is above 0."""

    span: Span
    owner: str
    name: str
    values: tuple[Expr, ...]
    ends: tuple[tuple[Expr, Expr], ...]
    declared: Span
    unit: str


def note(
    owner: Symbol,
    env: Env,
    given: Mapping[str, Value],
    declaration: ast.ParamDecl | ast.CountDecl,
    argument: ast.Argument,
    value: Value,
) -> None:
    """Keep an argument, stated in ``env``, for a parameter of ``owner`` that has a range, as far as what is ``given`` tells the ends.

    Those of the category's own file alone: what stands in a library is its affair.
    """
    domain, context = declaration.domain, env.context
    if argument.name is None or argument.span.source is not context.typed.main.source:
        return
    values: tuple[Expr, ...] = value.items if isinstance(value, Vec) else (value,) if isinstance(value, Expr) else ()
    if domain is None:
        if isinstance(declaration, ast.ParamDecl) and declaration.positive:
            context.handed.append(Handed(argument.span, owner.name, argument.name, values, (), declaration.span, ""))
        return
    if any(isinstance(node, ast.NameExpr) and not _known(context, given, node) for node in walk(domain)):
        return
    home = Env(context, owner.module, owner, env.scope, "", names=dict(given))
    components = range(len(values)) if isinstance(value, Vec) else (None,)
    ends = tuple((component_of(home, domain.low, k), component_of(home, domain.high, k)) for k in components)
    unit = SI_UNITS.get(declaration.type.name, "") if isinstance(declaration, ast.ParamDecl) else ""
    context.handed.append(Handed(argument.span, owner.name, argument.name, values, ends, domain.span, unit))


def _known(context: Draft, given: Mapping[str, Value], node: ast.NameExpr) -> bool:
    """Whether a name in a range has its value before the body of the template is lowered."""
    meaning = context.meaning(node)
    return node.name in given if isinstance(meaning, Declared) else isinstance(meaning, Global | Constant)


def warn(context: Draft) -> None:
    """Report arguments of which a component lies outside its range, whatever is drawn; and values whose own range reaches below 0,
    where they are handed to what is above 0: the rest of the range is never drawn."""
    intervals = Sharp(context.program.draws, context.program.definitions)
    told = {found.span for found in context.report.diagnostics if found.code == "argument-outside-range"}
    drawn = {draw.column: draw for draw in context.program.draws}
    for one in context.handed:
        for value in () if one.ends else one.values:
            draw = drawn.get(value.value) if value.op == "col" else None
            if draw is None or draw.low is None or draw.high is None or one.span in told:
                continue
            least, most = intervals.of(draw.low)[0], intervals.of(draw.high)[1]
            if least < 0.0 < most:
                told.add(one.span)
                context.report.warning(
                    "argument-outside-range",
                    one.span,
                    f"`{one.name}` of `{one.owner}` is above 0, and the range of `{draw.column.name}` begins at "
                    f"{plain(least, draw.unit)}: what lies below 0 is never drawn",
                    hint="is the sign right? Begin the range above 0",
                    notes=((context.spans[draw.column], "its range"),) if draw.column in context.spans else (),
                )
        for value, (low, high) in zip(one.values if one.ends else (), one.ends, strict=True):
            (least, most), first, last = intervals.of(value), intervals.of(low)[0], intervals.of(high)[1]
            near = _NEAR * max(abs(first), abs(last))
            if one.span in told or first - near <= most and least <= last + near:
                continue
            told.add(one.span)
            at = plain(least if least > last else most, one.unit)
            how = "" if least == most else "at least " if least > last else "at most "
            context.report.warning(
                "argument-outside-range",
                one.span,
                f"`{one.owner}` has `{one.name}` in {one.declared.text}, and this is {how}{at}",
                hint="is the unit right? If the value is meant, widen the range",
                notes=((one.declared, "declared here"),),
            )
