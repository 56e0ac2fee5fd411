"""GAPartNet's annotated folders and rendered views read back as its tools do, and compared with the model."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..clouds import norms
from ..entry import Entry
from ..findings import Findings, read_vertices, read_xml
from ..pictures import turn_points
from ..pth import read_plain_pickle
from .views import DATASET, LISTED, RENDERED, TARGETS, Subject, View, views

if TYPE_CHECKING:
    from ...runtime.batch import Batch

_URDF = "mobility_annotation_gapartnet.urdf"
_TO_WORLD = np.array([[0.0, 0, -1], [-1, 0, 0], [0, 1, 0]])  # from the raw frame


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as the tools do, and compare with the model."""
    assert entry.term is not None
    listed = (folder / LISTED).read_text("utf-8").splitlines()
    for subject, seen in views(batch, entry):
        own = folder / DATASET / str(subject.id)
        found.of(str(subject.id), f"{entry.term.name} {subject.id}" in listed, "not in the list of ids")
        links = _check_urdf(str(subject.id), own, found)
        _check_boxes(str(subject.id), own, subject, links, found)
        for name, data in subject.files.items():
            found.of(f"{subject.id}/{name}", (own / name).read_bytes() == data, "is not what the model gives")
        for view in seen:
            _check_view(folder / RENDERED, view, links, found)


def _check_urdf(place: str, own: Path, found: Findings) -> dict[str, tuple[np.ndarray, np.ndarray | None]]:
    """The annotated URDF: of each link what is seen of it, in the world, and the axis of the joint that moves it, None for
    none. A joint without an origin gets that of the one before it from the tools."""
    root, links = read_xml(own / _URDF), {}
    above = {}
    for joint in root.iter("joint"):
        child, axis = joint.find("child"), joint.find("axis")
        found.of(place, joint.find("origin") is not None, f"{joint.attrib['name']} has no origin")
        assert child is not None
        above[child.attrib["link"]] = None if axis is None else np.array(axis.attrib["xyz"].split(), dtype=np.float64)
    for link in root.iter("link"):
        name = link.attrib["name"]
        if name == "base":
            continue
        found.of(place, name in above, f"{name} hangs on no joint")
        files = [mesh.attrib["filename"] for mesh in link.findall("visual/geometry/mesh")]
        raw = [read_vertices(own / file) for file in files]
        points = np.concatenate([np.zeros((0, 3)), *raw])
        along = above.get(name)
        links[name] = turn_points(points, _TO_WORLD), None if along is None else _TO_WORLD @ along
    return links


def _check_boxes(
    place: str, own: Path, subject: Subject, links: dict[str, tuple[np.ndarray, np.ndarray | None]], found: Findings
) -> None:
    """The boxes of the parts: in the world at rest, their corners in order, around what is seen of their links."""
    read = {
        entry["link_name"]: entry for entry in json.loads((own / "link_annotation_gapartnet.json").read_text("utf-8"))
    }
    found.of(place, read.keys() == links.keys(), "boxes of other links than those of the URDF")
    for placed in subject.parts:
        entry = read.get(placed.link)
        if not found.of(place, entry is not None and entry["is_gapart"], f"{placed.link} is said to be no part"):
            continue
        assert entry is not None
        found.of(place, entry["category"] in TARGETS, f"{entry['category']}, which the tools drop in silence")
        corners = np.array(entry["bbox"], dtype=np.float64)
        found.near(place, f"box of {placed.link}", corners, placed.corners(), 1e-8)
        if corners.shape != (8, 3):
            continue
        axes, size = _box_axes(corners)
        found.of(place, abs(float(np.linalg.det(axes)) - 1) < 1e-6, f"corners of {placed.link} are out of order")
        points, axis = links[placed.link]
        local = turn_points(points - corners.mean(axis=0), axes)
        off = float(np.abs(np.abs(local).max(axis=0) - size / 2).max()) if len(local) else 1.0
        found.of(place, off < 2e-3, f"the box of {placed.link} is not that of its mesh: {off:.4f} off")
        if entry["category"] in ("hinge_door", "hinge_lid") and axis is not None:
            found.of(place, abs(abs(float(axes[0] @ axis)) - 1) < 1e-6, f"x of {placed.link} is not along its hinge")
        if entry["category"] == "slider_drawer" and axis is not None:
            found.of(place, abs(abs(float(axes[2] @ axis)) - 1) < 1e-6, f"z of {placed.link} is not how it slides")


