"""Arrays of ports, ``port end[k] = ...``: evaluated when one of them is first asked for."""

from __future__ import annotations

from dataclasses import field
from typing import NamedTuple

from ...graph import expr as E
from ...records import dataclass
from ...semantics.meanings import Local
from ...syntax import ast
from ..values.kinds import Ports, Value
from .env import Env
from .evaluate import Evaluator
from .members import At, fetch

_MOST_PORTS = 8  # of a port array bound in a repeat


class Binding(NamedTuple):
    """``port end[at] = value`` as it stands in a body."""

    home: Env
    at: ast.Expr
    value: ast.Expr


@dataclass(slots=True, eq=False)
class PortArray(Ports):
    """Ports of a body that are evaluated when they are first asked for."""

    pending: list[Binding] = field(default_factory=list)  # still to be evaluated
    size: int = 0  # how many there are, where the declaration says

    def settled(self) -> dict[int, Value]:
        """Evaluate the bindings: one per constant index, all of a repeat by its index, or all by an index of their own."""
        pending, self.pending = self.pending, []
        for home, index, port in pending:
            meaning = home.context.meaning(index)
            if isinstance(meaning, Local):
                for k in range(self.size):
                    self.values[k] = Evaluator(home, {meaning.name: E.const(float(k))}).value(port)
                continue
            value = Evaluator(home).value(port)
            number = Evaluator(home).scalar(index)
            if number.constant is not None:
                self.values[int(number.constant)] = value
                continue
            element = home.element
            if element is None or home.outer is None:
                raise home.context.internal(index.span, "this is not the index of a repeat")
            outer = Evaluator(home.outer)
            for k in range(self.size or _MOST_PORTS):
                self.values[k] = fetch(outer, At(element, E.const(float(k)), element), value)
        return self.values
