"""Files of real objects: every kind gives the same cloud, and what is wrong with a file is said."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
import trimesh

from artipg_dsl.errors import UserError
from artipg_dsl.fit.finding import find_files
from artipg_dsl.fit.given import read_objects
from artipg_dsl.fit.reading import read_cloud
from artipg_dsl.fit.sources import File, mark, name_files

SIZE = np.array([0.2, 0.4, 0.6])
ROBOT = """<robot name="r"><link name="base"><visual><geometry><box size="0.2 0.4 0.3"/></geometry></visual></link>
<link name="lid"><visual><origin xyz="0 0 0.15"/><geometry><mesh filename="lid.stl" scale="0.001 0.001 0.001"/></geometry></visual></link>
<joint name="j" type="fixed"><parent link="base"/><child link="lid"/><origin xyz="0 0 0.15"/></joint></robot>"""


@pytest.mark.parametrize("suffix", ["obj", "ply", "glb", "stl", "off"])
def test_kinds_of_meshes(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"box.{suffix}"
    trimesh.creation.box(SIZE).export(path)
    cloud = read_cloud(path)
    assert np.allclose(np.ptp(cloud.points, axis=0), SIZE, atol=2e-3)
    assert cloud.normals is not None and ((cloud.points * cloud.normals).sum(axis=1) > 0).all()


def test_points_with_and_without_normals(tmp_path: Path) -> None:
    points, face = trimesh.sample.sample_surface(trimesh.creation.box(SIZE), 500, seed=1)
    normals = trimesh.creation.box(SIZE).face_normals[face]
    np.savetxt(tmp_path / "a.xyz", points)
    np.savez(
        tmp_path / "b.npz", points=points, normals=normals, link_id=np.arange(500) % 2, link_names=["door", "body"]
    )
    trimesh.PointCloud(points).export(tmp_path / "c.ply")
    plain, told, cloud = (read_cloud(path) for path in find_files([str(tmp_path)]))
    assert plain.normals is None and cloud.normals is None and told.normals is not None
    assert told.names == ("door", "body") and set(told.label) == {0, 1}
    (tmp_path / "one").mkdir()
    trimesh.creation.box(SIZE).export(tmp_path / "one" / "object.obj")
    np.savez(tmp_path / "one" / "cloud.npz", points=points)
    assert find_files([str(tmp_path / "one")]) == [tmp_path / "one" / "object.obj"]  # both are of one object
    for one in (plain, told, cloud):
        assert np.allclose(np.sort(one.points[:, 0]), np.sort(points[:, 0]), atol=1e-6)


def test_one_urdf_of_each_object_in_a_folder(tmp_path: Path) -> None:
    for name in ("chair", "chair_fixed", "chair_physics", "chairs", "table_fixed"):
        (tmp_path / f"{name}.urdf").write_text("<robot/>")
    told: list[str] = []
    robots = [path.stem for path in find_files([str(tmp_path)], told.append)]
    assert robots == ["chair", "chairs", "table_fixed"]
    assert told == [
        f"2 URDF files are other ways to write objects of {tmp_path}: chair_fixed.urdf, for example, is chair.urdf"
    ]
    named = [str(tmp_path / "chair_fixed.urdf")]
    assert [str(path) for path in find_files(named)] == named  # who names it means it
    assert len(find_files([str(tmp_path)])) == 5


def test_a_robot_stands_with_its_joints_at_zero(tmp_path: Path) -> None:
    trimesh.creation.box([200, 400, 300]).export(tmp_path / "lid.stl")
    (tmp_path / "robot.urdf").write_text(ROBOT)
    assert find_files([str(tmp_path)]) == [tmp_path / "robot.urdf"]  # and not the mesh that belongs to it
    cloud = read_cloud(tmp_path / "robot.urdf")
    assert np.allclose(np.ptp(cloud.points, axis=0), SIZE, atol=2e-3) and cloud.names == ("base", "lid")


def test_marks_tell_of_all_that_a_file_is_read_from(tmp_path: Path) -> None:
    """The visible meshes of a URDF, a glTF among them, and the buffers of that."""
    robot, box = tmp_path / "robot.urdf", trimesh.creation.box(SIZE)
    robot.write_text(ROBOT.replace("lid.stl", "package://robots/lid.gltf"))
    empty = mark(robot)
    marks = []
    for size in (1.0, 2.0):
        (tmp_path / "robots").mkdir(exist_ok=True)
        for name, content in trimesh.Scene([box.copy().apply_scale(size)]).export(file_type="gltf").items():
            (tmp_path / "robots" / ("lid.gltf" if name == "model.gltf" else name)).write_bytes(content)
        marks.append((mark(robot), mark(tmp_path / "robots" / "lid.gltf")))
    assert len({empty, *(one for pair in marks for one in pair)}) == 5
    moved = tmp_path / "moved"
    moved.mkdir()
    (tmp_path / "robots").rename(moved / "robots")
    assert mark(robot.rename(moved / "robot.urdf")) == marks[1][0] and mark(moved / "robot.urdf") != empty
    for text in ("<robot", "<robot><visual><mesh filename='robot.urdf'/></visual></robot>"):
        (moved / "robot.urdf").write_text(text)
        assert mark(moved / "robot.urdf")


def test_names_are_those_of_files(tmp_path: Path) -> None:
    """Whatever files are called: other files are named by them."""
    odd = Path(str(tmp_path) + "/b\udcffd.obj")
    paths = [tmp_path / "bind.obj", tmp_path / "a" / ("é" * 124 + ".obj"), tmp_path / ("é" * 124 + ".obj"), odd]
    names = [item.name for item in name_files(paths)]
    assert len(set(names)) == 4 and names[0] == "bind" and names[3] == "b\ufffdd"
    assert all(0 < len(name.encode()) < 210 for name in names)
    with pytest.raises(UserError, match="not in UTF-8"):
        File(odd).read()


def test_nothing_but_our_words_is_said_of_a_file(tmp_path: Path) -> None:
    """trimesh logs a traceback of normals that it cannot read, and reads on; NumPy left files open that it refused."""
    text = trimesh.creation.box(SIZE).export(file_type="stl_ascii").replace("facet normal 0", "facet normal x", 1)
    (tmp_path / "a.stl").write_text(text)
    (tmp_path / "b.npz").write_bytes(b"PK\x05\x06" + bytes(18))
    read = "from pathlib import Path; from artipg_dsl.fit.reading import read_cloud; read_cloud(Path(r'{}'))"
    said = [
        subprocess.run(
            [sys.executable, "-W", "always::ResourceWarning", "-c", read.format(tmp_path / name)],
            capture_output=True,
            text=True,
        ).stderr
        for name in ("a.stl", "b.npz")
    ]
    assert said[0] == ""
    assert "b.npz has no array `points`" in said[1] and "ResourceWarning" not in said[1]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("points", "normals"), [(1e308, 1.0), (1.0, 1e200)])
def test_what_is_too_large_is_told_without_a_warning(tmp_path: Path, points: float, normals: float) -> None:
    cube = np.random.Generator(np.random.PCG64(1)).random((300, 3)) - 0.5
    np.savez(tmp_path / "a.npz", points=4 * points * cube, normals=normals * cube)
    with pytest.raises(UserError, match=r"a\.npz"):
        read_cloud(tmp_path / "a.npz")


def test_a_large_folder_is_listed_at_once(tmp_path: Path) -> None:
    """Each file was held against every other: of a thousand clouds and robots that took half a minute."""
    for k in range(1000):
        (tmp_path / f"{k}.npz").touch()
        (tmp_path / "robots" / str(k)).mkdir(parents=True)
        for name in ("object.urdf", "object_fixed.urdf", "a.obj", "b.obj"):
            (tmp_path / "robots" / str(k) / name).touch()
    begun, told = time.process_time(), list[str]()
    assert len(find_files([str(tmp_path)], told.append)) == 2000 and len(told) == 2
    assert time.process_time() - begun < 5.0


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("a.obj", b"", "a.obj is empty"),
        ("a.gltf", b"", "a.gltf is empty"),
        ("a.stl", b"solid\x00nonsense", "a.stl"),
        ("a.glb", b"glTF", "a.glb cannot be read as glb"),
        ("a.xyz", b"1 2\n3 4\n", "a.xyz, line 1: `1 2` has 2 numbers"),
        ("a.xyz", b"# x y z\n1 2 3\n3 4\n", "a.xyz, line 3: `3 4` has 2 numbers, those above 3"),
        ("a.xyz", b"0,1 0,2 0,3\n", "a.xyz, line 1: `0,1 0,2 0,3` is not numbers"),
        ("a.xyz", b"// x y z\n", "a.xyz has no points"),
        ("a.xyz", b"1 2 3\n", "too few to see a shape"),
        ("a.xyz", b"nan nan nan\n" * 300, "are no numbers"),
        ("a.xyz", b"".join(b"%d 0 0\n" % k for k in range(300)), "is a line, not a surface"),
        ("a.xyz", b"1 2 3\n" * 300, "there is no shape in it"),
        ("a.npz", b"PK", "cannot be read as npz: it is no archive"),
        ("a.npz", b"points", "cannot be read as npz: it is no archive"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "without area"),
        ("a.urdf", b"<robot", "cannot be read as urdf"),
        ("a.urdf", b'<robot name="r"><link name="a"/></robot>', "has no visible shapes"),
        ("a.blend", b"", "is no kind that can be read"),
    ],
)
def test_what_is_wrong_with_a_file(tmp_path: Path, name: str, content: bytes, told: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(UserError) as wrong:
        read_cloud(tmp_path / name)
    assert told in wrong.value.message


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("lid.stl", "nothing.stl", "robot.urdf names a mesh that is not there: nothing.stl"),
        ('"0.2 0.4 0.3"', '"0.2 0.4"', "`size` of a <box> is `0.2 0.4`: 3 numbers are needed"),
        ('xyz="0 0 0.15"', 'xyz="0 0 high"', "`xyz` of a <origin> is `0 0 high`: 3 numbers are needed"),
        (
            '<box size="0.2 0.4 0.3"/>',
            '<cylinder radius="1"/>',
            "`length` of a <cylinder> is missing: a number is needed",
        ),
        (
            '<box size="0.2 0.4 0.3"/>',
            '<capsule radius="1" length="1"/>',
            "robot.urdf has a visible <capsule>, which is no shape of a URDF",
        ),
    ],
)
def test_what_is_wrong_with_a_robot(tmp_path: Path, old: str, new: str, told: str) -> None:
    trimesh.creation.box([200, 400, 300]).export(tmp_path / "lid.stl")
    assert old in ROBOT
    (tmp_path / "robot.urdf").write_text(ROBOT.replace(old, new))
    with pytest.raises(UserError) as error:
        read_cloud(tmp_path / "robot.urdf")
    assert told in error.value.message


def test_files_that_no_robot_names_are_told(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "robot.urdf").write_text(ROBOT)
    for name in ("lid.stl", "mug.obj"):
        (tmp_path / "meshes" / name).write_text("")
    told: list[str] = []
    assert find_files([str(tmp_path)], told.append) == [tmp_path / "robot.urdf"]
    assert len(told) == 1 and told[0].startswith("1 of the files in") and "mug.obj, for example" in told[0]
    with mock.patch.object(Path, "read_text", side_effect=PermissionError):
        assert find_files([str(tmp_path)], told.append) == [tmp_path / "robot.urdf"]


def test_what_was_fitted_is_no_real_object(tmp_path: Path) -> None:
    """An output folder among the scans, whose objects were exported, or that is the folder of the scans."""
    for place in (tmp_path, tmp_path / "fitted"):
        (place / "objects" / "000000" / "obj").mkdir(parents=True)
        (place / "objects" / "000000" / "obj" / "body.obj").write_text("")
    (tmp_path / "scan.obj").write_text("")
    assert len(find_files([str(tmp_path)])) == 3
    for place in (tmp_path, tmp_path / "fitted"):
        (place / "fit.json").write_text("{}")
    assert find_files([str(tmp_path)]) == [tmp_path / "scan.obj"]
    assert len(find_files([str(tmp_path / "fitted" / "objects")])) == 1  # said in so many words


def test_a_file_that_went_away(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="there is no file"):
        read_cloud(tmp_path / "gone.obj")
    (tmp_path / "link.obj").symlink_to("gone.obj")
    assert find_files([str(tmp_path)]) == [tmp_path / "link.obj"]


@pytest.mark.parametrize("word", ["g", "o"])
def test_groups_and_objects_of_obj_are_labels(tmp_path: Path, word: str) -> None:
    corners = "\n".join(f"v {x} {y} {z}" for z in (0, 1) for x, y in ((0, 0), (2, 0), (0, 1)))
    (tmp_path / "a.obj").write_text(f"{corners}\n{word} upper\nf 4 5 6\n{word} base\nf 1 3 2\n")
    cloud = read_cloud(tmp_path / "a.obj")
    assert cloud.names == ("base", "upper")
    assert np.array_equal(cloud.points[:, 2] > 0.5, cloud.label == 1) and 0 < cloud.label.mean() < 1


def test_points_that_are_no_numbers_are_left_out_and_told(tmp_path: Path) -> None:
    points = np.random.default_rng(0).random((1000, 3))
    points[::4, 1] = np.nan
    np.savez(tmp_path / "a.npz", points=points)
    cloud = read_cloud(tmp_path / "a.npz")
    assert len(cloud.points) == 750 and np.isfinite(cloud.points).all()
    assert cloud.lost == "250 of 1000 points are no numbers"
    np.savez(tmp_path / "b.npz", points=points[1::4])
    assert read_cloud(tmp_path / "b.npz").lost == ""


def test_normals_of_text_are_told_from_colours(tmp_path: Path) -> None:
    box = trimesh.creation.box(SIZE)
    points, face = trimesh.sample.sample_surface(box, 500, seed=1)
    normals, colours = box.face_normals[face], np.tile([12.0, 200.0, 40.0], (500, 1))
    for behind, given in (([normals], True), ([colours, normals], True), ([colours], False), ([colours / 255], False)):
        np.savetxt(tmp_path / "a.xyz", np.hstack([points, *behind]), delimiter=", ", header="x y z and more")
        cloud = read_cloud(tmp_path / "a.xyz")
        assert (cloud.normals is not None) == given and cloud.lost == (
            "" if given else "the numbers behind x y z are no normals"
        )
        assert cloud.normals is None or ((cloud.points * cloud.normals).sum(axis=1) > 0).all()


@pytest.mark.parametrize("order", ["little", "big"])
def test_normals_of_a_ply(tmp_path: Path, order: str) -> None:
    box = trimesh.creation.box(SIZE)
    points, face = trimesh.sample.sample_surface(box, 500, seed=1)
    kinds = {name: f"{'<' if order == 'little' else '>'}f4" for name in ("x", "y", "z", "nx", "ny", "nz")}
    table = np.rec.fromarrays([*points.T, *box.face_normals[face].T], dtype=list(kinds.items()))
    names = "".join(f"property float {name}\n" for name in kinds)
    head = f"ply\nformat binary_{order}_endian 1.0\nelement vertex 500\n{names}end_header\n"
    (tmp_path / "a.ply").write_bytes(head.encode() + table.tobytes())
    cloud = read_cloud(tmp_path / "a.ply")
    assert cloud.normals is not None and ((cloud.points * cloud.normals).sum(axis=1) > 0).all()
    (given,) = read_objects(trimesh.load(tmp_path / "a.ply", process=False), print)
    assert np.array_equal(given.real.read().normals, cloud.normals)


@pytest.mark.parametrize(
    ("label", "told"),
    [
        (np.zeros(999, dtype=int), r"`label` is of shape \(999,\)"),
        (np.full(1000, 2), "`label` has 2, and `label_names` names 0 to 1"),
        (np.full(1000, 0.5), "`label` is of type float64"),
        (np.full(1000, "door"), "`label` is of type <U4"),
    ],
)
def test_labels_that_mean_nothing(tmp_path: Path, label: np.ndarray, told: str) -> None:
    points = np.random.default_rng(0).random((1000, 3))
    np.savez(tmp_path / "a.npz", points=points, label=label, label_names=["door", "body"])
    with pytest.raises(UserError, match=told):
        read_cloud(tmp_path / "a.npz")
    np.savez(tmp_path / "a.npz", points=points, label=np.full(1000, -1), label_names=["door", "body"])
    assert set(read_cloud(tmp_path / "a.npz").label) == {-1}
