"""What a value depends on: the columns behind expressions, and the draws among them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from .expr import Column, Expr, Scope
from .linear import follow
from .program import Program

SIDEWAYS = frozenset({"reduce", "element", "previous", "scan"})


def nodes_behind(program: Program, roots: Iterable[Expr], *, counted: bool = False) -> Iterator[Expr]:
    """All expressions that some depend on, through definitions, each once; with ``counted`` also those that count the rows they are
    taken in."""
    stack, seen = list(roots), set()
    while stack:
        node = stack.pop()
        if node in seen:
            continue
        seen.add(node)
        yield node
        stack.extend(node.args)
        if node.op == "col" and node.value in program.definitions:
            stack.append(program.definitions[node.value])
        if counted:
            stack.extend(a.count for s in _tables(node) for a in s.ancestors() if a.count is not None)


def _columns_behind(program: Program, roots: Iterable[Expr]) -> set[Column]:
    return {node.value for node in nodes_behind(program, roots, counted=True) if node.op == "col"}


def _tables(node: Expr) -> list[Scope]:
    """The tables whose rows a node is taken in, or reads."""
    scopes = [node.scope] if node.scope is not None else []
    if node.op == "reduce":
        scopes.append(node.value[1])
    elif node.op == "phi":
        scopes.extend(node.value)
    elif node.op != "col" and isinstance(node.value, Scope):
        scopes.append(node.value)
    return scopes


class Last:
    """Which of some columns in an ``order`` comes last among those an expression depends on, through definitions; with ``counted``
    also those that count the rows it is taken in. Each node is looked at once.
    """

    def __init__(self, order: Mapping[Column, int], definitions: Mapping[Column, Expr], *, counted: bool = False):
        self.order, self.definitions, self.counted = order, definitions, counted
        self._nodes: dict[Expr, int] = {}
        self._scopes: dict[Scope, int] = {}
        self._running: dict[Column, None] = {}  # definitions that are being followed, outermost first

    def of(self, node: Expr) -> int:
        """The place of the last column in the order; -1 without any. Raises Circle."""
        found = self._nodes.get(node)
        if found is None:
            if node.op == "col":
                found = self.order.get(node.value, -1)
                if node.value in self.definitions:
                    found = max(found, self._of_definition(node.value))
            else:
                found = max(map(self.of, node.args), default=-1)
            if self.counted:
                found = max(found, *map(self._of_table, _tables(node)), -1)
            self._nodes[node] = found
        return found

    def _of_definition(self, column: Column) -> int:
        follow(column, self._running)
        found = self.of(self.definitions[column])
        del self._running[column]
        return found

    def _of_table(self, scope: Scope) -> int:
        found = self._scopes.get(scope)
        if found is None:
            counts = [s.count for s in scope.ancestors() if s.count is not None]
            found = self._scopes[scope] = max(map(self.of, counts), default=-1)
        return found


def draws_behind(program: Program, roots: Iterable[Expr]) -> list[int]:
    """The indices of the draws that expressions depend on, in the order in which they are drawn."""
    found = _columns_behind(program, roots)
    return [number for number, draw in enumerate(program.draws) if draw.column in found]


def reads_across(program: Program, roots: Iterable[Expr]) -> bool:
    """Whether expressions read other rows of a table than the one they stand in and those above it."""
    return any(node.op in SIDEWAYS for node in nodes_behind(program, roots))
