"""Arrays of ports, ``port end[k] = ...``: evaluated when one of them is first asked for."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ...graph import expr as E
from ...semantics.meanings import Local
from ..values.kinds import Ports, Value
from .evaluate import Evaluator
from .members import At, fetch

MOST_PORTS = 8  # of a port array bound in a repeat


@dataclass(slots=True, eq=False)
class PortArray(Ports):
    """Ports of a body that are evaluated when they are first asked for."""

    pending: list[Any] = field(default_factory=list)  # (environment, declaration) still to be evaluated
    size: int = 0  # how many there are, where the declaration says

    def settled(self) -> dict[int, Value]:
        """Evaluate the bindings: one per constant index, all of a repeat by its index, or all by an index of their own."""
        pending, self.pending = self.pending, []
        for home, declaration in pending:
            index = home.context.meaning(declaration.index)
            if isinstance(index, Local):
                for k in range(self.size):
                    self.values[k] = Evaluator(home, {index.name: E.const(float(k))}).value(declaration.value)
                continue
            value = Evaluator(home).value(declaration.value)
            index = Evaluator(home).scalar(declaration.index)
            if index.constant is not None:
                self.values[int(index.constant)] = value
                continue
            element = home.element
            outer = Evaluator(home.outer)
            for k in range(self.size or MOST_PORTS):
                self.values[k] = fetch(outer, At(element, E.const(float(k)), element), value)
        return self.values
