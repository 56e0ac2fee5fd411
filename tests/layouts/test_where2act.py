"""Where2Act: trials read by the formulas of its loader, and what is wrong with a folder found."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.layouts.where2act.hand import PRIMITIVES
from artipg_dsl.view.png import png_bytes, read_png

from .conftest import Lay, faults, unlike

for package, extra in (("h5py", "hdf5"), ("sapien", "sim")):
    pytest.importorskip(package, reason=f"{package} is not installed: pip install 'artipg_dsl[{extra}]'")


@pytest.fixture(scope="module")
def trials(lay: Lay) -> Path:
    return lay("where2act", "Door", n=2, shares=(1, 0, 1))


def listed(folder: Path, split: str) -> list[str]:
    return (folder / split / "data_tuple_list.txt").read_text().split()


def told(folder: Path, split: str, name: str) -> dict[str, Any]:
    return json.loads((folder / split / name / "result.json").read_text())


def points(folder: Path) -> np.ndarray:
    """(448, 448, 4), as ``data.py`` makes it of ``cam_XYZA.h5``."""
    import h5py

    with h5py.File(folder / "cam_XYZA.h5") as file:
        rows, columns, seen = (file[word][:] for word in ("id1", "id2", "pc"))
    assert rows.dtype == columns.dtype == np.uint64 and seen.dtype == np.float32
    made = np.zeros((448, 448, 4), dtype=np.float32)
    made[rows, columns, :3], made[rows, columns, 3] = seen, 1
    return made


def succeeds(result: dict[str, Any], primitive: str) -> bool:
    """``check_success`` of ``data.py``, with its thresholds."""
    at = result["target_object_part_joint_id"]
    gone = abs(result["final_target_part_qpos"] - result["start_target_part_qpos"])
    span = result["joint_angles_upper"][at] - result["joint_angles_lower"][at] + 1e-8
    if result["result"] != "VALID" or (gone <= 0.01 and gone / span <= 0.5):
        return False
    toward, forward = (np.array(result[f"gripper_{word}_world"]) for word in ("direction", "forward_direction"))
    meant = -toward if primitive == "pulling" else forward if "left" in primitive else np.cross(toward, forward)
    way = np.subtract(result["touch_position_world_xyz_end"], result["touch_position_world_xyz_start"])
    return primitive == "pushing" or bool(meant @ way > 0.5 * np.sqrt(way @ way))


@pytest.mark.some
def test_the_folder_is_read_back(trials: Path) -> None:
    assert not faults(trials)
    assert listed(trials, "val") == []
    names = listed(trials, "train") + listed(trials, "test")
    assert len(names) == 24
    for name in names:
        _, category, state, primitive, trial = name.split("_")
        assert category == "Door" and state in "01" and primitive in PRIMITIVES
        assert int(trial) < 5, "`num_interaction_data_offline`: training begins with these alone"


def test_a_trial_is_what_its_pictures_show(trials: Path) -> None:
    """Point, normal and directions by the camera, and that the hand comes from outside."""
    results = []
    for split in ("train", "test"):
        for name in listed(trials, split):
            folder, result = trials / split / name, told(trials, split, name)
            seen, mask = points(folder), read_png((folder / "interaction_mask.png").read_bytes()) > 127
            row, column = result["pixel_locs"]
            pose = np.array(result["camera_metadata"]["mat44"])
            assert seen[row, column, 3] == 1 and mask[row, column] and mask.sum() < seen[..., 3].sum()
            assert np.abs(seen[seen[..., 3] > 0, 0] - 5).max() <= 1.01  # what the loader takes away
            assert abs(np.sqrt(pose[:3, 3] @ pose[:3, 3]) - 5) < 1e-6 and pose[0, 3] < 0
            place = pose[:3, :3] @ seen[row, column, :3] + pose[:3, 3]
            assert np.allclose(place, result["touch_position_world_xyz_start"], atol=1e-3)
            for word in ("gripper_direction", "gripper_forward_direction", "direction"):
                assert np.allclose(pose[:3, :3] @ result[f"{word}_camera"], result[f"{word}_world"], atol=1e-9)
            toward, forward = result["gripper_direction_world"], result["gripper_forward_direction_world"]
            assert abs(np.dot(toward, forward)) < 1e-9 and np.dot(toward, result["direction_world"]) <= 0
            assert np.dot(result["direction_camera"], seen[row, column, :3]) < 0  # its surface faces the camera
            plain, hand = (read_png((folder / f"{word}.png").read_bytes()) for word in ("rgb", "viz_target_pose"))
            assert plain.shape == hand.shape == (448, 448, 3)
            results.append(succeeds(result, name.split("_")[3]))
    assert 0 < sum(results) < len(results)


def test_what_is_wrong_is_found(trials: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(trials, tmp_path / "trials"))
    one, other, third, fourth = listed(folder, "train")[:4]
    result = told(folder, "train", one)
    result["touch_position_world_xyz_end"][0] += 0.1
    result["gripper_direction_world"] = [-x for x in result["gripper_direction_world"]]
    (folder / "train" / one / "result.json").write_text(json.dumps(result))
    mask = read_png((folder / "train" / other / "interaction_mask.png").read_bytes())
    (folder / "train" / other / "interaction_mask.png").write_bytes(png_bytes(255 - mask))
    (folder / "train" / third / "rgb.png").unlink()
    names = (folder / "train" / "data_tuple_list.txt").read_text()
    (folder / "train" / "data_tuple_list.txt").write_text(names.replace(f"{fourth}\n", ""))
    found = " ".join(unlike(folder))
    assert f"train/{one}: where the point comes to" in found and f"train/{one}: gripper_direction differ" in found
    assert "pixels of the mask differ" in found and "rgb.png is missing" in found
    assert f"train/{fourth}: not in data_tuple_list.txt" in found
    assert f"train/{third}/rgb.png: the file is missing" in found
    assert "train/data_tuple_list.txt: does not list" in found and found.count("train/") == 7


def test_what_it_cannot_hold_is_refused(lay: Lay, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UserError, match="there is no trial of Pen"):
        lay("where2act", "Pen", n=1)  # nothing of the first one moves
    monkeypatch.setattr("artipg_dsl.extras.find_spec", lambda name: None if name == "sapien" else True)
    with pytest.raises(UserError, match="where2act needs SAPIEN, which is not installed") as refused:
        lay("where2act", "Door", n=1)
    assert "artipg_dsl[sim]" in (refused.value.hint or "")
