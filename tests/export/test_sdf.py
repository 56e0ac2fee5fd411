"""SDFormat read back by a small reader of its rules: poses, joints, followers, screws, loops, masses, colliders."""

from __future__ import annotations

from dataclasses import dataclass, replace
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from artipg_dsl.annotate.frames import axis_angle
from artipg_dsl.export.sdf import sdf_files
from artipg_dsl.export.write import ExportError
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.pose import follow_leaders, link_poses
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session


def floats(element: ElementTree.Element | None) -> np.ndarray:
    assert element is not None and element.text is not None
    return np.array([float(word) for word in element.text.split()])


@dataclass
class Model:
    """What a reader of SDFormat makes of the file: link frames at joint values 0, then along the joints from the base."""

    files: dict[str, bytes]

    def __post_init__(self) -> None:
        self.model = ElementTree.fromstring(self.files["model.sdf"]).find("model")
        self.links = {link.get("name"): link for link in self.model.findall("link")}
        self.joints = {joint.get("name"): joint for joint in self.model.findall("joint")}
        self.tree = {n: j for n, j in self.joints.items() if not n.startswith("closure_")}

    def at_zero(self, name: str) -> np.ndarray:
        pose = floats(self.links[name].find("pose"))
        assert (pose[3:] == 0).all()
        return pose[:3]

    def poses(self, values: dict[str, float]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        base = self.model.get("canonical_link")
        found = {base: (np.eye(3), self.at_zero(base))}
        waiting = list(self.tree.values())
        while waiting:
            joint = waiting.pop(0)
            parent, child = joint.findtext("parent"), joint.findtext("child")
            if parent not in found:
                waiting.append(joint)
                continue
            turn, shift = found[parent]
            turn, shift = turn, turn @ (self.at_zero(child) - self.at_zero(parent)) + shift
            kind, q = joint.get("type"), values.get(joint.get("name"), 0.0)
            if kind not in ("fixed", "ball"):
                axis = floats(joint.find("axis/xyz"))
                axis = axis / np.linalg.norm(axis)
                if kind == "prismatic":
                    shift = turn @ axis * q + shift
                else:
                    pitch = float(joint.findtext("screw_thread_pitch", "0"))
                    shift = turn @ axis * (q * pitch / (2 * np.pi)) + shift
                    turn = turn @ axis_angle(axis, np.array(q))
            found[child] = turn, shift
        return found


def check(robot: Robot, seed: int = 0) -> Model:
    model = Model(sdf_files(robot))
    assert list(model.links) == [link.name for link in robot.links]
    assert list(model.tree) == [joint.name for joint in robot.joints]
    random = np.random.default_rng(seed)
    for _ in range(3):
        values = {}
        for joint in robot.joints:
            low, high = (-1.0, 1.0) if joint.low is None or joint.high is None else (joint.low, joint.high)
            values[joint.name] = 0.0 if joint.kind in ("ball", "fixed") else float(random.uniform(low, high))
        values = follow_leaders(robot, values)
        read = model.poses(values)
        for link, (turn, shift) in zip(robot.links, link_poses(robot, values), strict=True):
            assert read[link.name][0] == pytest.approx(turn, abs=1e-8) and read[link.name][1] == pytest.approx(
                shift, abs=1e-8
            )
    for joint in robot.joints:
        element = model.joints[joint.name]
        limit, mimic = element.find("axis/limit"), element.find("axis/mimic")
        if limit is not None:
            assert [float(limit.findtext(word, "nan")) for word in ("effort", "velocity")] == pytest.approx(
                [joint.effort, joint.velocity]
            )
            if element.get("type") != "continuous" and joint.low is not None:
                ends = [float(limit.findtext(word, "nan")) for word in ("lower", "upper")]
                assert ends == pytest.approx([joint.low, joint.high], rel=1e-8, abs=1e-9)
        assert (mimic is None) == (joint.mimic is None)
        if mimic is not None and joint.mimic is not None:
            read_mimic = (
                mimic.get("joint"),
                *(float(mimic.findtext(word, "nan")) for word in ("multiplier", "offset")),
            )
            assert read_mimic == (joint.mimic[0], pytest.approx(joint.mimic[1]), pytest.approx(joint.mimic[2]))
    for link in robot.links:
        element = model.links[link.name]
        assert float(element.findtext("inertial/mass", "nan")) == pytest.approx(link.mass)
        assert floats(element.find("inertial/pose"))[:3] == pytest.approx(link.center, abs=1e-9)
        cells = {c.tag: float(c.text or "nan") for c in element.find("inertial/inertia")}  # type: ignore[union-attr]
        assert [cells[word] for word in ("ixx", "iyy", "izz")] == pytest.approx(np.diag(link.inertia), rel=1e-6)
        assert len(element.findall("collision")) == len(link.colliders)
        for read_piece, collider in zip(element.findall("collision"), link.colliders, strict=True):
            (shape,) = read_piece.find("geometry")  # type: ignore[misc]
            kind = "box" if collider.size is not None else collider.bar.kind if collider.bar is not None else "mesh"
            assert shape.tag == kind
            mu = float(read_piece.findtext("surface/friction/ode/mu", "nan"))
            assert mu == pytest.approx(collider.material.friction_dynamic[0], abs=1e-5)
            if kind == "mesh":
                mesh = trimesh.load(
                    trimesh.util.wrap_as_stream(model.files[shape.findtext("uri")].decode()), file_type="obj"
                )
                corners = collider.hull.vertices
                assert mesh.bounds == pytest.approx(np.stack([corners.min(axis=0), corners.max(axis=0)]), abs=1e-7)
        for uri in element.iterfind("visual/geometry/mesh/uri"):
            assert uri.text in model.files
    return model


@pytest.mark.parametrize("name", ["Bottle", "Globe", "StorageFurniture"])
def test_shipped_objects_read_back(name: str) -> None:
    robots = Robots(Session.of(name).sampler.batch(np.arange(2), 3))
    for i in range(2):
        check(robots.robot(i), seed=i)


def test_a_loop_is_a_ball_joint_where_it_closes() -> None:
    robot = Robots(Session.of("Foldingrack").sampler.batch(np.arange(1), 1)).robot(0)
    model = check(robot)
    for n, closure in enumerate(robot.closures):
        joint = model.joints[f"closure_{n}"]
        assert joint.get("type") == "ball"
        ends = [robot.links[k].name for k in closure.links]
        assert [joint.findtext("parent"), joint.findtext("child")] == ends
        assert floats(joint.find("pose"))[:3] + model.at_zero(ends[1]) == pytest.approx(
            model.at_zero(ends[0]) + closure.points[0], abs=1e-8
        )
    assert robot.closures
    apart = replace(robot.closures[0], points=(robot.closures[0].points[0] + 0.01, robot.closures[0].points[1]))
    with pytest.raises(ExportError, match="is open with all joints at 0"):
        sdf_files(replace(robot, closures=(apart,)))


def test_a_joint_that_sdf_cannot_state_is_refused() -> None:
    robot = Robots(Session.of("USB").sampler.batch(np.arange(1), 1)).robot(0)
    with pytest.raises(ExportError, match="planar"):
        sdf_files(replace(robot, joints=(replace(robot.joints[0], kind="planar"),)))


def test_gazebo_finds_the_model() -> None:
    robot = Robots(Session.of("USB").sampler.batch(np.arange(1), 1)).robot(0)
    config = ElementTree.fromstring(sdf_files(robot)["model.config"])
    assert config.findtext("sdf") == "model.sdf" and config.findtext("name") == robot.name


def test_python_writes_it(tmp_path) -> None:  # type: ignore[no-untyped-def]
    from artipg_dsl import sample

    batch = sample("USB", 2, seed=1)
    assert [path.relative_to(tmp_path).as_posix() for path in batch.to_sdf(tmp_path)] == [
        "objects/000000/model.sdf",
        "objects/000001/model.sdf",
    ]
    assert [path.name for path in batch.to_mjcf(tmp_path / "mjcf")] == ["object.xml", "object.xml"]
