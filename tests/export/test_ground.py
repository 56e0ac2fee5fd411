"""Hinges that move what an object stands on: the floor spreads a step ladder, and its friction holds it."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.export.mjcf import mjcf_files
from artipg_dsl.robot.ground import find_thrust
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session
from artipg_dsl.validity.mass import masses

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install 'artipg_dsl[sim]'")

TEXT = """
apg 1
use primitives { Cuboid }
category Ladder {
  param tall : length in 60cm .. 90cm
  param lean : angle in 12deg .. 25deg
  let head = [16mm * cos(lean), 0, -16mm * sin(lean)]
  root part flight : Cuboid(size = [3cm, 50cm, tall]) turned lean about y
  part tray : Cuboid(size = [12cm, 50cm, 10cm]) turned lean about y
  connect tray to flight
  align tray.front.center = flight.back.top.center
  part stay : Cuboid(size = [3cm, 8cm, tall]) turned lean about y
  align stay.top.center = flight.top.center + 2 * head
  joint spread : revolute flight -> stay about line(at = flight.top.center + head, along = -y) range 0deg .. 80deg rest 2 * lean
  require stable
}
"""


@pytest.fixture(scope="module")
def robots() -> Robots:
    return Robots(Session.of_text(TEXT).sampler.batch(np.arange(2), 3))


def test_a_step_ladder_stays_as_it_stands_and_its_floor_pushes_as_foretold(robots: Robots) -> None:
    for i in range(2):
        files = mjcf_files(robots.robot(i))
        model = mujoco.MjModel.from_xml_string(files.pop("scene_free.xml").decode(), files)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        spread = data.joint("spread")
        start = spread.qpos[0]
        for _ in range(1000):
            mujoco.mj_step(model, data)
        assert np.degrees(abs(spread.qpos[0] - start)) < 0.03  # without that push one drifts by 0.13
        pushed, force = 0.0, np.zeros(6)
        for k, contact in enumerate(data.contact):
            if model.geom_bodyid[contact.geom].max() == model.body("stay").id:
                mujoco.mj_contactForce(model, data, k, force)
                pushed += force[0] * np.cross(spread.xaxis, contact.pos - spread.xanchor)[2]
        assert pushed == pytest.approx(robots.thrust[i], rel=0.01)


def test_what_need_not_stand_has_no_feet() -> None:
    batch = Session.of_text(TEXT.replace("require stable", "")).sampler.batch(np.arange(1), 3)
    assert not find_thrust(batch, masses(batch)).any()
