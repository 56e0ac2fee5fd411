"""Where a part stands: by a mount (frame to frame), between two points, or by unknown coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import ONE, ZERO, Expr, Scope
from ...graph.linear import tidy
from ...graph.primitive import Triple, triple
from ...graph.program import Pose
from ...records import dataclass
from ...semantics.meanings import Declared, Word
from ...syntax import ast
from ...syntax.walk import in_branches, path_root
from ..expressions.context import Abort, Equation
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..expressions.members import describe
from ..expressions.rows import has_row
from ..solve.cases import covered
from ..solve.recurrent import closed
from ..values.carry import merged
from ..values.faces import FACES, frame_of
from ..values.kinds import Branch, Face, Frame, Line, Ref, Value
from ..values.vectors import (
    AXES,
    HERE,
    IDENTITY,
    MINUS,
    Matrix,
    columns,
    cross,
    dot,
    matrix,
    minus,
    norm,
    normalized,
    plus,
    product,
    signed_axis,
    times,
    transpose,
    turn,
    unit,
)

if TYPE_CHECKING:
    from .part import Component


@dataclass(slots=True, eq=False)
class Mount:
    """A statement that fixes the whole pose of a part: ``subject`` on ``target`` (frames), or between two points."""

    env: Env
    statement: ast.Attaching
    subject: ast.Expr
    target: ast.Expr | None

    @property
    def words(self) -> str:
        """What is mounted on what: ``handle.mount on door.front``, ``rung between one.right and two.left``."""
        between, subject = self.statement.between, self.subject.span.words
        if between is not None:
            return f"{subject} {between.span.words}"
        return subject if self.target is None else f"{subject} on {self.target.span.words}"


def begins(env: Env, node: ast.Expr | None) -> Declared | None:
    """The declaration that a path begins with."""
    meaning = None if node is None else env.context.meaning(path_root(node))
    return meaning if isinstance(meaning, Declared) else None


def declared(part: Component) -> Declared:
    """What names a part where it is declared."""
    return Declared(part.name, part.env.depth)


def bare(env: Env, node: ast.Expr | None) -> bool:
    """Whether an expression is a part's name alone (or `base`), which attaches without placing."""
    if not isinstance(node, ast.NameExpr):
        return node is None
    name = begins(env, node)
    found = None if name is None else env.find(name.name, name.depth)
    return found is None or isinstance(found, Ref)


def _mount_of(env: Env, statement: ast.Stmt, part: Declared) -> Mount | None:
    """The mount that a statement states for a part, if it is one."""
    subject = ast.placed(statement)
    if subject is None or not isinstance(statement, ast.Attaching) or begins(env, subject) != part:
        return None
    if statement.between is not None:
        return Mount(env, statement, subject, None)
    if statement.to is not None and isinstance(subject, ast.MemberExpr):
        return Mount(env, statement, subject, statement.to.value)
    if isinstance(statement, ast.JointDecl) and statement.in_ is statement.on is None:
        if isinstance(subject, ast.MemberExpr | ast.IndexExpr) and not bare(env, statement.parent):
            return Mount(env, statement, subject, statement.parent)
    return None


def mounts_of(part: Component) -> list[Mount]:
    """The statements that fix the whole pose of a part: one, or one in each branch of a ``when``; none if equations place it."""
    return _mounts_of(part.env, declared(part))


def _mounts_of(env: Env, part: Declared) -> list[Mount]:
    """The mounts of a part in its environment, and under every ``when`` there, be it further down in the text."""
    for statement in env.statements:
        if isinstance(statement, ast.WhenStmt) and _mounting(env, statement, part):
            env.context.makers.enter_when(env, statement)
    found = [m for s in env.statements if (m := _mount_of(env, s, part)) is not None]
    for branch in env.branches.values():
        found.extend(_mounts_of(branch, part))
    return found


def _mounting(env: Env, statement: ast.WhenStmt, part: Declared) -> bool:
    """Whether a ``when`` may hold a mount of a part."""
    return any(begins(env, ast.placed(inner)) == part for inner in in_branches((statement,)))


def pose_of(part: Component) -> Pose:
    """The pose of a part in its environment, sought when it is first asked for."""
    if part.found is None:
        if part.seeking:
            return before(part)
        if part.unplaced:
            raise Abort(f"`{part.name}` could not be placed")
        part.seeking = True
        try:
            pose = _sought(part)
            part.found = pose if part.previous is None else _chain_pose(part, pose, part.previous)
        except Abort:
            part.unplaced = True
            raise
        finally:
            part.seeking = False
    return part.found


