"""What an operator supplies, and what the operators read alike."""

from __future__ import annotations

from dataclasses import field

from ...graph import expr as E
from ...graph.expr import ZERO, Expr
from ...graph.primitive import Patch, Piece, Triple
from ...records import dataclass
from ..values.kinds import Value
from .curves import TURN

U = E.var("u")
NARROW = "the path bends more tightly than its section allows"
FULL = (ZERO, E.const(TURN))


@dataclass(frozen=True, slots=True, eq=False)
class Demand:
    """``low <= high`` must hold, else ``message``. One about a path that bends tells in ``bend`` how far the section reaches
    towards the inside, and the radius of curvature.
    """

    low: Expr
    high: Expr
    message: str
    bend: tuple[Expr, Expr] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Made:
    """A solid's formulas."""

    patches: tuple[Patch, ...]
    pieces: tuple[Piece, ...]
    inside: Expr
    low: Triple
    high: Triple
    ports: dict[str, Value] = field(default_factory=dict)
    requires: tuple[Demand, ...] = ()
