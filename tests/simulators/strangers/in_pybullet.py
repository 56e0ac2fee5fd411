"""PyBullet: ``POSITION_CONTROL`` with the effort of the file as its force, default gains; the motors that the loader puts on all
other joints stay on. ``geared``: with collisions between links (``URDF_USE_SELF_COLLISION``) and with a gear for each joint that the
file has follow another, which the loader leaves to its user, as people do for the fingers of grippers."""

from __future__ import annotations

from pathlib import Path

import pybullet

from .moves import SECONDS, Follower, Move, followers, some, start

RATE = 240
LATERAL = {pybullet.JOINT_REVOLUTE, pybullet.JOINT_PRISMATIC}


def drive(path: Path, most: int | None = None, geared: bool = False) -> list[Move]:
    """Every joint that is limited and follows no other, or ``most`` of them, to both ends of its range."""
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
        flags = pybullet.URDF_USE_SELF_COLLISION if geared else 0
        body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=client)
        joints = {}
        for k in range(pybullet.getNumJoints(body, physicsClientId=client)):
            row = pybullet.getJointInfo(body, k, physicsClientId=client)
            if row[2] in LATERAL:
                joints[row[1].decode()] = (k, row[8], row[9], row[10])
        follow = followers(path)
        if geared:
            for follower in follow.values():
                _gear(client, body, joints[follower.joint][0], joints[follower.leader][0], follower.multiplier)
        return _drive(client, body, joints, follow, most)
    finally:
        pybullet.disconnect(client)


def _gear(client: int, body: int, follower: int, leader: int, multiplier: float) -> None:
    pybullet.setJointMotorControl2(body, follower, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=client)
    gear = pybullet.createConstraint(
        body, follower, body, leader, pybullet.JOINT_GEAR, [0, 0, 1], [0, 0, 0], [0, 0, 0], physicsClientId=client
    )
    pybullet.changeConstraint(gear, gearRatio=-multiplier, maxForce=10000, physicsClientId=client)


def _drive(
    client: int,
    body: int,
    joints: dict[str, tuple[int, float, float, float]],
    follow: dict[str, Follower],
    most: int | None,
) -> list[Move]:
    def value(name: str) -> float:
        return float(pybullet.getJointState(body, joints[name][0], physicsClientId=client)[0])

    def hold(name: str, goal: float) -> None:
        number, *_, effort = joints[name]
        pybullet.setJointMotorControl2(
            body, number, pybullet.POSITION_CONTROL, targetPosition=goal, force=effort, physicsClientId=client
        )

    moves = []
    limited = {name: row for name, row in joints.items() if row[1] < row[2]}
    for name in some([name for name in limited if name not in follow], most):
        _, low, high, _ = limited[name]
        for number, first, last, _ in limited.values():
            pybullet.resetJointState(body, number, start(first, last), physicsClientId=client)
        for goal in (low, high):
            hold(name, goal)
            for _ in range(round(SECONDS * RATE)):
                pybullet.stepSimulation(physicsClientId=client)
            lost = [f.lost(value(name), value(f.joint)) for f in follow.values() if f.leader == name]
            moves.append(Move(name, low, high, goal, value(name), max(lost, default=0.0)))
        hold(name, start(low, high))
    return moves
