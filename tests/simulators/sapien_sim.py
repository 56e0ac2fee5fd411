"""SAPIEN on the CPU, which reads what is to be seen only where it can render: the URDF without it.

Its loader drops a joint's friction and effort; both are given to the drives here.
"""

from __future__ import annotations

import warnings

import numpy as np

from artipg_dsl.robot.model import RobotJoint

from .levels import Poses
from .subject import Subject

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # it looks for a renderer when it is imported
    import sapien
    from sapien import physx

BANDWIDTH = 30.0  # 1/s of the drives
ITERATIONS = 60  # of the solver: with ten, hinges that hang on one another creep against their friction
BRISTLE = 1e-4  # rad or m by which a joint gives before its friction slips: P. R. Dahl, A Solid Friction Model, 1968


def _scene() -> sapien.Scene:
    """Without contacts that persist: between small pieces some are several millimetres deep where nothing touches."""
    config = physx.get_scene_config()
    persistent = config.enable_pcm
    config.enable_pcm = False
    physx.set_scene_config(config)
    try:
        return sapien.Scene([physx.PhysxCpuSystem()])
    finally:
        config.enable_pcm = persistent
        physx.set_scene_config(config)


class SapienSim:
    name = "SAPIEN"
    forms = ("urdf",)
    follows = False

    def __init__(self, subject: Subject, free: bool = False):
        self.subject, self.free = subject, free
        self.scene = _scene()
        self.step_time = float(self.scene.get_timestep())
        if free:
            self.scene.add_ground(0.0, render=False)
        loader = self.scene.create_urdf_loader()
        loader.fix_root_link = not free
        (builder,), _, _ = loader.parse(str(subject.folder / "object_physics.urdf"))
        self.articulation = builder.build(build_mimic_joints=False)  # its ties take the inverse of a ratio
        self.articulation.set_solver_position_iterations(ITERATIONS)
        found = self.articulation.active_joints
        self.joint = {joint.name: joint for joint in found}
        self.order = [joint.name for joint in found]
        self.held: dict[str, float] = {}

    def links(self) -> set[str]:
        return {link.name for link in self.articulation.links}

    def joints(self) -> set[str]:
        return set(self.joint)

    def place(self, values: dict[str, float]) -> None:
        base = sapien.Pose([0, 0, -float(self.subject.low[2])] if self.free else [0, 0, 0])
        self.articulation.set_qpos([values[name] for name in self.order])
        self.articulation.set_qvel(np.zeros(len(self.order)))
        if self.free:
            self.articulation.set_root_pose(base)
            self.articulation.set_root_linear_velocity([0, 0, 0])
            self.articulation.set_root_angular_velocity([0, 0, 0])
        self.held = {}
        for joint in self.subject.moving:
            self._brake(joint)

    def _brake(self, joint: RobotJoint) -> None:
        """The stated friction: a drive that holds the joint where it is, with no more force than that."""
        moved, value = self.joint[joint.name], self.value(joint.name)
        moved.set_friction(0.0)
        if joint.friction > 0:
            self.held[joint.name] = value
            stiff = joint.friction / BRISTLE
            moved.set_drive_properties(stiff, stiff * self.step_time, force_limit=joint.friction, mode="force")
        else:
            moved.set_drive_properties(0.0, joint.damping, mode="force")
        moved.set_drive_target(value)

    def drive(self, targets: dict[str, float]) -> None:
        for joint in self.subject.moving:
            if joint.name in targets:
                inertia = self.subject.inertia(joint, self.subject.rest)
                span = 1.0 if joint.low is None or joint.high is None else joint.high - joint.low
                stiff, damped = inertia * BANDWIDTH**2 + joint.effort / (0.01 * span), 2 * inertia * BANDWIDTH
                self.held.pop(joint.name, None)
                moved = self.joint[joint.name]
                moved.set_drive_properties(stiff, damped, force_limit=joint.effort, mode="force")
                moved.set_drive_target(targets[joint.name])

    def step(self) -> None:
        now = dict(zip(self.order, self.articulation.get_qpos().tolist(), strict=True)) if self.held else {}
        for name, place in self.held.items():  # what slips is held where it has come to
            value = now[name]
            if abs(place - value) > BRISTLE:
                self.held[name] = value + BRISTLE * (1.0 if place > value else -1.0)
                self.joint[name].set_drive_target(self.held[name])
        self.scene.step()

    def value(self, joint: str) -> float:
        return float(self.articulation.get_qpos()[self.order.index(joint)])

    def poses(self) -> Poses:
        found = {link.name: link.get_entity_pose() for link in self.articulation.links}
        return {name: (np.asarray(pose.p, np.float64), np.asarray(pose.q, np.float64)) for name, pose in found.items()}

    def close(self) -> None:
        pass
