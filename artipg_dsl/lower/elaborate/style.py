"""Styles: a choice and its parameters drawn once, used by many parts."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import field
from typing import TypeAlias

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...records import dataclass
from ...semantics.symbols import Symbol, is_a
from ...source import Span
from ...syntax import ast
from ..expressions.context import Present
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..solve.cases import covered
from ..values.kinds import Alternatives, Choice
from .draws import draw_choice, draw_option, draw_scalar, read_by

Key: TypeAlias = tuple[int | None, str]
"""A parameter: the number of the alternative that has it, None of the role, and its name."""


@dataclass(slots=True, eq=False)
class Style(Alternatives):
    """``style pull : Handle = A | B | none``: the choice, and per alternative the parameters drawn so far."""

    env: Env
    declaration: ast.StyleDecl
    role: Symbol | None
    choice: Choice
    alternatives: tuple[ast.Alternative, ...]
    templates: dict[str, Symbol]  # by the names of the alternatives
    drawn: dict[Key, Expr] = field(default_factory=dict)
    read: dict[Key, tuple[Expr, ...]] = field(default_factory=dict)  # by the draws

    def matches(self, symbol: Symbol) -> Expr:
        """The predicate of ``style is Name``."""
        return E.any_of(self.choice.chosen(option) for option, t in self.templates.items() if is_a(t, symbol))

    def scope(self, option: int) -> Scope:
        """The table of an alternative, by its number: one template may stand there several times."""
        options = self.choice.options
        guard = E.TRUE if len(options) == 1 else E.call("eq", self.choice.code, E.const(float(option)))
        path = self.declaration.name
        return self.env.context.guard(
            self.env.scope, guard, f"{path}={options[option]}", Present(path, options[option])
        )

    def shared(
        self,
        option: int | None,
        name: str,
        declaration: ast.ParamDecl | ast.CountDecl,
        component: int | None,
        local: Env,
    ) -> Expr | None:
        """The style's own draw of a parameter: of the role (``option`` None) or of one alternative. None where its range (or default, or
        distribution) follows from what each part has of its own, or is not that of the parts before: then it is each part's own."""
        home, path = self._home(option, local)
        read, key = read_by(local, declaration, component), (option, name)
        if not home.scope.within(E.deepest(read)) or self.read.setdefault(key, read) != read:
            return None
        return self._once(key, home, lambda: draw_scalar(home, declaration, path + name, component))

    def shared_option(self, option: int, name: str, declaration: ast.ParamDecl, local: Env) -> Choice:
        """The style's own draw of a parameter that is one of some words, of one alternative."""
        home, path = self._home(option, local)
        code = self._once((option, name), home, lambda: draw_option(home, declaration, path + name).code)
        return Choice(code, declaration.type.values)

    def _home(self, option: int | None, local: Env) -> tuple[Env, str]:
        """Where the parameters of the role or an alternative are drawn, and what their paths begin with."""
        scope = self.env.scope if option is None else self.scope(option)
        path = f"{self.env.path}{self.declaration.name}."
        return Env(local.context, local.module, local.symbol, scope, path, names=dict(local.names)), path

    def _once(self, key: Key, home: Env, draw: Callable[[], Expr]) -> Expr:
        """What is drawn at the first question, in the table of the alternative."""
        if key not in self.drawn:
            value = draw()
            shared = home.scope is self.env.scope
            self.drawn[key] = value if shared else E.phi(self.env.scope, [(home.scope, value)])
        return self.drawn[key]


def build_style(env: Env, declaration: ast.StyleDecl) -> Style:
    alternatives = complete_choice(env, declaration.alternatives)
    names = tuple(a.name or "none" for a in alternatives)
    path = env.path + declaration.name
    if len(names) == 1:
        choice = Choice(E.ZERO, names)
    else:
        choice = draw_choice(env, path, names, [(a,) for a in alternatives], declaration.name_span, declaration)
    return Style(
        env, declaration, env.context.symbol(declaration), choice, alternatives, templates_of(env, alternatives)
    )


def templates_of(env: Env, alternatives: tuple[ast.Alternative, ...]) -> dict[str, Symbol]:
    """The template or primitive of each alternative, by its name."""
    found = ((a.name, env.context.symbol(a)) for a in alternatives)
    return {name: symbol for name, symbol in found if name is not None and symbol is not None}


def complete_choice(env: Env, alternatives: tuple[ast.Alternative, ...]) -> tuple[ast.Alternative, ...]:
    """The alternatives, and `none` where all of them carry a guard and none of the guards need hold."""
    guards = [a.guard for a in alternatives if a.guard is not None]
    if len(guards) < len(alternatives):
        return alternatives
    ev = Evaluator(env)
    if covered([ev.condition(guard) for guard in guards], env.context.draws):
        return alternatives
    span = alternatives[-1].span
    some = functools.reduce(lambda a, b: ast.BinaryExpr(span=span, op="or", left=a, right=b), guards)
    rest = ast.UnaryExpr(span=span, op="not", operand=some)
    return (*alternatives, ast.Alternative(span=span, name=None, name_span=span, guard=rest))


def sole_style(env: Env, name: str, role: Symbol | None, template: Symbol, span: Span) -> Style:
    """The style that a template's name stands for where a style is handed in: one alternative, its parameters drawn once."""
    alternative = ast.Alternative(span=span, name=template.name, name_span=span)
    declaration = ast.StyleDecl(
        span=span,
        name=name,
        name_span=span,
        role=template.name if role is None else role.name,
        role_span=span,
        alternatives=(alternative,),
    )
    return Style(env, declaration, role, Choice(E.ZERO, (template.name,)), (alternative,), {template.name: template})