def before(part: Component) -> Pose:
    """The pose while it is being sought: of the element before, in a chain through ``previous``."""
    if part.env.scope.kind != "repeat":
        raise _circular_place(part)
    if part.previous is None:
        names = [f"{part.path}.at.{letter}" for letter in "xyz"]
        found = [part.context.column(part.env.scope, name, "real", part.span) for name in names]
        part.previous = Pose(IDENTITY, triple(map(E.col, found)), E.ONE)
    return part.previous


def _chain_pose(part: Component, pose: Pose, chain: Pose) -> Pose:
    """Close the chain: each element stands on the one before, all turned alike."""
    if pose.rotation != chain.rotation or pose.mirror is not E.ONE:
        raise part.context.error(
            "recurrence",
            part.span,
            f"each `{part.name}` is turned relative to the one before, so its place is not a sum of offsets",
            hint="place the elements in line at joint values 0 and turn them by their joints",
        )
    for name, value in zip(chain.translation, pose.translation, strict=True):
        part.context.program.definitions[name.value] = closed(part.context, name.value, value)
    return chain


def _sought(part: Component) -> Pose:
    """The pose of a part in its environment; registers unknown coordinates where equations shall find them."""
    if part.declaration.root:
        return Pose(part.rotation(), (ZERO, ZERO, ZERO), ONE)
    found = mounts_of(part)
    if not found:
        return Pose(part.rotation(), part.position(), ONE)
    part.mounted = found[0].statement.span
    with part.context.going_with(part.exists):
        poses = [(m.env.scope, _mount_pose(part, m)) for m in found]
    if not everywhere(part, [scope for scope, _ in poses]):
        return partly(part, [(m, pose) for m, (_, pose) in zip(found, poses, strict=True)])
    if len(poses) == 1:
        return poses[0][1]
    frame = merged(part.env.scope, [(scope, Frame(pose.translation, pose.rotation)) for scope, pose in poses])
    return Pose(frame.rotation, frame.origin, ONE)


def everywhere(part: Component, scopes: list[Scope]) -> bool:
    """Whether one of the tables has a row wherever the part exists."""
    if any(scope is part.env.scope for scope in scopes):
        return True
    return covered([has_row(scope, part.env.scope) for scope in scopes], part.context.draws, part.exists)


def partly(part: Component, mounts: list[tuple[Mount, Pose]]) -> Pose:
    """The pose of a part that is mounted in some cases alone: there its place is an equation, else what others determine."""
    place, rotation = part.position(), part.rotation()
    for mount, pose in mounts:
        span = mount.statement.span
        for column, value in zip(place, pose.translation, strict=True):
            mount.env.equations.append(Equation(column, value, span, span.words, part.exists))
    scope = part.env.scope
    cells = [
        [
            E.phi(scope, [(m.env.scope, pose.rotation[i][j]) for m, pose in mounts], rotation[i][j])
            if any(pose.rotation[i][j] is not rotation[i][j] for _, pose in mounts)
            else rotation[i][j]
            for j in range(3)
        ]
        for i in range(3)
    ]
    return Pose(matrix(cells), place, ONE)


def _mount_pose(part: Component, mount: Mount) -> Pose:
    ev = Evaluator(mount.env)
    statement = mount.statement
    if statement.between is not None:
        return _bridge_pose(part, mount, ev)
    assert mount.target is not None
    inner = part.rotation()
    own = _own_value(part, mount.subject, mount.env, inner)
    if inner != IDENTITY and not (isinstance(own, Face) and all(signed_axis(row) is not None for row in inner)):
        _turned_in_vain(part, mount)  # a face turns with its part unless it lies along the axes
    own, value = _mounted(ev, own, mount.subject, ONE), _mounted(ev, ev.value(mount.target), mount.target, MINUS)
    origin = moved(ev, value, statement.at)
    out, up = value.out, value.up
    side = triple(row[1] for row in value.rotation)
    rotation = product(columns(times(out, MINUS), times(side, MINUS), up), transpose(own.rotation))
    offset = ev.scalar(statement.gap.value) if statement.gap is not None else ZERO
    if statement.sink is not None:
        offset = E.sub(offset, ev.scalar(statement.sink.value))
    origin = plus(origin, times(out, offset))
    shift = minus(origin, turn(rotation, own.origin))
    if inner != IDENTITY:
        rotation = product(rotation, inner)
        _warn_turned(part, mount, inner, rotation, out)
    return Pose(rotation, shift, ONE)


