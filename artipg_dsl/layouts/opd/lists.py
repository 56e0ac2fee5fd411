"""The files that OPD's and OPDMulti's loaders read, put together of the views of all objects.

``annotations/MotionNet_<split>.json`` and ``urdf-attr.json`` are OPD's; ``annotations/OPDMulti_<split>.json`` and ``obj_info.json`` say the
same in OPDMulti's form, where the camera's axes are x right, y down, z forward. Both go with ``<split>.h5`` and ``depth.h5``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ...errors import UserError
from ..clouds import norms
from ..entry import Entry
from ..hdf5 import join_rows
from .files import CAMERAS, CLASSES, OBJECTS, columns, short

FOLDERS = {"train": "train", "val": "valid", "test": "test"}
ATTRIBUTES, INFO, STATES_FILE = "urdf-attr.json", "obj_info.json", "image_close.json"
_TO_FORWARD = np.diag([1.0, -1.0, -1.0, 1.0])  # from the axes of OPDSynth to those of OPDMulti, and back
_CATEGORIES = [{"id": k, "name": name, "supercategory": "Container_parts"} for k, name in enumerate(CLASSES, 1)]
_SIZE = {"height": CAMERAS.height, "width": CAMERAS.width}
_SAME = {"license": 1, "coco_url": "", "date_captured": "", "flickr_url": ""} | _SIZE
_SHAPE = (CAMERAS.height, CAMERAS.width)
Source = tuple[Path, int, dict[str, Any]]  # where a view's pictures are: file and row; and what is told of it


def index(entries: Sequence[Entry], folder: Path) -> dict[str, bytes | Callable[[BinaryIO], None]]:
    """All lists. Raises UserError where nothing opens in any object of a category."""
    objects: dict[str, dict[str, Any]] = {}
    views: dict[str, list[Source]] = {split: [] for split in FOLDERS}
    for entry in entries:
        before = len(objects)
        for shard in range(len(entry.chunks())):
            path = folder / OBJECTS / f"{entry.category}-{shard}"
            told = json.loads(path.with_suffix(".json").read_bytes())
            objects |= told["objects"]
            for row, view in enumerate(told["views"]):
                views[view["split"]].append((path.with_suffix(".h5"), row, view))
        if len(objects) == before:
            raise UserError(
                f"nothing of {entry.category} opens as a drawer, door or lid",
                "more objects (-n), or a --map with other words",
            )
    files: dict[str, bytes | Callable[[BinaryIO], None]] = {
        ATTRIBUTES: _json({id: _attributes(own) for id, own in sorted(objects.items())})
    }
    info, states = dict[str, Any](), dict[str, Any]()
    for split, own in views.items():
        name = FOLDERS[split]
        files[f"annotations/MotionNet_{name}.json"] = _json(_listed([view for *_, view in own], objects, _opd))
        files[f"annotations/OPDMulti_{name}.json"] = _json(_listed([view for *_, view in own], objects, _multi))
        files[f"{name}.h5"] = partial(_pictures, name, "images", own, ".png", np.zeros((0, *_SHAPE, 3), np.uint8))
        info |= {_key(view): _info(view, objects) for *_, view in own}
        states |= {
            view["name"]: {part: {"close": value < 1e-6, "value": value} for part, value in view["open"].items()}
            for *_, view in own
        }
    every = [source for own in views.values() for source in own]
    files["depth.h5"] = partial(_pictures, "depth", "depth", every, "_d.png", np.zeros((0, *_SHAPE, 1), np.float32))
    return files | {INFO: _json(info), STATES_FILE: _json(states)}


def _pictures(name: str, own: str, sources: Sequence[Source], ending: str, empty: np.ndarray, stream: BinaryIO) -> None:
    names = np.array([view["name"] + ending for *_, view in sources], dtype="S")
    more = {f"{name}_filenames": names if len(names) else np.zeros(0, "S1")}
    join_rows(stream, {f"{name}_images": (own, empty)}, [(path, row) for path, row, _ in sources], more)


def _listed(views: Sequence[dict[str, Any]], objects: dict[str, Any], form: Any) -> dict[str, Any]:
    """A list of COCO; images and annotations are numbered from 1 on."""
    images, annotations = list[dict[str, Any]](), list[dict[str, Any]]()
    for number, view in enumerate(views, 1):
        image, parts = form(view, objects)
        names = {"id": number, "file_name": f"{view['name']}.png", "depth_file_name": f"{view['name']}_d.png"}
        images.append(names | _SAME | image)
        for told, motion in zip(view["parts"], parts, strict=True):
            more = {key: value for key, value in told.items() if key != "motion"}
            where = {"id": len(annotations) + 1, "image_id": number, "iscrowd": 0}
            annotations.append(where | _SIZE | more | motion)
    return {
        "info": {"description": "artipg_dsl"},
        "licenses": [{"id": 1, "name": "", "url": ""}],
        "categories": _CATEGORIES,
        "images": images,
        "annotations": annotations,
    }


def _opd(view: dict[str, Any], objects: dict[str, Any]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    camera = {key: {"matrix": value} for key, value in view["camera"].items()}
    image = {"camera": camera, "label": objects[view["name"].partition("-")[0]]["category"]}
    return image, [{"motion": part["motion"]} for part in view["parts"]]


def _multi(view: dict[str, Any], objects: dict[str, Any]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    motions = []
    for part in view["parts"]:
        motion = dict(part["motion"])
        axis, origin = (short(np.array(motion[f"current_{word}"]) * [1, -1, -1]) for word in ("axis", "origin"))
        for word in ("axis", "origin"):
            motion.pop(f"current_{word}"), motion.pop(f"initial_{word}")
        motion |= {"axis": axis, "origin": origin, "part_label": motion.pop("label"), "state": motion.pop("value")}
        motion |= {"bbox": part["bbox"], "pixel_num": part["area"]}
        motions.append({"object_key": _key(view), "motion": motion})
    return {"camera": {"intrinsic": view["camera"]["intrinsic"], "extrinsic": _pose(view)}}, motions


def _key(view: dict[str, Any]) -> str:
    """The object in a view, as OPDMulti names it: <scan>_<frame>_<object>."""
    id, _, frame = view["name"].partition("-")
    return f"{id}_{frame}_1"


def _pose(view: dict[str, Any]) -> list[float]:
    """From the camera's frame to the object's, column by column, with the axes of OPDMulti's camera."""
    return columns(np.reshape(view["camera"]["extrinsic"], (4, 4)).T @ _TO_FORWARD)


def _info(view: dict[str, Any], objects: dict[str, Any]) -> dict[str, Any]:
    low, high = np.array(objects[view["name"].partition("-")[0]]["box"])
    bounds = {"min_bound": short(low), "max_bound": short(high)}
    return {"object_pose": _pose(view), "diagonal": short(norms(high - low))} | bounds


def _attributes(own: dict[str, Any]) -> dict[str, Any]:
    """Bounds are up, front, left: loaders turn them round, [x, y, z] into [z, x, y]."""
    low, high = np.array(own["box"])[:, [1, 2, 0]]
    return {
        "category": own["category"],
        "min_bound": short(low),
        "max_bound": short(high),
        "center": short((low + high) / 2),
        "size": short(high - low),
        "diameter": short(norms(high - low)),
    }


def _json(data: Any) -> bytes:
    return (json.dumps(data) + "\n").encode()
