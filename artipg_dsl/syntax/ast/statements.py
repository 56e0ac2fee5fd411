"""Statements of a body: what connects, places and moves, what has to hold, what is repeated and what is there at times."""

from __future__ import annotations

from ...records import dataclass
from ...source import Span
from .expressions import Argument, Expr, RangeExpr
from .nodes import Clause, Node, Stmt


@dataclass(frozen=True, slots=True, kw_only=True)
class Attaching(Stmt):
    """What ``connect`` and ``joint`` share: the clauses that place."""

    to: Clause[Expr] | None = None
    on: Clause[Expr] | None = None
    in_: Clause[Expr] | None = None
    between: Clause[tuple[Expr, Expr]] | None = None
    at: Clause[tuple[Argument, ...]] | None = None
    fit: Clause[tuple[Expr, ...]] | None = None
    gap: Clause[Expr] | None = None
    sink: Clause[Expr] | None = None
    facing: Clause[Expr] | None = None
    turned: Clause[Expr] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class JointDecl(Attaching):
    """``joint open : revolute body -> door about door.left.back range 0deg .. 110deg``; in a role ``joint motion ?``.

    ``kind`` is None for a role's joint; ``when`` compares joints that it waits for with values.
    In a range ``clearance`` is a NameExpr, in an AllExpr where it is ``clearance all``.
    """

    name: str
    name_span: Span
    optional: bool = False
    kind: str | None = None
    kind_span: Span | None = None
    parent: Expr | None = None
    child: Expr | None = None
    about: Clause[Expr] | None = None
    along: Clause[Expr] | None = None
    range: Clause[RangeExpr] | None = None
    rest: Clause[Expr] | None = None
    mimic: Clause[Expr] | None = None
    damping: Clause[Expr] | None = None
    friction: Clause[Expr] | None = None
    stiffness: Clause[Expr] | None = None
    effort: Clause[Expr] | None = None
    velocity: Clause[Expr] | None = None
    pitch: Clause[Expr] | None = None
    positions: Clause[Expr] | None = None
    when: Clause[Expr] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectStmt(Attaching):
    """``connect handle.mount to door.front at y = ..., z = ...``."""

    subject: Expr


def placed(statement: Stmt) -> Expr | None:
    """The subject of a ``connect``, the child of a joint that is no role's; None for other statements."""
    match statement:
        case ConnectStmt(subject=subject):
            return subject
        case JointDecl(kind=str(), child=child):
            return child
    return None


@dataclass(frozen=True, slots=True, kw_only=True)
class Start(Node):
    """``a = 1cm`` behind ``near``: where the search for a solution begins."""

    left: Expr
    right: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class AlignStmt(Stmt):
    """``align a = b near c = d``."""

    left: Expr
    right: Expr
    near: Clause[tuple[Start, ...]] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class RequireStmt(Stmt):
    """``require a <= b else "message" repair x``; ``require stable`` and ``require stable open`` set ``stable``."""

    condition: Expr | None
    stable: str | None = None  # None | "rest" | "open"
    message: str | None = None
    repair: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PreferStmt(Stmt):
    condition: Expr
    weight: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ClearStmt(Stmt):
    """``clear a from b by 1mm``; ``all``: whatever the joints between them do."""

    subject: Expr
    other: Expr
    distance: Expr
    all: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class AllowStmt(Stmt):
    """``allow overlap a, b because "reason"`` (kind "overlap"), ``allow floating a because "reason"`` (kind "floating", no
    ``other``) and ``free a, b`` (kind "free", reason may be None)."""

    kind: str
    subject: Expr
    other: Expr | None
    reason: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LimitStmt(Stmt):
    """``limit lid.motion 0deg .. clearance``."""

    joint: Expr
    range: RangeExpr


@dataclass(frozen=True, slots=True, kw_only=True)
class CloseStmt(Stmt):
    """``close a.pin on b.pin``."""

    subject: Expr
    other: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class RepeatStmt(Stmt):
    """``repeat post[i] in 0 ..< posts spread grip along z margin t { ... }``.

    ``count`` is the upper end (``in 0 ..< count``) or, for ``ring 2 about``, the number after ``ring``; None for
    ``fill`` and for ``mirror`` (two). ``form`` is "", "pitch", "spread", "fill", "split", "ring" or "mirror".
    """

    name: str
    name_span: Span
    index: str | None
    count: Expr | None
    form: str
    body: tuple[Stmt, ...]
    spread: Clause[Expr] | None = None
    fill: Clause[Expr] | None = None
    split: Clause[Expr] | None = None
    ring: Clause[Expr] | None = None
    pitch: Clause[Expr] | None = None
    mirror: Clause[None] | None = None
    along: Clause[Expr] | None = None
    across: Clause[Expr] | None = None
    about: Clause[Expr] | None = None
    margin: Clause[Expr] | None = None
    every: Clause[Expr] | None = None
    weight: Clause[Expr] | None = None
    gap: Clause[Expr] | None = None
    each: Clause[RangeExpr] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class WhenStmt(Stmt):
    """``when guard { } else { }``; ``else when`` nests a WhenStmt as the only statement of ``otherwise``."""

    guard: Expr
    body: tuple[Stmt, ...]
    otherwise: tuple[Stmt, ...] = ()