def _mounted(ev: Evaluator, value: Value, node: ast.Expr, way: E.Expr) -> Frame:
    """One end of a mount as a frame; a line counts as one whose ``out`` runs along it, or against it, and ``up`` along z (x where
    it is vertical)."""
    match value:
        case Frame():
            return value
        case Line(point=point, direction=direction, on=on):
            vertical = abs(direction[2].constant or 0.0) == 1.0
            return Frame(point, frame_of(times(direction, way), unit(0 if vertical else 2)), on)
    message = f"this is {describe(value)}, but a frame (a port or a face) is needed here"
    raise ev.env.context.error(
        "wrong-kind",
        node.span,
        message,
        hint="name a port or a face of the part, or write `frame(at = ..., out = ..., up = ...)`",
    )


def _turned_in_vain(part: Component, mount: Mount) -> None:
    """Refuse `along` and `turned` of a part that a port or two points place: turned or not, it would stand the same."""
    said = [*part.declaration.placements, *(p for o in part.options for p in o.source.placements)]
    said += part.declaration.alternatives[0].placements if part.style is not None else ()
    raise part.context.error(
        "over-determined",
        said[0].span,
        f"`{part.name}` is turned here, but its mount turns with it, so the turn has no effect",
        hint="turn the port in its template, or place the part by a face of its box (`connect lid.back on ...`) and equations",
        notes=((mount.statement.span, "the mount"),),
    )


def _warn_turned(part: Component, mount: Mount, inner: Matrix, turned: Matrix, out: Triple) -> None:
    """Report that a part whose face is mounted comes to lie along another axis than its `along` says; ``out``: of the target."""
    written, found = (signed_axis(triple(row[2] for row in matrix)) for matrix in (inner, turned))
    if written is None or found is None or written[0] == found[0]:
        return
    placements = part.declaration.placements or tuple(p for o in part.options for p in o.source.placements)
    span = placements[0].span if placements else part.span
    meeting = signed_axis(times(out, MINUS))
    there = next((f"`{part.name}.{name}`" for name, axis in FACES.items() if axis == meeting), "the face that meets it")
    part.context.report.warning(
        "turned-again",
        span,
        f"`{part.name}` lies along {'xyz'[found[0]]}, not along {'xyz'[written[0]]}: "
        f"`{mount.subject.span.words}` is turned until it meets the other face",
        hint=f"mount {there}, which meets it as the part lies, or leave the `along` out",
        notes=((mount.statement.span, "the mount"),),
    )


def _own_value(part: Component, subject: ast.Expr, env: Env, rotation: Matrix = IDENTITY) -> Value:
    """The subject of a mount in the part's own frame (its pose is what is sought), turned as the part says."""
    frame = HERE if rotation == IDENTITY else Pose(rotation, (ZERO, ZERO, ZERO), ONE)
    own = Ref(part.name, (Branch(None, ((part, frame),)),), own=True)
    return Evaluator(env, instead={id(path_root(subject)): own}).value(subject)


def moved(ev: Evaluator, frame: Frame, at: ast.Clause[tuple[ast.Argument, ...]] | None) -> Triple:
    """The origin of a target, moved by ``at y = ..., z = ...`` within its plane."""
    given: dict[int, Expr] = {}
    for argument in ast.value_of(at) or ():
        name, node = argument.name, argument.value
        if name in AXES:
            axis = AXES.index(name)
            if frame.out[axis].constant in (1.0, -1.0):
                raise ev.env.context.error(
                    "plane-across-axes",
                    node.span,
                    f"the target faces along {name}, and `at` only moves within its plane",
                    hint=f"give the other two coordinates, and the distance along {name} by `gap` or `sink`",
                )
            given[axis] = ev.scalar(node)
            if all(frame.out[k] is ZERO for k in range(3) if k not in given):
                raise ev.env.context.error(
                    "plane-across-axes",
                    node.span,
                    f"the target is tilted, and what is said before leaves one place along {name} in its plane",
                    hint=f"leave `{name}` out",
                )
        elif not isinstance(ev.env.context.meaning(node), Word):  # `center` is where it is
            way = minus(ev.vector(node), frame.origin)
            return plus(frame.origin, minus(way, times(frame.out, dot(way, frame.out))))
    return _within(frame, given)


def _within(frame: Frame, given: dict[int, Expr]) -> Triple:
    """The point of the plane of a frame that has up to two coordinates given: of those that have, the nearest to its origin."""
    origin, out = frame.origin, frame.out
    if all(out[axis] is ZERO for axis in given):
        return triple(given.get(k, c) for k, c in enumerate(origin))
    far = triple(E.sub(given[k], c) if k in given else ZERO for k, c in enumerate(origin))
    if len(given) == 1:
        (axis,) = given
        share = E.div(far[axis], E.sub(ONE, E.mul(out[axis], out[axis])))
        return plus(origin, times(minus(unit(axis), times(out, out[axis])), share))
    lost = dot(out, far)
    return triple(given.get(k, E.sub(c, E.div(lost, out[k]))) for k, c in enumerate(origin))