def _box_axes(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axes (3, 3), as rows, and size (3,) of a box by its corners (8, 3), as the tools take them."""
    edges = np.stack([corners[1] - corners[0], corners[1] - corners[2], corners[0] - corners[4]])
    size = norms(edges)
    return edges / np.maximum(size, 1e-300)[:, None], size


def _check_view(folder: Path, view: View, links: Any, found: Findings) -> None:
    """As ``convert_rendered_into_input.py`` reads it, and against the model."""
    name = view.name
    found.of(name, (folder / "rgb" / f"{name}.png").is_file(), "no picture")
    read: dict[str, np.ndarray] = {}
    for kind, arrays in view.arrays.items():
        with np.load(folder / kind / f"{name}.npz", allow_pickle=False) as held:
            for key, model in arrays.items():
                read[key] = held[key]
                found.near(name, key, held[key], model, 1e-6)
    meta = json.loads((folder / "metafile" / f"{name}.json").read_text("utf-8"))
    boxes = read_plain_pickle(folder / "bbox" / f"{name}.pkl")["bbox_pose_dict"]
    found.of(name, boxes.keys() == view.boxes["bbox_pose_dict"].keys(), "boxes of other parts")
    found.of(name, meta["target_gaparts"] == list(TARGETS), "other classes than the tools know")
    shape = (meta["height"], meta["width"])
    depth, semantic, instance = (read[k] for k in ("depth_map", "semantic_segmentation", "instance_segmentation"))
    if not all(found.of(name, a.shape == shape, f"an image of {a.shape}") for a in (depth, semantic, instance)):
        return
    found.of(name, bool(((depth > 0) == (semantic > -2)).all()), "depth where nothing is, or the reverse")
    found.of(name, bool(((semantic < 0) == (instance < 0)).all()), "a class without an instance, or the reverse")
    found.of(name, bool((semantic >= -2).all() and (semantic < len(TARGETS)).all()), "a class that there is not")
    matrix = np.array(meta["camera_intrinsic"]).reshape(3, 3)
    turn, shift = np.array(meta["world2camera_rotation"]).reshape(3, 3), np.array(meta["camera2world_translation"])
    for link, box in boxes.items():
        found.of(name, link in links, f"{link} is not in the URDF")
        _check_part(f"{name} {link}", box, read, matrix, turn, shift, found)


def _check_part(
    place: str,
    box: dict[str, Any],
    read: dict[str, np.ndarray],
    matrix: np.ndarray,
    turn: np.ndarray,
    shift: np.ndarray,
    found: Findings,
) -> None:
    """A part of a view: its coordinates by the tools' formula from depth and box, within the box."""
    row, column = np.nonzero(read["instance_segmentation"] == box["instance_id"])
    if not found.of(place, len(row) > 0, "has no pixel, which the tools do not take"):
        return
    found.of(place, bool((read["semantic_segmentation"][row, column] == box["category_id"]).all()), "several classes")
    axes, size = _box_axes(np.asarray(box["bbox"]))
    pose, scale = box["pose_RTS_param"], float(norms(size))
    found.near(place, "R", pose["R"], axes, 1e-6)
    found.near(place, "S", pose["S"], size, 1e-6)
    z = read["depth_map"][row, column].astype(np.float64)
    camera = np.stack([(column - matrix[0, 2]) * z / matrix[0, 0], (row - matrix[1, 2]) * z / matrix[1, 1], z], axis=-1)
    world = turn_points(camera, turn) + shift
    npcs = read["npcs_map"][row, column].astype(np.float64)
    found.near(place, "coordinates", npcs, turn_points(world - np.mean(box["bbox"], axis=0), axes) / scale, 1e-3)
    within = np.abs(npcs) * scale <= size / 2 + 5e-3
    found.of(place, bool(within.all()), "coordinates beyond the box")
    found.of(place, float(np.abs(npcs).max()) <= 0.5 + 5e-3, "coordinates beyond 0.5")
