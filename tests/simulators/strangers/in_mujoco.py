"""MuJoCo: a ``position`` actuator on one joint, critically damped by ``dampratio``.

Its stiffness is what brings the joint's whole effort to bear within 1 % of its range (``actuatorfrcrange``, else 100 N or
N m), or ``constant``: that which ManiSkill gives its robots. The other joints are left to themselves.
"""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from .moves import SECONDS, SLID, STEADY, TURNED, Move, some

HINGE, SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
TIE, POINT = int(mujoco.mjtEq.mjEQ_JOINT), int(mujoco.mjtEq.mjEQ_CONNECT)
STRENGTH, NEAR = 100.0, 0.01
STIFFNESS, DAMPING = 1000.0, 100.0


def drive(path: Path, most: int | None = None, constant: bool = False) -> list[Move]:
    """Every joint that is limited and follows no other, or ``most`` of them, to both ends of its range."""
    model = mujoco.MjSpec.from_file(str(path)).compile()
    led = {int(model.eq_obj1id[e]) for e in range(model.neq) if model.eq_type[e] == TIE}
    free = [
        model.joint(joint).name
        for joint in range(model.njnt)
        if joint not in led and model.jnt_limited[joint] and model.jnt_type[joint] in (HINGE, SLIDE)
    ]
    return [move for name in some(free, most) for move in _there_and_back(path, name, constant)]


def _there_and_back(path: Path, name: str, constant: bool) -> list[Move]:
    spec = mujoco.MjSpec.from_file(str(path))
    low, high = (float(end) for end in spec.joint(name).range)
    effort = float(spec.joint(name).actfrcrange[1]) or STRENGTH
    actuator = spec.add_actuator(name="driver", target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    if constant:
        actuator.set_to_position(kp=STIFFNESS, kv=DAMPING)
        actuator.forcerange = [-STRENGTH, STRENGTH]
    else:
        actuator.set_to_position(kp=effort / (NEAR * (high - low)), dampratio=1.0)
        actuator.forcerange = [-effort, effort]
    actuator.forcelimited = True
    model = spec.compile()
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    moves = []
    for goal in (low, high):
        data.ctrl[0], steady = goal, 0
        for _ in range(round(SECONDS / model.opt.timestep)):
            mujoco.mj_step(model, data)
            steady = steady + 1 if abs(data.joint(name).qpos[0] - goal) <= NEAR * (high - low) else 0
            if steady * model.opt.timestep > STEADY:
                break
        moves.append(Move(name, low, high, goal, float(data.joint(name).qpos[0]), _lost(model, data)))
    return moves


def _lost(model: mujoco.MjModel, data: mujoco.MjData) -> float:
    """By how much the worst equality is off: joints that follow, points that stay together."""
    mujoco.mj_forward(model, data)
    worst = 0.0
    for e in range(model.neq):
        one, other = int(model.eq_obj1id[e]), int(model.eq_obj2id[e])
        if model.eq_type[e] == TIE:
            follower, leader = (data.qpos[model.jnt_qposadr[j]] for j in (one, other))
            off = abs(follower - np.polyval(model.eq_data[e][:5][::-1], leader))
            worst = max(worst, float(off) / (SLID if model.jnt_type[one] == SLIDE else TURNED))
        elif model.eq_type[e] == POINT:
            worst = max(worst, float(np.linalg.norm(data.site_xpos[one] - data.site_xpos[other])) / SLID)
    return worst
