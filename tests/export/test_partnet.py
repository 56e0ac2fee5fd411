"""The folder of PartNet-Mobility, read as its readers do: by URDF, by mobility_v2.json, by semantics.txt, by points."""

from __future__ import annotations

import json
import os
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from artipg_dsl import Samples, sample
from artipg_dsl.export.partnet.mobility import partnet_files
from artipg_dsl.export.partnet.words import CATEGORIES
from artipg_dsl.export.write import ExportError
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session
from tests.vice import VICE

EVERY = os.environ.get("ARTIPG_EVERY") == "1"
WORDS = {"hinge", "slider", "slider+", "free", "heavy", "static"}
OURS = ["Microwave", "StorageFurniture", "Chair"]


class Folder:
    """An object's folder with our own tables of the same object."""

    def __init__(self, batch: Samples, root: Path):
        self.path = batch.export(root, "partnet-mobility")[0]
        self.batch = batch
        self.mobility = json.loads((self.path / "mobility_v2.json").read_text())
        self.unit = json.loads((self.path / "meta.json").read_text())["metres_per_unit"]
        bounds = batch.meshes(np.zeros(len(batch.joints().owner)))[0].bounds
        self.center = bounds.mean(axis=0)
        self.joints, self.links = batch.joints(), batch.links()
        children = self.joints.child.tolist()
        self.order = [k for k in range(len(self.links.owner)) if k in children] + [0]  # ours by the folder's id

    def raw(self, points: np.ndarray) -> np.ndarray:
        """Ours (x front, y left, z up) as x right for who faces the object, y up, z front."""
        points = (points - self.center) / self.unit
        return np.stack([points[..., 1], points[..., 2], points[..., 0]], axis=-1)

    def world(self, points: np.ndarray) -> np.ndarray:
        x, y, z = np.moveaxis(self.raw(points), -1, 0)
        return np.stack([-z, -x, y], axis=-1)

    def joint_of(self, id: int) -> int:
        return self.joints.child.tolist().index(self.order[id])

    def random_state(self) -> tuple[np.ndarray, dict[str, float]]:
        """Values of our joints, and the same under the folder's names and in its unit."""
        values = self.batch.joint_values("random:1")[0]
        theirs = {}
        for entry in self.mobility:
            if entry["parent"] >= 0 and entry["joint"] != "static":
                value = values[self.joint_of(entry["id"])]
                row = self.joint_of(entry["id"])
                per = self.joints.pitch[row] / (2 * np.pi) if entry["joint"] == "slider+" else 1.0
                theirs[f"joint_{entry['id']}"] = float(value if entry["joint"] == "hinge" else value * per / self.unit)
        return values, theirs

    def check_poses(self, values: np.ndarray, transforms: dict[str, np.ndarray], tolerance: float) -> None:
        """Points of every link where our own tables have them; ``transforms`` from link frames to the world."""
        turn, shift = self.batch.batch.pose(values)
        still = np.random.default_rng(0).uniform(-0.3, 0.3, (5, 3))
        origins = {e["id"]: e["jointData"]["axis"]["origin"] for e in self.mobility if e["jointData"]}
        for id, ours in enumerate(self.order):
            local = self.raw(still) - np.array(origins.get(id, (0, 0, 0)))
            found = local @ transforms[f"link_{id}"][:3, :3].T + transforms[f"link_{id}"][:3, 3]
            assert found == pytest.approx(self.world(still @ turn[ours].T + shift[ours]), abs=tolerance)


@pytest.fixture(scope="module", params=OURS)
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Folder:
    return Folder(sample(request.param, numbers=[2], seed=7), tmp_path_factory.mktemp("partnet"))


def test_every_file_is_there(folder: Folder) -> None:
    names = {p.name for p in folder.path.iterdir()}
    assert names == {
        "mobility.urdf",
        "mobility_vhacd.urdf",
        "mobility_cvx.urdf",
        "mobility_v2.json",
        "semantics.txt",
        "result.json",
        "bounding_box.json",
        "meta.json",
        "textured_objs",
        "point_sample",
    }
    meta = json.loads((folder.path / "meta.json").read_text())
    assert meta.pop("metres_per_unit") == folder.unit and all(isinstance(value, str) for value in meta.values())
    assert {"model_id", "anno_id", "user_id", "time_in_sec", "version", "model_cat"} <= set(meta)
    assert meta["model_cat"] in CATEGORIES and "_" not in meta["model_id"]


