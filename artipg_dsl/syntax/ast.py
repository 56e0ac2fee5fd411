"""The syntax tree: frozen nodes, each with the span it was read from.

The tree knows no types and resolves no names. Expressions end in ``Expr``, statements and declarations in
``Decl`` or ``Stmt``. Tuples everywhere; absent parts are ``None`` or an empty tuple.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Generic, TypeVar

from ..source import Span

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    span: Span


# ---------------------------------------------------------------- expressions


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
    """``function`` is a NameExpr or, for ``body.wall.at(...)``, a MemberExpr."""

    function: NameExpr | MemberExpr
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


# ---------------------------------------------------------------- pieces of declarations


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
class Clause(Node, Generic[Value]):
    """A word and what stands behind it: ``to E``, ``fit a, b``, ``range a .. b``; the span is that of both.

    Clauses are fields of their statement, named as their word is (``in_`` and ``from_`` with an underscore). ``word`` is for messages.
    """

    word: str
    value: Value


# ---------------------------------------------------------------- statements


@dataclass(frozen=True, slots=True, kw_only=True)
class Stmt(Node):
    """``doc`` is the text of the ``##`` comments that stand before (or after, on the line of) a declaration."""

    doc: str = ""


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

    ``kind`` is None for a role's joint. In a range ``clearance`` is a NameExpr, in an AllExpr where it is ``clearance all``.
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
    effort: Clause[Expr] | None = None
    velocity: Clause[Expr] | None = None
    pitch: Clause[Expr] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectStmt(Attaching):
    """``connect handle.mount to door.front at y = ..., z = ...``."""

    subject: Expr


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


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelStmt(Stmt):
    """``label affordance.pull on a, b where p.y < 0`` or ``label affordance.press on a = 1 - hypot(p.y, p.z) / r``;
    ``label affordance.lift for raise on a``: by which joint."""

    vocabulary: str
    label: str
    label_span: Span
    targets: tuple[Expr, ...]
    joint: Expr | None = None
    where: Expr | None = None
    value: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldStmt(Stmt):
    """``field heat : ratio on body where p.z > 0 = formula``."""

    name: str
    name_span: Span
    type: TypeRef
    targets: tuple[Expr, ...]
    where: Expr | None = None
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspStmt(Stmt):
    """``grasp pull_handle on handle.grip for t in -0.4 .. 0.4 { at ... approach -x close y opening ... }``.

    Any word may stand in the braces: ``unknown`` are those that a grasp does not have.
    """

    name: str
    name_span: Span
    target: Expr
    parameter: str | None
    range: RangeExpr | None
    at: Clause[Expr] | None = None
    approach: Clause[Expr] | None = None
    close: Clause[Expr] | None = None
    opening: Clause[Expr] | None = None
    quality: Clause[Expr] | None = None
    stroke: Clause[Expr] | None = None
    length: Clause[Expr] | None = None
    width: Clause[Expr] | None = None
    thickness: Clause[Expr] | None = None
    pad: Clause[Expr] | None = None
    palm: Clause[Expr] | None = None
    palm_width: Clause[Expr] | None = None
    palm_depth: Clause[Expr] | None = None
    unknown: tuple[Clause[Any], ...] = ()

    @property
    def hand(self) -> tuple[Clause[Expr], ...]:
        """The measures of the gripper that the grasp is meant for, as far as they are given."""
        measures = (
            self.stroke,
            self.length,
            self.width,
            self.thickness,
            self.pad,
            self.palm,
            self.palm_width,
            self.palm_depth,
        )
        return tuple(m for m in measures if m is not None)


@dataclass(frozen=True, slots=True, kw_only=True)
class KeypointStmt(Stmt):
    """``keypoint tip on spout.end``, ``keypoint tip on grip at [size.x / 2, 0, 0]``."""

    name: str
    name_span: Span
    target: Expr
    at: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SymmetryStmt(Stmt):
    """``symmetry handle : turn 2 about z``; ``turn`` None for ``symmetry knob : any about z``."""

    target: Expr
    turn: Expr | None
    direction: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class MaterialStmt(Stmt):
    """``material oak on body, column.cell.front``."""

    material: str
    material_span: Span
    targets: tuple[Expr, ...]


# ---------------------------------------------------------------- primitives only


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


# ---------------------------------------------------------------- top level


@dataclass(frozen=True, slots=True, kw_only=True)
class Decl(Stmt):
    """A named top-level declaration."""

    name: str
    name_span: Span


@dataclass(frozen=True, slots=True, kw_only=True)
class RoleDecl(Decl):
    parent: str | None
    parent_span: Span | None
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TemplateDecl(Decl):
    role: str | None
    role_span: Span | None
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class PrimitiveDecl(Decl):
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CategoryDecl(Decl):
    body: tuple[Stmt, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class MaterialDecl(Decl):
    """``material oak { density 700kg/m3  colour [0.6, 0.4, 0.2] .. [0.7, 0.5, 0.3] }``: a value is a range with equal ends.

    Any word may stand in the braces: ``unknown`` are those that a material does not have.
    """

    density: Clause[RangeExpr] | None = None
    friction: Clause[RangeExpr] | None = None
    static_friction: Clause[RangeExpr] | None = None
    dynamic_friction: Clause[RangeExpr] | None = None
    restitution: Clause[RangeExpr] | None = None
    colour: Clause[RangeExpr] | None = None
    roughness: Clause[RangeExpr] | None = None
    metalness: Clause[RangeExpr] | None = None
    transparency: Clause[RangeExpr] | None = None
    unknown: tuple[Clause[Any], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class VocabularyDecl(Decl):
    """``vocabulary affordance { push, turn : about, lift : along }``: words, and by which kind of joint some of them move."""

    words: tuple[str, ...]
    word_spans: tuple[Span, ...]
    motions: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FunctionDecl(Decl):
    """A module-level ``let f(x) = ...`` or constant (no parameters)."""

    parameters: tuple[str, ...]
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class UseDecl(Node):
    module: str
    module_span: Span
    names: tuple[str, ...]
    name_spans: tuple[Span, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Module(Node):
    version: int
    uses: tuple[UseDecl, ...]
    declarations: tuple[Decl, ...]


# ---------------------------------------------------------------- clauses of a statement


def clause_words(kind: type[Stmt]) -> tuple[str, ...]:
    """The words of the clauses that a statement of this kind may have, as messages list them."""
    return tuple(f.name.rstrip("_") for f in fields(kind) if str(f.type).startswith("Clause["))


def value_of(clause: Clause[Value] | None) -> Value | None:
    """What stands behind the word of a clause; None without it."""
    return None if clause is None else clause.value


def clauses(statement: Stmt) -> list[Clause[Any]]:
    """The clauses of a statement in the order of the text, known or not."""
    found: list[Clause[Any]] = []
    for field in fields(statement):
        value = getattr(statement, field.name)
        found += [c for c in (value if isinstance(value, tuple) else (value,)) if isinstance(c, Clause)]
    return sorted(found, key=lambda c: c.span.start)
