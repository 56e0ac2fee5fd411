"""Statements of a primitive: surfaces, curves, what is inside, the box, convex pieces, operators on curves."""

from __future__ import annotations

from ...records import dataclass
from ...source import Span
from .expressions import Argument, Expr, RangeExpr
from .nodes import Clause, Stmt


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceDecl(Stmt):
    """``surface side (u in 0turn .. 1turn, v in 0 .. 1) = [...] when guard``.

    An indexed patch has ``index``: ``surface side[i in 0 ..< n] (u ..., v ...)``.
    """

    name: str
    name_span: Span
    u: str
    u_range: RangeExpr
    v: str
    v_range: RangeExpr
    value: Expr
    guard: Expr | None = None
    index: str | None = None
    index_count: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CurveDecl(Stmt):
    """``curve skin (v in 0 .. 1) = [radius, height]``."""

    name: str
    name_span: Span
    parameter: str
    parameter_range: RangeExpr
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class InsideDecl(Stmt):
    """``inside (p) = length`` (negative within)."""

    parameter: str
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class BoxDecl(Stmt):
    """``box = [w, d, h]`` (size, centred) or ``box = low .. high``: ``value`` or ``low`` and ``high``."""

    value: Expr | None = None
    low: Expr | None = None
    high: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PieceDecl(Stmt):
    """``piece wall (i in 0 ..< 8) = hull(a, b, ...) when guard``: convex pieces by corners; surfaces are callable.

    ``index`` None and ``count`` None for a single piece; without any, a primitive is one hull of its mesh.
    """

    name: str
    name_span: Span
    index: str | None
    count: Expr | None
    points: tuple[Expr, ...]
    guard: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SolidDecl(Stmt):
    """``solid = lathe(skin, lining) about z``; ``operator`` lathe extrude sweep loft."""

    operator: str
    arguments: tuple[Argument, ...]
    about: Clause[Expr] | None = None
    along: Clause[Expr] | None = None
    up: Clause[Expr] | None = None
    from_: Clause[Expr] | None = None
    to: Clause[Expr] | None = None
    at: Clause[Expr] | None = None
    smooth: Clause[None] | None = None
