"""Where a part stands: by a mount (frame to frame), between two points, or by unknown coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..graph import expr as E
from ..graph.expr import ONE, ZERO
from ..graph.linear import tidy
from ..graph.program import Pose
from ..syntax import ast
from .carry import mapped_pose
from .context import Equation
from .env import Env
from .evaluate import Evaluator
from .values import Branch, Frame, Line, Ref, Value
from .vectors import (
    AXES,
    HERE,
    Matrix,
    Triple,
    columns,
    cross,
    dot,
    minus,
    norm,
    normalized,
    plus,
    product,
    times,
    transpose,
    turn,
    unit,
)

if TYPE_CHECKING:
    from .part import Part

MINUS = E.const(-1.0)


@dataclass(slots=True, eq=False)
class Mount:
    """A statement that fixes the whole pose of a part: ``subject`` on ``target`` (frames), or between two points."""

    env: Env
    statement: ast.ConnectStmt | ast.JointDecl
    subject: ast.Expr
    target: ast.Expr | None
    clauses: tuple[ast.Clause, ...]

    def clause(self, word: str) -> ast.Clause | None:
        return next((c for c in self.clauses if c.word == word), None)


def root_name(node: ast.Expr | None) -> str | None:
    """The name a path begins with."""
    while isinstance(node, ast.MemberExpr | ast.IndexExpr):
        node = node.obj
    return node.name if isinstance(node, ast.NameExpr) else None


def bare(env: Env, node: ast.Expr | None) -> bool:
    """Whether an expression is a part's name alone (or `base`), which attaches without placing."""
    if not isinstance(node, ast.NameExpr):
        return node is None
    found = env.find(node.name)
    return found is None or isinstance(found, Ref)


def mount_of(env: Env, statement: ast.Stmt, name: str) -> Mount | None:
    """The mount that a statement states for the part ``name``, if it is one."""
    if isinstance(statement, ast.ConnectStmt) and root_name(statement.subject) == name:
        words = {c.word: c for c in statement.clauses}
        if "between" in words:
            return Mount(env, statement, statement.subject, None, statement.clauses)
        if "to" in words and isinstance(statement.subject, ast.MemberExpr):
            return Mount(env, statement, statement.subject, words["to"].values[0], statement.clauses)
    if isinstance(statement, ast.JointDecl) and statement.child is not None and root_name(statement.child) == name:
        words = {c.word: c for c in statement.clauses}
        if "between" in words:
            return Mount(env, statement, statement.child, None, statement.clauses)
        if "to" in words and isinstance(statement.child, ast.MemberExpr):
            return Mount(env, statement, statement.child, words["to"].values[0], statement.clauses)
        ported = isinstance(statement.child, ast.MemberExpr | ast.IndexExpr) and not bare(env, statement.parent)
        if ported and not {"in", "on"} & set(words):
            return Mount(env, statement, statement.child, statement.parent, statement.clauses)
    return None


def mounts(env: Env, name: str) -> list[Mount]:
    """The mounts of a part in its environment, and under every ``when`` there, be it further down in the text."""
    from .body import enter_when

    for statement in env.statements:
        if isinstance(statement, ast.WhenStmt) and mounting(statement, name):
            enter_when(env, statement)
    found = [m for s in env.statements if (m := mount_of(env, s, name)) is not None]
    for branch in env.branches.values():
        found.extend(mounts(branch, name))
    return found


def mounting(statement: ast.WhenStmt, name: str) -> bool:
    """Whether a ``when`` may hold a mount of the part ``name``."""
    for inner in (*statement.body, *statement.otherwise):
        if isinstance(inner, ast.WhenStmt):
            if mounting(inner, name):
                return True
        elif isinstance(inner, ast.ConnectStmt | ast.JointDecl):
            subject = inner.subject if isinstance(inner, ast.ConnectStmt) else inner.child
            if root_name(subject) == name:
                return True
    return False


def pose_of(part: Part) -> Pose:
    """The pose of a part in its environment; registers unknown coordinates where equations shall find them."""
    from .build import position_columns, rotation_of

    if part.declaration.root:
        return Pose(rotation_of(part), (ZERO, ZERO, ZERO), ONE)
    found = mounts(part.env, part.name)
    if not found:
        return Pose(rotation_of(part), position_columns(part), ONE)
    poses = [(m.env.scope, mounted(part, m)) for m in found]
    if len(poses) == 1:
        return poses[0][1]
    context = part.context
    lists = [flat(pose) for _, pose in poses]
    order = iter(range(len(lists[0])))

    def pick(_: E.Expr) -> E.Expr:
        k = next(order)
        if all(scope is part.env.scope for scope, _ in poses):
            raise context.error("over-determined", found[1].statement.span, f"`{part.name}` is mounted twice")
        return E.phi(part.env.scope, [(scope, values[k]) for (scope, _), values in zip(poses, lists, strict=True)])

    return mapped_pose(poses[0][1], pick)


def flat(pose: Pose) -> list[E.Expr]:
    found: list[E.Expr] = []
    mapped_pose(Pose(pose.rotation, pose.translation, pose.mirror), lambda e: found.append(e) or e)  # type: ignore[func-returns-value]
    return found


