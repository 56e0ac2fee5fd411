"""What a value depends on: the columns behind expressions, and the draws among them."""

from __future__ import annotations

from collections.abc import Iterable

from .expr import Column, Expr, Scope
from .program import Program

_SIDEWAYS = frozenset({"reduce", "element", "previous", "scan"})


def columns_behind(program: Program, roots: Iterable[Expr]) -> set[Column]:
    """All columns that expressions depend on, those included that count the rows they are taken in."""
    found: set[Column] = set()
    stack, seen = list(roots), set()
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        stack.extend(node.args)
        scopes = [node.scope] if node.scope is not None else []
        if node.op == "col":
            column: Column = node.value
            found.add(column)
            if column in program.definitions:
                stack.append(program.definitions[column])
        elif node.op == "reduce":
            scopes.append(node.value[1])
        elif node.op == "phi":
            scopes.extend(node.value)
        elif isinstance(node.value, Scope):
            scopes.append(node.value)
        stack.extend(a.count for s in scopes for a in s.ancestors() if a.count is not None)
    return found


def draws_behind(program: Program, roots: Iterable[Expr]) -> list[int]:
    """The indices of the draws that expressions depend on, in the order in which they are drawn."""
    found = columns_behind(program, roots)
    return [number for number, draw in enumerate(program.draws) if draw.column in found]


def reads_across(program: Program, roots: Iterable[Expr]) -> bool:
    """Whether expressions read other rows of a table than the one they stand in and those above it."""
    stack, seen = list(roots), set()
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        if node.op in _SIDEWAYS:
            return True
        stack.extend(node.args)
        if node.op == "col" and node.value in program.definitions:
            stack.append(program.definitions[node.value])
    return False
