"""Exported objects read back, format by format, reader by reader: the same object as our model.

A few categories and one object of each; ``ARTIPG_EVERY=1`` takes all of them, ``ARTIPG_EVERY=3`` three objects of each.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.export.registry import FORMATS
from artipg_dsl.robot.model import Robot
from artipg_dsl.robot.robots import Robots
from artipg_dsl.robot.substitute import simple_joints
from artipg_dsl.session import Session

from . import engines, files, others
from .reading import Reading, model_bounds, model_poses, random_values

ROOT = Path(__file__).parents[2]
EVERY = int(os.environ.get("ARTIPG_EVERY", "0"))
SHIPPED = sorted(path.stem for path in (ROOT / "categories").glob("*.apg"))
FEW = ["bottle", "chair", "faucet", "foldingrack"]  # every kind of joint, followers and a loop
FORMATS_READ = ("urdf", "mjcf", "sdf", "usd", "glb", "obj", "partnet-mobility")
# reader: (package, format, function, metres within which frames agree, share within which masses do)
READERS = {
    "mujoco-mjcf": ("mujoco", "mjcf", engines.mujoco_mjcf, 1e-6, 1e-6),
    "mujoco-urdf": ("mujoco", "urdf", engines.mujoco_urdf, 1e-6, 1e-6),
    "pybullet-urdf": ("pybullet", "urdf", engines.pybullet_urdf, 1e-6, 1e-6),
    "sapien-urdf": ("sapien", "urdf", engines.sapien_urdf, 1e-6, 1e-5),  # single precision
    "yourdfpy-urdf": ("yourdfpy", "urdf", files.yourdfpy_urdf, 1e-6, 1e-6),
    "usd-core": ("pxr", "usd", files.usd, 1e-6, 1e-5),  # single precision
    "drake-sdf": ("pydrake", "sdf", others.drake_sdf, 1e-6, 1e-6),
    "drake-urdf": ("pydrake", "urdf", others.drake_urdf, 1e-6, 1e-6),
    "pinocchio-urdf": ("pinocchio", "urdf", others.pinocchio_urdf, 1e-6, 1e-6),
    "newton-usd": ("newton", "usd", others.newton_usd, 2e-6, 1e-5),  # single precision
    "newton-urdf": ("newton", "urdf", others.newton_urdf, 2e-6, 1e-5),
    "trimesh-glb": ("trimesh", "glb", files.glb, 1e-6, 1e-6),
    "trimesh-obj": ("trimesh", "obj", files.obj, 1e-6, 1e-6),
    "yourdfpy-partnet": ("yourdfpy", "partnet-mobility", files.partnet, 1e-6, 1e-6),
}


@dataclass(frozen=True)
class Written:
    robot: Robot
    folder: Path


@pytest.fixture(scope="module", params=SHIPPED if EVERY else FEW)
def written(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> list[Written]:
    """Objects of a category in all formats, a folder for each format."""
    batch = Session.of(str(ROOT / "categories" / f"{request.param}.apg")).sampler.batch(np.arange(max(EVERY, 1)), 1)
    robots, made = Robots(batch), []
    for i in range(len(batch)):
        root = tmp_path_factory.mktemp(request.param)
        for name in FORMATS_READ:
            for path, data in FORMATS[name].files(robots, i).items():
                (root / name / path).parent.mkdir(parents=True, exist_ok=True)
                (root / name / path).write_bytes(data)
        made.append(Written(robots.robot(i), root))
    return made


@pytest.mark.parametrize("reader", READERS)
def test_read_back_it_is_the_same_object(written: list[Written], reader: str) -> None:
    package, form, read, near, share = READERS[reader]
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed: pip install 'artipg_dsl[test,sim,readers]'")
    for one in written:
        robot = simple_joints(one.robot) if form == "urdf" else one.robot
        found = read(one.folder / form, robot)
        links(found, robot, form, share)
        limits(found, robot, form)
        poses(found, robot, form, near)
        if found.bounds is not None:
            assert found.bounds == pytest.approx(model_bounds(robot, found.seen_at), abs=2e-6)


def links(found: Reading, robot: Robot, form: str, share: float) -> None:
    """Names, and of each link mass, centre of mass, inertia and the number of colliders."""
    seen = {link.name for link in robot.links if link.visuals or form != "obj"}
    assert set(found.bodies) == seen
    for link in robot.links:
        body = found.bodies.get(link.name)
        if body is None:
            continue
        if body.mass is not None:
            assert body.mass == pytest.approx(link.mass, rel=share), link.name
        if body.center is not None:
            assert body.center == pytest.approx(link.center, abs=1e-6), link.name
        if body.inertia is not None:
            assert body.inertia == pytest.approx(link.inertia, abs=10 * share * float(np.trace(link.inertia))), (
                link.name
            )
        if body.colliders is not None:
            assert body.colliders == len(link.colliders), link.name


def limits(found: Reading, robot: Robot, form: str) -> None:
    if found.joints is None:
        return
    wanted: dict[str, tuple[float, float] | None] = {}
    for joint in robot.joints:
        free = joint.kind in ("continuous", "ball") or joint.low is None or joint.high is None
        if joint.kind != "fixed":
            wanted[joint.name] = None if free else (joint.low, joint.high)
        if form == "mjcf" and joint.kind == "screw":
            wanted[f"{joint.name}_advance"] = None
        if form == "partnet-mobility" and joint.kind not in ("revolute", "prismatic", "continuous"):
            wanted.pop(joint.name, None)
    assert set(found.joints) == set(wanted)
    for name, ends in wanted.items():
        read = found.joints[name]
        assert (read is None) == (ends is None), name
        assert ends is None or read == pytest.approx(ends, rel=1e-6, abs=1e-7), name


def poses(found: Reading, robot: Robot, form: str, near: float) -> None:
    """Where all links are in random states."""
    if found.poses is None:
        return
    for seed in range(3):
        values = random_values(robot, seed)
        if form == "partnet-mobility":  # what its words cannot say stays where it is
            values = {j.name: 0.0 if j.kind in ("screw", "ball") else values[j.name] for j in robot.joints}
        there, wanted = found.poses(values), model_poses(robot, values)
        assert set(there) == set(wanted)
        for name, place in wanted.items():
            assert there[name][:3, 3] == pytest.approx(place[:3, 3], abs=near), (name, values)
            assert there[name][:3, :3] == pytest.approx(place[:3, :3], abs=2e-6), (name, values)
