"""ManiSkill: lists and folders read by the formulas of its tasks, loaded in SAPIEN as its loaders do, faults that the reader finds."""

from __future__ import annotations

import json
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl import sample
from artipg_dsl.errors import UserError
from artipg_dsl.layouts.entry import Entry
from artipg_dsl.layouts.maniskill.files import subjects
from artipg_dsl.layouts.registry import LAYOUTS

from .conftest import Lay, faults, unlike

META, DATASET = "assets/partnet_mobility/meta", "data/partnet_mobility/dataset"
TYPES = {"cabinet_drawer": ("prismatic",), "cabinet_door": ("revolute", "continuous")}


@pytest.fixture(scope="module")
def cabinets(lay: Lay) -> Path:
    return lay("maniskill", "StorageFurniture", n=4, shares=(3, 0, 1))


def listed(folder: Path, kind: str, split: str = "train") -> dict[str, Any]:
    return json.loads((folder / META / f"info_{kind}_{split}.json").read_text())


def test_the_tasks_find_a_handle_on_every_link_that_they_may_choose(cabinets: Path) -> None:
    """As ``open_cabinet_drawer.py`` goes through joints by type, and closes them at their lower limits."""
    assert not faults(cabinets)
    assert len(listed(cabinets, "cabinet_drawer")) >= 2 and len(listed(cabinets, "cabinet_door")) >= 1
    for kind, types in TYPES.items():
        for id, told in listed(cabinets, kind).items():
            assert int(id) == told["partnet_mobility_id"] and set(told) == {
                "num_target_links",
                "partnet_mobility_id",
                "scale",
            }
            root = ET.parse(cabinets / DATASET / id / "mobility_cvx.urdf").getroot()
            links = {link.attrib["name"]: link for link in root.iter("link")}
            joints = [joint for joint in root.iter("joint") if joint.attrib["type"] in types]
            assert len(joints) == told["num_target_links"] > 0
            for joint in joints:
                names = [v.attrib["name"] for v in links[joint.find("child").attrib["link"]].iter("visual")]  # type: ignore[union-attr]
                limit = joint.find("limit")
                assert any("handle" in name for name in names) and limit is not None
                assert float(limit.attrib["lower"]) == 0 < float(limit.attrib["upper"])
    assert {path.name for path in (cabinets / DATASET).iterdir()} == {
        id for kind in TYPES for split in ("train", "test") for id in listed(cabinets, kind, split)
    }
    assert not list((cabinets / DATASET).glob("*/point_sample"))


def test_what_has_no_lower_limit_is_in_no_list() -> None:
    """The tasks set all joints of a cabinet to their lower limits, castors too: minus infinity, of which simulators make nan."""
    layout = LAYOUTS["maniskill"]
    term = layout.term("StorageFurniture")
    assert term is not None
    for support in ("Castors", "Plinth"):
        batch = sample("StorageFurniture", n=4, seed=7, set={"support": support}, checked=False).batch
        lists = [told for *_, told, _ in subjects(batch, Entry("StorageFurniture", 7, batch.numbers, term=term))]
        assert any("cabinet_drawer" in told for told in lists) == (support == "Plinth")
    with pytest.raises(UserError, match="ManiSkill has no class for WashingMachine"):
        layout.term("WashingMachine")  # its drum turns without limits


def test_drawers_behind_doors_are_in_no_list() -> None:
    """The task shuts the doors of refrigerators, and nobody could open it."""
    batch = sample("Refrigerator", n=20, seed=7, checked=False).batch
    seen = set()
    term = LAYOUTS["maniskill"].term("Refrigerator")
    for i, _, _, told, robots in subjects(batch, Entry("Refrigerator", 7, batch.numbers, term=term)):
        drawers = [joint for joint in robots.robot(i).joints if joint.traits.slides]
        free = bool(drawers) and not any(joint.gates for joint in drawers)
        assert ("cabinet_drawer" in told) == free and "cabinet_door" in told
        seen.add((bool(drawers), free))
    assert (True, False) in seen


