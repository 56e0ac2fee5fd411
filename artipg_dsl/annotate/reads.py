"""What annotation reads of a program: every expression it will ask a batch for, known before anything is evaluated."""

from __future__ import annotations

from collections.abc import Iterator

from ..graph.expr import Expr, Scope
from ..graph.program import Pose, Program
from .fields import Field


def reads(program: Program) -> Iterator[tuple[Expr, Scope]]:
    """Expressions with the scope in whose rows they are read: for labels, grasps, keypoints and materials."""
    for label in program.labels:
        inputs = Field([label.value]).inputs
        for target in label.targets:
            scope = program.sites[target.site].scope
            for expr in (*inputs, *cells(target.frame), *target.size, *target.center):
                yield expr, scope
    for grasp in program.grasps:
        formulas = Field([*grasp.at, *grasp.approach, *grasp.close, grasp.opening, grasp.quality])
        own = (grasp.low, grasp.high, *cells(grasp.frame), *grasp.size, *grasp.center)
        for expr in (*own, *formulas.inputs):
            yield expr, grasp.scope
    for keypoint in program.keypoints:
        for expr in keypoint.point:
            yield expr, keypoint.scope
    for site in program.sites:
        for _, predicate in site.materials:
            yield predicate, site.scope


def cells(pose: Pose) -> list[Expr]:
    """The thirteen scalars of a pose in the order in which ``fields.read_pose`` asks for them."""
    return [cell for row in pose.rotation for cell in row] + [*pose.translation, pose.mirror]
