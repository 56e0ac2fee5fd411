"""The common model, OBJ and URDF: closed meshes, real masses, and a robot that MuJoCo loads and moves."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from artipg_dsl.export.urdf import urdf_files
from artipg_dsl.export.write import ExportError
from artipg_dsl.geometry.resolution import Resolution
from artipg_dsl.language.kinds import JOINTS, Kind
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.pose import follow_leaders, link_poses
from artipg_dsl.robot.robots import Robots
from artipg_dsl.robot.solids import match_box
from artipg_dsl.robot.substitute import simple_joints

from .fake_batch import FakeBatch


@pytest.fixture(scope="module")
def robot() -> Robot:
    return Robots(FakeBatch(3)).robot(1)


@pytest.fixture(scope="module")
def files(robot: Robot) -> dict[str, bytes]:
    return urdf_files(robot)


def mujoco_model(files: dict[str, bytes]):  # type: ignore[no-untyped-def]
    mujoco = pytest.importorskip("mujoco")
    assets = {name: data for name, data in files.items() if name.endswith(".obj")}
    return mujoco, mujoco.MjModel.from_xml_string(files["object.urdf"].decode(), assets)


def test_every_primitive_is_closed_and_faces_outwards(robot: Robot) -> None:
    for link in robot.links:
        for visual in link.visuals:
            solid = trimesh.Trimesh(visual.shape.vertices, visual.shape.faces, process=False)
            assert solid.is_watertight and solid.volume > 0, visual.name


def test_obj_reads_back_as_closed_pieces_of_one_group(files: dict[str, bytes]) -> None:
    """Of more than one ``o`` MuJoCo takes the faces of the first alone."""
    text = files["meshes/base_paint.obj"].decode()
    assert [line for line in text.splitlines() if line.startswith("o ")] == ["o base_paint"]
    pieces = trimesh.load(trimesh.util.wrap_as_stream(text), file_type="obj", force="mesh").split()
    assert len(pieces) == 5 and all(piece.is_watertight for piece in pieces)


def test_masses_are_volume_times_density_and_centres_those_of_the_solid() -> None:
    batch = FakeBatch(2)
    robot = Robots(batch, resolution=Resolution(192)).robot(1)
    door = robot.links[1]
    slab = np.prod(batch._boxes()[1][5][1]) * 2500
    bar = trimesh.Trimesh(door.visuals[1].shape.vertices, door.visuals[1].shape.faces).volume * 7850
    assert door.mass == pytest.approx(slab + bar, rel=1e-3)
    center = batch._boxes()[0][5:7, 1] - door.origin
    assert door.center == pytest.approx((slab * center[0] + bar * center[1]) / (slab + bar), abs=1e-5)


def test_inertia_agrees_with_an_independent_computation(robot: Robot) -> None:
    link = robot.links[0]
    whole = trimesh.util.concatenate([trimesh.Trimesh(v.shape.vertices, v.shape.faces) for v in link.visuals])
    whole.density = link.colliders[0].material.density[0]  # drawn from 600 .. 800
    assert 600 <= whole.density <= 800
    assert link.inertia == pytest.approx(whole.moment_inertia, rel=1e-5, abs=1e-7)


def test_products_of_inertia_are_no_rounding_noise(robot: Robot) -> None:
    for link in robot.links:
        products = np.abs(link.inertia[[0, 0, 1], [1, 2, 2]])
        assert ((products == 0.0) | (products > 1e-11 * np.trace(link.inertia))).all(), link.name
    assert any((link.inertia[[0, 0, 1], [1, 2, 2]] == 0.0).any() for link in robot.links)


def test_inertia_is_valid_also_of_a_tiny_button(robot: Robot) -> None:
    assert robot.links[2].mass < 0.1
    for link in robot.links:
        principal = np.sort(np.linalg.eigvalsh(link.inertia))
        assert link.mass > 0 and principal[0] > 0 and principal[0] + principal[1] > principal[2], link.name


def test_box_is_told_from_other_hulls() -> None:
    corners = np.array([[x, y, z] for x in (-1.0, 1) for y in (-2.0, 2) for z in (-3.0, 3)])
    sheared = corners + corners[:, 2:] * [0.1, 0, 0]
    repeated = corners.copy()
    repeated[7] = corners[6]
    is_box, size, center = match_box(np.stack([corners, sheared, repeated]))
    assert is_box.tolist() == [True, False, False]
    assert size[0].tolist() == [2, 4, 6] and center[0].tolist() == [0, 0, 0]


def test_boards_collide_as_boxes_and_bars_as_cylinders(files: dict[str, bytes]) -> None:
    tree = ElementTree.fromstring(files["object.urdf"])
    base, door = tree.findall("link")[:2]
    assert len(base.findall("collision/geometry/box")) == 5
    assert len(door.findall("collision/geometry/cylinder")) == 1  # its handle
    for mesh in tree.iter("mesh"):
        assert mesh.get("filename") in files and mesh.get("filename", "").startswith("meshes/")
    named = [(e.tag, e.get("name")) for kind in ("link", "joint", "visual", "collision") for e in tree.iter(kind)]
    assert len(named) == len(set(named))


def test_mujoco_loads_it_with_its_joints_ranges_and_masses(files: dict[str, bytes]) -> None:
    mujoco, model = mujoco_model(files)
    assert model.njnt == 2
    assert model.joint("open").range == pytest.approx([0, 1.9]) and model.joint("press").range == pytest.approx(
        [0, 0.005]
    )
    assert (model.body_mass[1:] > 0).all() and (model.body_inertia[1:] > 0).all()


def test_the_door_moves_through_its_range_in_mujoco(files: dict[str, bytes]) -> None:
    mujoco = pytest.importorskip("mujoco")
    assets = {name: data for name, data in files.items() if name.endswith(".obj")}
    spec = mujoco.MjSpec.from_string(files["object.urdf"].decode(), assets=assets)
    spec.option.gravity = [0, 0, 0]
    for joint in spec.joints:
        joint.armature = 0.01
        actuator = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=40.0, kv=8.0)
    model = spec.compile()
    data = mujoco.MjData(model)
    for end in (1, 0):
        data.ctrl[:] = model.jnt_range[:, end]
        for _ in range(3000):
            mujoco.mj_step(model, data)
        assert data.joint("open").qpos[0] == pytest.approx(model.joint("open").range[end], abs=0.02)
        assert np.isfinite(data.qacc).all()


def test_files_are_the_same_alone_and_in_a_batch(files: dict[str, bytes]) -> None:
    assert urdf_files(Robots(FakeBatch(1, first=1)).robot(0)) == files


def test_a_mimicking_joint_names_its_leader() -> None:
    tree = ElementTree.fromstring(urdf_files(Robots(FakeBatch(1, mimic=True)).robot(0))["object.urdf"])
    mimic = tree.find("joint[@name='press']/mimic")
    assert mimic is not None and mimic.attrib == {"joint": "open", "multiplier": "0.002", "offset": "0"}


def test_joints_that_urdf_cannot_state_are_refused_with_words(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(JOINTS, "planar", Kind("planar"))  # a kind that the language might gain
    planar = replace(robot, joints=(replace(robot.joints[0], kind="planar"),))
    with pytest.raises(ExportError, match="open is a planar joint"):
        urdf_files(planar)


@pytest.mark.parametrize("kind, added", [("screw", 1), ("ball", 2)])
def test_a_substitute_moves_as_the_joint_does(robot: Robot, kind: str, added: int) -> None:
    first = replace(robot.joints[0], kind=kind, pitch=0.02 if kind == "screw" else 0.0)
    whole = replace(robot, joints=(first, *robot.joints[1:]))
    simple = simple_joints(whole)
    assert len(simple.links) == len(whole.links) + added and len(simple.joints) == len(whole.joints) + added
    assert {joint.kind for joint in simple.joints} <= {"revolute", "continuous", "prismatic", "fixed"}
    for value in (-0.7, 0.0, 1.1):
        states = {joint.name: 0.0 for joint in simple.joints} | {first.name: value}
        poses = zip(link_poses(whole, states), link_poses(simple, follow_leaders(simple, states)), strict=False)
        for (turn, shift), (simple_turn, simple_shift) in poses:
            assert simple_turn == pytest.approx(turn, abs=1e-12) and simple_shift == pytest.approx(shift, abs=1e-12)
    more = sum(link.mass for link in simple.links) - sum(link.mass for link in whole.links)
    assert 0 < more <= 0.003 * whole.links[first.child].mass


@pytest.mark.parametrize("kind", ["screw", "ball"])
def test_mujoco_moves_the_substitute_of_urdf_alike(robot: Robot, kind: str) -> None:
    first = replace(robot.joints[0], kind=kind, pitch=0.02 if kind == "screw" else 0.0)
    whole = replace(robot, joints=(first, *robot.joints[1:]))
    mujoco, model = mujoco_model(urdf_files(whole))
    assert model.nbody == len(simple_joints(whole).links) + 1
    data = mujoco.MjData(model)
    data.joint(first.name).qpos[0] = 0.8
    if kind == "screw":
        data.joint(f"{first.name}_advance").qpos[0] = 0.8 * 0.02 / (2 * np.pi)
    mujoco.mj_kinematics(model, data)
    values = {joint.name: 0.0 for joint in whole.joints} | {first.name: 0.8}
    root = robot.links[0].name
    for link, (turn, shift) in zip(whole.links, link_poses(whole, values), strict=True):
        body = data.body(link.name)
        assert body.xpos - data.body(root).xpos == pytest.approx(shift, abs=1e-6), link.name
        assert body.xmat.reshape(3, 3) == pytest.approx(turn, abs=1e-6), link.name


def test_all_followers_name_the_joint_that_leads_them_all(robot: Robot) -> None:
    """yourdfpy leaves what follows a follower at 0, as the slide of a screw that follows another joint does."""
    door = robot.joints[0]
    screw = replace(robot.joints[1], kind="screw", pitch=0.02, low=-3.0, high=3.0, mimic=(door.name, -2.0, 0.5))
    root = ElementTree.fromstring(urdf_files(replace(robot, joints=(door, screw)))["object.urdf"])
    told = {}
    for name in (screw.name, f"{screw.name}_advance"):
        mimic = root.find(f"joint[@name='{name}']/mimic")
        assert mimic is not None and mimic.get("joint") == door.name
        told[name] = [float(mimic.get(word, "nan")) for word in ("multiplier", "offset")]
    advance = 0.02 / (2 * np.pi)
    assert told[screw.name] == [-2.0, 0.5]
    assert told[f"{screw.name}_advance"] == pytest.approx([-2.0 * advance, 0.5 * advance])


def test_a_joint_without_limits_is_continuous(robot: Robot) -> None:
    wheel = replace(robot, joints=(replace(robot.joints[0], kind="continuous", low=None, high=None),))
    joint = ElementTree.fromstring(urdf_files(wheel)["object.urdf"]).find("joint")
    assert joint is not None and joint.get("type") == "continuous"
    limit = joint.find("limit")
    assert limit is not None and set(limit.attrib) == {"effort", "velocity"}
