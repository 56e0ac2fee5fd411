"""The syntax tree: frozen nodes, each with the span it was read from.

The tree knows no types and resolves no names. Expressions end in ``Expr``, statements and declarations in
``Decl`` or ``Stmt``. Tuples everywhere; absent parts are ``None`` or an empty tuple.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..source import Span


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
class Clause(Node):
    """A clause of ``connect``, ``joint``, ``repeat`` ...: ``to E``, ``fit a, b``, ``range a .. b``.

    ``word`` is the clause word; ``values`` its expressions, ``names`` their argument names where the clause has
    ``name = value`` items (``at y = ..., z = ...``; "" for a bare item such as ``at center``); a range puts its
    two ends into ``values``. ``between A and B`` has two values.
    """

    word: str
    values: tuple[Expr, ...] = ()
    names: tuple[str, ...] = ()


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
class JointDecl(Stmt):
    """``joint open : revolute body -> door about door.left.back range 0deg .. 110deg``; in a role ``joint motion ?``.

    ``kind`` is None for a role's joint. Clauses: to on in at fit gap between sink facing, about along range rest
    mimic damping friction effort velocity pitch; ``clearance`` in a range is a NameExpr, in an AllExpr where it is
    ``clearance all``.
    """

    name: str
    name_span: Span
    optional: bool = False
    kind: str | None = None
    kind_span: Span | None = None
    parent: Expr | None = None
    child: Expr | None = None
    clauses: tuple[Clause, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectStmt(Stmt):
    """``connect handle.mount to door.front at y = ..., z = ...``."""

    subject: Expr
    clauses: tuple[Clause, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class AlignStmt(Stmt):
    """``align a = b near c = d``: ``near`` holds the sides of all its pairs, one after the other."""

    left: Expr
    right: Expr
    near: Clause | None = None


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
    Clauses: the form's own values under its word (``spread``: the box; ``pitch``: the distance; ``mirror``: nothing)
    and along, margin, every, weight, gap, each (two values), about, across.
    """

    name: str
    name_span: Span
    index: str | None
    count: Expr | None
    form: str
    clauses: tuple[Clause, ...]
    body: tuple[Stmt, ...]


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
    """``grasp pull_handle on handle.grip for t in -0.4 .. 0.4 { at ... approach -x close y opening ... }``."""

    name: str
    name_span: Span
    target: Expr
    parameter: str | None
    range: RangeExpr | None
    clauses: tuple[Clause, ...]  # at, approach, close, opening, quality


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
    """``solid = lathe(skin, lining) about z``; ``operator`` lathe extrude sweep loft; clauses about along up ..."""

    operator: str
    arguments: tuple[Argument, ...]
    clauses: tuple[Clause, ...]


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
    """``material oak { density 700kg/m3  colour [0.6, 0.4, 0.2] }``: property names with values or ranges."""

    properties: tuple[Clause, ...]


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
