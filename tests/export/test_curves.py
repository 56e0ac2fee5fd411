"""A joint that follows another by a formula, in the files of formats with and without room for one."""

from __future__ import annotations

import json
import struct
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.jacobian import find_jacobian, find_rates
from artipg_dsl.annotate.states import draw_values
from artipg_dsl.export.registry import FORMATS
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.pose import open_values, rest_values
from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session
from tests.pipeline.stages import HERE, PROGRAM

QUARTER, REST = np.deg2rad(90.0), np.deg2rad(30.0)


@pytest.fixture(scope="module")
def batch() -> Batch:
    return Session.of(str(HERE / "crank" / PROGRAM)).sampler.batch(np.arange(3), seed=1)


@pytest.fixture(scope="module")
def robots(batch: Batch) -> Robots:
    return Robots(batch)


def throw_of(robot: Robot) -> float:
    return next(float(joint.high or 0.0) for joint in robot.joints if joint.name == "sink")


def test_the_model_follows_the_formula(robots: Robots) -> None:
    for n in range(3):
        robot = robots.robot(n)
        throw = throw_of(robot)
        assert rest_values(robot)["sink"] == pytest.approx(throw * np.sin(REST), abs=1e-6)
        assert open_values(robot)["sink"] == pytest.approx(throw, abs=1e-12)
        sink = robot.joints[1]
        at = np.linspace(0.0, QUARTER, 200)
        assert np.abs(sink.following(at) - throw * np.sin(at)).max() < 1e-5 * throw


def test_mujoco_couples_them_by_a_polynomial(robots: Robots) -> None:
    robot = robots.robot(1)
    files = FORMATS["mjcf"].files(robots, 1)
    model = mujoco.MjModel.from_xml_string(files["object.xml"].decode(), files)
    coefficients = np.asarray(model.eq_data[0, :5])
    at = np.linspace(0.0, QUARTER, 50)
    assert np.abs(np.polyval(coefficients[::-1], at) - throw_of(robot) * np.sin(at)).max() < 5e-4 * throw_of(robot)
    data = mujoco.MjData(model)
    model.opt.gravity[:] = 0.0
    data.qpos[:] = [REST, throw_of(robot) * np.sin(REST)]
    data.qfrc_applied[0] = robot.joints[0].effort
    for _ in range(60):
        mujoco.mj_step(model, data)
    turn, sink = data.qpos
    assert QUARTER > turn > REST + 0.1
    assert sink == pytest.approx(throw_of(robot) * np.sin(turn), abs=5e-4)


def test_formats_with_a_factor_have_the_straight_line_between_the_ends(robots: Robots) -> None:
    throw = throw_of(robots.robot(0))
    for name, file in (("urdf", "object.urdf"), ("sdf", "model.sdf")):
        tree = ElementTree.fromstring(FORMATS[name].files(robots, 0)[file])
        mimic = next(tree.iter("mimic"))
        said = {**mimic.attrib, **{child.tag: child.text for child in mimic}}
        assert float(said["multiplier"] or "nan") == pytest.approx(throw / QUARTER, rel=1e-8)
        assert float(said["offset"] or "nan") == pytest.approx(0.0, abs=1e-12)


def test_formats_with_room_for_it_have_the_curve(robots: Robots, batch: Batch) -> None:
    throw = throw_of(robots.robot(0))
    data = FORMATS["glb"].files(robots, 0)["object.glb"]
    (length,) = struct.unpack("<I", data[12:16])
    scene = json.loads(data[20 : 20 + length])
    described = next(j for node in scene["nodes"] for j in [node.get("extras", {}).get("joint")] if j and "mimic" in j)
    stage = FORMATS["usd"].files(robots, 0)["object.usda"].decode()
    lists = [
        line.split("[", 2)[2].strip("]") for line in stage.splitlines() if "artipg:mimic:" in line and "[]" in line
    ]
    told = [[float(word) for word in line.split(",")] for line in lists]
    noted = annotate(batch)[0]["joints"][1]["mimic"]["curve"]
    for lead, own in (described["mimic"]["curve"].values(), told, noted.values()):
        assert (lead[0], lead[-1]) == pytest.approx((0.0, QUARTER), abs=1e-8)
        assert np.asarray(own) == pytest.approx(throw * np.sin(lead), abs=1e-8)


def test_points_move_as_fast_as_the_curve_is_steep(batch: Batch) -> None:
    states = draw_values(batch, 0)
    joints = batch.joints()
    drivers, rate, _ = find_rates(batch, batch.settle(states))
    turn, sink = (np.flatnonzero(np.array(joints.name) == name) for name in ("turn", "sink"))
    assert drivers[:, 0].tolist() == turn.tolist()
    np.testing.assert_allclose(rate[sink, 0], joints.high[sink] * np.cos(states[turn]), rtol=1e-12)
    shift = find_jacobian(batch, states).shift[np.searchsorted(batch.links().owner, np.arange(3)) + 2, 0]
    np.testing.assert_allclose(shift, rate[sink] * [[0.0, 0.0, -1.0]], atol=1e-12)
