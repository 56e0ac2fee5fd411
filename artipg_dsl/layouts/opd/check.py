"""OPD's and OPDMulti's files read back as their loaders do, and compared with the model."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..clouds import norms
from ..entry import Entry
from ..findings import Findings
from ..pictures import turn_points
from .files import CLASSES, DEPTH, LEAST, TYPES, Shot, shots
from .lists import ATTRIBUTES, FOLDERS, INFO, STATES_FILE
from .outlines import along_pixels, fill

if TYPE_CHECKING:
    from ...runtime.batch import Batch

_NEAR = 1e-6  # lengths
_FLIP = np.array([1.0, -1.0, -1.0])  # between the axes of OPD's and of OPDMulti's camera
Record = tuple[dict[str, Any], list[dict[str, Any]]]  # an image and its annotations


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as the loaders do, and compare with the model."""
    attributes = _read(folder / ATTRIBUTES)
    states = _read(folder / STATES_FILE)
    for shot in shots(batch, entry):
        split = FOLDERS[shot.told["split"]]
        name = f"{shot.name}.png"
        place = f"{split}/{name}"
        lists = [_records(folder / f"annotations/{form}_{split}.json") for form in ("MotionNet", "OPDMulti")]
        if not all(found.of(place, name in known, "not in the list of its split") for known in lists):
            continue
        (image, parts), (other, others) = (known[name] for known in lists)
        _check_pictures(place, folder, split, image, shot, found)
        number = shot.name.partition("-")[0]
        found.of(place, int(number) < 1 << 31, f"its id, {number}, is too large for loaders")
        if found.of(place, number in attributes, f"its object is not in {ATTRIBUTES}"):
            _check_attributes(place, attributes[number], shot, found)
        held = {part: told["value"] for part, told in states.get(shot.name, {}).items()}
        found.of(place, held == shot.told["open"], f"how far parts are open in {STATES_FILE} is not as in the model")
        turn = _check_camera(place, folder, image, shot, found)
        if not found.of(
            place, len(parts) == len(others) == len(shot.masks), f"{len(parts)} parts, not {len(shot.masks)}"
        ):
            continue
        for k, (part, again) in enumerate(zip(parts, others, strict=True)):
            _check_part(f"{place} part {k}", part, again, k, turn, shot, found)
        _check_multi(place, folder, other, others, turn, shot, found)


def _read(path: Path) -> Any:
    return _parsed(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=16)
def _parsed(path: Path, stamp: int) -> Any:
    return json.loads(path.read_bytes())


def _records(path: Path) -> dict[str, Record]:
    return _listed(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=8)
def _listed(path: Path, stamp: int) -> dict[str, Record]:
    """Images by name, with their annotations. Classes are numbered from 0 on, in the order of their ids."""
    read = json.loads(path.read_bytes())
    order = {id: k for k, id in enumerate(sorted(known["id"] for known in read["categories"]))}
    made: dict[int, Record] = {image["id"]: (image, []) for image in read["images"]}
    for told in read["annotations"]:
        made[told["image_id"]][1].append(told | {"category_id": order.get(told["category_id"], -1)})
    return {image["file_name"]: (image, parts) for image, parts in made.values()}


@lru_cache(maxsize=8)
def _rows(path: Path, name: str, stamp: int) -> dict[str, int]:
    import h5py

    with h5py.File(path, "r") as file:
        return {word.decode("utf-8"): k for k, word in enumerate(file[f"{name}_filenames"][()])}


def _picture(folder: Path, name: str, word: str) -> np.ndarray | None:
    """A picture by the name of its file, as loaders look for it; None where there is none."""
    import h5py

    path = folder / f"{name}.h5"
    row = _rows(path, name, path.stat().st_mtime_ns).get(word)
    if row is None:
        return None
    with h5py.File(path, "r") as file:
        found: np.ndarray = file[f"{name}_images"][row]
        return found


def _check_pictures(place: str, folder: Path, split: str, image: dict[str, Any], shot: Shot, found: Findings) -> None:
    size = (image["height"], image["width"])
    rgb, depth = _picture(folder, split, image["file_name"]), _picture(folder, "depth", image["depth_file_name"])
    if found.of(place, rgb is not None, f"not in {split}.h5"):
        assert rgb is not None
        found.of(place, rgb.dtype == np.uint8 and rgb.shape == (*size, 3), f"a picture of {rgb.shape}, {rgb.dtype}")
        found.same(place, "colours", rgb, shot.rgb)
    if found.of(place, depth is not None, "not in depth.h5"):
        assert depth is not None
        found.of(
            place, depth.dtype == np.float32 and depth.shape == (*size, 1), f"depths of {depth.shape}, {depth.dtype}"
        )
        found.near(place, "depths", depth[..., 0], shot.depth, 1e-3)


def _check_attributes(place: str, read: dict[str, Any], shot: Shot, found: Findings) -> None:
    """As the loader turns bounds round."""
    bounds = np.array([np.array(read[f"{end}_bound"])[[2, 0, 1]] for end in ("min", "max")])
    found.near(place, f"bounds in {ATTRIBUTES}", bounds, shot.subject.box, _NEAR)
    size = float(norms(shot.subject.box[1] - shot.subject.box[0]))
    found.of(
        place,
        abs(read["diameter"] - size) < _NEAR,
        f"its diagonal in {ATTRIBUTES} is {read['diameter']}, not {size:.6g}",
    )


