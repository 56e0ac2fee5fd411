"""What is known to go wrong when simulators read articulated objects, each as a test that it does not with ours.

That joints are numbered in another order by every reader is in ``tests/equivalence``, where all is addressed by name; degrees
in USD are in ``tests/export/test_usd.py``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from export.fake_batch import FakeBatch

from artipg_dsl.export.urdf import urdf_files
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.pose import link_poses
from artipg_dsl.robot.robots import Robots

from .matrix import objects, simulator
from .subject import Subject, written


def adapter(package: str):  # type: ignore[no-untyped-def]
    found = simulator(package)
    if found is None:
        pytest.skip(f"{package} is not installed: pip install 'artipg_dsl[sim]'")
    return found


@pytest.fixture(scope="module")
def microwave() -> Iterator[Subject]:
    with written(objects("microwave", 1, 1)[0].robot, "urdf") as subject:
        yield subject


def above_the_plate(subject: Subject) -> np.ndarray:
    """A point in the cavity, 5 cm above the middle of the plate."""
    robot = subject.robot
    plate = next(joint.child for joint in robot.joints if joint.name == "spin")
    turn, shift = link_poses(robot, subject.rest)[plate]
    return turn @ robot.links[plate].center + shift + np.array([0.0, 0.0, 0.05])


def fake(**changes: object) -> Robot:
    robot = Robots(FakeBatch(1)).robot(0)
    return replace(robot, joints=(replace(robot.joints[0], **changes), *robot.joints[1:]))  # type: ignore[arg-type]


# ------------------------------------------------------------ hulls: a cavity stays open


def test_a_cavity_stays_open_in_mujoco(microwave: Subject) -> None:
    mujoco = pytest.importorskip("mujoco")
    spec = mujoco.MjSpec.from_file(str(microwave.folder / "object.urdf"))
    ball = spec.worldbody.add_body(name="ball", pos=above_the_plate(microwave))
    ball.add_freejoint()
    ball.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.02, 0, 0])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    geom = int(np.flatnonzero(model.geom_bodyid == model.body("ball").id)[0])
    assert not any(geom in (contact.geom1, contact.geom2) for contact in data.contact)


def test_a_cavity_stays_open_in_pybullet(microwave: Subject) -> None:
    adapter("pybullet")
    import pybullet

    from .bullet_sim import BulletSim

    world = BulletSim(microwave)
    try:
        world.place(microwave.rest)
        ball = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.02, physicsClientId=world.client)
        place = above_the_plate(microwave).tolist()
        ball = pybullet.createMultiBody(1.0, ball, basePosition=place, physicsClientId=world.client)
        assert not pybullet.getClosestPoints(world.body, ball, 0.0, physicsClientId=world.client)
    finally:
        world.close()


def test_a_cavity_stays_open_in_sapien(microwave: Subject) -> None:
    adapter("sapien")
    import sapien

    from .sapien_sim import SapienSim

    world = SapienSim(microwave)
    world.place(microwave.rest)
    builder = world.scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.02)
    builder.initial_pose = sapien.Pose(above_the_plate(microwave))
    ball = builder.build(name="ball")
    world.step()
    touching = [c for c in world.scene.get_contacts() if any(body.entity == ball for body in c.bodies)]
    assert not any(np.abs(point.impulse).max() > 0 for contact in touching for point in contact.points)


# ------------------------------------------------------------ what a joint holds together does not collide


def test_links_with_others_between_do_not_collide_in_sapien() -> None:
    """A screw's slide has a link of its own, so the cap is not the bottle's child: the SRDF says what URDF cannot."""
    found = adapter("sapien")
    robot = fake(kind="screw", pitch=0.01, low=0.0, high=6.0, origin=np.zeros(3))  # the door lies within the body
    names = robot.links[0].name, robot.links[1].name
    for kept in (True, False):
        with written(robot, "urdf") as subject:
            if not kept:
                (subject.folder / "object_physics.srdf").unlink()
            world = found(subject)
            world.place(subject.rest)
            world.step()
            pairs = [{body.entity.name for body in contact.bodies} for contact in world.scene.get_contacts()]
            assert (set(names) in pairs) == (not kept)


def test_pairs_that_do_not_collide_are_groups_in_pybullet_and_still_collide_with_all_else() -> None:
    """It reads no SRDF, but ``group`` and ``mask``; a ball lies on what has them as on anything."""
    adapter("pybullet")
    import pybullet

    robot = fake(kind="screw", pitch=0.01, low=0.0, high=6.0, origin=np.zeros(3))  # the door lies within the body
    with written(robot, "urdf") as subject:
        path, met = subject.folder / "object.urdf", []
        plain = path.read_text()
        for text in (plain, re.sub(r' (group|mask)="[^"]*"', "", plain)):
            path.write_text(text)
            client = pybullet.connect(pybullet.DIRECT)
            try:
                flags = pybullet.URDF_USE_SELF_COLLISION
                body = pybullet.loadURDF(str(path), useFixedBase=True, flags=flags, physicsClientId=client)
                ball = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1, physicsClientId=client)
                ball = pybullet.createMultiBody(1.0, ball, physicsClientId=client)
                pybullet.stepSimulation(physicsClientId=client)
                inside = pybullet.getContactPoints(body, body, physicsClientId=client)
                met.append((bool(inside), bool(pybullet.getContactPoints(body, ball, physicsClientId=client))))
            finally:
                pybullet.disconnect(client)
    assert met == [(False, True), (True, True)]


# ------------------------------------------------------------ light links under a limited effort


def test_a_knob_under_a_limited_effort_comes_to_rest_in_mujoco() -> None:
    """With the drive's damping clamped away it runs to and fro for ever; our MJCF and what the docs do to a URDF end that."""
    mujoco = pytest.importorskip("mujoco")
    from .mujoco_sim import settle

    robot = fake(axis=np.array([1.0, 0, 0]), effort=1.0)
    knob = replace(robot.links[1], mass=0.1, inertia=np.diag([2.7e-5, 2e-5, 2e-5]), center=np.zeros(3), colliders=())
    robot = replace(robot, links=(robot.links[0], knob, *robot.links[2:]))
    speeds = []
    for form, settled in (("mjcf", False), ("urdf", True), ("urdf", False)):
        with written(robot, form) as subject:
            spec = mujoco.MjSpec.from_file(str(subject.folder / f"object.{'xml' if form == 'mjcf' else form}"))
            if settled:
                settle(spec, subject.folder / "object.srdf")
            drive = spec.add_actuator(name="drive", target="open", trntype=mujoco.mjtTrn.mjTRN_JOINT)
            drive.set_to_position(kp=50.0, kv=5.0)
            model = spec.compile()
        data = mujoco.MjData(model)
        data.ctrl[0] = 1.0
        for _ in range(1000):
            mujoco.mj_step(model, data)
        speeds.append(abs(data.joint("open").qvel[0]))
    assert speeds[0] < 0.01 and speeds[1] < 0.01 and speeds[2] > 1.0