def test_frame_and_size(folder: Folder) -> None:
    box = json.loads((folder.path / "bounding_box.json").read_text())
    low, high = np.array(box["min"]), np.array(box["max"])
    assert low + high == pytest.approx(0, abs=1e-8) and np.linalg.norm(high) == pytest.approx(1, abs=1e-8)
    meshes = (folder.path / "textured_objs").glob("original-*.obj")
    loaded = [trimesh.load(p, force="mesh", process=False) for p in meshes]
    points = np.concatenate([mesh.vertices for mesh in loaded])
    assert points.min(axis=0) == pytest.approx(low, abs=1e-7) and points.max(axis=0) == pytest.approx(high, abs=1e-7)


def test_semantics_are_three_tokens_for_every_link(folder: Folder) -> None:
    text = (folder.path / "semantics.txt").read_text()
    rows = [line.split(" ") for line in text.splitlines()]
    assert text.endswith("\n") and "\n\n" not in text and all(len(row) == 3 for row in rows)
    assert [row[0] for row in rows] == [f"link_{k}" for k in range(len(folder.order))]
    assert {row[1] for row in rows} <= WORDS and rows[-1][1] in ("heavy", "free")
    for entry, (_, word, label) in zip(folder.mobility, rows, strict=True):
        assert (entry["joint"], entry["name"]) == (word, label)


def test_mobility_tells_the_joints_of_our_annotation(folder: Folder) -> None:
    annotated = folder.batch.annotations()[0]
    assert [entry["id"] for entry in folder.mobility] == list(range(len(folder.order)))
    assert folder.mobility[-1]["parent"] == -1 and folder.mobility[-1]["jointData"] == {}
    assert len(annotated["joints"]) == len(folder.mobility) - 1
    for entry in folder.mobility[:-1]:
        joint = annotated["joints"][folder.joint_of(entry["id"])]
        row = folder.joint_of(entry["id"])
        parent = folder.order[entry["parent"]]
        assert annotated["links"][parent]["name"] == joint["parent"]
        axis, limit = entry["jointData"]["axis"], entry["jointData"]["limit"]
        assert axis["direction"] == pytest.approx(np.roll(folder.joints.axis[row], -1), abs=1e-8)
        assert axis["origin"] == pytest.approx(folder.raw(folder.joints.origin[row]), abs=1e-8)
        if joint["type"] == "prismatic":
            assert entry["joint"] == "slider"
            assert [limit["a"] * folder.unit, limit["b"] * folder.unit] == pytest.approx(joint["range"], abs=1e-8)
        else:
            assert entry["joint"] == "hinge" and limit["noLimit"] == (joint["type"] == "continuous")
            if not limit["noLimit"]:
                assert np.radians([limit["a"], limit["b"]]) == pytest.approx(joint["range"], abs=1e-8)


def test_leaves_agree_between_tree_mobility_urdf_and_points(folder: Folder) -> None:
    (tree,) = json.loads((folder.path / "result.json").read_text())
    leaves: dict[int, dict] = {}

    def walk(node: dict) -> None:
        assert set(node) == {"id", "name", "text", "objs"} if "objs" in node else {"id", "name", "text", "children"}
        leaves.update({node["id"]: node} if "objs" in node else {})
        for child in node.get("children", []):
            walk(child)

    walk(tree)
    assert tree["id"] == 0
    assert {part["id"] for entry in folder.mobility for part in entry["parts"]} == set(leaves)
    stems = [stem for leaf in leaves.values() for stem in leaf["objs"]]
    assert sorted(stems) == sorted(p.stem for p in (folder.path / "textured_objs").glob("original-*.obj"))
    assert len(set(stems)) == len(stems) and all(re.fullmatch(r"original-\d+", stem) for stem in stems)
    urdf = ElementTree.parse(folder.path / "mobility.urdf").getroot()
    for visual in urdf.iter("visual"):
        name, _, id = visual.attrib["name"].rpartition("-")
        stem = Path(visual.find("geometry/mesh").attrib["filename"]).stem  # type: ignore[union-attr]
        assert leaves[int(id)]["name"] == name and stem in leaves[int(id)]["objs"]
    sampled = np.loadtxt(folder.path / "point_sample" / "sample-points-all-pts-nor-rgba-10000.txt")
    points = np.loadtxt(folder.path / "point_sample" / "pts-10000.txt")
    labels = np.loadtxt(folder.path / "point_sample" / "label-10000.txt", dtype=int)
    assert sampled.shape == (10000, 10) and (sampled[:, :3] == points).all()
    assert (labels == np.loadtxt(folder.path / "point_sample" / "sample-points-all-label-10000.txt", dtype=int)).all()
    assert np.linalg.norm(sampled[:, 3:6], axis=1) == pytest.approx(1, abs=1e-5)
    assert sampled[:, 6:9].min() >= 0 and sampled[:, 6:9].max() <= 255 and len(set(labels)) > len(leaves) / 4
    for label in set(labels.tolist()):
        meshes = [trimesh.load(folder.path / "textured_objs" / f"{s}.obj", force="mesh") for s in leaves[label]["objs"]]
        corners = np.concatenate([mesh.bounds for mesh in meshes])
        own = points[labels == label]  # a mesh of a round thing lies a little inside of it
        assert (own >= corners.min(axis=0) - 0.01).all() and (own <= corners.max(axis=0) + 0.01).all()


