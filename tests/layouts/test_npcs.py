"""NPCS and ANCSH: files read by the formulas of their loader, joints against the points that they move, faults that the reader finds."""

from __future__ import annotations

import pickletools
import shutil
import time
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.export.containers import hdf5_bytes
from artipg_dsl.export.write import ExportError
from artipg_dsl.layouts.clouds import similarity_error
from artipg_dsl.layouts.hdf5 import read_h5
from artipg_dsl.layouts.pth import read_plain_pickle
from artipg_dsl.layouts.registry import LAYOUTS

from .conftest import Lay, faults, unlike

pytest.importorskip("h5py", reason="h5py is not installed: the layouts of NPCS and ANCSH are HDF5")


@pytest.fixture(scope="module")
def laptop(lay: Lay) -> Path:
    return lay("ancsh", "Laptop", n=1)


def test_it_is_read_by_the_loaders_formulas(laptop: Path) -> None:
    """As ``create_data_shape2motion`` of ``lib/dataset.py``: normalised coordinates lie within 0 .. 1 about 0.5."""
    lines = (laptop / "splits/laptop/3.6/train.txt").read_text().splitlines()
    assert len(lines) >= 6 and (laptop / "splits/laptop/3.61/train.txt").read_text().splitlines() == lines
    factors, corners = (read_plain_pickle(laptop / f"pickle/laptop{end}.pkl") for end in ("", "_corners"))
    for line in lines:
        item = line.split(".")[0].split("/")[-3]
        assert item == "Laptop7n000000" and (laptop / "render/laptop" / item).is_dir()
        held = read_h5(laptop / line)
        clouds = []
        for k in range(2):
            points, coords = held[f"gt_points/{k}"][:, :3], held[f"gt_coords/{k}"][:, :3]
            factor, (low, high) = factors[item][k + 1], corners[item][k + 1]
            assert low.shape == high.shape == (1, 3)
            npcs = (coords - low) * factor + 0.5 - 0.5 * (high - low) * factor
            assert -1e-3 < npcs.min() and npcs.max() < 1 + 1e-3 and len(points) > 200
            assert factor == pytest.approx(1 / np.linalg.norm(high - low))
            assert similarity_error(coords.astype(float), points.astype(float)) < 1e-5
            clouds.append(points)
        assert np.concatenate(clouds)[:, 2].min() > 0, "in front of the camera"
        assert clouds[1][:, 1].mean() > clouds[0][:, 1].mean(), "y is up: the screen stands on the keyboard"


def test_the_urdf_turns_the_coordinates_as_the_views_show_them(laptop: Path) -> None:
    """Points of the lid, turned about the axis through the pivot by some angle, lie where the view has them beside the base."""
    folder = laptop / "urdf/laptop/Laptop7n000000"
    assert len(list(folder.iterdir())) == 3, "loaders take the number of files less one for that of links"
    root = ET.parse(folder / "syn.urdf").getroot()
    visual = next(e for e in root.iter("link") if e.attrib["name"] == "1").find("visual/origin")
    joint = root.find("joint")
    assert visual is not None and joint is not None and joint.attrib["name"] == "0_1"
    pivot = -np.array(visual.attrib["xyz"].split(), dtype=float)
    axis = np.array(joint.find("axis").attrib["xyz"].split(), dtype=float)  # type: ignore[union-attr]
    seen = set()
    for path in sorted((laptop / "hdf5/laptop/Laptop7n000000").glob("*/0.h5")):
        held = {name: a.astype(float) for name, a in read_h5(path).items() if name.startswith("gt")}
        base, base_points = held["gt_coords/0"], held["gt_points/0"]
        middle, seen_middle = base.mean(axis=0), base_points.mean(axis=0)
        u, _, vt = np.linalg.svd((base - middle).T @ (base_points - seen_middle))
        lid = (held["gt_points/1"] - seen_middle) @ (u @ vt).T + middle  # as the base stands
        still = held["gt_coords/1"] - pivot
        assert still @ axis == pytest.approx((lid - pivot) @ axis, abs=1e-5)
        assert np.linalg.norm(still, axis=1) == pytest.approx(np.linalg.norm(lid - pivot, axis=1), abs=1e-5)
        across = np.stack([still - np.outer(still @ axis, axis), lid - pivot - np.outer((lid - pivot) @ axis, axis)])
        angles = np.arctan2(np.cross(across[0], across[1]) @ axis, (across[0] * across[1]).sum(axis=1))
        assert np.ptp(angles) < 1e-3
        seen.add(round(float(angles.mean()), 3))
    assert len(seen) == 4 and min(seen) >= 0, "four states, open to the side that the axis says"


def test_the_folder_is_read_back(laptop: Path) -> None:
    assert not faults(laptop)


