"""The shipped microwave through the whole path: every URDF in MuJoCo, with the joints that its annotation states."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.rows import to_text
from artipg_dsl.export.glb import glb_bytes
from artipg_dsl.export.shards import point_arrays
from artipg_dsl.export.urdf import urdf_files
from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session


@pytest.fixture(scope="module")
def sampler() -> Sampler:
    return Session.of("Microwave").sampler


@pytest.fixture(scope="module")
def batch(sampler: Sampler) -> Batch:
    return sampler.batch(np.arange(30, 40), seed=7)


@pytest.fixture(scope="module")
def robots(batch: Batch) -> Robots:
    return Robots(batch)


def test_every_urdf_loads_with_the_joints_of_its_annotation(batch: Batch, robots: Robots) -> None:
    mujoco = pytest.importorskip("mujoco")
    for i, annotation in enumerate(annotate(batch)):
        files = urdf_files(robots.robot(i))
        assets = {name: data for name, data in files.items() if name.endswith(".obj")}
        model = mujoco.MjModel.from_xml_string(files["object.urdf"].decode(), assets)
        assert [model.joint(k).name for k in range(model.njnt)] != [] and model.njnt == len(annotation["joints"])
        for joint in annotation["joints"]:
            if joint["range"] is not None:
                assert model.joint(joint["name"]).range == pytest.approx(joint["range"], abs=1e-8)
        assert (model.body_mass[1:] > 0).all() and (model.body_inertia[1:] > 0).all()


def test_its_door_moves_through_its_range(batch: Batch, robots: Robots) -> None:
    mujoco = pytest.importorskip("mujoco")
    files = urdf_files(robots.robot(3))
    assets = {name: data for name, data in files.items() if name.endswith(".obj")}
    spec = mujoco.MjSpec.from_string(files["object.urdf"].decode(), assets=assets)
    for joint in spec.joints:
        joint.armature = 0.01
    actuator = spec.add_actuator(name="drive", target="open", trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.set_to_position(kp=40.0, kv=8.0)
    model = spec.compile()
    data = mujoco.MjData(model)
    for end in (1, 0):
        data.ctrl[0] = model.joint("open").range[end]
        for _ in range(1500):
            mujoco.mj_step(model, data)
        assert data.joint("open").qpos[0] == pytest.approx(model.joint("open").range[end], abs=0.02)


def test_an_object_is_the_same_alone(sampler: Sampler, batch: Batch, robots: Robots) -> None:
    alone = sampler.batch(np.array([37]), seed=7)
    one = Robots(alone).robot(0)
    assert urdf_files(one) == urdf_files(robots.robot(7)) and glb_bytes(one) == glb_bytes(robots.robot(7))
    assert to_text(annotate(alone)[0]) == to_text(annotate(batch)[7])
    mine, theirs = point_arrays(alone, 128), point_arrays(batch, 128)
    assert list(mine) == list(theirs)
    for name, array in mine.items():
        assert array[0].tobytes() == theirs[name][7].tobytes(), name


def test_opening_the_door_carries_its_points_and_labels(batch: Batch) -> None:
    joints, links = batch.joints(), batch.links()
    opened = np.where([name == "open" for name in joints.name], joints.high, joints.rest)
    rest, swung = sample_points(batch, 256), sample_points(batch, 256, opened)
    door = np.array([[name == "door" for name in links.name]])
    starts = np.searchsorted(links.owner, np.arange(len(batch)))
    on_door = door[0][starts[:, None] + rest.link]
    moved = np.sqrt(((rest.position - swung.position) ** 2).sum(axis=-1))
    assert on_door.any() and (moved[~on_door] < 1e-9).all() and (moved[on_door] > 1e-3).mean() > 0.95
    assert (rest.semantic == swung.semantic).all() and rest.labels["affordance.pull"].any()
    assert all((field == swung.labels[name]).all() for name, field in rest.labels.items())