def test_every_mesh_of_the_urdf_lies_where_readers_look(folder: Folder) -> None:
    """What the reader of the data set calls usable, and well formed: the URDF names the OBJs of `textured_objs/`."""
    present = {f"textured_objs/{path.name}" for path in (folder.path / "textured_objs").glob("*.obj")}
    named = {
        mesh.attrib["filename"] for mesh in ElementTree.parse(folder.path / "mobility.urdf").getroot().iter("mesh")
    }
    assert named == present


# paths of PartNet's part vocabularies before merging, those that objects below may have
def test_the_urdf_is_as_the_data_set_writes_it(folder: Folder) -> None:
    urdf = ElementTree.parse(folder.path / "mobility.urdf").getroot()
    assert urdf.attrib["name"].startswith("partnet_") and [link.attrib["name"] for link in urdf.findall("link")] == [
        "base",
        *(f"link_{k}" for k in range(len(folder.order))),
    ]
    roots = [joint for joint in urdf.findall("joint") if joint.find("parent").attrib["link"] == "base"]  # type: ignore[union-attr]
    assert len(roots) == 1 and roots[0].attrib["type"] == "fixed" and roots[0].find("axis") is None
    assert roots[0].find("origin").attrib["rpy"] == "1.570796326794897 0 -1.570796326794897"  # type: ignore[union-attr]
    for joint in urdf.findall("joint"):
        assert joint.find("child").attrib["link"] == joint.attrib["name"].replace("joint", "link")  # type: ignore[union-attr]
        assert joint.find("origin") is not None
        if joint.attrib["type"] in ("revolute", "prismatic"):
            assert set(joint.find("limit").attrib) == {"lower", "upper"}  # type: ignore[union-attr]
    assert not list(urdf.iter("inertial"))
    for link in urdf.findall("link")[1:]:
        assert link.findall("visual") and link.findall("collision")
        origins = {e.attrib["xyz"] for e in link.iter("origin")}
        assert len(origins) == 1
    for name in ("mobility_vhacd.urdf", "mobility_cvx.urdf"):
        assert (folder.path / name).read_bytes() == (folder.path / "mobility.urdf").read_bytes()


def test_yourdfpy_moves_it_as_we_do(folder: Folder) -> None:
    yourdfpy = pytest.importorskip("yourdfpy", reason="yourdfpy is not installed")
    robot = yourdfpy.URDF.load(str(folder.path / "mobility.urdf"), load_meshes=True, build_scene_graph=True)
    values, theirs = folder.random_state()
    assert set(robot.actuated_joint_names) == set(theirs)
    robot.update_cfg(theirs)
    names = [f"link_{k}" for k in range(len(folder.order))]
    folder.check_poses(values, {name: robot.get_transform(name, "base") for name in names}, 1e-6)


