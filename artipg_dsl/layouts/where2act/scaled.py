"""A robot in another unit of length, for simulators with lengths of their own: what they round off is then small beside the object.

Density and time stay, so all else follows: kilograms grow by the third power of lengths, newton by the fourth, newton metres and moments
of inertia by the fifth. What is seen is left out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...robot.model import Robot, RobotJoint, RobotLink
from ...robot.primitives import Collider


def scaled(robot: Robot, unit: float) -> Robot:
    """The same robot of hinges, slides and fixed joints, where ``unit`` metres are 1."""
    per = 1.0 / unit
    long = {joint.name: value_scale(joint, unit) for joint in robot.joints}
    return replace(
        robot,
        links=tuple(_link(link, per) for link in robot.links),
        joints=tuple(_joint(joint, per, long) for joint in robot.joints),
    )


def value_scale(joint: RobotJoint, unit: float) -> float:
    """What 1 of a joint's value becomes."""
    return 1.0 / unit if joint.traits.slides else 1.0


def resistance_scale(joint: RobotJoint, unit: float) -> float:
    """What 1 kg, N s/m and N/m at a joint become, or 1 kg m2 and so on of one that turns."""
    return (1.0 / unit) ** (3 if joint.traits.slides else 5)


def _link(link: RobotLink, per: float) -> RobotLink:
    return replace(
        link,
        origin=link.origin * per,
        mass=link.mass * per**3,
        center=link.center * per,
        inertia=link.inertia * per**5,
        visuals=(),
        colliders=tuple(_collider(collider, per) for collider in link.colliders),
    )


def _collider(collider: Collider, per: float) -> Collider:
    size, bar, hull = collider.size, collider.bar, collider.hull
    return replace(
        collider,
        center=collider.center * per,
        size=size and (size[0] * per, size[1] * per, size[2] * per),
        bar=bar and replace(bar, radius=bar.radius * per, length=bar.length * per),
        hull=hull and replace(hull, vertices=np.asarray(hull.vertices) * per),
    )


def _joint(joint: RobotJoint, per: float, long: dict[str, float]) -> RobotJoint:
    own, heavy = long[joint.name], resistance_scale(joint, 1.0 / per)
    mimic, curve = joint.mimic, joint.curve
    if mimic is not None:
        mimic = mimic[0], mimic[1] * own / long[mimic[0]], mimic[2] * own
        curve = curve and (curve[0] * long[mimic[0]], curve[1] * own)
    return replace(
        joint,
        origin=joint.origin * per,
        low=None if joint.low is None else joint.low * own,
        high=None if joint.high is None else joint.high * own,
        rest=joint.rest * own,
        effort=joint.effort * heavy * own,
        velocity=joint.velocity * own,
        damping=joint.damping * heavy,
        friction=joint.friction * heavy * own,
        armature=joint.armature * heavy,
        stiffness=joint.stiffness * heavy,
        mimic=mimic,
        curve=curve,
        gates=tuple((name, low * long[name], high * long[name]) for name, low, high in joint.gates),
    )
