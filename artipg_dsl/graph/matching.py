"""Which unknowns a set of equations determines: a matching of lowest cost, found greedily.

The sets of unknowns that equations can determine form a transversal matroid, so taking the unknowns in order of
preference and keeping each that can still be matched gives the best set.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..records import dataclass


@dataclass(slots=True)
class Matching:
    """``equation_of[u]`` is the equation that determines unknown u (-1: none), ``unknown_of[e]`` the other way."""

    equation_of: list[int]
    unknown_of: list[int]
    edges: list[list[int]]  # per unknown, its equations

    @property
    def free_equations(self) -> list[int]:
        return [e for e, u in enumerate(self.unknown_of) if u < 0]

    def exchangeable(self, unknown: int) -> list[int]:
        """Unknowns that an unmatched one could replace, the others staying matched."""
        reached: set[int] = set()
        stack = [unknown]
        seen: set[int] = set()
        while stack:
            at = stack.pop()
            for equation in self.edges[at]:
                if equation in seen:
                    continue
                seen.add(equation)
                other = self.unknown_of[equation]
                if other >= 0 and other not in reached:
                    reached.add(other)
                    stack.append(other)
        return sorted(reached)


def match(edges: Sequence[Sequence[int]], equations: int, order: Sequence[int]) -> Matching:
    """``edges[u]`` lists the equations that unknown u stands in; ``order`` the unknowns, most preferred first."""
    result = Matching([-1] * len(edges), [-1] * equations, [list(e) for e in edges])

    def augment(unknown: int, seen: set[int]) -> bool:
        for equation in result.edges[unknown]:
            if equation in seen:
                continue
            seen.add(equation)
            holder = result.unknown_of[equation]
            if holder < 0 or augment(holder, seen):
                result.unknown_of[equation] = unknown
                result.equation_of[unknown] = equation
                return True
        return False

    for unknown in order:
        augment(unknown, set())
    return result


def components(order: Sequence[int], reads: Sequence[set[int]]) -> list[list[int]]:
    """Strongly connected components in the order of evaluation (Tarjan): ``reads[k]`` are the nodes that k needs."""
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    on_stack: set[int] = set()
    found: list[list[int]] = []

    def visit(node: int) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        on_stack.add(node)
        for other in sorted(reads[node]):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in on_stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            component = []
            while True:
                other = stack.pop()
                on_stack.discard(other)
                component.append(other)
                if other == node:
                    break
            found.append(sorted(component))

    for node in order:
        if node not in index:
            visit(node)
    return found
