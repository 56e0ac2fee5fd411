"""Declarations of a body: parameters, counts, values, parts, styles, slots and ports."""

from __future__ import annotations

from ...records import dataclass
from ...source import Span
from .expressions import Argument, Expr, RangeExpr
from .nodes import Node, Stmt


@dataclass(frozen=True, slots=True, kw_only=True)
class TypeRef(Node):
    """``length``, ``length[3]``, ``style Handle`` (style=True), ``choice a | b`` (values), ``material`` ..."""

    name: str
    size: int | None = None
    style: bool = False
    values: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution(Node):
    """``~ normal(50cm, 4cm)``."""

    name: str
    arguments: tuple[Argument, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement(Node):
    """``along x`` (direction) or ``turned 20deg about y`` (angle, direction)."""

    kind: str  # "along" | "turned"
    direction: Expr
    angle: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Alternative(Node):
    """``BarHandle(x = 1) along x weight 2 when guard``; ``name`` is None for ``none``."""

    name: str | None
    name_span: Span
    arguments: tuple[Argument, ...] = ()
    placements: tuple[Placement, ...] = ()
    weight: Expr | None = None
    guard: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ParamDecl(Stmt):
    """``param a, b : length in 1cm .. 2cm = 1.5cm ~ uniform() vary 8%``; ``inherit`` in a role, ``out`` in a role.

    ``keyword`` is "param", "inherit" or "out". ``domain`` is ``in lo .. hi``; ``positive`` stands for ``> 0``.
    """

    keyword: str
    names: tuple[str, ...]
    name_spans: tuple[Span, ...]
    type: TypeRef
    domain: RangeExpr | None = None
    positive: bool = False
    default: Expr | None = None
    distribution: Distribution | None = None
    vary: Expr | None = None
    derived: bool = False
    test: RangeExpr | None = None
    was: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CountDecl(Stmt):
    """``count rows in 1 .. 5 = 3``."""

    name: str
    name_span: Span
    domain: RangeExpr
    default: Expr | None = None
    distribution: Distribution | None = None
    was: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LetDecl(Stmt):
    """``let name = value``, ``let r(v) = value``; also ``curve`` declarations without a domain (keyword "curve")."""

    keyword: str
    name: str
    name_span: Span
    parameters: tuple[str, ...]
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class PartDecl(Stmt):
    """``root part body : Role(args) = A weight 2 | B | none`` or ``part pad : ButtonPad(args)``.

    ``role`` is the name after ``:`` when alternatives follow ``=``, with its arguments; otherwise None and the
    alternatives stand directly after the colon. A style or a template is an alternative by its name.
    """

    root: bool
    name: str
    name_span: Span
    role: str | None
    role_span: Span | None
    arguments: tuple[Argument, ...]
    placements: tuple[Placement, ...]
    alternatives: tuple[Alternative, ...]
    was: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class StyleDecl(Stmt):
    """``style pull : Handle = BarHandle weight 3 | none``; ``style look : material = oak | white``."""

    name: str
    name_span: Span
    role: str
    role_span: Span
    alternatives: tuple[Alternative, ...]
    was: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SlotDecl(Stmt):
    """``slot grip``, ``slot tube ?`` in a role; ``slot tube = riser, bar`` in a template."""

    name: str
    name_span: Span
    optional: bool = False
    targets: tuple[Expr, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class PortDecl(Stmt):
    """``port mount : frame``, ``port socket[2] : frame``; bound as ``port mount = ...``, ``port socket[i] = ...``.

    ``index`` is the expression in brackets; ``type`` or ``value`` may be absent.
    """

    name: str
    name_span: Span
    index: Expr | None = None
    optional: bool = False
    type: TypeRef | None = None
    value: Expr | None = None
