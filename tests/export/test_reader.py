"""A reader of its own: what is written, read with json, NumPy, an XML parser and trimesh, and nothing of ours.

Every point has a word, the one that the annotation gives its part; it lies on the mesh of its link, and moves as the URDF
says that the link does.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

from artipg_dsl.cli.main import main
from artipg_dsl.session import categories

EVERY = os.environ.get("ARTIPG_EVERY") == "1"  # all categories, not only a few
CHORD = 5e-4  # m, what the meshes are asked for
FINER = {"Bottle": {"neck"}}  # words of surfaces of a part that has another
STATES = "rest,open,random:2"


def turn(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def numbers(element: ElementTree.Element | None, name: str) -> np.ndarray:
    return np.array((element.get(name) if element is not None else "0 0 0").split(), dtype=float)  # type: ignore[union-attr]


class Urdf:
    """Links with their meshes, and where they are for values of the joints."""

    def __init__(self, path: Path):
        root = ElementTree.parse(path).getroot()
        self.joints = root.findall("joint")
        self.meshes: dict[str, list[trimesh.Trimesh]] = {}
        for link in root.findall("link"):
            files = [(v.find("origin"), v.find("geometry/mesh")) for v in link.findall("visual")]
            assert all(not numbers(origin, "xyz").any() and not numbers(origin, "rpy").any() for origin, _ in files)
            loaded = [
                trimesh.load(path.parent / mesh.get("filename"), force="mesh", process=False) for _, mesh in files
            ]  # type: ignore[union-attr,arg-type]
            self.meshes[link.attrib["name"]] = loaded

    def poses(self, values: dict[str, float]) -> dict[str, np.ndarray]:
        """Of each link, 4 x 4."""
        values = dict(values)
        for joint in self.joints:
            follows = joint.find("mimic")
            if follows is not None:
                leader = follows.attrib
                ratio, offset = float(leader.get("multiplier", 1)), float(leader.get("offset", 0))
                values.setdefault(joint.attrib["name"], values[leader["joint"]] * ratio + offset)
        above = {joint.find("child").attrib["link"]: joint for joint in self.joints}  # type: ignore[union-attr]
        found: dict[str, np.ndarray] = {}

        def pose(link: str) -> np.ndarray:
            if link not in found:
                joint = above.get(link)
                found[link] = np.eye(4) if joint is None else pose(joint.find("parent").attrib["link"]) @ step(joint)  # type: ignore[union-attr]
            return found[link]

        def step(joint: ElementTree.Element) -> np.ndarray:
            moved = np.eye(4)
            moved[:3, 3] = numbers(joint.find("origin"), "xyz")
            assert not numbers(joint.find("origin"), "rpy").any()
            kind, axis = joint.attrib["type"], numbers(joint.find("axis"), "xyz")
            if kind == "prismatic":
                moved[:3, 3] += axis * values[joint.attrib["name"]]
            elif kind != "fixed":
                moved[:3, :3] = turn(axis, values.get(joint.attrib["name"], 0.0))
            return moved

        for link in self.meshes:
            pose(link)
        return found


def off(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distances (n,) of points from triangles (t, 3, 3): the nearest place of each, inside or on an edge."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1)
    kept = area > 1e-16
    a, b, c, normal = a[kept], b[kept], c[kept], normal[kept] / area[kept, None]
    best = np.full(len(points), np.inf)
    for start in range(0, len(points), 64):
        p = points[start : start + 64, None]
        flat = p - ((p - a) * normal).sum(-1, keepdims=True) * normal
        inside = np.ones(flat.shape[:2], dtype=bool)
        near = np.full(flat.shape[:2], np.inf)
        for one, two in ((a, b), (b, c), (c, a)):
            inside &= (np.cross(two - one, flat - one) * normal).sum(-1) >= 0
            along = two - one
            share = np.clip(((p - one) * along).sum(-1) / (along * along).sum(-1), 0, 1)
            near = np.minimum(near, np.linalg.norm(p - one - share[..., None] * along, axis=-1))
        near = np.where(inside, np.abs(((p - a) * normal).sum(-1)), near)
        best[start : start + 64] = near.min(axis=1)
    return best


@pytest.mark.parametrize("name", sorted(categories()) if EVERY else ["Chair", "Globe", "Microwave"])
def test_points_have_words_lie_on_their_link_and_move_with_it(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    wishes = ["--points", "400", "--balance", "semantic", "--states", STATES, "--tolerance", "0.5mm"]
    formats = ["--format", "points,annotation,urdf"]
    assert (
        main(
            [
                "sample",
                name,
                "-n",
                "1" if not EVERY else "2",
                "--seed",
                "9",
                "--unchecked",
                "-o",
                str(folder),
                *wishes,
                *formats,
            ]
        )
        == 0
    )
    manifest = json.loads((folder / "manifest.json").read_text())
    words = manifest["vocabularies"]["semantic"]
    annotations = [json.loads(line) for line in (folder / "annotation-00000.jsonl").read_text().splitlines()]
    with np.load(folder / "points-00000.npz") as archive:
        arrays = {key: archive[key] for key in archive.files}
    assert words[0] == "unlabelled" and (arrays["semantic"] > 0).all() and (arrays["semantic"] < len(words)).all()
    for row, number in enumerate(arrays["object"].tolist()):
        annotation = annotations[row]
        assert annotation["object"] == number
        parts = {part["number"]: part for part in annotation["parts"]}
        said = [parts[k]["semantic"] for k in arrays["instance"][row].tolist()]
        found = [words[k] for k in arrays["semantic"][row].tolist()]
        assert None not in said and {w for s, w in zip(said, found, strict=True) if s != w} <= FINER.get(name, set())
        links = {link["number"]: link["name"] for link in annotation["links"]}
        urdf = Urdf(folder / "objects" / f"{number:06d}" / "object.urdf")
        joints = [joint["name"] for joint in annotation["joints"]]
        states = arrays["state"][row]
        assert not np.isnan(states[:, : len(joints)]).any() and np.isnan(states[:, len(joints) :]).all()
        shown = [urdf.poses(dict(zip(joints, state, strict=False))) for state in states.tolist()]
        for k in np.unique(arrays["link"][row]).tolist():
            mine = arrays["link"][row] == k
            link, points = links[k], arrays["points"][row][:, mine].astype(float)
            turned = [pose[link] for pose in shown]
            local = (points[0] - turned[0][:3, 3]) @ turned[0][:3, :3]
            for seen, pose in zip(points, turned, strict=True):
                assert np.abs(local @ pose[:3, :3].T + pose[:3, 3] - seen).max() < 1e-5, (link, "does not move with it")
            corners = np.concatenate([mesh.triangles for mesh in urdf.meshes[link]])
            assert off(local, corners).max() < CHORD + 1e-5, (link, "lies off its mesh")


def test_the_reader_sees_what_is_wrong(tmp_path: Path) -> None:
    """Distances by a second way, so that the test above can fail."""
    ball = trimesh.creation.icosphere(3, 0.1)
    rng = np.random.default_rng(0)
    out = rng.normal(size=(200, 3))
    out *= rng.uniform(0.05, 0.3, (200, 1)) / np.linalg.norm(out, axis=1, keepdims=True)
    assert off(out, ball.triangles) == pytest.approx(np.abs(np.linalg.norm(out, axis=1) - 0.1), abs=1.5e-3)
    assert off(ball.triangles.mean(axis=1)[:50], ball.triangles).max() < 1e-12
