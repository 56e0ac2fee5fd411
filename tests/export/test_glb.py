"""GLB: nodes, colours, normals and the opening animation, read back by trimesh and by hand."""

from __future__ import annotations

import json
import struct
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from artipg_dsl import api as apg
from artipg_dsl.export.glb import VERTICES, glb_bytes, open_values
from artipg_dsl.robot.materials import to_linear
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.robots import Robots
from artipg_dsl.robot.shading import shade

from .fake_batch import FakeBatch


@pytest.fixture(scope="module")
def robot() -> Robot:
    return Robots(FakeBatch(2)).robot(0)


def parse(data: bytes) -> tuple[dict, bytes]:
    magic, version, length = struct.unpack("<III", data[:12])
    assert (magic, version, length) == (0x46546C67, 2, len(data))
    size = struct.unpack("<I", data[12:16])[0]
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def accessor(document: dict, binary: bytes, number: int) -> np.ndarray:
    entry = document["accessors"][number]
    view = document["bufferViews"][entry["bufferView"]]
    dtype = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[entry["componentType"]]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[entry["type"]]
    place = view["byteOffset"] + entry["byteOffset"]
    return np.frombuffer(binary, dtype, entry["count"] * width, place).reshape(-1, width)


def test_meshes_share_views_as_the_standard_asks(robot: Robot) -> None:
    """Its sections on buffers and accessors: what lies in one view has its stride, and each value a multiple of its size for a place."""
    document, binary = parse(glb_bytes(robot))
    views, shared = document["bufferViews"], Counter(entry["bufferView"] for entry in document["accessors"])
    for entry in document["accessors"]:
        view = views[entry["bufferView"]]
        size = {5126: 4, 5123: 2, 5125: 4}[entry["componentType"]]
        row = size * {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[entry["type"]]
        assert (view["byteOffset"] + entry["byteOffset"]) % size == 0
        assert entry["byteOffset"] + row * entry["count"] <= view["byteLength"]
        if view.get("target") == VERTICES:
            assert shared[entry["bufferView"]] == 1 or view["byteStride"] == row
    visuals = [(link, visual) for link in robot.links for visual in link.visuals]
    assert len(visuals) == len(document["meshes"]) > 4
    for (link, visual), made in zip(visuals, document["meshes"], strict=True):
        (primitive,) = made["primitives"]
        numbers = primitive["attributes"]
        position, normal = (accessor(document, binary, numbers[name]) for name in ("POSITION", "NORMAL"))
        group, k = visual.item.group, visual.item.k
        assert np.allclose(position, group.vertices[k][group.shading.source] - link.origin, atol=1e-6)
        assert np.allclose(normal, group.shading.normals[k], atol=1e-6)
        bounds = document["accessors"][numbers["POSITION"]]
        assert bounds["min"] == position.min(axis=0).tolist() and bounds["max"] == position.max(axis=0).tolist()
        assert accessor(document, binary, primitive["indices"]).ravel().tolist() == group.shading.faces.ravel().tolist()
    groups = {id(visual.item.group) for _, visual in visuals}
    assert len({made["primitives"][0]["indices"] for made in document["meshes"]}) == len(groups)


def test_trimesh_reads_links_and_primitives_standing_upright(robot: Robot) -> None:
    batch = FakeBatch(1)
    scene = trimesh.load(trimesh.util.wrap_as_stream(glb_bytes(robot)), file_type="glb")
    assert {"base", "door", "button", "body.left", "door.solid", "handle"} <= set(scene.graph.nodes)
    low, high = scene.bounds
    assert low[1] == pytest.approx(0, abs=1e-6) and high[1] == pytest.approx(batch.height[0])  # up is y
    assert low[2] == pytest.approx(-batch.depth[0] / 2) and high[0] == pytest.approx(batch.width[0] / 2)
    for solid in scene.geometry.values():
        solid.merge_vertices(merge_norm=True)
        assert solid.is_watertight and solid.volume > 0


def test_every_node_has_a_name_of_its_own_and_tells_its_part() -> None:
    robot = Robots(apg.sample("Bottle", n=1).batch).robot(0)
    document, _ = parse(glb_bytes(robot))
    names = [node["name"] for node in document["nodes"]]
    seen = [visual.name for link in robot.links for visual in link.visuals]
    assert len(set(names)) == len(names) and len({mesh["name"] for mesh in document["meshes"]}) == len(seen)
    told = [node["extras"]["part"] for node in document["nodes"] if "mesh" in node]
    assert sorted(told) == sorted(seen) and len(set(told)) < len(told)
    assert any(name.endswith("_2") and name.removesuffix("_2") in names for name in names)


def test_colours_are_linear_and_glass_is_blended(robot: Robot) -> None:
    document, _ = parse(glb_bytes(robot))
    glass = next(m for m in document["materials"] if m["name"] == "glass")
    colour = glass["pbrMetallicRoughness"]["baseColorFactor"]
    assert colour[:3] == pytest.approx(to_linear(np.array([0.6, 0.75, 0.8])), abs=1e-6) and colour[3] == pytest.approx(
        0.4
    )
    assert glass["alphaMode"] == "BLEND"
    assert to_linear(np.array([0.0, 1.0])).tolist() == [0.0, 1.0]


def test_nodes_tell_their_joints_and_the_animation_drives_them(robot: Robot) -> None:
    document, binary = parse(glb_bytes(robot))
    nodes = {node["name"]: node for node in document["nodes"]}
    joint = nodes["door"]["extras"]["joint"]
    assert joint["name"] == "open" and joint["type"] == "revolute" and joint["limits"] == [0.0, 1.9]
    animation = document["animations"][0]
    targets = {document["nodes"][c["target"]["node"]]["name"]: c for c in animation["channels"]}
    assert {name: c["target"]["path"] for name, c in targets.items()} == {"door": "rotation", "button": "translation"}
    sampler = animation["samplers"][targets["door"]["sampler"]]
    turns = accessor(document, binary, sampler["output"])
    assert turns[0] == pytest.approx(turns[-1]) and turns[0] == pytest.approx([0, 0, 0, 1])
    assert turns[4] == pytest.approx([0, 0, np.sin(0.95), np.cos(0.95)])
    slide = accessor(document, binary, animation["samplers"][targets["button"]["sampler"]]["output"])
    assert (slide[4] - slide[0]).tolist() == pytest.approx([-0.005, 0, 0], abs=1e-6)


def test_a_joint_at_rest_inside_its_range_is_placed_there(robot: Robot) -> None:
    ajar = replace(robot, joints=(replace(robot.joints[0], rest=0.5), robot.joints[1]))
    document, _ = parse(glb_bytes(ajar))
    door = next(node for node in document["nodes"] if node["name"] == "door")
    assert door["rotation"] == pytest.approx([0, 0, np.sin(0.25), np.cos(0.25)], abs=1e-8)


def test_a_screw_turns_by_short_steps_and_advances(robot: Robot) -> None:
    screw = replace(robot.joints[0], kind="screw", pitch=0.01, low=0.0, high=6 * np.pi)
    document, binary = parse(glb_bytes(replace(robot, joints=(screw, robot.joints[1]))))
    animation = document["animations"][0]
    door = next(k for k, node in enumerate(document["nodes"]) if node["name"] == "door")
    own = {c["target"]["path"]: c for c in animation["channels"] if c["target"]["node"] == door}
    keys = {path: accessor(document, binary, animation["samplers"][c["sampler"]]["output"]) for path, c in own.items()}
    turns, shifts = keys["rotation"], keys["translation"]
    assert (np.abs((turns[1:] * turns[:-1]).sum(axis=1)) > np.cos(0.81)).all()  # less than a quarter of a turn each
    assert (shifts[len(shifts) // 2] - shifts[0]).tolist() == pytest.approx((0.03 * screw.axis).tolist(), abs=1e-6)
    assert document["nodes"][door]["extras"]["joint"]["pitch"] == 0.01
    times = accessor(document, binary, animation["samplers"][own["rotation"]["sampler"]]["input"]).ravel()
    assert times[0] == 0 and times[-1] == 3 and len(times) == len(turns)


def test_a_ball_tilts(robot: Robot) -> None:
    ball = replace(robot.joints[0], kind="ball", low=0.0, high=0.4)
    document, binary = parse(glb_bytes(replace(robot, joints=(ball, robot.joints[1]))))
    animation = document["animations"][0]
    sampler = animation["samplers"][animation["channels"][0]["sampler"]]
    tilt = accessor(document, binary, sampler["output"])[4]
    assert tilt[3] == pytest.approx(np.cos(0.2)) and tilt[:3] @ ball.axis == pytest.approx(0, abs=1e-7)


def test_followers_go_with_their_leader(robot: Robot) -> None:
    follower = replace(robot.joints[1], mimic=("open", 0.5, 0.1))
    assert open_values(replace(robot, joints=(robot.joints[0], follower)))["press"] == pytest.approx(0.5 * 1.9 + 0.1)


def test_what_follows_a_wheel_goes_on_as_it_does(robot: Robot) -> None:
    """The wheel turns once and does not come back: neither does the slide."""
    wheel = replace(robot.joints[0], kind="continuous", low=None, high=None)
    slide = replace(robot.joints[1], mimic=("open", 0.002, 0.001))
    document, binary = parse(glb_bytes(replace(robot, joints=(wheel, slide))))
    animation = document["animations"][0]
    channel = next(c for c in animation["channels"] if c["target"]["path"] == "translation")
    sampler = animation["samplers"][channel["sampler"]]
    times, places = (accessor(document, binary, sampler[word]) for word in ("input", "output"))
    gone = 0.001 + 0.002 * 2 * np.pi * times / 3.0
    assert places == pytest.approx(slide.origin + gone * slide.axis, abs=1e-6)


def test_normals_are_smooth_over_a_cylinder_and_sharp_at_its_rim() -> None:
    group = next(g for g in Robots(FakeBatch(2)).meshes if g.table.path == "handle")
    shading = group.shading
    position = group.vertices[0][shading.source] - group.table.translation[0]
    normal = shading.normals[0]
    assert np.abs(np.sqrt((normal**2).sum(axis=1)) - 1).max() < 1e-12
    side = np.abs(normal[:, 2]) < 0.5
    radial = position[side, :2] / np.sqrt((position[side, :2] ** 2).sum(axis=1, keepdims=True))
    assert np.abs(normal[side, :2] - radial).max() < 1e-6
    assert np.abs(np.abs(normal[~side, 2]) - 1).max() < 1e-12 and (~side).any()


def test_patches_that_are_tangent_share_their_normals() -> None:
    flat = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0.1], [2, 1, 0.1]])
    faces = np.array([[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]])
    shading = shade(flat[None], faces, np.array([0, 0, 1, 1]))
    at_seam = [shading.normals[0][shading.source == vertex] for vertex in (1, 2)]
    assert all(len(n) == 2 and np.abs(n[0] - n[1]).max() < 1e-12 for n in at_seam)
    folded = flat.copy()
    folded[4:, 2] = 2.0
    sharp = shade(folded[None], faces, np.array([0, 0, 1, 1]))
    first, second = sharp.normals[0][sharp.source == 1]
    assert np.abs(first - second).max() > 0.5


def test_bytes_do_not_depend_on_the_batch(robot: Robot) -> None:
    assert glb_bytes(Robots(FakeBatch(5)).robot(0)) == glb_bytes(robot)