@pytest.mark.filterwarnings("ignore:Failed to find system libvulkan")
def test_sapien_loads_and_moves_it(folder: Folder, tmp_path: Path) -> None:
    sapien = pytest.importorskip("sapien", reason="sapien is not installed")
    from sapien import physx

    # without a graphics card sapien loads no visuals: a copy beside the original goes without
    tree = ElementTree.parse(folder.path / "mobility.urdf")
    for link in tree.getroot().findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    bare = folder.path / "bare.urdf"
    tree.write(bare)
    try:
        loader = sapien.Scene([physx.PhysxCpuSystem()]).create_urdf_loader()
        loader.fix_root_link = True
        robot = loader.load(str(bare))
    finally:
        bare.unlink()
    values, theirs = folder.random_state()
    active = [joint.name for joint in robot.get_active_joints()]
    assert set(active) == set(theirs)
    for joint in robot.get_active_joints():
        data = folder.mobility[int(joint.name.split("_")[1])]
        limit = data["jointData"]["limit"]
        ends = np.array([limit["a"], limit["b"]])
        expected = (
            np.array([-np.inf, np.inf]) if limit["noLimit"] else np.radians(ends) if data["joint"] == "hinge" else ends
        )
        assert joint.get_limits()[0] == pytest.approx(expected, abs=1e-5)
    robot.set_qpos(np.array([theirs[name] for name in active]))
    poses = {link.name: link.get_entity_pose().to_transformation_matrix() for link in robot.get_links()}
    folder.check_poses(values, poses, 1e-5)  # sapien computes in single precision
    collisions = len(list(tree.getroot().iter("collision")))
    shapes = sum(len(link.get_collision_shapes()) for link in robot.get_links())
    assert shapes == collisions


def test_bytes_do_not_depend_on_the_batch() -> None:
    one = partnet_files(Robots(sample("Microwave", numbers=[3], seed=7).batch), 0)
    assert one == partnet_files(Robots(sample("Microwave", 5, seed=7).batch), 3)


def test_screws_advance_and_balls_keep_still(monkeypatch: pytest.MonkeyPatch) -> None:
    robots = Robots(sample("Microwave", 1, seed=7).batch)
    robot = robots.robot(0)
    door = robot.joints[0]
    assert door.kind == "revolute" and door.high is not None

    def changed(**values: object) -> dict[str, bytes]:
        joints = (replace(door, **values), *robot.joints[1:])
        monkeypatch.setattr(robots, "robot", lambda _: replace(robot, joints=joints))
        return partnet_files(robots, 0)

    files = changed(kind="screw", pitch=0.02)
    unit = json.loads(files["meta.json"])["metres_per_unit"]
    entry = json.loads(files["mobility_v2.json"])[0]
    limit = entry["jointData"]["limit"]
    assert (
        entry["joint"] == "slider+"
        and limit["rotates"]
        and limit["rotationLimit"] == pytest.approx(np.degrees(door.high))
    )
    assert limit["b"] * unit == pytest.approx(0.02 * door.high / (2 * np.pi), abs=1e-8)
    joint = ElementTree.fromstring(files["mobility.urdf"]).find("joint[@name='joint_0']")
    assert joint is not None and joint.attrib["type"] == "prismatic" and joint.find("limit") is not None
    files = changed(kind="ball")
    assert files["semantics.txt"].startswith(b"link_0 static door\n")
    assert json.loads(files["mobility_v2.json"])[0]["jointData"] == {}
    joint = ElementTree.fromstring(files["mobility.urdf"]).find("joint[@name='joint_0']")
    assert joint is not None and joint.attrib["type"] == "fixed" and joint.find("axis") is None


def test_left_handed_screws_have_their_lower_limit_first() -> None:
    """Of two mirrored screws one goes along its axis, the other against it, and as far."""
    batch = Session.of_text(VICE).sampler.batch(np.arange(1), 1)
    assert batch.joints().pitch[1:].tolist() == pytest.approx([0.003, -0.003])
    files = partnet_files(Robots(batch), 0)
    unit = json.loads(files["meta.json"])["metres_per_unit"]
    entries = json.loads(files["mobility_v2.json"])
    screws = [entry for entry in entries if entry["joint"] == "slider+"]
    ends = [[entry["jointData"]["limit"][end] * unit for end in "ab"] for entry in screws]
    assert ends == [pytest.approx([0, 0.006], abs=1e-8), pytest.approx([-0.006, 0], abs=1e-8)]
    urdf = ElementTree.fromstring(files["mobility.urdf"])
    for entry, (low, high) in zip(screws, ends, strict=True):
        limit = urdf.find(f"joint[@name='joint_{entry['id']}']/limit")
        assert limit is not None and limit.attrib.keys() == {"lower", "upper"}
        read = [float(limit.attrib[end]) * unit for end in ("lower", "upper")]
        assert read == pytest.approx([low, high], abs=1e-8)
    (key,) = (entry for entry in entries if entry["joint"] == "slider")
    one, other = key["jointData"]["enabled_when"]
    assert one.keys() == {"id", "from"} and one["from"] * unit == pytest.approx(0.003, abs=1e-8)
    assert other.keys() == {"id", "to"} and other["to"] * unit == pytest.approx(-0.003, abs=1e-8)


