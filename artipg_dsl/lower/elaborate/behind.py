"""Statements that stand behind a ``when`` and place what its branches declare: they are said in each of those branches."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from ...semantics.meanings import Declared
from ...syntax import ast
from ...syntax.walk import walk
from ..expressions.env import Env
from .place import begins

Body = tuple[ast.Stmt, ...]


def said_inside(env: Env, body: Body, more: Iterable[tuple[ast.Stmt, str]] = ()) -> Body:
    """A body in which every ``align``, ``connect`` and ``joint`` stands where the part that it places is declared; ``more``
    are those from around the body, with the part of a branch in it that each places."""
    if not any(isinstance(s, ast.WhenStmt) for s in body):
        return body
    moved = list(more)
    kept: list[ast.Stmt] = []
    for statement in body:
        if isinstance(statement, ast.WhenStmt):
            taken, rest = _under_another(env, body, statement)
            moved += taken
            kept.append(rest)
        elif (name := _placed_in_branch(env, body, statement)) is not None:
            moved.append((statement, name))
        else:
            kept.append(statement)
    return tuple(_taking(env, s, moved) if isinstance(s, ast.WhenStmt) else s for s in kept)


def _under_another(env: Env, body: Body, when: ast.WhenStmt) -> tuple[list[tuple[ast.Stmt, str]], ast.WhenStmt]:
    """The statements in a ``when`` that place what another one declares, under a copy of its guard, and what is left of it.

    Branches of one guard are one body, however often the text says it.
    """
    said = {
        name
        for s in body
        if isinstance(s, ast.WhenStmt) and s.guard.span.words == when.guard.span.words
        for name in _declared_parts((s,))
    }
    names = {
        id(s): name
        for s in (*when.body, *when.otherwise)
        if (name := _placed_in_branch(env, body, s)) is not None and name not in said
    }
    if not names:
        return [], when
    yes, no = (tuple(s for s in branch if id(s) not in names) for branch in (when.body, when.otherwise))
    taken: list[tuple[ast.Stmt, str]] = []
    for name in dict.fromkeys(names.values()):
        own, other = (tuple(s for s in branch if names.get(id(s)) == name) for branch in (when.body, when.otherwise))
        taken.append((replace(when, body=own, otherwise=other), name))
    return taken, replace(when, body=yes, otherwise=no)


def _taking(env: Env, when: ast.WhenStmt, moved: list[tuple[ast.Stmt, str]]) -> ast.WhenStmt:
    """A ``when`` with the statements of parts that its branches declare; itself where there are none."""
    branches = []
    for branch in (when.body, when.otherwise):
        here = [s for s, name in moved if name in parts(branch)]
        deeper = [(s, name) for s, name in moved if name not in parts(branch)]
        branches.append(said_inside(env, (*branch, *here), deeper))
    same = [[*map(id, new)] == [*map(id, old)] for new, old in zip(branches, (when.body, when.otherwise), strict=True)]
    if all(same):
        return when
    return replace(when, body=branches[0], otherwise=branches[1])


def _placed_in_branch(env: Env, body: Body, statement: ast.Stmt) -> str | None:
    """The name of what a statement places, if only branches of a ``when`` of this body declare it."""
    match statement:
        case ast.ConnectStmt() | ast.JointDecl():
            named = [begins(env, ast.placed(statement))]
        case ast.AlignStmt(left=left, right=right):
            named = [
                m
                for side in (left, right)
                for node in walk(side)
                if isinstance(m := env.context.meaning(node), Declared)
            ]
        case _:
            return None
    places = _declared_parts(body)
    names = [m.name for m in named if m is not None and m.depth == env.depth and m.name in places]
    if not names:
        return None
    last = max(names, key=lambda name: places[name])  # of two, the one that is declared later yields
    return None if last in parts(body) else last


def parts(body: Body) -> set[str]:
    """The parts that a body declares itself."""
    return {s.name for s in body if isinstance(s, ast.PartDecl)}


def _declared_parts(body: Iterable[ast.Stmt]) -> dict[str, int]:
    """The parts that a body and the branches in it declare, and where they are first declared."""
    found: dict[str, int] = {}
    for statement in body:
        if isinstance(statement, ast.PartDecl):
            found.setdefault(statement.name, statement.name_span.start)
        elif isinstance(statement, ast.WhenStmt):
            for name, place in _declared_parts((*statement.body, *statement.otherwise)).items():
                found.setdefault(name, place)
    return found
