"""OPD and OPDMulti: lists and pictures read by the formulas of their loaders, motions against what the views show."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl import sample
from artipg_dsl.errors import UserError
from artipg_dsl.export.partnet.mobility import folder_frame
from artipg_dsl.layouts.clouds import turn_about
from artipg_dsl.layouts.opd.outlines import along_pixels, fill, outlines
from artipg_dsl.layouts.registry import LAYOUTS
from artipg_dsl.robot.robots import Robots

from .conftest import Lay, faults, unlike

h5py = pytest.importorskip("h5py", reason="h5py, of the extra hdf5, is not installed: the layout of OPD is HDF5")


@pytest.fixture(scope="module")
def opd(lay: Lay) -> Path:
    return lay("opd", "StorageFurniture", n=3, shares=(1, 2, 0))


def listed(folder: Path, split: str, form: str = "MotionNet") -> dict[str, Any]:
    return json.loads((folder / f"annotations/{form}_{split}.json").read_text())


def picture(folder: Path, name: str, word: str) -> np.ndarray:
    """As ``motion_dataset_mapper.py`` looks for it."""
    with h5py.File(folder / f"{name}.h5") as file:
        names = {file[f"{name}_filenames"][k].decode("utf-8"): k for k in range(file[f"{name}_filenames"].shape[0])}
        return file[f"{name}_images"][names[word]]


def points(folder: Path, image: dict[str, Any], mask: np.ndarray) -> np.ndarray:
    """What a mask shows, in the object's frame, by its depths and its camera."""
    depth = picture(folder, "depth", image["depth_file_name"])[..., 0].astype(float) / 1000
    row, column = np.nonzero(mask)
    z, focal = depth[row, column], 128 / np.tan(np.radians(25))  # as ``camera_to_image`` of OPD's visualizer has it
    seen = np.stack([(column + 0.5 - 128) * z / focal, -(row + 0.5 - 128) * z / focal, -z, np.ones(len(z))], axis=1)
    return (seen @ np.reshape(image["camera"]["extrinsic"]["matrix"], (4, 4)))[:, :3]


@pytest.mark.some
def test_the_folder_is_read_back(opd: Path) -> None:
    assert not faults(opd)
    names = {path.relative_to(opd).as_posix() for path in opd.rglob("*.*") if path.is_file()}
    lists = {
        f"annotations/{form}_{split}.json" for form in ("MotionNet", "OPDMulti") for split in ("train", "valid", "test")
    }
    assert names >= lists | {"train.h5", "valid.h5", "test.h5", "depth.h5", "urdf-attr.json", "obj_info.json"}
    assert listed(opd, "test")["images"] == [] and len(listed(opd, "train")["images"]) >= 4
    with h5py.File(opd / "test.h5") as file:
        assert file["test_images"].shape == (0, 256, 256, 3) and file["test_filenames"].shape == (0,)


def test_parts_moved_back_by_their_motion_lie_where_the_shut_object_has_them(opd: Path) -> None:
    """Class, type, axis, origin and value of every part that is seen, by the points that its depths give."""
    ours = sample("StorageFurniture", n=3, seed=7, checked=False)
    robots = Robots(ours.batch, physics=False)
    moved = {"rotation": 0, "translation": 0}
    for split, numbers in (("train", {0}), ("valid", {1, 2})):
        told = listed(opd, split)
        assert {known["id"]: known["name"] for known in told["categories"]} == {1: "drawer", 2: "door", 3: "lid"}
        for image in told["images"]:
            id = int(image["file_name"].split("-")[0])
            assert id < 2**31 and id - 100000000 in numbers
            robot = robots.robot(id - 100000000)
            frame = folder_frame(robot)
            assert (image["height"], image["width"]) == picture(opd, split, image["file_name"]).shape[:2] == (256, 256)
            for part in (part for part in told["annotations"] if part["image_id"] == image["id"]):
                mask, motion = fill(part["segmentation"], 256, 256), part["motion"]
                row, column = np.nonzero(mask)
                x, y, width, height = part["bbox"]
                assert (x, y, x + width, y + height) == (column.min(), row.min(), column.max() + 1, row.max() + 1)
                assert part["area"] == mask.sum() >= 16 and part["iscrowd"] == 0
                kind = {1: "translation", 2: "rotation"}[part["category_id"]]
                assert motion["type"] == kind and motion["rangeMin"] == 0 < motion["rangeMax"]
                matrix = np.reshape(image["camera"]["extrinsic"]["matrix"], (4, 4)).T
                ends = np.stack([motion["current_origin"], np.add(motion["current_origin"], motion["current_axis"])])
                ends = ends @ matrix[:3, :3].T + matrix[:3, 3]
                origin, axis, value = ends[0], ends[1] - ends[0], motion["value"]
                seen = points(opd, image, mask)
                back = (
                    seen - value * axis if kind == "translation" else turn_about(seen, origin, axis, -np.radians(value))
                )
                link = [joint.child for joint in robot.joints] + [0]
                own = robot.links[link[int(motion["partId"])]]
                shut = frame.points(np.concatenate([v.shape.vertices + own.origin for v in own.visuals]))
                assert (back > shut.min(axis=0) - 1e-3).all() and (back < shut.max(axis=0) + 1e-3).all()
                moved[kind] += value > 0.05
    assert moved["rotation"] and moved["translation"], "doors and drawers that stand open"


