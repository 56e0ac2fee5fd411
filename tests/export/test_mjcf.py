"""MJCF and URDF read back by MuJoCo: the same links, frames, masses, limits and colliders as the model they come from."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from artipg_dsl.export.mjcf import mjcf_files, qpos
from artipg_dsl.export.write import ExportError
from artipg_dsl.robot.adjacent import find_adjacent
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.pose import follow_leaders, link_poses, rest_values
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session

from .fake_batch import FakeBatch

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install 'artipg_dsl[sim]'")

ROOT = Path(__file__).parents[2]
SHIPPED = sorted(path.stem for path in (ROOT / "categories").glob("*.apg"))
# together they have every kind of joint: hinges, slides, wheels, balls, a screw, a follower; ARTIPG_ALL=1 takes all of them
FEW = ["microwave", "faucet", "scissors", "bottle", "storage_furniture"]
CATEGORIES = SHIPPED if os.environ.get("ARTIPG_ALL") else FEW


@pytest.fixture(scope="module", params=CATEGORIES)
def robot(request: pytest.FixtureRequest) -> Robot:
    batch = Session.of(str(ROOT / "categories" / f"{request.param}.apg")).sampler.batch(np.arange(1), 1)
    return Robots(batch).robot(0)


@pytest.fixture(scope="module")
def files(robot: Robot) -> dict[str, bytes]:
    return mjcf_files(robot)


def load(files: dict[str, bytes], name: str = "object.xml"):  # type: ignore[no-untyped-def]
    return mujoco.MjModel.from_xml_string(files[name].decode(), files)


def order(model) -> list[str]:  # type: ignore[no-untyped-def]
    return [model.joint(i).name for i in range(model.njnt) if model.jnt_type[i] != mujoco.mjtJoint.mjJNT_FREE]


def some_values(robot: Robot, seed: int) -> dict[str, float]:
    random = np.random.default_rng(seed)
    ends = {j.name: (j.low, j.high) if j.low is not None and j.high is not None else (-1.0, 1.0) for j in robot.joints}
    return follow_leaders(robot, {name: float(random.uniform(low, high)) for name, (low, high) in ends.items()})


def test_links_masses_centres_and_inertia(robot: Robot, files: dict[str, bytes]) -> None:
    model = load(files)
    assert {model.body(i).name for i in range(1, model.nbody)} == {link.name for link in robot.links}
    for link in robot.links:
        body = model.body(link.name)
        assert body.mass[0] == pytest.approx(link.mass, rel=1e-7)
        assert body.ipos == pytest.approx(link.center, abs=1e-8)
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, body.iquat)
        turn = turn.reshape(3, 3)
        scale = float(np.trace(link.inertia))
        assert turn @ np.diag(body.inertia) @ turn.T == pytest.approx(link.inertia, abs=1e-6 * scale)


@pytest.mark.parametrize("name", ["object.xml", "object_free.xml"])
def test_every_link_is_where_it_should_be_in_any_state(robot: Robot, files: dict[str, bytes], name: str) -> None:
    model = load(files, name)
    data = mujoco.MjData(model)
    names = order(model)
    base = [] if name == "object.xml" else [*robot.links[0].origin, 1.0, 0, 0, 0]
    for seed in range(3):
        values = some_values(robot, seed)
        data.qpos[:] = [*base, *qpos(robot, values, names)]
        mujoco.mj_kinematics(model, data)
        for link, (turn, shift) in zip(robot.links, link_poses(robot, values), strict=True):
            assert data.body(link.name).xpos == pytest.approx(shift, abs=1e-6), (link.name, values)
            assert data.body(link.name).xmat.reshape(3, 3) == pytest.approx(turn, abs=1e-6), link.name


def test_limits_and_what_is_unlimited(robot: Robot, files: dict[str, bytes]) -> None:
    model = load(files)
    for joint in robot.joints:
        if joint.kind in ("fixed", "ball"):
            continue
        read = model.joint(joint.name)
        limited = joint.kind != "continuous" and joint.low is not None
        assert bool(model.jnt_limited[read.id]) == limited
        if limited:
            assert read.range == pytest.approx([joint.low, joint.high], rel=1e-9, abs=1e-9)
        assert read.damping[0] == pytest.approx(joint.damping, rel=1e-6)


def test_what_collides_is_all_there_and_stays_in_its_place(robot: Robot, files: dict[str, bytes]) -> None:
    model = load(files)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    poses = link_poses(robot, {joint.name: 0.0 for joint in robot.joints})
    count = 0
    for link, (_, shift) in zip(robot.links, poses, strict=True):
        for collider in link.colliders:
            count += 1
            geom = model.geom(f"{link.name}_{collider.name}_collision")
            if collider.size is not None or collider.bar is not None:
                bar = collider.bar
                size = np.array(collider.size) / 2 if bar is None else [bar.radius, bar.length / 2, 0]
                assert geom.size == pytest.approx(size, abs=1e-9)
                assert data.geom(geom.id).xpos == pytest.approx(collider.center + shift, abs=1e-6)
                continue
            mesh = model.mesh(int(geom.dataid[0]))
            start, number = int(mesh.vertadr[0]), int(mesh.vertnum[0])
            read = model.mesh_vert[start : start + number] @ data.geom(geom.id).xmat.reshape(3, 3).T
            read = read + data.geom(geom.id).xpos
            points = collider.hull.vertices + shift
            assert read.min(axis=0) == pytest.approx(points.min(axis=0), abs=2e-6)
            assert read.max(axis=0) == pytest.approx(points.max(axis=0), abs=2e-6)
    assert count == np.count_nonzero(model.geom_contype)


def test_the_rest_pose_is_a_keyframe(robot: Robot, files: dict[str, bytes]) -> None:
    model = load(files)
    if model.njnt:
        assert model.key("rest").qpos == pytest.approx(qpos(robot, rest_values(robot), order(model)), abs=1e-9)
    free = load(files, "object_free.xml")
    assert free.key("rest").qpos[:3] == pytest.approx(robot.links[0].origin)


def test_the_first_step_is_finite_and_nothing_flies_apart(files: dict[str, bytes]) -> None:
    for scene in ("scene.xml", "scene_free.xml"):
        model = load(files, scene)
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, model.key("rest").id) if model.nkey else None
        for _ in range(100):
            mujoco.mj_step(model, data)
        assert np.isfinite(data.qacc).all() and np.isfinite(data.qpos).all()
        assert all(int(warning.number) == 0 for warning in data.warning)
        assert min(data.contact.dist, default=0.0) > -5e-5  # with MuJoCo's own softness all sink further into the floor


def fake(**changes: object) -> Robot:
    robot = Robots(FakeBatch(1)).robot(0)
    return replace(robot, joints=(replace(robot.joints[0], **changes), *robot.joints[1:]))  # type: ignore[arg-type]


def test_a_link_does_not_collide_with_its_fixed_parent() -> None:
    """MuJoCo leaves parent and child out by itself, but not where the parent is fixed to the world."""
    robot = fake(origin=np.zeros(3))  # the door lies within the body
    model = load(mjcf_files(robot))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pair = {robot.links[0].name, robot.links[1].name}
    touching = [{model.body(int(model.geom_bodyid[g])).name for g in (c.geom1, c.geom2)} for c in data.contact]
    assert pair not in touching
    free = {tuple(sorted(names)) for names in find_adjacent(robot)}
    assert tuple(sorted(pair)) in free and model.nexclude == len(free)


def test_links_that_are_welded_count_as_one() -> None:
    robot = fake(kind="fixed")
    door = robot.joints[1]
    on_door = replace(robot, joints=(robot.joints[0], replace(door, parent=1)))
    names = [link.name for link in robot.links]
    assert set(find_adjacent(on_door)) == {(names[0], names[1]), (names[0], names[2]), (names[1], names[2])}


def test_the_halves_of_scissors_and_what_a_ring_carries_count_as_held() -> None:
    robot = fake()
    names = [link.name for link in robot.links]
    door, button = robot.joints
    halves = replace(
        button, kind="revolute", axis=-door.axis, origin=door.origin + 0.01 * door.axis, mimic=("open", 1.0, 0.0)
    )
    assert (names[1], names[2]) in find_adjacent(replace(robot, joints=(door, halves)))
    assert (names[1], names[2]) not in find_adjacent(replace(robot, joints=(door, replace(halves, mimic=None))))
    carried = replace(robot, joints=(door, replace(button, parent=1)))
    assert (names[0], names[2]) not in find_adjacent(carried)
    ring = replace(robot.links[1], mass=0.01 * robot.links[2].mass)
    assert (names[0], names[2]) in find_adjacent(replace(carried, links=(robot.links[0], ring, robot.links[2])))


def test_a_follower_is_tied_by_an_equality_and_follows() -> None:
    robot = Robots(FakeBatch(1, mimic=True)).robot(0)
    model = load(mjcf_files(robot))
    assert model.neq == 1
    data = mujoco.MjData(model)
    data.joint("open").qpos[0] = 0.0
    data.qfrc_applied[model.joint("open").dofadr[0]] = 1.0
    for _ in range(300):
        mujoco.mj_step(model, data)
    lead, follow_ = data.joint("open").qpos[0], data.joint("press").qpos[0]
    assert lead > 0.05 and follow_ == pytest.approx(0.002 * lead, abs=2e-4)


def test_a_screw_advances_by_its_pitch() -> None:
    model = load(mjcf_files(fake(kind="screw", pitch=0.01, low=0.0, high=6.0)))
    data = mujoco.MjData(model)
    data.qfrc_applied[model.joint("open").dofadr[0]] = 1.0
    for _ in range(300):
        mujoco.mj_step(model, data)
    turned, advanced = data.joint("open").qpos[0], data.joint("open_advance").qpos[0]
    assert turned > 0.05 and advanced == pytest.approx(turned * 0.01 / (2 * np.pi), rel=0.01)


def test_a_ball_has_three_freedoms() -> None:
    model = load(mjcf_files(fake(kind="ball", low=None, high=None)))
    assert model.jnt_type[model.joint("open").id] == mujoco.mjtJoint.mjJNT_BALL and model.nv == 4


def test_a_joint_that_mujoco_does_not_have_is_refused_in_words() -> None:
    with pytest.raises(ExportError, match="open is a planar joint, which MuJoCo cannot express"):
        mjcf_files(fake(kind="planar"))


def test_equal_pieces_share_a_mesh_and_names_are_unique(robot: Robot, files: dict[str, bytes]) -> None:
    tree = ElementTree.fromstring(files["object.xml"])
    bodies = tree.find("worldbody")
    assert bodies is not None
    points = [mesh.get("vertex") for mesh in tree.iter("mesh") if mesh.get("vertex")]
    assert len(points) == len(set(points))
    for part, tag in ((bodies, "body"), (bodies, "joint"), (bodies, "geom"), (tree, "mesh"), (tree, "material")):
        names = [e.get("name") for e in part.iter(tag) if e.get("name")]
        assert len(names) == len(set(names)), tag
    assert {mesh.get("file") for mesh in tree.iter("mesh") if mesh.get("file")} <= set(files)


def test_a_ball_that_follows_is_refused_in_words() -> None:
    robot = fake(kind="ball", low=None, high=None)
    led = replace(robot.joints[1], mimic=("open", 0.002, 0.0))
    with pytest.raises(ExportError, match="press follows open, and MuJoCo couples no ball joints"):
        mjcf_files(replace(robot, joints=(robot.joints[0], led)))
