"""A program whose objects lie turned about the vertical by quarter turns, and the same of everything else.

Formulas, sizes and draws are in frames of parts, which lie in the object as before. Quarter turns swap coordinates and
change signs, so nothing is rounded.
"""

from __future__ import annotations

from dataclasses import replace

from . import expr as E
from .program import Pose, Program, Triple


def turn(program: Program, quarters: int) -> Program:
    """The program, its objects turned from x towards y so many times. It keeps its hash: what is bound to its parts fits these, too."""
    made = program
    for _ in range(quarters % 4):
        made = _turned(made)
    return made


def _turned(program: Program) -> Program:
    return replace(
        program,
        parts=[replace(part, pose=_pose(part.pose)) for part in program.parts],
        sites=[replace(site, pose=_pose(site.pose)) for site in program.sites],
        joints=[replace(joint, origin=_vector(joint.origin), axis=_vector(joint.axis)) for joint in program.joints],
        labels=[
            replace(label, targets=tuple(replace(target, frame=_pose(target.frame)) for target in label.targets))
            for label in program.labels
        ],
        grasps=[replace(grasp, frame=_pose(grasp.frame)) for grasp in program.grasps],
        keypoints=[replace(keypoint, point=_vector(keypoint.point)) for keypoint in program.keypoints],
        closures=[
            replace(closure, points=(_vector(closure.points[0]), _vector(closure.points[1])))
            for closure in program.closures
        ],
    )


def _vector(vector: Triple) -> Triple:
    x, y, z = vector
    return E.neg(y), x, z


def _pose(pose: Pose) -> Pose:
    x, y, z = pose.rotation
    return replace(
        pose, rotation=((E.neg(y[0]), E.neg(y[1]), E.neg(y[2])), x, z), translation=_vector(pose.translation)
    )