# ------------------------------------------------------------ a damping that a step of PyBullet cannot bear


def test_pybullet_throws_what_is_light_for_its_damping() -> None:
    """The cap of a glue stick passes its ends with the damping of the file, and arrives with as much as docs/formats.md says."""
    bullet = adapter("pybullet")
    import pybullet

    name = "body.off"
    with written(objects("gluestick", 1, 1)[0].robot, "urdf") as subject:
        joint = next(joint for joint in subject.moving if joint.name == name)
        assert joint.low is not None and joint.high is not None
        ends = []
        for stated in (False, True):
            world = bullet(subject)
            if stated:
                pybullet.changeDynamics(
                    world.body, world.index[name], jointDamping=joint.damping, physicsClientId=world.client
                )
            world.place(subject.rest)
            world.drive({name: joint.high})
            for _ in range(240):
                world.step()
            ends.append(world.value(name))
            world.close()
    assert abs(ends[0] - joint.high) < 1e-4
    assert ends[1] < joint.low or ends[1] > 2 * joint.high


# ------------------------------------------------------------ followers


def test_mujoco_4_ties_followers_of_urdf() -> None:
    mujoco = pytest.importorskip("mujoco", minversion="4.0")
    files = urdf_files(Robots(FakeBatch(1, mimic=True)).robot(0))
    tied = {
        name: mujoco.MjModel.from_xml_string(files[name].decode(), files).neq
        for name in files
        if name.endswith(".urdf")
    }
    assert tied == {"object.urdf": 1, "object_fixed.urdf": 1, "object_physics.urdf": 1, "object_independent.urdf": 0}


def test_sapien_moves_joints_apart_where_the_file_does_not_tie_them() -> None:
    """SAPIEN 3.0.3 inverts the ratio of joints that share a parent: ``object_independent.urdf`` does not ask it to tie them."""
    found = adapter("sapien")
    with written(Robots(FakeBatch(1, mimic=True)).robot(0), "urdf") as subject:
        text = (subject.folder / "object_independent.urdf").read_text()
        (subject.folder / "object_physics.urdf").write_text(re.sub("<visual.*?</visual>", "", text, flags=re.DOTALL))
        world = found(subject)
        world.place(subject.rest)
        world.drive({"open": 1.0})
        for _ in range(200):
            world.step()
        assert world.value("open") == pytest.approx(1.0, abs=0.02) and abs(world.value("press")) < 1e-4


def test_a_screw_does_not_spin_by_itself_in_sapien() -> None:
    """A tie of a ratio far from 1 pulls at its leader with the inverse ratio: the slide comes first, so there is none."""
    found = adapter("sapien")
    with written(fake(kind="screw", pitch=0.002, low=0.0, high=6.0), "urdf") as subject:
        world = found(subject)
        world.place(subject.rest)
        for _ in range(100):
            world.step()
        assert abs(world.value("open")) < 1e-3


# ------------------------------------------------------------ the base, and what loaders leave out


def test_the_fixed_variant_hangs_in_the_air_wherever_the_reader_would_let_it_fall(tmp_path: Path) -> None:
    adapter("pybullet")
    import pybullet

    with written(fake(), "urdf") as subject:
        client = pybullet.connect(pybullet.DIRECT)
        try:
            pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
            ends = []
            for name in ("object", "object_fixed"):
                body = pybullet.loadURDF(
                    str(subject.folder / f"{name}.urdf"), [3.0 * len(ends), 0, 1], physicsClientId=client
                )
                ends.append(body)
            for _ in range(120):
                pybullet.stepSimulation(physicsClientId=client)
            fallen = [pybullet.getBasePositionAndOrientation(body, physicsClientId=client)[0][2] for body in ends]
        finally:
            pybullet.disconnect(client)
    assert fallen[0] < 0.5 and fallen[1] == pytest.approx(1.0, abs=1e-9)


def test_pybullet_reads_the_friction_that_it_leaves_to_the_user() -> None:
    adapter("pybullet")
    from .bullet_sim import BulletSim

    with written(fake(friction=0.25), "urdf") as subject:
        world = BulletSim(subject)
        try:
            assert world.friction["open"] == pytest.approx(0.25)
        finally:
            world.close()
