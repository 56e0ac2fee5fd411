"""PyBullet: URDF.

Its loader brakes every joint with a motor; that is taken off, and what is put in its place is the friction that the URDF
states (PyBullet reads it and leaves it to the user to apply, by a velocity motor of so much force). Bullet damps by the velocity
before a step, which leaves 1 - damping * step / inertia of it: nothing if the damping is the inertia by the step, more than
before, the other way, beyond twice that (a cap of 3.6 g with 20 N s/m, 23 times that, goes to and fro past both ends as fast as
its motor can). What is above that is taken down to it.
"""

from __future__ import annotations

import numpy as np
import pybullet

from .levels import Poses
from .subject import G, Subject


class BulletSim:
    name = "PyBullet"
    forms = ("urdf",)
    step_time = 1 / 240
    follows = False

    def __init__(self, subject: Subject, free: bool = False):
        self.subject, self.free = subject, free
        self.client = pybullet.connect(pybullet.DIRECT)
        try:
            pybullet.setGravity(0, 0, -G, physicsClientId=self.client)
            flags = pybullet.URDF_USE_INERTIA_FROM_FILE
            path = str(subject.folder / "object.urdf")
            self.body = pybullet.loadURDF(path, useFixedBase=not free, flags=flags, physicsClientId=self.client)
            if free:
                plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self.client)
                pybullet.createMultiBody(0, plane, physicsClientId=self.client)
            count = range(pybullet.getNumJoints(self.body, physicsClientId=self.client))
            info = [pybullet.getJointInfo(self.body, k, physicsClientId=self.client) for k in count]
            self.index = {row[1].decode(): row[0] for row in info if row[2] != pybullet.JOINT_FIXED}
            self.friction = {row[1].decode(): row[7] for row in info}
            base = pybullet.getBodyInfo(self.body, physicsClientId=self.client)[0].decode()
            self.link = {base: -1} | {row[12].decode(): row[0] for row in info}
            self._bear([row for row in info if row[2] != pybullet.JOINT_FIXED])
        except BaseException:
            self.close()
            raise

    def _bear(self, joints: list[tuple]) -> None:  # type: ignore[type-arg]
        """Take dampings down to what a step can bear; of a row of ``getJointInfo`` 4 is the velocity's place, 6 the damping."""
        if not joints:
            return
        inertia = np.diag(pybullet.calculateMassMatrix(self.body, [0.0] * len(joints), physicsClientId=self.client))
        for row in joints:
            most = inertia[row[4] - (0 if self.free else 6)] / self.step_time
            if row[6] > most:
                pybullet.changeDynamics(self.body, row[0], jointDamping=most, physicsClientId=self.client)

    def links(self) -> set[str]:
        return set(self.link)

    def joints(self) -> set[str]:
        return set(self.index)

    def place(self, values: dict[str, float]) -> None:
        for name, k in self.index.items():
            pybullet.resetJointState(self.body, k, values[name], 0.0, physicsClientId=self.client)
            pybullet.setJointMotorControl2(
                self.body, k, pybullet.VELOCITY_CONTROL, force=self.friction[name], physicsClientId=self.client
            )
        if self.free:
            self._put_base([0, 0, -float(self.subject.low[2])])

    def _put_base(self, place: list[float]) -> None:
        """PyBullet's base is the centre of mass of the root link, in its principal axes."""
        data = pybullet.getDynamicsInfo(self.body, -1, physicsClientId=self.client)
        place, turn = pybullet.multiplyTransforms(place, [0, 0, 0, 1], data[3], data[4])
        pybullet.resetBasePositionAndOrientation(self.body, place, turn, physicsClientId=self.client)
        pybullet.resetBaseVelocity(self.body, [0, 0, 0], [0, 0, 0], physicsClientId=self.client)

    def drive(self, targets: dict[str, float]) -> None:
        for joint in self.subject.moving:
            if joint.name in targets:
                pybullet.setJointMotorControl2(
                    self.body,
                    self.index[joint.name],
                    pybullet.POSITION_CONTROL,
                    targetPosition=targets[joint.name],
                    force=joint.effort,
                    physicsClientId=self.client,
                )

    def step(self) -> None:
        pybullet.stepSimulation(physicsClientId=self.client)

    def value(self, joint: str) -> float:
        return float(pybullet.getJointState(self.body, self.index[joint], physicsClientId=self.client)[0])

    def poses(self) -> Poses:
        found = {}
        for name, k in self.link.items():
            if k < 0:
                place, turn = pybullet.getBasePositionAndOrientation(self.body, physicsClientId=self.client)
                data = pybullet.getDynamicsInfo(self.body, -1, physicsClientId=self.client)
                place, turn = pybullet.multiplyTransforms(place, turn, *pybullet.invertTransform(data[3], data[4]))
            else:
                state = pybullet.getLinkState(self.body, k, computeForwardKinematics=1, physicsClientId=self.client)
                place, turn = state[4], state[5]
            found[name] = np.array(place), np.array(turn)[[3, 0, 1, 2]]
        return found

    def close(self) -> None:
        pybullet.disconnect(self.client)
