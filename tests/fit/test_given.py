"""Real objects as Python gives them: they make the clouds that files of them make, and what cannot be meant is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from artipg_dsl.errors import UsageError, UserError
from artipg_dsl.fit.given import read_objects
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.sources import File

POINTS = np.random.default_rng(1).uniform(size=(400, 3))
BOX = trimesh.creation.box([0.2, 0.4, 0.6])
LABELS: dict[str, Any] = {"label": np.arange(400) % 2, "label_names": ["door", "body"]}


def read(given: Any) -> Cloud:
    (item,) = read_objects(given, pytest.fail)
    return item.real.read()


def same(one: Cloud, other: Cloud) -> bool:
    columns = ((one.points, other.points), (one.normals, other.normals), (one.label, other.label))
    return one.names == other.names and all(np.array_equal(a, b) for a, b in columns)


@pytest.mark.parametrize("suffix", ["ply", "off", "stl", "glb"])
def test_meshes_are_as_their_files(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"box.{suffix}"
    BOX.export(path)
    held = trimesh.load(path, process=False)
    expected = File(path).read()
    assert same(read({"box": held}), expected)
    if not isinstance(held, trimesh.Scene):
        arrays = np.asarray(held.vertices), np.asarray(held.faces)
        assert same(read({"box": arrays}), expected) and len(read(arrays).points) == len(expected.points)


def test_clouds_are_as_their_files(tmp_path: Path) -> None:
    arrays = {"points": POINTS, "normals": POINTS - 0.5, **LABELS}
    np.savez(tmp_path / "cloud.npz", **arrays)
    np.savetxt(tmp_path / "cloud.xyz", POINTS, fmt="%.18g")
    trimesh.PointCloud(POINTS).export(tmp_path / "cloud.ply")
    expected = File(tmp_path / "cloud.npz").read()
    assert same(read(arrays), expected) and expected.names == ("door", "body")
    with np.load(tmp_path / "cloud.npz") as held:
        assert same(read(held), expected)
    for given in (POINTS, {"points": POINTS.tolist()}, trimesh.PointCloud(POINTS)):
        assert same(read(given), File(tmp_path / "cloud.xyz").read())
    assert same(read(trimesh.load(tmp_path / "cloud.ply")), File(tmp_path / "cloud.ply").read())


@pytest.mark.parametrize(
    "given",
    [
        POINTS,
        BOX,
        trimesh.Scene([BOX]),
        {"points": POINTS, "normals": POINTS - 0.5, **LABELS},
        {"vertices": BOX.vertices, "faces": BOX.faces, "label": [-1] + [0] * 5 + [1] * 6, "label_names": ["a", "b"]},
    ],
)
def test_arrays_are_kept_as_they_are(given: Any, tmp_path: Path) -> None:
    (item,) = read_objects({"one": given}, pytest.fail)
    path = tmp_path / "another.npz"
    path.write_bytes(item.real.bytes())
    kept = File(path, held=True)
    assert same(kept.read(), item.real.read()) and kept.mark() == item.real.mark() and str(kept) == str(item.real)
    kept.require(item.real.mark())


def test_meshes_in_npz(tmp_path: Path) -> None:
    path = tmp_path / "box.npz"
    np.savez(path, vertices=BOX.vertices, faces=BOX.faces)
    assert same(File(path).read(), read({"box": BOX}))
    for arrays, told in (
        ({"vertices": BOX.vertices}, "has `vertices`, and no `faces`"),
        ({"vertices": BOX.vertices, "faces": BOX.faces + 8}, "`faces` has 15, and there are 8 vertices"),
        ({"vertices": BOX.vertices, "faces": BOX.faces * 1.0}, "`faces` is of type float64"),
        ({"vertices": BOX.vertices, "faces": BOX.faces[:0]}, "has no faces"),
        ({"faces": BOX.faces}, "no array `points`, nor `vertices` and `faces` .it has faces"),
    ):
        np.savez(path, **arrays)
        with pytest.raises(UserError, match=told):
            File(path).read()


def test_labels_of_faces() -> None:
    labelled = {"vertices": BOX.vertices, "faces": BOX.faces, "label": [-1] + [0] * 5 + [1] * 6}
    cloud = read({**labelled, "label_names": ["seat", "back"]})
    assert cloud.names == ("seat", "back") and set(cloud.label.tolist()) == {-1, 0, 1}


def test_what_is_one_and_what_is_several(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", points=POINTS)
    np.savez(tmp_path / "b.npz", points=POINTS)

    def names(given: Any) -> list[str]:
        return [item.name for item in read_objects(given, pytest.fail)]

    mesh = (BOX.vertices, BOX.faces)
    assert names(POINTS) == names(BOX) == names(mesh) == names([mesh]) == names({"points": POINTS}) == ["object0"]
    assert names(np.stack([POINTS, POINTS])) == names([POINTS, BOX]) == ["object0", "object1"]
    assert names([BOX, BOX]) == ["object0", "object1"]  # twice the same is not one
    assert names(tmp_path) == names((tmp_path / "a.npz", str(tmp_path / "b.npz"))) == ["a", "b"]
    assert names([BOX, tmp_path, tmp_path / "b.npz", POINTS]) == ["object0", "a", "b", "object3"]
    assert names({"antique": BOX, "cloud": tmp_path / "a.npz"}) == ["antique", "cloud"]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (np.zeros((0, 3)), "object0 has 0 points, too few"),
        (np.full((400, 3), np.nan), "400 of 400 points are no numbers"),
        (np.linspace(0, 1, 400)[:, None] * [1.0, 0, 0], "is a line, not a surface"),
        (trimesh.Trimesh(BOX.vertices, np.zeros((0, 3), int)), "object0 has no faces"),
        (trimesh.Scene(), "object0 has 0 points"),
        ((np.zeros((3, 3)), np.array([[0, 1, 2]])), "they are all without area"),
    ],
)
def test_what_has_no_shape_is_told_when_it_is_read(given: Any, told: str) -> None:
    with pytest.raises(UserError, match=told):
        read([given])


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ([], "there is nothing to fit"),
        ({}, "there is nothing to fit"),
        (None, "object0 is None, and no real object"),
        ([POINTS, 3], "object1 is 3, and no real object"),
        ([POINTS.tolist()], "object0 is a list, and no real object"),
        (POINTS[:, :2], r"object0: `points` is of shape \(400, 2\)"),
        (POINTS[0], r"object0: `points` is of shape \(3,\)"),
        (POINTS.astype(str), "`points` is of type <U"),
        ((POINTS, POINTS), "`faces` is of type float64 .whole numbers are needed"),
        ((BOX.vertices, BOX.faces + 8), "`faces` has 15, and there are 8 vertices"),
        ((BOX.vertices, BOX.faces - 1), "`faces` has -1, and there are 8 vertices"),
        ((BOX.vertices, np.zeros((2, 4), int)), r"`faces` is of shape \(2, 4\)"),
        ({"points": POINTS, "normals": POINTS[:9]}, r"`normals` is of shape \(9, 3\), not that of the points"),
        ({"points": [[0, 1, 2], [3]]}, "`points` is no array"),
        ({"points": POINTS, "normal": POINTS}, r"has an array `normal`, which means nothing \(did you mean `normals`"),
        ({"points": POINTS, **LABELS, "label": np.zeros(9, int)}, r"`label` is of shape \(9,\)"),
        ({"points": POINTS, **LABELS, "label": np.zeros(400)}, "`label` is of type float64"),
        ({"points": POINTS, "label": LABELS["label"]}, "has `label`, and no `label_names`"),
        ({"points": POINTS, **LABELS, "label_names": ["door"]}, "`label` has 1, and `label_names` names 0 to 0"),
        ({"points": POINTS, **LABELS, "label": np.full(400, -2)}, "`label` has -2, and `label_names` names 0 to 1"),
        ({"points": POINTS, **LABELS, "label_names": 3}, "`label_names` is 3 .it is a list of names"),
        ({"points": POINTS, **LABELS, "label_names": "ab"}, "`label_names` is 'ab'"),
        (b"x", "object0 is b'x', and no real object"),
        ({"vertices": BOX.vertices}, "has `vertices`, and no `faces`"),
        ({"points": POINTS, "faces": BOX.faces}, "has `faces` of `points`"),
        ({"vertices": BOX.vertices, "faces": BOX.faces, **LABELS}, r"one of \(12,\) is needed, as of the faces"),
        ({"a/b": BOX}, "'a/b' is no name of an object"),
        ({3: BOX}, "3 is no name of an object"),
        ({"a" * 300: BOX}, "no object can be called 'aaa"),
        ({"a": "."}, "a is to be one object, and . is a folder"),
        ({"a": "nowhere.obj"}, "there is no file or folder nowhere.obj"),
        (["nowhere.obj"], "there is no file or folder nowhere.obj"),
        ("", "the name of a real object is empty text"),
    ],
)
def test_what_is_refused(given: Any, told: str) -> None:
    with pytest.raises(UserError, match=told) as caught:
        read_objects(given, pytest.fail)
    assert "nowhere" in told or isinstance(caught.value, UsageError)


def test_arrays_that_have_changed_are_told() -> None:
    points = POINTS.copy()
    for given in (points, (points, np.arange(399).reshape(-1, 3)), {"points": points, "normals": points[::-1]}):
        (item,) = read_objects([given], pytest.fail)
        mark = item.real.mark()
        item.real.require(mark)
        points[0] += 1.0
        with pytest.raises(UserError, match="the arrays of object0 have changed since they were fitted"):
            item.real.require(mark)
