"""Trees of joints and boxes, read as CAGE's loader does, and moved to where the model has its links."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl import sample
from artipg_dsl.errors import UserError
from artipg_dsl.layouts.cage import nodes, tree_hash
from artipg_dsl.layouts.registry import LAYOUTS
from artipg_dsl.session import Session
from tests.vice import VICE

from .conftest import Lay, faults, unlike


@pytest.fixture(scope="module")
def cage(lay: Lay) -> Path:
    return lay("cage", "StorageFurniture", "Microwave", n=3)


def trees(folder: Path, category: str) -> list[dict]:
    return [json.loads(path.read_text()) for path in sorted(folder.glob(f"{category}/*/train.json"))]


@pytest.mark.parametrize("category", ["StorageFurniture", "Microwave"])
def test_trees_are_what_the_loader_takes(cage: Path, category: str) -> None:
    listed = json.loads((cage / "data_split.json").read_text())
    assert sum(name.startswith(category) for names in listed.values() for name in names) == 3
    for file in trees(cage, category):
        tree = file["diffuse_tree"]
        assert file["meta"]["obj_cat"] == category
        assert [node["id"] for node in tree] == list(range(len(tree)))
        assert [node["name"] for node in tree if node["parent"] == -1] == ["base"]
        for node in tree:
            assert node["children"] == [other["id"] for other in tree if other["parent"] == node["id"]]
            assert node["name"] in ("door", "drawer", "base", "handle", "wheel", "knob", "shelf", "tray")
            assert node["joint"]["type"] in ("fixed", "revolute", "prismatic", "screw", "continuous")
            assert node["joint"]["range"][0] == 0 and (node["joint"]["range"][1] > 0) == (
                node["joint"]["type"] not in ("fixed", "continuous")
            )
            assert np.abs(node["aabb"]["center"]).max() <= 1 and min(node["aabb"]["size"]) > 0
        low = np.min([np.array(n["aabb"]["center"]) - np.array(n["aabb"]["size"]) / 2 for n in tree], axis=0)
        high = np.max([np.array(n["aabb"]["center"]) + np.array(n["aabb"]["size"]) / 2 for n in tree], axis=0)
        assert np.linalg.norm(high - low) == pytest.approx(2, abs=1e-6), "the half diagonal is 1"


def test_joints_are_those_of_the_model(cage: Path) -> None:
    """As many doors and drawers as joints move them; a drawer comes out to the front, z, as far as the model's."""
    ours = sample("StorageFurniture", n=3, seed=7, checked=False)
    joints = ours.joints()
    for i, file in enumerate(trees(cage, "StorageFurniture")):
        tree = file["diffuse_tree"]
        own = [j for j in range(len(joints.owner)) if joints.owner[j] == i]
        for kind, name in (("prismatic", "drawer"), ("revolute", "door")):
            rows = [j for j in own if joints.kind[j] == kind]
            nodes = [node for node in tree if node["joint"]["type"] == kind]
            assert len(nodes) == len(rows)
            for node, j in zip(nodes, rows, strict=True):
                assert node["name"] == name
                axis, reach = np.array(node["joint"]["axis"]["direction"]), node["joint"]["range"][1]
                if kind == "revolute":
                    assert reach == pytest.approx(np.degrees(joints.high[j] - joints.low[j]))
                    assert abs(axis[1]) == pytest.approx(1) or abs(axis[0]) == pytest.approx(1)
                else:
                    assert axis == pytest.approx([0, 0, 1], abs=1e-9)
                    assert reach / node["aabb"]["size"][2] == pytest.approx(
                        (joints.high[j] - joints.low[j]) / depth(ours, i, j), rel=1e-3
                    )
        handles = [node for node in tree if node["name"] == "handle"]
        assert all(tree[node["parent"]]["name"] in ("door", "drawer") for node in handles)


def test_left_handed_screws_open_from_0_on() -> None:
    batch = Session.of_text(VICE).sampler.batch(np.arange(1), 1)
    term = LAYOUTS["cage"].term("Vice", {"Vice": {"class": "Table", "parts": {"knob/screw": "knob"}}})
    assert term is not None
    (made,) = nodes(batch, term)
    screws = [node.joint for node in made if node.joint["type"] == "screw"]
    assert [joint["axis"]["direction"] for joint in screws] == [[1, 0, 0], [-1, 0, 0]]  # each outwards
    assert all(joint["range"][0] == 0 and joint["range"][1] > 0 for joint in screws)


def depth(objects, i: int, j: int) -> float:
    """How deep the link of a drawer is without its handle, in metres."""
    from artipg_dsl.layouts.pieces import Pieces
    from artipg_dsl.robot.robots import Robots

    term = LAYOUTS["cage"].term("StorageFurniture")
    assert term is not None
    pieces = Pieces(Robots(objects.batch, physics=False), i, term)
    link = int(objects.joints().child[j])
    apart = pieces.apart(link)
    return float(np.ptp(np.concatenate([shape.vertices for k, shape in pieces.of(link) if k not in apart])[:, 0]))


