"""Expressions: numbers, names, paths, operations, calls; ranges and arguments, which stand where one is asked for."""

from __future__ import annotations

from ...records import dataclass
from ...source import Span
from .nodes import Node


@dataclass(frozen=True, slots=True, kw_only=True)
class Expr(Node):
    pass


@dataclass(frozen=True, slots=True, kw_only=True)
class NumberExpr(Expr):
    """``5cm``: ``value`` as written, ``unit`` as written ("" where there is none; ``%`` is a unit)."""

    value: float
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class StringExpr(Expr):
    value: str


@dataclass(frozen=True, slots=True, kw_only=True)
class NameExpr(Expr):
    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class HoleExpr(Expr):
    """``_``: a component of a vector argument that is left open."""


@dataclass(frozen=True, slots=True, kw_only=True)
class VectorExpr(Expr):
    items: tuple[Expr, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class UnaryExpr(Expr):
    """``op`` is ``-``, ``+`` or ``not``."""

    op: str
    operand: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class BinaryExpr(Expr):
    """``op`` is one of ``+ - * / ^ and or == != < <= > >=``."""

    op: str
    left: Expr
    right: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class IsExpr(Expr):
    """``front is Closed``: ``subject`` is a path to a part, ``type_name`` a role or template."""

    subject: Expr
    type_name: str
    type_span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class IfExpr(Expr):
    """``then if condition else otherwise``."""

    then: Expr
    condition: Expr
    otherwise: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class MemberExpr(Expr):
    """``obj.name``; ``name_span`` is the name alone."""

    obj: Expr
    name: str
    name_span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class IndexExpr(Expr):
    """``row[last]``, ``socket[k]``."""

    obj: Expr
    index: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class Argument(Node):
    """``name`` is None for a positional argument."""

    name: str | None
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class CallExpr(Expr):
    """``function`` is a NameExpr; for ``body.wall.at(...)`` a MemberExpr, for ``side[0](...)`` an IndexExpr."""

    function: NameExpr | MemberExpr | IndexExpr
    arguments: tuple[Argument, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChainExpr(Expr):
    """A path of curve pieces: ``from([0, 0, 0], z) line(a) arc(radius = r, angle = 180deg, towards = x)``."""

    pieces: tuple[CallExpr, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeExpr(Node):
    """``low .. high``; only where a clause or a declaration takes a range."""

    low: Expr
    high: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class AllExpr(Expr):
    """``clearance all``, as the high end of a range of motion."""

    value: Expr
