"""OBJ per link: where each link is, its materials, and the poses that place it."""

from __future__ import annotations

import io

import numpy as np
import pytest
import trimesh

from artipg_dsl.api import sample
from artipg_dsl.export.mesh_obj import obj_files
from artipg_dsl.robot.pose import link_poses, rest_values
from artipg_dsl.robot.robots import Robots

from .fake_batch import FakeBatch


def vertices(data: bytes) -> np.ndarray:
    """All vertices (V, 3) of an OBJ, read with nothing but its definition."""
    lines = data.decode().splitlines()
    return np.array([[float(x) for x in line.split()[1:]] for line in lines if line.startswith("v ")])


def test_the_files_together_show_the_object_at_rest() -> None:
    batch = sample("Microwave", 2, seed=3)
    robots = Robots(batch.batch)
    for i, scene in enumerate(batch.meshes(batch.rest())):
        files = obj_files(robots.robot(i))
        points = np.concatenate([vertices(data) for name, data in files.items() if name.endswith(".obj")])
        assert len(points) == sum(len(mesh.vertices) for mesh in scene.geometry.values())
        assert np.allclose([points.min(axis=0), points.max(axis=0)], scene.bounds, atol=1e-6)


def test_each_mesh_has_a_material_of_the_library() -> None:
    robot = Robots(FakeBatch(2)).robot(1)
    files = obj_files(robot)
    assert set(files) == {"obj/base.obj", "obj/door.obj", "obj/button.obj", "obj/object.mtl"}
    known = {line.split()[1] for line in files["obj/object.mtl"].decode().splitlines() if line.startswith("newmtl")}
    for name, data in files.items():
        if name.endswith(".obj"):
            lines = data.decode().splitlines()
            assert lines[0] == "mtllib object.mtl"
            used = [line.split()[1] for line in lines if line.startswith("usemtl")]
            assert len(used) == sum(line.startswith("o ") for line in lines) and set(used) <= known
            loaded = trimesh.load(io.BytesIO(data), file_type="obj", force="mesh", process=False)
            assert len(loaded.faces) == sum(line.startswith("f ") for line in lines)
    glass = files["obj/object.mtl"].decode().split("newmtl glass\n")[1].split("\n\n")[0]
    assert "d 0.4" in glass and "Pr 0.05" in glass


def test_poses_agree_with_those_of_the_batch() -> None:
    batch = sample("StorageFurniture", 2, seed=5)
    robots = Robots(batch.batch)
    values = batch.joint_values("random:2")[1]
    turn, shift = batch.batch.pose(values)
    first = 0
    for i in range(2):
        robot = robots.robot(i)
        own = {j.name: float(v) for j, v in zip(robot.joints, values[batch.joints().owner == i], strict=True)}
        assert set(rest_values(robot)) == set(own)
        for k, (rotation, origin) in enumerate(link_poses(robot, own)):
            assert rotation == pytest.approx(turn[first + k], abs=1e-9)
            expected = turn[first + k] @ robot.links[k].origin + shift[first + k]
            assert origin == pytest.approx(expected, abs=1e-9)
        first += len(robot.links)
