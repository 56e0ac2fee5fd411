"""SAPIEN: drives with the gains that ManiSkill gives its robots and, as its controllers have it, no joint friction; gravity made
up for as SAPIEN's own lessons do it, the other joints left to themselves. Loaded with ``load``, without a renderer."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from .moves import SECONDS, Move, followers, some, start

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it looks for a renderer when it is imported
    import sapien
    from sapien import physx

STIFFNESS, DAMPING, FORCE = 1000.0, 100.0, 100.0
RATE = 240


def drive(path: Path, most: int | None = None) -> list[Move]:
    """Every joint that is limited and follows no other, or ``most`` of them, to both ends of its range."""
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    scene.set_timestep(1 / RATE)
    loader = scene.create_urdf_loader()
    loader.fix_root_link = True
    thing = loader.load(str(path))
    names = [joint.name for joint in thing.active_joints]
    ends = [tuple(map(float, joint.limits[0])) for joint in thing.active_joints]
    rest = [start(*pair) for pair in ends]
    follow = followers(path)
    moves = []
    free = [name for name, pair in zip(names, ends, strict=True) if name not in follow and np.isfinite(pair).all()]
    for name in some(free, most):
        k = names.index(name)
        joint, (low, high) = thing.active_joints[k], ends[k]
        thing.set_qpos(rest)
        thing.set_qvel(np.zeros(len(rest)))
        joint.set_drive_properties(STIFFNESS, DAMPING, force_limit=FORCE, mode="force")
        joint.set_friction(0.0)
        for goal in (low, high):
            joint.set_drive_target(goal)
            for _ in range(round(SECONDS * RATE)):
                thing.set_qf(thing.compute_passive_force(gravity=True, coriolis_and_centrifugal=True))
                scene.step()
            at = thing.get_qpos()
            lost = [f.lost(at[k], at[names.index(f.joint)]) for f in follow.values() if f.leader == joint.name]
            moves.append(Move(joint.name, low, high, goal, float(at[k]), max(lost, default=0.0)))
        joint.set_drive_properties(0.0, 0.0)
    return moves
