"""Declared parameters to draws and unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from ...graph import expr as E
from ...graph.defined import Sharp
from ...graph.expr import Column, Expr
from ...graph.program import Draw
from ...source import Span
from ...syntax import ast
from ...units import SI_UNITS
from ..expressions.context import Draft, Unknown, where
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.kinds import Choice, Value, Vec

if TYPE_CHECKING:
    from .part import Component

SMALL = 1e-9
Drawn: TypeAlias = ast.ParamDecl | ast.CountDecl | ast.PartDecl | ast.StyleDecl


def address(env: Env, path: str, was: str | None) -> str:
    """The name under which a variable is drawn: its path and the alternatives above it, or its old name."""
    if was is not None:
        path = ".".join([*path.split(".")[:-1], was])
    alternatives = [s.name for s in env.scope.ancestors() if s.kind == "guard"]
    return "/".join([*reversed(alternatives), path])


def _new_draw(env: Env, declaration: Drawn, path: str, column: Column, span: Span, **more: Any) -> Draw:
    """What is drawn for a declaration, under its address."""
    at = address(env, path, declaration.was)
    return Draw(column, at, column.kind, where=where(span), doc=declaration.doc, **more)


def component_of(env: Env, node: ast.Expr, component: int | None) -> Expr:
    value = Evaluator(env).value(node)
    if component is not None and isinstance(value, Vec):
        return value.items[component]
    return Evaluator(env).number(value, node.span)


def draw_scalar(env: Env, declaration: ast.ParamDecl | ast.CountDecl, path: str, component: int | None = None) -> Expr:
    """A fresh drawn column in the environment's table."""
    draw = make_draw(env, declaration, path, component)
    env.context.draws.append(draw)
    return E.col(draw.column)


def read_by(env: Env, declaration: ast.ParamDecl | ast.CountDecl, component: int | None) -> tuple[Expr, ...]:
    """The values that a draw follows from: the ends of its range, its default, what its distribution and its variation take."""
    domain, vary = declaration.domain, declaration.vary if isinstance(declaration, ast.ParamDecl) else None
    assert domain is not None
    arguments = () if declaration.distribution is None else (a.value for a in declaration.distribution.arguments)
    said = [domain.low, domain.high, *(end for end in (declaration.default,) if end is not None), *arguments]
    found = tuple(component_of(env, node, component) for node in said)
    return found if vary is None else (*found, component_of(env, vary, None))


def make_draw(env: Env, declaration: ast.ParamDecl | ast.CountDecl, path: str, component: int | None) -> Draw:
    counted = isinstance(declaration, ast.CountDecl) or declaration.type.name == "count"
    column = env.context.column(env.scope, path, "count" if counted else "real", declaration.span)
    domain = declaration.domain
    assert domain is not None
    low, high = component_of(env, domain.low, component), component_of(env, domain.high, component)
    if low.constant is not None and high.constant is not None and low.constant > high.constant:
        raise env.context.error(
            "empty-range",
            domain.span,
            "the range is empty: its low end lies above its high end",
            hint="exchange the ends, or correct what they are computed from",
        )
    said = env.context.values[column] = {("range", 0): domain.low.span, ("range", 1): domain.high.span}
    unit = SI_UNITS.get(declaration.type.name, "") if isinstance(declaration, ast.ParamDecl) else ""
    draw = _new_draw(env, declaration, path, column, declaration.span, low=low, high=high, unit=unit)
    if declaration.default is not None:
        draw.default = component_of(env, declaration.default, component)
        first, value, last = low.constant, draw.default.constant, high.constant
        outside = (
            first is not None and value is not None and last is not None and not first - SMALL <= value <= last + SMALL
        )
        if outside:
            raise env.context.error(
                "default-outside-range",
                declaration.default.span,
                f"the default of `{path}` lies outside its range",
                notes=((domain.span, "the range"),),
                hint="choose a default in the range, or widen the range",
            )
    if declaration.distribution is not None:
        draw.distribution = declaration.distribution.name
        given = [argument.value for argument in declaration.distribution.arguments]
        draw.arguments = tuple(component_of(env, node, component) for node in given)
        said |= {("argument", number): node.span for number, node in enumerate(given)}
    vary = declaration.vary if isinstance(declaration, ast.ParamDecl) else None
    if vary is not None:
        relative = isinstance(vary, ast.NumberExpr) and vary.unit == "%"
        draw.vary = (relative, component_of(env, vary, None))
        said["vary", 0] = vary.span
    return draw


def draw_choice(
    env: Env,
    path: str,
    names: tuple[str, ...],
    alternatives: Sequence[tuple[ast.Alternative, ...]],
    span: Span,
    declaration: ast.PartDecl | ast.StyleDecl,
) -> Choice:
    """A drawn choice among options of which each has one alternative or several, whose weights add up.

    A false ``when`` is weight 0. ``names`` may repeat, of templates with different arguments; what is drawn is told apart as
    ``BarHandle`` and ``BarHandle#2`` then.
    """
    weights = [E.total(_weight_of(env, alternative) for alternative in same) for same in alternatives]
    column = env.context.column(env.scope, path, "choice", span)
    made = _new_draw(env, declaration, path, column, span, options=_told_apart(names), weights=tuple(weights))
    env.context.draws.append(made)
    alone = {number: same[0].weight for number, same in enumerate(alternatives) if len(same) == 1}
    env.context.values[column] = {("weight", n): weight.span for n, weight in alone.items() if weight is not None}
    return Choice(E.col(column), names)