def _bridge_pose(part: Component, mount: Mount, ev: Evaluator) -> Pose:
    """``between A and B [facing d] [sink s]``: the pose and the one parameter on which the length of ``ends`` depends."""
    statement = mount.statement
    clause = statement.between
    assert clause is not None
    if part.rotation() != IDENTITY:
        _turned_in_vain(part, mount)
    subject = mount.subject
    line = part.own("ends") if isinstance(subject, ast.NameExpr) else _own_value(part, subject, mount.env)
    if not isinstance(line, Line) or line.to is None:
        raise ev.env.context.error(
            "unknown-port",
            subject.span,
            f"`{part.name}` has no port `ends : line` with two ends, which `between` needs",
            hint="declare it in the template: port ends = line(at = ..., to = ...)",
        )
    sink = ev.scalar(statement.sink.value) if statement.sink is not None else ZERO
    if statement.gap is not None:
        sink = E.sub(sink, ev.scalar(statement.gap.value))
    a, b = _sunk(ev, clause.value, sink)
    x, y, z = map(tidy, minus(b, a))
    outer, inner = (x, y, z), minus(line.to, line.point)
    if all(c is ZERO for c in outer):
        raise ev.env.context.error(
            "illegal-value", clause.span, "the two places are the same", hint="name two places that lie apart"
        )
    distance = norm(outer)
    reach = next((c for c in inner if c is not ZERO), ZERO) if sum(c is not ZERO for c in inner) == 1 else norm(inner)
    mount.env.equations.append(Equation(reach, distance, clause.span, "the distance of the two ends", part.exists))
    along = normalized(outer)
    upright = along[0] is ZERO and along[1] is ZERO  # by construction
    toward = ev.direction(statement.facing.value) if statement.facing is not None else unit(0 if upright else 2)
    own_axis = next((k for k in range(3) if inner[k] is not ZERO), 2)
    own_along = unit(own_axis) if sum(c is not ZERO for c in inner) == 1 else normalized(inner)
    own_toward = unit(0 if own_axis != 0 else 2)
    world, local = _basis(along, toward), _basis(own_along, own_toward)
    rotation = product(world, transpose(local))
    return Pose(rotation, minus(a, turn(rotation, line.point)), ONE)


def _sunk(ev: Evaluator, places: tuple[ast.Expr, ...], sink: E.Expr) -> tuple[Triple, Triple]:
    """The two places, each moved into what it lies on: against ``out`` of a frame, or of the frame whose centre it is; any other
    point lies on nothing, and moves along the line of both."""
    a, b = (ev.vector(node) for node in places)
    if sink is ZERO:
        return a, b
    frames = [_frame_at(ev, node) for node in places]
    away = normalized(minus(b, a)) if None in frames else (ZERO, ZERO, ZERO)
    outs = [d if f is None else f.out for f, d in zip(frames, (away, times(away, MINUS)), strict=True)]
    return minus(a, times(outs[0], sink)), minus(b, times(outs[1], sink))


def _frame_at(ev: Evaluator, node: ast.Expr) -> Frame | None:
    """The frame that an expression is, or is the centre of (``body.left.center``)."""
    value = ev.value(node)
    if not isinstance(value, Frame) and isinstance(node, ast.MemberExpr) and node.name in ("center", "origin"):
        value = ev.value(node.obj)
    return value if isinstance(value, Frame) else None


def _basis(along: Triple, toward: Triple) -> Matrix:
    """Orthonormal columns: along, toward made square to it, and their cross product."""
    square = toward
    if dot(along, toward) is not ZERO:
        square = minus(toward, times(along, dot(along, toward)))
    square = normalized(square)
    return columns(along, square, cross(along, square))


def _circular_place(part: Component) -> Abort:
    """Report a part whose mount leads back to it, with the statements that lead there."""
    waiting = [p for p in part.env.parts if p.seeking]
    others = [p for p in waiting if p is not part]
    via = f", by way of {' and '.join(f'`{p.name}`' for p in others)}" if others else ""
    notes = [(m.statement.span, f"places `{p.name}`") for p in waiting for m in _mounts_of(part.env, declared(p))]
    return part.context.error(
        "circular-definition",
        part.span,
        f"the place of `{part.name}` depends on itself{via}",
        notes=tuple(notes[:4]),
        hint="`to` and `between` take the place from their target: attach one of these parts to something already placed",
    )