def test_what_it_cannot_state_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    batch = sample("Microwave", 1, seed=7)
    robots = Robots(batch.batch)
    robot = robots.robot(0)
    for changed in ({"kind": "gear"}, {"kind": "prismatic", "low": None}):
        joints = (replace(robot.joints[0], **changed), *robot.joints[1:])
        monkeypatch.setattr(robots, "robot", lambda _, joints=joints: replace(robot, joints=joints))
        with pytest.raises(ExportError, match="cannot express"):
            partnet_files(robots, 0)


def test_a_folder_without_meshes_says_so_and_is_the_same_else(tmp_path: Path) -> None:
    """What it has is what the whole folder has; what it has not is named nowhere."""
    batch = sample("Microwave", numbers=[2], seed=7, checked=False)
    (whole,), (bare,) = (
        batch.export(tmp_path / "a", "partnet-mobility"),
        batch.export(tmp_path / "b", "partnet-mobility.bare"),
    )
    names = {path.relative_to(bare).as_posix() for path in bare.rglob("*") if path.is_file()}
    points = {f"point_sample/{path.name}" for path in (whole / "point_sample").iterdir()}
    told = {"mobility_v2.json", "semantics.txt", "bounding_box.json", *points}
    assert names == told | {"mobility.urdf", "result.json", "meta.json"} and len(points) == 4
    for name in told:
        assert (bare / name).read_bytes() == (whole / name).read_bytes(), name
    meta, full = (json.loads((path / "meta.json").read_text()) for path in (bare, whole))
    assert meta == full | {"meshes": "none"}
    text, parts = (bare / "mobility.urdf").read_text(), (bare / "result.json").read_text()
    assert "mesh" not in text and "original-" not in parts and json.loads(parts)[0]["children"]
    urdf, other = (ElementTree.parse(path / "mobility.urdf").getroot() for path in (bare, whole))
    assert [ElementTree.tostring(j) for j in urdf.iter("joint")] == [
        ElementTree.tostring(j) for j in other.iter("joint")
    ]
    assert [link.attrib for link in urdf.iter("link")] == [link.attrib for link in other.iter("link")]


def test_one_kind_of_folder_takes_the_place_of_the_other(tmp_path: Path) -> None:
    batch = sample("Microwave", numbers=[2], seed=7, checked=False)
    (folder,) = batch.export(tmp_path, "partnet-mobility.bare")
    batch.export(tmp_path, "partnet-mobility")  # which is not there yet
    assert (folder / "mobility_cvx.urdf").exists() and '"meshes"' not in (folder / "meta.json").read_text()
    with pytest.raises(ExportError, match="exists"):
        batch.export(tmp_path, "partnet-mobility.bare")
    batch.export(tmp_path, "partnet-mobility.bare", force=True)
    left = {path.name for path in folder.iterdir()}
    assert not left & {"textured_objs", "mobility_cvx.urdf", "mobility_vhacd.urdf"} and "mobility.urdf" in left
    with pytest.raises(ExportError, match="has the files of partnet-mobility"):
        batch.export(tmp_path, "partnet-mobility,partnet-mobility.bare")


@pytest.mark.filterwarnings("ignore:Failed to find system libvulkan")
def test_sapien_loads_an_export_without_a_render_device(tmp_path: Path) -> None:
    """What is written, as it is written: the loader makes a render shape of each visual, so one file has none."""
    sapien = pytest.importorskip("sapien", reason="sapien is not installed")
    from sapien import physx

    (folder,) = sample("Microwave", numbers=[2], seed=7).export(tmp_path, "urdf")
    seen, bare = (ElementTree.parse(folder / f"object{kind}.urdf").getroot() for kind in ("", "_physics"))
    assert list(seen.iter("visual")) and not list(bare.iter("visual")) and not list(bare.iter("material"))
    for tag in ("link", "joint", "inertial", "collision"):
        assert len(list(seen.iter(tag))) == len(list(bare.iter(tag)))
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    robot = scene.create_urdf_loader().load(str(folder / "object_physics.urdf"))
    assert {link.name for link in robot.get_links()} == {link.attrib["name"] for link in seen.findall("link")}
    assert len(robot.get_active_joints()) == sum(j.attrib["type"] != "fixed" for j in seen.findall("joint"))
