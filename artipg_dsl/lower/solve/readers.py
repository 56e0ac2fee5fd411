"""What is asked again and again while requirements become ranges, each answered once for a node."""

from __future__ import annotations

import math
from collections.abc import Iterable

from ...graph.depend import Last
from ...graph.expr import Column, Expr, Scope
from ...graph.inequality import Ends
from ...graph.interval import Intervals
from ...graph.linear import Linear
from ...graph.program import Program


class Readers:
    """The readers of a program's expressions, for as long as its definitions and the domains of its draws stand.

    Expressions of a program share most of their nodes, and its inequalities come back to them for every draw.
    """

    def __init__(self, program: Program):
        self.order = {draw.column: k for k, draw in enumerate(program.draws)}
        self.definitions = program.definitions
        self.intervals = Intervals(program.draws, program.definitions)
        self.drawn = Linear(lambda c: c in self.order, program.definitions, through=True)
        self._ends: dict[Column, Ends] = {}
        self._columns = list(self.order)
        self._named = Last(self.order, program.definitions)
        self._needed = Last(self.order, program.definitions, counted=True)
        self._open: dict[Expr, bool] = {}

    def ends(self, column: Column) -> Ends:
        """The reader of one column, alone."""
        found = self._ends.get(column)
        if found is None:
            found = self._ends[column] = Ends(column, self.intervals, self.definitions)
        return found

    def last(self, scope: Scope, *nodes: Expr) -> Column | None:
        """Of all draws that expressions name, the guards that their table stands under included, the last one."""
        guards = [s.count for s in scope.ancestors() if s.kind == "guard" and s.count is not None]
        number = max(self._named.of(node) for node in (*nodes, *guards))
        return None if number < 0 else self._columns[number]

    def late(self, column: Column, roots: Iterable[Expr]) -> bool:
        """Whether expressions need the column itself or what is drawn after it, be it to count the rows they stand in."""
        return any(self._needed.of(root) >= self.order[column] for root in roots)

    def open_ended(self, node: Expr) -> bool:
        """Whether an expression says "no bound" in some rows: it comes from bounds of other alternatives."""
        found = self._open.get(node)
        if found is None:
            infinite = node.op == "const" and math.isinf(node.value)
            found = self._open[node] = infinite or any(map(self.open_ended, node.args))
        return found
