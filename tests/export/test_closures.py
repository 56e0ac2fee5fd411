"""Where loops close: MuJoCo and USD keep the points together, and so the object moves as its program says."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.export.mjcf import mjcf_files, qpos
from artipg_dsl.export.usd import usd_files
from artipg_dsl.robot.pose import link_poses, rest_values
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session

# a slider crank: crank of 3 cm about the origin, rod of 10 cm, a block that slides along x
CRANK = """apg 1
use primitives { Cuboid }
category Crank {
  root part frame_block : Cuboid(size = [2cm, 2cm, 2cm])
  part crank : Cuboid(size = [3cm, 5mm, 5mm])
  joint turn : revolute frame_block -> crank about line(at = [0, 2cm, 0], along = -y) range 0deg .. 300deg
  align crank.back = 0
  align crank.center.y = 2cm
  align crank.center.z = 0
  part rod : Cuboid(size = [10cm, 5mm, 5mm])
  joint knee : revolute crank -> rod about line(at = [3cm, 3cm, 0], along = -y) range -400deg .. 400deg
  align rod.back = 3cm
  align rod.center.y = 3cm
  align rod.center.z = 0
  part block : Cuboid(size = [1cm, 5mm, 1cm])
  joint slide : prismatic frame_block -> block along x range -20cm .. 20cm
  align block.center = [13cm, 4cm, 0]
  close line(at = rod.front.center, along = y) on line(at = block.center, along = y)
}
"""
ANGLE = 1.2


@pytest.fixture(scope="module")
def robots() -> Robots:
    return Robots(Session.of_text(CRANK).sampler.batch(np.arange(2), 0))


def test_the_points_of_a_closure_meet_at_rest_and_in_settled_states(robots: Robots) -> None:
    robot, batch = robots.robot(1), robots.batch
    (closure,) = robot.closures
    joints = batch.joints()
    states = np.where([name == "turn" for name in joints.name], ANGLE, batch.rest())
    settled = dict(zip(joints.name[3:], batch.settle(states)[3:].tolist(), strict=True))
    assert settled["turn"] == ANGLE and abs(settled["slide"]) > 0.01
    for values in (rest_values(robot), settled):
        poses = link_poses(robot, values)
        one, other = (poses[k][0] @ point + poses[k][1] for k, point in zip(closure.links, closure.points, strict=True))
        assert one == pytest.approx(other, abs=1e-9)


def test_mujoco_turns_the_crank_and_the_block_follows(robots: Robots) -> None:
    mujoco = pytest.importorskip("mujoco")
    files = mjcf_files(robots.robot(0))
    spec = mujoco.MjSpec.from_string(
        files["object.xml"].decode(), assets={k: v for k, v in files.items() if k.endswith(".obj")}
    )
    spec.option.gravity = [0, 0, 0]
    drive = spec.add_actuator(name="turn", target="turn", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    drive.set_to_position(kp=20.0, dampratio=1.0)
    model = spec.compile()
    assert model.neq == 1 and model.eq_type[0] == mujoco.mjtEq.mjEQ_CONNECT
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("rest").id)
    for step in range(2000):
        data.ctrl[0] = ANGLE * min(step / 1000, 1.0)
        mujoco.mj_step(model, data)
    angle = float(data.joint("turn").qpos[0])
    assert angle == pytest.approx(ANGLE, abs=0.02)
    expected = 0.03 * np.cos(angle) + np.sqrt(0.10**2 - (0.03 * np.sin(angle)) ** 2) - 0.13
    assert float(data.joint("slide").qpos[0]) == pytest.approx(expected, abs=2e-4)


def test_a_rack_hangs_together_in_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco")
    robot = Robots(Session.of("Foldingrack").sampler.batch(np.arange(1), 1)).robot(0)
    files = mjcf_files(robot)
    model = mujoco.MjModel.from_xml_string(
        files["object.xml"].decode(), {k: v for k, v in files.items() if k.endswith(".obj")}
    )
    order = [model.joint(k).name for k in range(model.njnt)]
    assert robot.closures and model.key("rest").qpos == pytest.approx(qpos(robot, rest_values(robot), order), abs=1e-9)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for _ in range(300):
        mujoco.mj_step(model, data)
    for n in range(len(robot.closures)):
        apart = data.site(f"closure_{n}_a").xpos - data.site(f"closure_{n}_b").xpos
        assert np.abs(apart).max() < 5e-4


def test_usd_has_a_joint_outside_the_articulation(robots: Robots) -> None:
    pxr = pytest.importorskip("pxr")
    from pxr import Usd, UsdPhysics  # noqa: F401

    layer = pxr.Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(usd_files(robots, 0)["object.usda"].decode())
    stage = Usd.Stage.Open(layer)
    robot = robots.robot(0)
    (prim,) = [p for p in stage.Traverse() if p.GetName().startswith("closure_")]
    joint = UsdPhysics.SphericalJoint(prim)
    assert joint.GetExcludeFromArticulationAttr().Get() is True
    (closure,) = robot.closures
    for k, point, body, local in zip(
        closure.links,
        closure.points,
        (joint.GetBody0Rel(), joint.GetBody1Rel()),
        (joint.GetLocalPos0Attr(), joint.GetLocalPos1Attr()),
        strict=True,
    ):
        assert [p.name for p in body.GetTargets()] == [robot.links[k].name]
        assert np.array(local.Get()) == pytest.approx(point, abs=1e-6)