def _weight_of(env: Env, alternative: ast.Alternative) -> Expr:
    ev = Evaluator(env)
    weight = E.ONE if alternative.weight is None else ev.scalar(alternative.weight)
    if alternative.guard is None:
        return weight
    known = ev.condition(alternative.guard)
    env.context.guarded.append((known, alternative))
    return E.where(known, weight, E.ZERO)


def warn_never_drawn(context: Draft, own: object) -> None:
    """Report the alternatives in the file ``own`` of which the ``when`` never holds, wherever it is asked."""
    intervals = Sharp(context.program.draws, context.program.definitions)
    asked: dict[int, tuple[ast.Alternative, list[Expr]]] = {}
    for known, alternative in context.guarded:
        asked.setdefault(id(alternative), (alternative, []))[1].append(known)
    for alternative, conditions in asked.values():
        guard = alternative.guard
        if guard is None or guard.span.source is not own or any(intervals.of(known)[1] > 0.0 for known in conditions):
            continue
        context.report.warning(
            "excluded-value",
            guard.span,
            f"`{guard.span.words}` never holds: the alternative {alternative.name or 'none'} is never drawn",
            hint="correct the condition, widen the ranges of what it compares, or leave the alternative out",
        )


def _told_apart(names: Sequence[str]) -> tuple[str, ...]:
    """Names with a number behind those that stand further up, too: a, b, a#2."""
    seen: dict[str, int] = {}
    found = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        found.append(name if seen[name] == 1 else f"{name}#{seen[name]}")
    return tuple(found)


def draw_option(env: Env, declaration: ast.ParamDecl, path: str) -> Choice:
    """``param place : choice side | bail = side ~ values(side, side, bail)``."""
    options = declaration.type.values
    weights = tuple(E.ONE for _ in options)
    if declaration.distribution is not None:
        named = [a.value.name for a in declaration.distribution.arguments if isinstance(a.value, ast.NameExpr)]
        weights = tuple(E.const(float(named.count(option))) for option in options)
    column = env.context.column(env.scope, path, "choice", declaration.span)
    usual = declaration.default
    default = (
        E.const(float(options.index(usual.name))) if isinstance(usual, ast.NameExpr) and usual.name in options else None
    )
    span = declaration.span
    made = _new_draw(env, declaration, path, column, span, default=default, options=options, weights=weights)
    env.context.draws.append(made)
    return Choice(E.col(column), options)


def open_parameter(
    part: Component, local: Env, declaration: ast.ParamDecl, name: str, argument: ast.Argument | None
) -> Value:
    """Columns for a parameter that no argument gives: unknowns that equations may determine."""
    kind = declaration.type
    if kind.values:
        return draw_option(local, declaration, f"{part.path}.{name}")
    if kind.style:
        raise part.context.error(
            "wrong-arguments",
            part.span,
            f"the style `{name}` must be given as an argument",
            hint=f"write `{name} = ` and a style, or a template with the role `{kind.name}`",
        )
    if kind.name == "count" and declaration.domain is not None:
        return draw_scalar(local, declaration, f"{part.path}.{name}")
    if kind.name == "curve":
        hint = f"give it a path, `{name} = way`, made by `curve way = from(point, direction) line(length)`"
        raise part.context.error("missing-argument", part.span, f"`{part.name}` needs `{name}`", hint=hint)
    if kind.size is None:
        return _open_scalar(part, local, declaration, name, None)
    stated: tuple[ast.Expr | None, ...] = (None,) * kind.size
    if argument is not None and isinstance(argument.value, ast.VectorExpr):
        stated = argument.value.items
    items = []
    for k, item in enumerate(stated):
        if item is not None and not isinstance(item, ast.HoleExpr):
            items.append(Evaluator(part.env).scalar(item))
        else:
            items.append(_open_scalar(part, local, declaration, f"{name}.{'xyz'[k]}", k))
    return Vec(tuple(items))


def _open_scalar(part: Component, local: Env, declaration: ast.ParamDecl, name: str, component: int | None) -> Expr:
    path = f"{part.path}.{name}"
    shown = f"`{part.name}.{name}`"
    if declaration.domain is not None:
        draw = make_draw(local, declaration, path, component)
        unknown = Unknown(draw.column, "param", part.span, shown, part, draw=draw)
        shared = None if part.style is None else part.style.shared(None, name, declaration, component, local)
        if shared is not None:
            unknown.default, unknown.kind = shared, "default"
        else:
            part.context.draws.append(draw)
    else:
        kind = "bool" if declaration.type.name == "bool" else "real"
        column: Column = part.context.column(local.scope, path, kind, part.span)
        unknown = Unknown(column, "size", part.span, shown, part, positive=declaration.positive)
        if declaration.default is not None:
            unknown.kind = "default"
            unknown.default = component_of(local, declaration.default, component)
    part.env.unknowns.append(unknown)
    return E.col(unknown.column)