def test_what_has_not_all_parts_is_left_out(lay: Lay) -> None:
    """Of an object without a door or lid there is nothing; where none has all parts the map is refused."""
    with pytest.raises(UserError, match="no object of Laptop has the 2 parts of oven"):
        lay("ancsh", "Laptop", n=1, own={"Laptop": {"class": "oven", "parts": {"door/revolute": "part"}}})


@pytest.mark.slow
def test_both_kinds_of_test_objects_are_there(lay: Lay) -> None:
    """As ``Dataset`` parts them by names that it has by heart; ``predict_and_save`` divides by the number of views of either kind."""
    folder = lay("ancsh", "Laptop", n=4, shares=(1, 0, 3))
    items = [line.split(".")[0].split("/")[-3] for line in (folder / "splits/laptop/3.6/test.txt").read_text().split()]
    unseen = [item in ("0004", "0008", "0069") for item in items]
    assert len(set(items)) == 3 and any(unseen) and not all(unseen)
    assert set(items) <= read_plain_pickle(folder / "pickle/laptop.pkl").keys()
    assert set(items) < {path.name for path in (folder / "render/laptop").iterdir()}
    assert not faults(folder)
    own = {"Display": {"class": "laptop", "parts": {"screen/revolute": "part"}}}
    with pytest.raises(ExportError, match="already has Laptop, which ancsh calls laptop, too"):
        lay("ancsh", "Display", n=1, own=own, folder=folder)


def test_pickles_name_arrays_alone(laptop: Path) -> None:
    names = set()
    for name in ("laptop.pkl", "laptop_corners.pkl"):
        ops = pickletools.genops((laptop / "pickle" / name).read_bytes())
        names |= {arg for op, arg, _ in ops if op.name in ("GLOBAL", "STACK_GLOBAL")}
    assert names == {"numpy ndarray", "builtins bytearray"}


def test_bytes_do_not_depend_on_the_hour(laptop: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    arrays = read_h5(next(laptop.glob("hdf5/*/*/*/0.h5")))
    first = hdf5_bytes(arrays, pack=True)
    begun = int(time.time())
    while int(time.time()) == begun:  # HDF5 keeps whole seconds where it keeps any
        time.sleep(0.02)
    assert hdf5_bytes(arrays, pack=True) == first


def test_faults_are_found(laptop: Path, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    shutil.copytree(laptop, folder)
    views = sorted(folder.glob("hdf5/*/*/*/*.h5"))
    cases = {
        "normalised coordinates leave": ("gt_coords/1", lambda a: a + np.float32(0.5)),
        "are not its points moved": ("gt_coords/0", lambda a: a * np.float32([-1, 1, 1])),
        "has another size": ("gt_points/1", lambda a: a * np.float32(1.2)),
        "1 pixels of the mask differ": ("mask", lambda a: np.where(np.arange(a.size).reshape(a.shape), a, 1 - a[0, 0])),
    }
    for view, (name, change) in zip(views, cases.values(), strict=False):
        arrays = read_h5(view)
        arrays[name] = change(arrays[name]).astype(arrays[name].dtype)
        view.write_bytes(hdf5_bytes(arrays))
    urdf = folder / "urdf/laptop/Laptop7n000000/syn.urdf"
    text = urdf.read_text().replace(
        'name="1">\n    <visual>\n      <origin rpy="0 0 0" xyz="',
        'name="1">\n    <visual>\n      <origin rpy="0 0 0" xyz="1',
    )
    urdf.write_text(text)
    (urdf.parent / "more.txt").write_text("")
    splits = folder / "splits/laptop/3.61/train.txt"
    splits.write_text(splits.read_text() + "hdf5/laptop/Laptop7n000000/0009/0.h5\n")
    found = unlike(folder)
    for fault in (*cases, "minus the pivot of link 1", "3 files beside the URDF", "in a list, but not there"):
        assert any(fault in line for line in found), fault
    (folder / "pickle/laptop.pkl").write_bytes(b"\x80\x04cos\nsystem\n")
    with pytest.raises(UserError, match="is not plain data"):
        read_plain_pickle(folder / "pickle/laptop.pkl")


def test_classes_and_parts_that_ancsh_lacks_are_refused() -> None:
    layout = LAYOUTS["ancsh"]
    with pytest.raises(UserError, match="ANCSH has no class for Microwave") as refused:
        layout.term("Microwave")
    assert "the nearest is oven" in (refused.value.hint or "") and "partnet-seg any" in (refused.value.hint or "")
    with pytest.raises(UserError, match="is not of the form"):
        layout.term("Microwave", {"Microwave": {"class": "oven", "parts": {"door/revolute": "door"}}})
