"""GAPartNet's annotated folders and rendered views, read by the formulas of its render tool and its converter."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.layouts.gapartnet import views as tools
from artipg_dsl.layouts.pth import read_plain_pickle

from .conftest import Lay, faults, unlike


@pytest.fixture(scope="module", autouse=True)
def small() -> Iterator[None]:
    """Views of 160 x 160 pixels: what is tested does not depend on their size."""
    usual, tools._VIEWS = tools._VIEWS, replace(tools._VIEWS, width=160, height=160)
    yield
    tools._VIEWS = usual


@pytest.fixture(scope="module")
def views(lay: Lay) -> Path:
    return lay("gapartnet-views", "StorageFurniture", n=1)


def test_the_folder_is_read_back(views: Path) -> None:
    assert not faults(views)
    line = (views / "meta/partnet_all_id_list.txt").read_text().split()
    assert line[0] == "StorageFurniture" and (views / "dataset" / str(int(line[1]))).is_dir()
    names = {path.stem for path in (views / "rendered_data/rgb").iterdir()}
    assert names == {f"StorageFurniture_{line[1]}_{view}_{state}" for view in (0, 1) for state in (0, 1)}


def test_the_annotated_urdf_shows_what_the_plain_one_shows(views: Path) -> None:
    """Handles hang by fixed joints on the links that they were part of, and every joint has an origin."""
    folder = next((views / "dataset").iterdir())
    plain, split = (ET.parse(folder / f"mobility{end}.urdf").getroot() for end in ("", "_annotation_gapartnet"))
    meshes = [sorted(m.attrib["filename"] for m in root.iter("mesh")) for root in (plain, split)]
    assert meshes[0] == meshes[1] and all(joint.find("origin") is not None for joint in split.iter("joint"))
    joints = {j.find("child").attrib["link"]: j for j in split.iter("joint")}  # type: ignore[union-attr]
    boxes = json.loads((folder / "link_annotation_gapartnet.json").read_text())
    assert [box["link_name"] for box in boxes] == [f"link_{k}" for k in range(len(joints))]
    handles = [box["link_name"] for box in boxes if box["category"].endswith("fixed_handle")]
    assert handles and {joints[name].attrib["type"] for name in handles} == {"fixed"}
    for name in handles:
        link = next(link for link in split.iter("link") if link.attrib["name"] == name)
        assert {v.attrib["name"].rpartition("-")[0] for v in link.iter("visual")} == {"handle"}
    assert len((folder / "semantics_gapartnet.txt").read_text().splitlines()) == len(boxes)


def test_views_are_those_that_the_render_tool_makes(views: Path) -> None:
    """Boxes carried by the joints as ``query_part_pose_from_joint_qpos`` does, coordinates as ``get_NPCS_map_from_oriented_bbox``."""
    root, folder = views / "rendered_data", next((views / "dataset").iterdir())
    still = {box["link_name"]: box for box in json.loads((folder / "link_annotation_gapartnet.json").read_text())}
    joints = {
        j.find("child").attrib["link"]: j for j in ET.parse(folder / "mobility_annotation_gapartnet.urdf").iter("joint")
    }  # type: ignore[union-attr]
    moved = 0
    for path in sorted((root / "metafile").iterdir()):
        meta = json.loads(path.read_text())
        boxes = read_plain_pickle(root / "bbox" / f"{path.stem}.pkl")["bbox_pose_dict"]
        depth = np.load(root / "depth" / f"{path.stem}.npz")["depth_map"]
        segments, npcs = (
            np.load(root / "segmentation" / f"{path.stem}.npz"),
            np.load(root / "npcs" / f"{path.stem}.npz")["npcs_map"],
        )
        matrix = np.array(meta["camera_intrinsic"]).reshape(3, 3)
        turn = np.array(meta["world2camera_rotation"]).reshape(3, 3)
        assert np.linalg.det(turn) == pytest.approx(1)
        for link, box in boxes.items():
            own = link if joints[link].attrib["type"] != "fixed" else joints[link].find("parent").attrib["link"]  # type: ignore[union-attr]
            value = meta["joint_qpos"][joints[own].attrib["name"]]
            if joints[own].attrib["type"] == "prismatic":
                x, y, z = map(float, joints[own].find("axis").attrib["xyz"].split())  # type: ignore[union-attr]
                assert np.array(box["bbox"]) == pytest.approx(
                    np.array(still[link]["bbox"]) + value * np.array([-z, -x, y]), abs=1e-6
                )
                moved += abs(value) > 0.01
            row, column = np.nonzero(segments["instance_segmentation"] == box["instance_id"])
            far = depth[row, column].astype(float)
            camera = np.stack(
                [(column - matrix[0, 2]) * far / matrix[0, 0], (row - matrix[1, 2]) * far / matrix[1, 1], far], axis=1
            )
            world = camera @ turn.T + np.array(meta["camera2world_translation"])
            pose = box["pose_RTS_param"]
            again = ((world - pose["T"]) / pose["scaler"]) @ pose["R"].T
            assert again == pytest.approx(npcs[row, column], abs=1e-4) and np.abs(again).max() < 0.505
    assert moved, "a drawer that stands open"


def test_what_the_tools_pass_over_is_found(views: Path) -> None:
    folder = next((views / "dataset").iterdir())
    path = folder / "link_annotation_gapartnet.json"
    good = path.read_text()
    boxes = json.loads(good)
    drawer = next(box for box in boxes if box["category"] == "slider_drawer")
    handle = next(box for box in boxes if box["category"].endswith("fixed_handle"))
    drawer["bbox"] = [drawer["bbox"][k] for k in (7, 6, 4, 3, 5, 2, 0, 1)]
    handle["category"] = "hinge_grip"
    path.write_text(json.dumps(boxes))
    urdf = folder / "mobility_annotation_gapartnet.urdf"
    text = urdf.read_text()
    urdf.write_text(re.sub(r'(type="fixed">\s*)<origin xyz="0 0 0" />', r"\1", text))
    view = sorted((views / "rendered_data/npcs").iterdir())[0]
    map_ = np.load(view)["npcs_map"]
    np.savez(view, npcs_map=map_ + np.float32(0.3))
    found = unlike(views)
    for fault in ("out of order", "drop in silence", "has no origin", "coordinates beyond 0.5", "npcs_map differ"):
        assert any(fault in line for line in found), fault