def mounted(part: Part, mount: Mount) -> Pose:
    ev = Evaluator(mount.env)
    if mount.clause("between") is not None:
        return bridged(part, mount, ev)
    assert mount.target is not None
    own = own_value(part, mount.subject, mount.env)
    if isinstance(own, Line):
        own = Frame(own.point, axes_from(own.direction), own.on)
    if not isinstance(own, Frame):
        raise ev.wrong(mount.subject.span, "a frame of the part (a port or a face)", own)
    value = ev.value(mount.target)
    if isinstance(value, Line):
        value = Frame(value.point, axes_from(times(value.direction, MINUS)), value.on)
    if not isinstance(value, Frame):
        raise ev.wrong(mount.target.span, "a frame (a port or a face)", value)
    origin = located(value, mount, ev)
    out, up = value.out, value.up
    side = tuple(row[1] for row in value.rotation)
    rotation = product(columns(times(out, MINUS), times(side, MINUS), up), transpose(own.rotation))  # type: ignore[arg-type]
    extra = mount.clause("gap")
    offset = ev.scalar(extra.values[0]) if extra is not None else ZERO
    sink = mount.clause("sink")
    if sink is not None:
        offset = E.sub(offset, ev.scalar(sink.values[0]))
    origin = plus(origin, times(out, offset))
    return Pose(rotation, minus(origin, turn(rotation, own.origin)), ONE)


def axes_from(direction: Triple) -> Matrix:
    """Axes for a line used as a frame: out along it, up z (x for a vertical one)."""
    from .faces import frame_of

    return frame_of(direction, unit(0 if abs(direction[2].constant or 0.0) == 1.0 else 2))


def own_value(part: Part, subject: ast.Expr, env: Env) -> Value:
    """The subject of a mount in the part's own frame (its pose is what is sought)."""
    return Evaluator(env, {part.name: Ref(part.name, (Branch(None, ((part, HERE),)),), own=True)}).value(subject)


def located(frame: Frame, mount: Mount, ev: Evaluator) -> Triple:
    """The origin of the target, moved by ``at y = ..., z = ...`` within its plane."""
    clause = mount.clause("at")
    origin = list(frame.origin)
    if clause is None:
        return frame.origin
    for name, node in zip(clause.names, clause.values, strict=True):
        if name in AXES:
            axis = AXES.index(name)
            if frame.out[axis].constant in (1.0, -1.0):
                raise ev.env.context.error(
                    "plane-across-axes", node.span, f"the target faces along {name}; `at` moves within its plane",
                    hint=f"give the other two coordinates here, and the distance along {name} by `gap` or `sink`",
                )  # fmt: skip
            origin[axis] = ev.scalar(node)
        elif isinstance(node, ast.NameExpr) and node.name == "center":
            continue
        else:
            origin = list(ev.vector(node))
    return tuple(origin)  # type: ignore[return-value]


def bridged(part: Part, mount: Mount, ev: Evaluator) -> Pose:
    """``between A and B [facing d] [sink s]``: the pose and the one parameter on which the length of ``ends`` depends."""
    clause = mount.clause("between")
    assert clause is not None
    subject = mount.subject
    line = part.own("ends", subject.span) if isinstance(subject, ast.NameExpr) else own_value(part, subject, mount.env)
    if not isinstance(line, Line) or line.to is None:
        raise ev.env.context.error(
            "unknown-port", subject.span, f"`{part.name}` has no port `ends : line` with two ends, which `between` needs",
            hint="declare it in the template: port ends = line(at = ..., to = ...)",
        )  # fmt: skip
    sink_clause = mount.clause("sink")
    sink = ev.scalar(sink_clause.values[0]) if sink_clause is not None else ZERO
    gap_clause = mount.clause("gap")
    if gap_clause is not None:
        sink = E.sub(sink, ev.scalar(gap_clause.values[0]))
    a, b = sunk(ev, clause.values, sink)
    outer, inner = tuple(tidy(c) for c in minus(b, a)), minus(line.to, line.point)
    distance = norm(outer)
    reach = next((c for c in inner if c is not ZERO), ZERO) if sum(c is not ZERO for c in inner) == 1 else norm(inner)
    mount.env.equations.append(Equation(reach, distance, clause.span, "the distance of the two ends", part.exists))
    facing = mount.clause("facing")
    along = normalized(outer)
    toward = ev.direction(facing.values[0]) if facing is not None else perpendicular(along)
    own_axis = next((k for k in range(3) if inner[k] is not ZERO), 2)
    own_along = unit(own_axis) if sum(c is not ZERO for c in inner) == 1 else normalized(inner)
    own_toward = unit(0 if own_axis != 0 else 2)
    world, local = basis(along, toward), basis(own_along, own_toward)
    rotation = product(world, transpose(local))
    return Pose(rotation, minus(a, turn(rotation, line.point)), ONE)


def sunk(ev: Evaluator, places: tuple[ast.Expr, ...], sink: E.Expr) -> tuple[Triple, Triple]:
    """The two places, each moved into what it lies on: against ``out`` of a frame; a point has none, so along the line of both."""
    values = [ev.value(node) for node in places]
    a, b = (ev.vector(node) for node in places)
    if sink is ZERO:
        return a, b
    away = normalized(minus(b, a)) if any(not isinstance(v, Frame) for v in values) else (ZERO, ZERO, ZERO)
    outs = [v.out if isinstance(v, Frame) else d for v, d in zip(values, (away, times(away, MINUS)), strict=True)]
    return minus(a, times(outs[0], sink)), minus(b, times(outs[1], sink))


def perpendicular(direction: Triple) -> Triple:
    """z, or x where the direction is vertical by construction."""
    return unit(0) if direction[0] is ZERO and direction[1] is ZERO else unit(2)


def basis(along: Triple, toward: Triple) -> Matrix:
    """Orthonormal columns: along, toward made square to it, and their cross product."""
    square = toward
    if dot(along, toward) is not ZERO:
        square = minus(toward, times(along, dot(along, toward)))
    square = normalized(square)
    return columns(along, square, cross(along, square))
