"""What a role, a template or a primitive takes: its parameters, and their values where nobody hands any in."""

from __future__ import annotations

from ...graph import expr as E
from ...semantics.symbols import Symbol, lineage
from ...syntax import ast
from ...syntax.walk import in_branches
from ..expressions.context import Unknown
from ..expressions.env import Env
from ..values.kinds import Value, Vec
from .draws import component_of, draw_option, draw_scalar, make_draw
from .looks import look_of
from .style import Style


def parameters_of(symbol: Symbol) -> list[tuple[Symbol, ast.ParamDecl, str]]:
    """The interface of a role, template or primitive: (declaring symbol, declaration, name), outermost role first."""
    found: dict[str, tuple[Symbol, ast.ParamDecl, str]] = {}
    for owner in reversed(lineage(symbol)):
        for statement in owner.body:
            if isinstance(statement, ast.ParamDecl):
                for name in statement.names:
                    found[name] = (owner, statement, name)
    return list(found.values())


def within(symbol: Symbol) -> dict[str, ast.ParamDecl | ast.CountDecl]:
    """What the body of a template draws itself unless it is handed in: its counts, and the parameters under a ``when``."""
    found: dict[str, ast.ParamDecl | ast.CountDecl] = {}
    for statement in in_branches(symbol.body):
        if isinstance(statement, ast.CountDecl):
            found.setdefault(statement.name, statement)
        elif isinstance(statement, ast.ParamDecl) and not any(statement is own for own in symbol.body):
            found.update((name, statement) for name in statement.names if name not in found)
    return found


def own_parameter(
    env: Env, declaration: ast.ParamDecl, name: str, style: Style | None = None, option: int = 0
) -> Value:
    """A parameter of the body itself: drawn, derived, or its default."""
    path = env.path + name
    kind = declaration.type
    if kind.values:
        return (
            draw_option(env, declaration, path)
            if style is None
            else style.shared_option(option, name, declaration, env)
        )
    if kind.name == "material" and declaration.default is not None:
        return look_of(env, declaration.default)
    if kind.size is None:
        return _own_scalar(env, declaration, name, None, style, option)
    items = (_own_scalar(env, declaration, f"{name}.{'xyz'[k]}", k, style, option) for k in range(kind.size))
    return Vec(tuple(items))


def _own_scalar(
    env: Env, declaration: ast.ParamDecl, name: str, component: int | None, style: Style | None, option: int
) -> E.Expr:
    path = env.path + name
    if declaration.derived:
        column = env.context.column(env.scope, path, "real", declaration.span)
        unknown = Unknown(column, "derived", declaration.span, f"`{name}`")
        if declaration.domain is not None:
            unknown.draw = make_draw(env, declaration, path, component)
            unknown.draw.column = column
        env.unknowns.append(unknown)
        return E.col(column)
    if declaration.domain is not None:
        shared = None if style is None else style.shared(option, name, declaration, component, env)
        return shared if shared is not None else draw_scalar(env, declaration, path, component)
    if declaration.default is not None:
        return component_of(env, declaration.default, component)
    column = env.context.column(env.scope, path, "real", declaration.span)
    env.unknowns.append(Unknown(column, "size", declaration.span, f"`{name}`", positive=declaration.positive))
    return E.col(column)