def test_the_folder_is_read_back(cage: Path) -> None:
    assert not faults(cage)


def test_loaders_find_objects_and_meshes(cage: Path) -> None:
    """CAGE's predictions take objects from ``hash_table.json`` (``dm.py``), SINGAPO's retrieval meshes by ``plys``."""
    listed, forms = (json.loads((cage / f"{name}.json").read_text()) for name in ("data_split", "hash_table"))
    told = {name: form for own in forms.values() for form, names in own.items() for name in names}
    assert set(forms) == {"StorageFurniture", "Microwave"}
    assert sorted(told) == sorted(name for names in listed.values() for name in names)
    for name, form in told.items():
        file = json.loads((cage / name / "object.json").read_text())
        assert file["meta"]["tree_hash"] == form
        assert all((cage / name / ply).is_file() for node in file["diffuse_tree"] for ply in node["plys"])


def test_what_has_too_many_nodes_is_left_out(lay: Lay, monkeypatch: pytest.MonkeyPatch) -> None:
    """CAGE's loader fills arrays of 32 nodes, and fails at the next."""
    sizes = {name: len(file["diffuse_tree"]) for name, file in _sized(lay("cage", "StorageFurniture", n=3))}
    monkeypatch.setattr("artipg_dsl.layouts.cage.MOST", sorted(sizes.values())[1])
    folder = lay("cage", "StorageFurniture", n=3)
    left = {name for name, _ in _sized(folder)}
    assert left == {name for name, count in sizes.items() if count <= sorted(sizes.values())[1]} != set(sizes)
    assert {name for names in json.loads((folder / "data_split.json").read_text()).values() for name in names} == left
    assert not faults(folder)
    monkeypatch.setattr("artipg_dsl.layouts.cage.MOST", 0)
    with pytest.raises(UserError, match="no object of StorageFurniture has 2 to 0 nodes"):
        lay("cage", "StorageFurniture", n=1)


def test_what_does_not_move_is_left_out(lay: Lay) -> None:
    """CAGE's metrics take the mean over what moves, and give the worst score where nothing does."""
    folder = lay("cage", "Table", n=12)
    left = {name for name, _ in _sized(folder)}
    joints = sample("Table", n=12, seed=7, checked=False).joints()
    assert left <= {f"Table/Table7n{i:06d}" for i in set(joints.owner.tolist())} and 0 < len(left) < 12
    assert all(len(file["diffuse_tree"]) > 1 for _, file in _sized(folder))
    assert {name for names in json.loads((folder / "data_split.json").read_text()).values() for name in names} == left
    assert not faults(folder)


def _sized(folder: Path) -> list[tuple[str, dict]]:
    paths = sorted(folder.glob("*/*/train.json"))
    return [(str(path.parent.relative_to(folder)), json.loads(path.read_text())) for path in paths]


def test_trees_of_one_form_have_one_hash() -> None:
    assert tree_hash([-1, 0]) == "8a8a4905c9b0f8fd7847dc408134a288"  # as CAGE's own table has it, of networkx 3.1
    assert tree_hash([-1, 0, 0, 1]) == tree_hash([-1, 0, 0, 2]) != tree_hash([-1, 0, 1, 2])
    assert len({tree_hash(parents) for parents in ([-1], [-1, 0], [-1, 0, 0], [-1, 0, 1])}) == 4


def test_faults_are_found(lay: Lay) -> None:
    folder = lay("cage", "Microwave", n=1)
    path = next(folder.glob("Microwave/*/train.json"))
    good = json.loads(path.read_text())
    door = next(node["id"] for node in good["diffuse_tree"] if node["name"] == "door")

    def broken(change) -> list[str]:
        file = json.loads(json.dumps(good))
        change(file["diffuse_tree"][door])
        path.write_text(json.dumps(file))
        return unlike(folder)

    assert any("origin differ" in fault for fault in broken(lambda n: n["joint"]["axis"].update(origin=[0, 0, 0])))
    assert any("does not begin at 0" in fault for fault in broken(lambda n: n["joint"].update(range=[-5, 100])))
    assert any("gate instead of door" in fault for fault in broken(lambda n: n.update(name="gate")))
    assert any("box of its mesh" in fault for fault in broken(lambda n: n["aabb"].update(center=[0, 0, 0])))


def test_what_cage_lacks_is_refused() -> None:
    with pytest.raises(UserError, match="CAGE has no class for Door") as refused:
        LAYOUTS["cage"].term("Door")
    assert "the nearest is StorageFurniture" in (refused.value.hint or "")
    with pytest.raises(UserError, match="there is no part `leaf`"):
        LAYOUTS["cage"].term("Door", {"Door": {"class": "StorageFurniture", "parts": {"leaf/revolute": "leaf"}}})
    with pytest.raises(UserError, match="no word of it is a part"):
        LAYOUTS["cage"].term("Door", {"Door": {"class": "StorageFurniture"}})
