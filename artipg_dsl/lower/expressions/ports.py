"""Arrays of ports, ``port end[k] = ...``: evaluated when one of them is first asked for."""

from __future__ import annotations

from dataclasses import field, replace
from typing import NamedTuple

from ...graph import expr as E
from ...records import dataclass
from ...semantics.meanings import Local
from ...semantics.symbols import lineage
from ...syntax import ast
from ..values.kinds import Ports, Value, Vec
from .env import Env
from .evaluate import Evaluator
from .members import At, fetch

_MOST_PORTS = 8  # of a port array bound in a repeat


class Binding(NamedTuple):
    """``port end[at] = value`` as it stands in a body."""

    home: Env
    at: ast.Expr
    statement: ast.PortDecl


def bound(env: Env, statement: ast.PortDecl, local: dict[str, Value] | None = None) -> Value:
    """The value of a port. A vector is a place where a ``point`` is declared, by itself or by the role, and moves with its frame."""
    assert statement.value is not None
    value = Evaluator(env, local).value(statement.value)
    return replace(value, point=True) if isinstance(value, Vec) and _is_point(env, statement) else value


def _is_point(env: Env, statement: ast.PortDecl) -> bool:
    declared = [statement]
    for owner in lineage(env.symbol) if env.symbol is not None else ():
        declared += [s for s in owner.body if isinstance(s, ast.PortDecl) and s.name == statement.name]
    return any(port.type is not None and port.type.name == "point" for port in declared)


@dataclass(slots=True, eq=False)
class PortArray(Ports):
    """Ports of a body that are evaluated when they are first asked for."""

    pending: list[Binding] = field(default_factory=list)  # still to be evaluated
    size: int = 0  # how many there are, where the declaration says

    def settled(self) -> dict[int, Value]:
        """Evaluate the bindings: one per constant index, all of a repeat by its index, or all by an index of their own."""
        pending, self.pending = self.pending, []
        for home, index, statement in pending:
            meaning = home.context.meaning(index)
            if isinstance(meaning, Local):
                for k in range(self.size):
                    self.values[k] = bound(home, statement, {meaning.name: E.const(float(k))})
                continue
            value = bound(home, statement)
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
