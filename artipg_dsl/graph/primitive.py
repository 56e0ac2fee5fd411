"""A primitive as the runtime knows it: formulas over its parameters, nothing else.

Variables of the formulas: each parameter by its name (a vector's components as ``size.x``, ``size.y``, ``size.z``),
``u`` and ``v`` on a surface, ``p.x``, ``p.y``, ``p.z`` in the inside function, ``i`` (the index) in indexed patches
and pieces. Lengths in metres, angles in radians, the primitive's own frame.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import field, fields
from typing import Any

from ..records import dataclass
from .expr import Expr

Pair = tuple[Expr, Expr]
Triple = tuple[Expr, Expr, Expr]


def pair(items: Iterable[Expr]) -> Pair:
    """Two expressions as such; another number of them is an error."""
    a, b = items
    return a, b


def triple(items: Iterable[Expr]) -> Triple:
    """Three expressions as such; another number of them is an error."""
    a, b, c = items
    return a, b, c


@dataclass(frozen=True, slots=True, eq=False)
class Patch:
    """A surface ``position(u, v)`` over ``u0 .. u1`` by ``v0 .. v1`` (formulas of the parameters).

    ``guard`` (a predicate of the parameters, or None) says when the patch exists. ``count`` (a constant, or None)
    repeats an indexed patch for ``i`` = 0 .. count - 1; where the number differs between instances it is the greatest,
    and the guard says which of them exist.
    """

    name: str
    position: Triple
    u_range: tuple[Expr, Expr]
    v_range: tuple[Expr, Expr]
    guard: Expr | None = None
    count: int | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """Convex pieces: the hull of ``points``, for ``i`` = 0 .. count - 1 (``count`` a formula of the parameters, None: one)."""

    name: str
    points: tuple[Triple, ...]
    count: Expr | None = None
    guard: Expr | None = None


LATER = ("patches", "inside", "low", "high", "pieces", "requires")  # what may be read once it is asked for


class _Deferred:
    """What may lack some of its formulas until they are asked for."""

    __slots__ = ("_read",)

    def __getattr__(self, name: str) -> Any:
        if name not in LATER:
            raise AttributeError(name)
        found = self._read(name)
        object.__setattr__(self, name, found)
        return found


@dataclass(frozen=True, slots=True, eq=False)
class Primitive(_Deferred):
    """``parameters`` are the scalar parameter names in order; ``test`` their test ranges (metres, radians) in the same
    order; ``whole`` those that count something, and switches, which are 0 or 1; ``requires`` predicates that the parameters must meet. Without
    ``pieces`` a primitive is the hull of its mesh.
    """

    name: str
    parameters: tuple[str, ...]
    test: tuple[tuple[float, float], ...]
    patches: tuple[Patch, ...]
    inside: Expr
    low: Triple
    high: Triple
    pieces: tuple[Piece, ...] = ()
    requires: tuple[Expr, ...] = ()
    where: str = ""  # "file:line" of the declaration
    surfaces: tuple[str, ...] = field(default=())  # names that labels may use, in order
    whole: tuple[str, ...] = ()


def defer(told: dict[str, Any], read: Callable[[str], Any]) -> Primitive:
    """A primitive of which the fields beside ``LATER`` are ``told``; ``read`` gives one of the others once it is asked for."""
    made = object.__new__(Primitive)
    for each in fields(Primitive):
        if each.name not in LATER:
            object.__setattr__(made, each.name, told.get(each.name, each.default))
    object.__setattr__(made, "_read", read)
    return made