def test_opdmulti_reads_the_same_in_its_own_form(opd: Path) -> None:
    """As its ``bm_annotations_to_instances`` carries axes: matrices are lists, and the camera looks along z."""
    info = json.loads((opd / "obj_info.json").read_text())
    ours, theirs = (listed(opd, "train", form) for form in ("MotionNet", "OPDMulti"))
    cameras = [{image["id"]: image["camera"] for image in told["images"]} for told in (ours, theirs)]
    for mine, other in zip(ours["annotations"], theirs["annotations"], strict=True):
        places = []
        for k, (part, words) in enumerate(((mine, ("current_origin", "current_axis")), (other, ("origin", "axis")))):
            camera = cameras[k][part["image_id"]]["extrinsic"]
            matrix = np.reshape(camera if k else camera["matrix"], (4, 4)).T
            origin, axis = (np.array(part["motion"][word]) for word in words)
            places.append(np.stack([origin, origin + axis]) @ matrix[:3, :3].T + matrix[:3, 3])
        assert places[0] == pytest.approx(places[1], abs=1e-6) and other["motion"]["origin"][2] > 0
        held = info[other["object_key"]]
        assert held["object_pose"] == cameras[1][other["image_id"]]["extrinsic"] and held["diagonal"] == pytest.approx(
            2
        )
        assert mine["segmentation"] == other["segmentation"]


def test_what_loaders_do_not_notice_is_found(opd: Path, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    shutil.copytree(opd, folder)
    path = folder / "annotations/MotionNet_train.json"
    told = json.loads(path.read_text())
    parts = told["annotations"]
    matrix = told["images"][0]["camera"]["extrinsic"]
    matrix["matrix"] = np.reshape(matrix["matrix"], (4, 4)).T.ravel().tolist()
    parts[0]["motion"]["current_axis"] = [-x for x in parts[0]["motion"]["current_axis"]]
    parts[1]["motion"]["current_origin"][2] += 0.1
    parts[2]["category_id"] = 4
    parts[3]["bbox"][2] -= 1
    parts[4]["segmentation"] = parts[4]["segmentation"][1:] or [[0.0, 0.0, 9.0, 0.0, 9.0, 9.0]]
    parts[5]["motion"]["type"] = "hinge"
    told["images"][-1]["file_name"] = "1.png"
    path.write_text(json.dumps(told))
    multi = folder / "annotations/OPDMulti_train.json"
    other = json.loads(multi.read_text())
    other["images"][1]["camera"]["extrinsic"] = {"matrix": other["images"][1]["camera"]["extrinsic"]}
    other["annotations"][0]["object_key"] = "none"
    multi.write_text(json.dumps(other))
    with h5py.File(folder / "depth.h5", "a") as file:
        file["depth_images"][2] = file["depth_images"][2] * 2
    with h5py.File(folder / "valid.h5", "a") as file:
        file["valid_images"][0, 100, 100] = 7
    found = unlike(folder)
    for fault in (
        "its matrix is not column by column",
        "current axis differ",
        "axis in the object's frame differ",
        "current origin differ",
        "a class that there is not",
        "box around its pixels differ",
        "pixels differ from the model",
        "hinge is no type",
        "not in the list of its split",
        "OPDMulti's matrix is no list of 16",
        "none is not in obj_info.json",
        "depths differ",
        "points by its depths differ",
        "colours differ",
    ):
        assert any(fault in line for line in found), fault


def test_bytes_are_the_same_again(opd: Path, lay: Lay) -> None:
    again = lay("opd", "StorageFurniture", n=3, shares=(1, 2, 0))
    for path in (path for path in opd.rglob("*") if path.is_file()):
        assert path.read_bytes() == (again / path.relative_to(opd)).read_bytes(), path.name


@pytest.mark.parametrize("grain", [1, 3, 9])
def test_outlines_are_the_mask(grain: int) -> None:
    """Whatever holes and corners it has: polygons that neither overlap nor leave a pixel out."""
    draw = np.random.default_rng(grain)
    mask = np.kron(draw.random((40 // grain + 1, 50 // grain + 1)) < 0.6, np.ones((grain, grain))).astype(bool)
    polygons = outlines(mask)
    assert (fill(polygons, *mask.shape) == mask).all() and along_pixels(polygons)
    area = 0.0
    for polygon in polygons:
        x, y = np.reshape(polygon, (-1, 2)).T
        area += float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    assert abs(area) == mask.sum() and outlines(np.zeros((3, 3), dtype=bool)) == []
    assert fill([[1, 1, 4, 1, 4, 3, 1, 3]], 4, 5).sum() == 6 and not along_pixels([[0, 0, 4, 4, 0, 4]])


def test_what_it_cannot_hold_is_refused(lay: Lay, monkeypatch: pytest.MonkeyPatch) -> None:
    layout = LAYOUTS["opd"]
    with pytest.raises(UserError, match="OPD has no class for Kettle") as refused:
        layout.term("Kettle")
    assert "the nearest is Box" in (refused.value.hint or "")
    with pytest.raises(UserError, match="there is no part `flap`"):
        layout.term("Kettle", {"Kettle": {"class": "Box", "parts": {"lid/revolute": "flap"}}})
    with pytest.raises(UserError, match="joints are revolute, continuous, prismatic"):
        layout.term("Kettle", {"Kettle": {"class": "Box", "parts": {"lid/screw": "lid"}}})
    with pytest.raises(UserError, match="nothing of StorageFurniture opens"):
        own = {"StorageFurniture": {"class": "Table", "parts": {"lid/revolute": "lid"}}}
        lay("opd", "StorageFurniture", n=1, own=own)
    monkeypatch.setattr("artipg_dsl.extras.find_spec", lambda name: None)
    with pytest.raises(UserError, match="opd needs h5py, which is not installed") as refused:
        lay("opd", "StorageFurniture", n=1)
    assert "artipg_dsl[hdf5]" in (refused.value.hint or "")
