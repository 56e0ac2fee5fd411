"""Joints that a spring draws back to their rest: what files say of them, and that they return in a simulator."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.export.mjcf import mjcf_files
from artipg_dsl.export.sdf import sdf_files
from artipg_dsl.export.usd import usd_files
from artipg_dsl.robot.dynamics import GRAVITY
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.robots import Robots
from artipg_dsl.robot.substitute import ADVANCE, simple_joints
from artipg_dsl.session import Session

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install 'artipg_dsl[sim]'")
pytest.importorskip("pxr", reason="usd-core is not installed")
from pxr import Usd, UsdPhysics  # noqa: E402

TEXT = """
apg 1
use primitives { Cuboid, Cylinder }
category Panel {
  param stiffness : length in 1cm .. 2cm          # the word is a name elsewhere
  root part body : Cuboid(size = [20cm, 30cm, 20cm])
  part key : Cuboid(size = [1cm, 3cm, stiffness])
  align key.back = body.front + 9mm
  joint press : prismatic body -> key along -x range 0mm .. 3mm stiffness 2000N/m
  part lever : Cuboid(size = [6cm, 2cm, 1cm])
  align lever.back = body.front + 9mm
  align lever.center.y = 8cm
  joint work : revolute body -> lever about lever.back.bottom range -10deg .. 10deg rest 4deg stiffness 2Nm/rad
  part nut : Cylinder(radius = 1cm, height = 2cm)
  joint drive : screw body.bottom -> nut.top gap 1mm range 0turn .. 3turn pitch 2mm stiffness 0.1N*m/rad
  part flag : Cuboid(size = [1cm, 1cm, 1cm])
  align flag.right = body.left + 1cm
  joint show : prismatic body -> flag along z range 0mm .. 30mm friction 0.0001N mimic 10 * press
  part plain : Cuboid(size = [1cm, 1cm, 1cm])
  align plain.front = body.back - 1cm
  joint slide : prismatic body -> plain along y range 0cm .. 5cm
}
"""
SPRUNG = {"press": 2000.0, "work": 2.0, "drive": 0.1}  # N/m, N m/rad


@pytest.fixture(scope="module")
def robots() -> Robots:
    return Robots(Session.of_text(TEXT).sampler.batch(np.arange(2), 3))


@pytest.fixture(scope="module")
def robot(robots: Robots) -> Robot:
    return robots.robot(0)


def test_annotations_tell_the_stiffness(robots: Robots) -> None:
    for told in annotate(robots.batch):
        assert {joint["name"]: joint["stiffness"] for joint in told["joints"]} == {
            **SPRUNG,
            "show": None,
            "slide": None,
        }


@pytest.fixture(scope="module")
def model(robot: Robot) -> mujoco.MjModel:
    files = mjcf_files(robot)
    return mujoco.MjModel.from_xml_string(files.pop("object.xml").decode(), files)


def test_joints_return_to_their_rest_in_mujoco(robot: Robot, model: mujoco.MjModel) -> None:
    moved = {joint.name: joint for joint in robot.joints}
    for end in ("low", "high"):
        data = mujoco.MjData(model)
        goal = {name: getattr(moved[name], end) for name in (*SPRUNG, "show", "slide")}
        for name, value in goal.items():
            data.joint(name).qpos[0] = value
        data.joint(f"drive{ADVANCE}").qpos[0] = goal["drive"] * moved["drive"].pitch / (2 * np.pi)
        while data.time < 2.0:
            mujoco.mj_step(model, data)
        for name, value in goal.items():
            joint = moved[name]
            left = abs(data.joint(name).qpos[0] - joint.rest) / (joint.high - joint.low)
            if name == "slide":  # no spring: it stays
                assert abs(data.joint(name).qpos[0] - value) < 1e-3
            else:
                assert left < 0.05, (name, end, left)
            assert abs(data.joint(name).qvel[0]) < 1e-3 * max(joint.velocity, 1.0)


def test_a_given_force_presses_a_key_as_far_as_its_spring_says(robot: Robot, model: mujoco.MjModel) -> None:
    (flag,) = (joint.child for joint in robot.joints if joint.name == "show")
    lifts = 10 * GRAVITY * robot.links[flag].mass  # what the follower weighs at its rate
    state = mujoco.MjData(model)
    while state.time < 2.0:
        state.joint("press").qfrc_applied[0] = 1.2
        mujoco.mj_step(model, state)
    assert state.joint("press").qpos[0] == pytest.approx((1.2 - lifts) / SPRUNG["press"], rel=0.02)


def test_sdf_and_usd_have_them_and_no_others(robots: Robots, robot: Robot) -> None:
    model = ElementTree.fromstring(sdf_files(robot)["model.sdf"]).find("model")
    assert model is not None
    stage = Usd.Stage.CreateInMemory()
    stage.GetRootLayer().ImportFromString(usd_files(robots, 0)["object.usda"].decode())
    prims = {prim.GetName(): prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)}
    for joint in robot.joints:
        found = model.find(f"joint[@name='{joint.name}']/axis/dynamics")
        assert found is not None
        stiffness = SPRUNG.get(joint.name, 0.0)
        assert (found.find("spring_stiffness") is None) == (stiffness == 0.0)
        assert float(found.findtext("spring_stiffness", "0")) == pytest.approx(stiffness)
        assert float(found.findtext("spring_reference", "0")) == pytest.approx(joint.rest if stiffness else 0.0)
        angular = not joint.traits.slides
        drive = UsdPhysics.DriveAPI(prims[joint.name], "angular" if angular else "linear")
        unit = np.degrees(1.0) if angular else 1.0
        assert drive.GetStiffnessAttr().Get() * unit == pytest.approx(stiffness)
        if stiffness:
            assert drive.GetTargetPositionAttr().Get() == pytest.approx(joint.rest * unit)


def test_where_a_format_has_no_springs_joints_are_as_without(robot: Robot) -> None:
    """A damping that suits a spring and an armature would throw the key of a URDF about: it has neither."""
    without = Robots(Session.of_text(re.sub(r" stiffness [\d.]+\S+", "", TEXT)).sampler.batch(np.arange(1), 3)).robot(0)
    assert max(joint.damping for joint in robot.joints) > 100 * max(joint.damping for joint in without.joints)
    for joint, plain in zip(simple_joints(robot).joints, simple_joints(without).joints, strict=True):
        assert (joint.name, joint.stiffness, joint.unsprung) == (plain.name, 0.0, None)
        assert (joint.damping, joint.effort, joint.friction) == (plain.damping, plain.effort, plain.friction)
