"""What an operator supplies, and what the operators read alike."""

from __future__ import annotations

from dataclasses import dataclass, field

from ...graph import expr as E
from ...graph.expr import ZERO, Expr
from ...graph.primitive import Patch, Piece, Triple
from ..values.kinds import Value
from .curves import TURN

U = E.var("u")
FULL = (ZERO, E.const(TURN))


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A solid's formulas. ``requires`` are (low, high, message): low <= high must hold."""

    patches: tuple[Patch, ...]
    pieces: tuple[Piece, ...]
    inside: Expr
    low: Triple
    high: Triple
    ports: dict[str, Value] = field(default_factory=dict)
    requires: tuple[tuple[Expr, Expr, str], ...] = ()
