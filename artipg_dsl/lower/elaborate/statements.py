"""Statements that wait until all parts are made: a pass names the kinds that it is about, and what each of them means."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from ...syntax import ast
from ..expressions.env import Env

if TYPE_CHECKING:
    from .links import Links

Meanings: TypeAlias = "Mapping[type[ast.Stmt], Callable[[Links, Env, Any], None]]"


def carry_out(links: Links, env: Env, meanings: Meanings) -> None:
    """The statements of some kinds in an environment and all inside it, the innermost first."""
    for home in _deepest_first(env):
        for statement in home.statements:
            attempt(links, home, statement, meanings)


def attempt(links: Links, env: Env, statement: ast.Stmt, meanings: Meanings) -> None:
    """One statement, if it is of one of the kinds; after an error the next ones are still looked at."""
    if (meaning := meanings.get(type(statement))) is not None:
        with env.context.attempt(statement.span):
            meaning(links, env, statement)


def _deepest_first(env: Env) -> Iterator[Env]:
    """The bodies of the parts of an environment, its repeats and branches, then the environment itself."""
    for part in env.parts:
        for body in part.bodies:
            yield from _deepest_first(body)
    for inner in env.inner:
        yield from _deepest_first(inner)
    yield env
