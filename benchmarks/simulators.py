"""What simulators make of exported objects, level by level: ``python benchmarks/simulators.py [-n OBJECTS] [CATEGORY ...]``.

Levels, each of every object: *loads* with all links and joints; the first *step* is finite; one second at *rest* drifts
by less than 1 mm and 0.1 degree; every joint (at most ``--joints`` of an object, spread over it) is *driven* under
gravity, within its effort, to both ends within 2 % of its range. A failure is told with what failed.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import mujoco
import numpy as np

from artipg_dsl.export.mjcf import mjcf_files
from artipg_dsl.export.robot import Robot, Robots
from artipg_dsl.export.urdf import urdf_files
from artipg_dsl.session import Session

ROOT = Path(__file__).parents[1]
LEVELS = ("loads", "step", "rest", "driven")
DRIVE = 150.0  # 1/s: the bandwidth of the drives; gains are scaled to the inertia that a joint moves


def load(robot: Robot, form: str) -> mujoco.MjModel:
    """The model of a robot with a fixed base, through MJCF or URDF."""
    files = mjcf_files(robot) if form == "mjcf" else urdf_files(robot)
    model = mujoco.MjModel.from_xml_string(files["object.xml" if form == "mjcf" else "object.urdf"].decode(), files)
    names = {model.body(i).name for i in range(model.nbody)}
    missing = [link.name for link in robot.links if link.name not in names]
    missing += [j.name for j in robot.joints if j.kind != "fixed" and mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, j.name) < 0]
    if missing:
        raise ValueError(f"without {', '.join(missing)}")
    return model


def at_rest(model: mujoco.MjModel, robot: Robot) -> mujoco.MjData:
    data = mujoco.MjData(model)
    for joint in robot.joints:
        if joint.kind not in ("fixed", "ball"):
            data.joint(joint.name).qpos[0] = joint.rest
    mujoco.mj_forward(model, data)
    return data


def levels(model: mujoco.MjModel, robot: Robot, most: int) -> dict[str, str]:
    """What failed at each level after loading; empty where nothing did."""
    data = at_rest(model, robot)
    mujoco.mj_step(model, data)
    found = {"step": "" if np.isfinite(data.qacc).all() else "not finite"}
    data = at_rest(model, robot)
    places, turns = data.xpos.copy(), data.xquat.copy()
    for _ in range(round(1.0 / model.opt.timestep)):
        mujoco.mj_step(model, data)
    mujoco.mj_kinematics(model, data)
    shift = np.linalg.norm(data.xpos - places, axis=1).max()
    angle = 2 * np.degrees(np.arccos(np.clip(np.abs((data.xquat * turns).sum(axis=1)), 0, 1))).max()
    found["rest"] = "" if shift < 1e-3 and angle < 0.1 else f"{1000 * shift:.1f} mm, {angle:.2f} degrees"
    limited = [j for j in robot.joints if j.low is not None and j.high is not None and j.kind != "ball" and j.mimic is None]
    chosen = limited[:: max(1, -(-len(limited) // most))]
    found["driven"] = "; ".join(text for joint in chosen if (text := driven(model, robot, joint.name)))
    return found


def driven(model: mujoco.MjModel, robot: Robot, name: str) -> str:
    joint = next(j for j in robot.joints if j.name == name)
    drag = sum(j.friction for j in robot.joints if j is joint or (j.mimic and j.mimic[0] == name))  # what it has to overcome
    near = 0.005 * (joint.high - joint.low)
    dof, missed = int(model.joint(name).dofadr[0]), []
    for end in (joint.high, joint.low):
        data = at_rest(model, robot)
        moved, unit = np.zeros(model.nv), np.zeros(model.nv)
        unit[dof] = 1.0
        mujoco.mj_mulM(model, data, moved, unit)
        for _ in range(round(2.0 / model.opt.timestep)):
            error = end - data.joint(name).qpos[0]
            force = moved[dof] * (DRIVE**2 * error - 2 * DRIVE * data.qvel[dof]) + drag * np.clip(error / near, -1, 1)
            data.qfrc_applied[dof] = np.clip(data.qfrc_bias[dof] + force, -joint.effort, joint.effort)
            mujoco.mj_step(model, data)
        if not abs(data.joint(name).qpos[0] - end) <= 0.02 * (joint.high - joint.low):
            missed.append(f"{name} at {data.joint(name).qpos[0]:.4g} of {end:.4g}")
    return ", ".join(missed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("categories", nargs="*", default=sorted(p.stem for p in (ROOT / "categories").glob("*.apg")))
    parser.add_argument("-n", type=int, default=2, help="objects of each category")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--joints", type=int, default=6, help="driven joints of an object")
    arguments = parser.parse_args()
    passed = {(form, level): 0 for form in ("mjcf", "urdf") for level in LEVELS}
    count = 0
    for category in arguments.categories:
        path = str(ROOT / "categories" / f"{category}.apg")
        robots = Robots(Session.of(path).sampler.batch(np.arange(arguments.n), arguments.seed))
        for i in range(arguments.n):
            robot, count = robots.robot(i), count + 1
            for form in ("mjcf", "urdf"):
                try:
                    model = load(robot, form)
                except ValueError as error:
                    print(f"{robot.name} {form}: loads: {error}")
                    continue
                found = {"loads": ""} | levels(model, robot, arguments.joints)
                for level, text in found.items():
                    passed[form, level] += not text
                    print(f"{robot.name} {form}: {level}: {text}") if text else None
    print(f"MuJoCo {mujoco.__version__}, {count} objects\n| form | {' | '.join(LEVELS)} |\n|---|{'---|' * len(LEVELS)}")
    for form in ("mjcf", "urdf"):
        print(f"| {form} | {' | '.join(f'{100 * passed[form, level] / count:.0f} %' for level in LEVELS)} |")


if __name__ == "__main__":
    main()