@pytest.mark.filterwarnings("ignore:Failed to find system libvulkan")
def test_sapien_loads_a_cabinet_in_metres(cabinets: Path, tmp_path: Path) -> None:
    """By ``get_partnet_mobility_builder``: the scale of the list, several colliders a file, a fixed root. Without a render device
    the loader cannot make shapes of what is seen, so that is left out."""
    sapien = pytest.importorskip("sapien", reason="sapien is not installed")
    from sapien import physx

    ours = sample("StorageFurniture", n=4, seed=7, checked=False)
    joints = ours.joints()
    for id, told in list(listed(cabinets, "cabinet_drawer").items())[:1]:
        own = tmp_path / id
        shutil.copytree(cabinets / DATASET / id, own)
        text = ET.parse(own / "mobility_cvx.urdf")
        for link in text.getroot().iter("link"):
            for visual in link.findall("visual"):
                link.remove(visual)
        text.write(own / "mobility_cvx.urdf")
        scene = sapien.Scene([physx.PhysxCpuSystem()])
        loader = scene.create_urdf_loader()
        loader.fix_root_link, loader.scale, loader.load_multiple_collisions_from_file = True, told["scale"], True
        robot = loader.load(str(own / "mobility_cvx.urdf"))
        i = int(id) % 1000000
        rows = [j for j in range(len(joints.owner)) if joints.owner[j] == i and joints.kind[j] == "prismatic"]
        active = [joint for joint in robot.get_active_joints() if joint.type == "prismatic"]
        assert len(active) == told["num_target_links"] == len(rows)
        reach = sorted(float(joint.get_limits()[0, 1]) for joint in active)
        assert reach == pytest.approx(sorted((joints.high - joints.low)[rows]), abs=1e-5), "metres"
        robot.set_qpos(np.zeros(robot.dof))
        corners = []
        for link in robot.get_links():
            for shape in link.get_collision_shapes():
                local = shape.get_vertices() * shape.get_scale()
                corners.append(
                    (link.get_entity_pose() * shape.get_local_pose()).to_transformation_matrix()[:3]
                    @ np.c_[local, np.ones(len(local))].T
                )
        size = np.ptp(np.concatenate(corners, axis=1), axis=1)
        still = ours.object(i).meshes(np.zeros((joints.owner == i).sum()))[0].bounds
        assert size == pytest.approx(still[1] - still[0], abs=2e-3), (
            "as large as ours, and upright: x, y and z are ours"
        )


def test_faucets_stand_on_their_offset_and_name_their_switches(lay: Lay) -> None:
    """As ``turn_faucet.py`` reads them."""
    folder = lay("maniskill", "Faucet", n=3, shares=(1, 0, 0))
    assert not faults(folder)
    told = listed(folder, "faucet")
    assert told and not listed(folder, "cabinet_door")
    for id, own in told.items():
        root = ET.parse(folder / DATASET / id / "mobility_cvx.urdf").getroot()
        types = {joint.find("child").attrib["link"]: joint.attrib["type"] for joint in root.iter("joint")}  # type: ignore[union-attr]
        switches = [name for name, _, word in own["semantics"] if word == "switch"]
        assert switches and all(types[name] in ("revolute", "continuous") for name in switches)
        assert np.array(own["offset"]) == pytest.approx(-np.array(own["bbox"]["min"]) * own["scale"])
        meshes = [
            path.read_text().splitlines() for path in (folder / DATASET / id / "textured_objs").glob("original-*.obj")
        ]
        raw = np.array([line.split()[1:] for lines in meshes for line in lines if line.startswith("v ")], dtype=float)
        assert raw[:, 1].min() == pytest.approx(own["bbox"]["min"][2], abs=1e-6), "y of the raw frame is up"


def test_what_would_make_a_task_fail_is_found(cabinets: Path, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    shutil.copytree(cabinets, folder)
    path = folder / META / "info_cabinet_drawer_train.json"
    told = json.loads(path.read_text())
    first, second = list(told)[:2]
    told[first]["scale"] *= 2
    told[second]["num_target_links"] += 1
    path.write_text(json.dumps(told))
    urdf = folder / DATASET / first / "mobility_cvx.urdf"
    text = urdf.read_text().replace('name="handle-', 'name="grip-')
    text = text.replace("</robot>", '<joint name="joint_99" type="continuous"><child link="link_99"/></joint></robot>')
    urdf.write_text(
        text.replace('<limit lower="0"', '<limit lower="-9"').replace('type="prismatic"', 'type="revolute"', 1)
    )
    next((folder / DATASET / second / "textured_objs").glob("convex-*.obj")).unlink()
    (folder / META / "info_cabinet_door_train.json").write_text("{}")
    found = unlike(folder)
    for fault in (
        "has no handle, at which the task fails",
        "is not shut at its lower limit",
        "link_99 has no limits, of which the task sets it to the lower",
        "links move so, not",
        "in metres differ",
        "is revolute, not prismatic",
        "limits of",
        "is not there",
        "is in the list, or is not, unlike in the model",
    ):
        assert any(fault in line for line in found), fault


def test_what_its_tasks_cannot_take_is_refused(lay: Lay) -> None:
    layout = LAYOUTS["maniskill"]
    with pytest.raises(UserError, match="ManiSkill has no class for Door"):
        layout.term("Door")
    with pytest.raises(UserError, match="there is no part `lid`: the parts are drawer, door"):
        layout.term("Box", {"Box": {"class": "cabinet", "parts": {"lid/revolute": "lid"}}})
    with pytest.raises(UserError, match="is not of the form"):
        layout.term("Box", {"Box": {"class": "cabinet", "parts": {"door": "door"}}})
    with pytest.raises(UserError, match="no object of Faucet is one that ManiSkill's tasks take") as refused:
        lay("maniskill", "Faucet", n=1, own={"Faucet": {"class": "cabinet", "parts": {"switch/revolute": "door"}}})
    assert "need handles" in (refused.value.hint or "")
