"""MuJoCo: MJCF, and URDF with what that cannot state."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from .levels import Poses
from .subject import Subject

BANDWIDTH = 150.0  # 1/s of the drives; gains are scaled to the inertia that a joint moves


def settle(spec: mujoco.MjSpec, srdf: Path) -> None:
    """What URDF cannot state and MuJoCo's defaults are too soft for: docs/formats.md, URDF."""
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for joint in spec.joints:
        joint.armature = 0.01 if joint.type == mujoco.mjtJoint.mjJNT_SLIDE else 1e-4
        joint.solref_limit = joint.solref_friction = [0.004, 1]
        joint.solimp_limit = [0.99, 0.999, 0.001, 0.5, 2]
        joint.solimp_friction = [0.999, 0.999, 0.001, 0.5, 2]
    for geom in spec.geoms:
        geom.solref = [0.004, 1]
    for equality in spec.equalities:
        equality.solref, equality.solimp = [0.004, 1], [0.999, 0.9999, 0.001, 0.5, 2]
    for pair in ElementTree.parse(srdf).getroot() if srdf.exists() else []:
        spec.add_exclude(bodyname1=pair.get("link1"), bodyname2=pair.get("link2"))


class MujocoSim:
    name = "MuJoCo"
    forms = ("mjcf", "urdf")
    follows = True

    def __init__(self, subject: Subject, free: bool = False):
        self.subject, self.free = subject, free
        if subject.form == "mjcf":
            self.model = mujoco.MjModel.from_xml_path(
                str(subject.folder / ("scene_free.xml" if free else "object.xml"))
            )
        else:
            spec = mujoco.MjSpec.from_file(str(subject.folder / "object.urdf"))
            settle(spec, subject.folder / "object.srdf")
            if free:
                spec.worldbody.first_body().add_freejoint()
                spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05])
            self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.step_time = float(self.model.opt.timestep)
        self.targets: dict[str, float] = {}

    def links(self) -> set[str]:
        return {self.model.body(i).name for i in range(self.model.nbody)}

    def joints(self) -> set[str]:
        return {self.model.joint(i).name for i in range(self.model.njnt)}

    def place(self, values: dict[str, float]) -> None:
        self.targets = {}
        mujoco.mj_resetData(self.model, self.data)
        for joint in self.subject.moving:
            if joint.kind != "ball":
                self.data.joint(joint.name).qpos[0] = values[joint.name]
            if joint.kind == "screw":
                self.data.joint(f"{joint.name}_advance").qpos[0] = values[joint.name] * joint.pitch / (2 * np.pi)
        if self.free:
            self.data.qpos[2] = -self.subject.low[2]
        mujoco.mj_forward(self.model, self.data)

    def drive(self, targets: dict[str, float]) -> None:
        self.targets = targets

    def step(self) -> None:
        for name, target in self.targets.items():
            self._push(name, target)
        mujoco.mj_step(self.model, self.data)

    def _push(self, name: str, target: float) -> None:
        """A drive: gravity and springs made up for, a critically damped pull to the target, and what friction takes away."""
        model, data = self.model, self.data
        joint = next(j for j in self.subject.moving if j.name == name)
        drag = sum(j.friction for j in self.subject.moving if j is joint or (j.mimic and j.mimic[0] == name))
        dof = int(model.joint(name).dofadr[0])
        moved, unit = np.zeros(model.nv), np.zeros(model.nv)
        unit[dof] = 1.0
        for other in self.subject.moving:  # it moves what follows it, too
            if other.mimic and other.mimic[0] == name:
                unit[int(model.joint(other.name).dofadr[0])] = other.mimic[1]
        mujoco.mj_mulM(model, data, moved, unit)
        error = target - data.joint(name).qpos[0]
        pull = (unit @ moved) * (BANDWIDTH**2 * error - 2 * BANDWIDTH * data.qvel[dof])
        near = 0.005 * (joint.high - joint.low)
        force = unit @ (data.qfrc_bias - data.qfrc_spring) + pull + drag * np.clip(error / near, -1, 1)
        data.qfrc_applied[dof] = np.clip(force, -joint.effort, joint.effort)

    def value(self, joint: str) -> float:
        return float(self.data.joint(joint).qpos[0])

    def poses(self) -> Poses:
        mujoco.mj_kinematics(self.model, self.data)
        bodies = [self.data.body(link.name) for link in self.subject.robot.links]
        return {body.name: (body.xpos.copy(), body.xquat.copy()) for body in bodies}

    def close(self) -> None:
        pass
