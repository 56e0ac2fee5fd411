"""What a batch must know of a program: the expressions, each in the scope whose rows want it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..graph.derive import derive
from ..graph.expr import Expr, Scope
from ..graph.formula import row_values
from ..graph.program import LEAD, Joint, Pose, Program
from ..graph.reference import ranks_of

Wanted = tuple[Expr, Scope]


def pose_cells(pose: Pose) -> list[Expr]:
    """The 13 scalars of a pose: rotation by rows, translation, mirror."""
    return [*(cell for row in pose.rotation for cell in row), *pose.translation, pose.mirror]


def find_wanted(program: Program) -> Iterator[Wanted]:
    """Everything that tables, loops, labels, grasps, keypoints and repairs read."""
    yield from narrowing_of(program)
    for site in program.sites:
        yield from _each(site.scope, site.parameters, pose_cells(site.pose), (p for _, p in site.materials))
    for part in program.parts:
        words = (p for _, p in part.semantic)
        yield from _each(part.scope, pose_cells(part.pose), part.low, part.high, words, part.symmetry or ())
        yield from ranks_of(part.link)
        yield from ranks_of(part.holder)
    yield from motion_of(program)
    for label in program.labels:
        inputs = row_values(label.formulas)
        for target in label.targets:
            scope = program.sites[target.site].scope
            yield from _each(scope, pose_cells(target.frame), target.size, target.center, inputs)
    for grasp in program.grasps:
        inputs = row_values(grasp.formulas)
        yield from _each(
            grasp.scope, pose_cells(grasp.frame), grasp.size, grasp.center, (grasp.low, grasp.high), inputs
        )
        yield from ranks_of(grasp.link)
    for keypoint in program.keypoints:
        yield from _each(keypoint.scope, keypoint.point)
        yield from ranks_of(keypoint.link)


def motion_of(program: Program) -> Iterator[Wanted]:
    """What links, closed loops and joints read."""
    for link in program.links:
        if link.part >= 0 and link.scope.within(program.parts[link.part].scope):
            yield from _each(link.scope, pose_cells(program.parts[link.part].pose))
    for closure in program.closures:
        yield from _each(closure.scope, *closure.points)
        for side in closure.links:
            yield from ranks_of(side)
    for joint in program.joints:
        yield from _each(joint.scope, joint.origin, joint.axis, (p for p in joint.values if p is not None))
        yield from ranks_of(joint.parent)
        if joint.mimic is not None:
            yield from _each(joint.scope, joint.mimic[1:], row_values(following(joint)))
            yield from ranks_of(joint.mimic[0])
        for gate in joint.gates:
            yield from _each(joint.scope, (end for end in (gate.low, gate.high) if end is not None))
            yield from ranks_of(gate.joint)


def axes_of(program: Program) -> Iterator[Wanted]:
    """What tells which links joints move, and how."""
    for joint in program.joints:
        yield from _each(joint.scope, joint.origin, joint.axis)
        yield from ranks_of(joint.parent)


def following(joint: Joint) -> list[Expr]:
    """The formula by which a joint follows another, and its derivative by the value of that."""
    return [] if joint.curve is None else [joint.curve, derive(joint.curve, LEAD)]


def narrowing_of(program: Program) -> Iterator[Wanted]:
    """The domain and the bounds of each draw."""
    for draw in program.draws:
        ends = (end for end in (draw.low, draw.high) if end is not None)
        bounds = (e for bound in draw.bounds for e in (bound.value, bound.guard))
        unions = (e for union in draw.unions for e in (union.guard, *(end for pair in union.intervals for end in pair)))
        yield from _each(draw.column.scope, ends, bounds, unions, (limit.allowed for limit in draw.limits))


def _each(scope: Scope, *groups: Iterable[Expr]) -> Iterator[Wanted]:
    for group in groups:
        for expr in group:
            yield expr, scope