def _check_camera(place: str, folder: Path, image: dict[str, Any], shot: Shot, found: Findings) -> np.ndarray:
    """The matrix to the object's frame, as the loader reads it; depths by it are where the model has its surface."""
    turn = np.reshape(image["camera"]["extrinsic"]["matrix"], (4, 4)).T
    lens = np.reshape(image["camera"]["intrinsic"]["matrix"], (3, 3), order="F")
    found.of(place, bool((turn[3] == [0, 0, 0, 1]).all()), "its matrix is not column by column")
    proper = np.abs(turn[:3, :3] @ turn[:3, :3].T - np.eye(3)).max() < 1e-6 and np.linalg.det(turn[:3, :3]) > 0
    found.of(place, bool(proper), "its camera is not turned, but mirrored or stretched")
    depth = _picture(folder, "depth", image["depth_file_name"])
    if depth is None or depth.shape[:2] != shot.depth.shape:
        return turn
    row, column = shot.pixel.T
    seen = np.zeros(shot.depth.shape, dtype=bool)
    seen[row, column] = True
    found.of(place, bool(((depth[..., 0] > 0) == seen).all()), "depths where nothing is, or the reverse")
    z = depth[row, column, 0].astype(np.float64) / DEPTH
    x, y = (column + 0.5 - lens[0, 2]) * z / lens[0, 0], (row + 0.5 - lens[1, 2]) * z / lens[1, 1]
    again = turn_points(np.stack([x, -y, -z], axis=-1), turn[:3, :3]) + turn[:3, 3]
    found.near(place, "points by its depths", again, shot.raw, 1e-5)
    return turn


def _check_part(
    place: str, part: dict[str, Any], again: dict[str, Any], k: int, turn: np.ndarray, shot: Shot, found: Findings
) -> None:
    mask, told = shot.masks[k], shot.told["parts"][k]
    found.of(place, part["iscrowd"] == 0, "is a crowd, which loaders leave out")
    found.of(place, 0 <= part["category_id"] < len(CLASSES), "a class that there is not")
    found.of(place, part["category_id"] == told["category_id"] - 1, "another class than in the model")
    polygons = part["segmentation"]
    found.of(place, all(len(p) % 2 == 0 and len(p) >= 6 for p in polygons), "a polygon that loaders leave out")
    found.of(place, along_pixels(polygons), "edges across pixels")
    read = fill(polygons, *mask.shape)
    found.same(place, "pixels", read, mask)
    found.of(place, int(read.sum()) >= LEAST, "next to nothing of it is seen")
    row, column = np.nonzero(read)
    if len(row):
        box = [column.min(), row.min(), np.ptp(column) + 1, np.ptp(row) + 1]
        found.near(place, "box around its pixels", np.array(part["bbox"]), np.array(box, dtype=np.float64), 0.0)
    found.of(place, part["area"] == int(read.sum()), "its area is not its pixels")
    for key in ("segmentation", "bbox", "area", "category_id"):
        found.of(place, part[key] == again[key], f"{key} is another in OPDMulti's list")
    _check_motion(place, part["motion"], again["motion"], k, turn, shot, found)


def _check_motion(
    place: str, motion: dict[str, Any], again: dict[str, Any], k: int, turn: np.ndarray, shot: Shot, found: Findings
) -> None:
    """As the loader carries it to the object's frame, where the model has its joint."""
    model = shot.told["parts"][k]["motion"]
    found.of(place, motion["type"] in TYPES.values(), f"{motion['type']} is no type that loaders know")
    for word in ("partId", "type", "label", "rangeMin", "rangeMax", "value", "isClosed"):
        found.of(place, motion[word] == model[word], f"{word} is {motion[word]}, not {model[word]}")
    for word in ("current", "initial"):
        axis, origin = (np.array(motion[f"{word}_{what}"]) for what in ("axis", "origin"))
        found.of(place, abs(float(norms(axis)) - 1) < _NEAR, f"the {word} axis has not the length 1")
        found.near(place, f"{word} axis", axis, np.array(model[f"{word}_axis"]), _NEAR)
        found.near(place, f"{word} origin", origin, np.array(model[f"{word}_origin"]), _NEAR)
    axis, origin = (np.array(motion[f"current_{what}"]) for what in ("axis", "origin"))
    joint = shot.joints[k]
    ends = turn_points(np.stack([origin, origin + axis]), turn[:3, :3]) + turn[:3, 3]
    found.near(place, "origin in the object's frame", ends[0], joint[0], _NEAR)
    found.near(place, "axis in the object's frame", ends[1] - ends[0], joint[1], _NEAR)
    for word, mine in (("axis", axis), ("origin", origin)):
        found.near(place, f"{word} in OPDMulti's list", np.array(again[word]) * _FLIP, mine, _NEAR)


def _check_multi(
    place: str,
    folder: Path,
    image: dict[str, Any],
    parts: list[dict[str, Any]],
    turn: np.ndarray,
    shot: Shot,
    found: Findings,
) -> None:
    """What OPDMulti's loader asks for beside that: matrices as lists, the object of each part."""
    info = _read(folder / INFO)
    camera = image["camera"]["extrinsic"]
    if not found.of(place, isinstance(camera, list) and len(camera) == 16, "OPDMulti's matrix is no list of 16"):
        return
    found.near(place, "OPDMulti's camera", np.reshape(camera, (4, 4)).T[:3], (turn * [1, -1, -1, 1])[:3], _NEAR)
    for key in {part["object_key"] for part in parts}:
        if found.of(place, key in info, f"{key} is not in {INFO}"):
            found.near(place, "pose of its object", np.array(info[key]["object_pose"]), np.array(camera), _NEAR)
            size = float(norms(shot.subject.box[1] - shot.subject.box[0]))
            found.of(place, abs(info[key]["diagonal"] - size) < _NEAR, f"another diagonal in {INFO}")
