"""ManiSkill's folders and lists read back as its loaders and tasks do, and compared with the model in metres."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...export.partnet.mobility import folder_frame, folder_order
from ...robot.model import RobotJoint
from ...robot.robots import Robots
from ..entry import Entry
from ..findings import Findings, read_vertices, read_xml
from ..pictures import turn_points
from .files import DATASET, LISTS, list_name, subjects, urdf_type

if TYPE_CHECKING:
    from ...runtime.batch import Batch

_URDFS = ("mobility_cvx.urdf", "mobility_fixed.urdf")  # in the order in which loaders look for them
_NEAR = 1e-6  # metres
_OUT_OF_RAW = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # to the object's axes


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as loaders and tasks do, and compare with the model."""
    for i, id, files, lists, robots in subjects(batch, entry):
        number = int(batch.numbers[i])
        own = folder / DATASET / str(id)
        for kind in LISTS:
            held = json.loads((folder / list_name(kind, entry.split(number))).read_bytes())
            told = held.get(str(id))
            place = f"{kind} {id}"
            if found.of(place, (told is not None) == (kind in lists), "is in the list, or is not, unlike in the model"):
                if told is not None:
                    _check_list(place, kind, told, lists[kind], own, found)
                    _check_folder(place, own, told["scale"], robots, i, found)
        if lists:
            for name, data in files.items():
                found.of(f"{id}/{name}", (own / name).read_bytes() == data, "is not what the model gives")


def _urdf(own: Path) -> ET.Element:
    path = next((own / name for name in _URDFS if (own / name).exists()), own / _URDFS[0])
    return read_xml(path)


def _visuals(link: ET.Element) -> Iterator[tuple[str, str]]:
    """Names and files of what is seen of a link."""
    for visual in link.findall("visual"):
        mesh = visual.find("geometry/mesh")
        assert mesh is not None
        yield visual.attrib["name"], mesh.attrib["filename"]


def _check_list(place: str, kind: str, told: dict[str, Any], model: dict[str, Any], own: Path, found: Findings) -> None:
    """What the tasks take without looking: every joint of their types is one to be moved, by a handle, from the lower limit on."""
    found.of(place, told == model, "its entry is not what the model gives")
    root = _urdf(own)
    links = {link.attrib["name"]: link for link in root.iter("link")}
    joints = {child.attrib["link"]: joint for joint in root.iter("joint") for child in joint.findall("child")}
    wanted = [name for name, joint in joints.items() if joint.attrib["type"] in LISTS[kind]]
    if kind == "faucet":
        switches = [name for name, _, word in told["semantics"] if word == "switch"]
        found.of(place, bool(switches), "has no switch, of which the task takes one")
        found.of(place, set(switches) <= set(wanted), "a switch that does not turn")
        found.of(
            place,
            {name for name, _, _ in told["semantics"]} == links.keys() - {"base"},
            "other links than the URDF has",
        )
        return
    found.of(
        place, len(wanted) == told["num_target_links"], f"{len(wanted)} links move so, not {told['num_target_links']}"
    )
    found.of(place, str(told["partnet_mobility_id"]) == own.name, "another id")
    for name, joint in joints.items():
        limit = joint.find("limit")
        if joint.attrib["type"] != "fixed" and found.of(
            place, limit is not None, f"{name} has no limits, of which the task sets it to the lower"
        ):
            assert limit is not None
            low, high = float(limit.attrib["lower"]), float(limit.attrib["upper"])
            found.of(place, -low <= high, f"{name} is not shut at its lower limit")
    for name in wanted:
        handles = [file for word, file in _visuals(links[name]) if "handle" in word]
        found.of(place, bool(handles), f"{name} has no handle, at which the task fails")
        found.of(place, all(len(read_vertices(own / file)) for file in handles), f"the handle of {name} has no mesh")


def _check_folder(place: str, own: Path, scale: float, robots: Robots, i: int, found: Findings) -> None:
    """Meshes, colliders and joints, scaled as the loader does, where the model has them, in metres."""
    robot, root = robots.robot(i), _urdf(own)
    frame, order = folder_frame(robot), folder_order(robot)
    links = {link.attrib["name"]: link for link in root.iter("link")}
    joints = {joint.attrib["name"]: joint for joint in root.iter("joint")}
    above = {joint.child: joint for joint in robot.joints}
    pivot = {k: frame.points(robot.links[k].origin) if k in above else np.zeros(3) for k in order}
    for n, k in enumerate(order):
        name, ours, joint = f"link_{n}", robot.links[k], joints.get(f"joint_{n}")
        if not found.of(place, name in links and joint is not None, f"{name} is not there, or hangs on nothing"):
            continue
        assert joint is not None
        for shape in (*links[name].findall("visual"), *links[name].findall("collision")):
            found.near(place, f"pivot of {name}", _xyz(shape, "origin"), -pivot[k], _NEAR)
        seen = np.concatenate([np.zeros((0, 3)), *(read_vertices(own / file) for _, file in _visuals(links[name]))])
        model = np.concatenate([np.zeros((0, 3)), *(v.shape.vertices + ours.origin for v in ours.visuals)])
        if found.of(place, len(seen) == len(model), f"{len(seen)} vertices of {name}, not {len(model)}") and len(seen):
            metres = turn_points(seen * scale, _OUT_OF_RAW) + frame.center
            found.near(place, f"ends of {name} in metres", _ends(metres), _ends(model), _NEAR)
        hulls = [mesh.attrib["filename"] for mesh in links[name].findall("collision/geometry/mesh")]
        found.of(
            place, len(hulls) == len(ours.colliders), f"{len(hulls)} colliders of {name}, not {len(ours.colliders)}"
        )
        found.of(place, all((own / file).is_file() for file in hulls), f"a collider of {name} is not there")
        if k in above:
            _check_joint(place, joint, above[k], pivot[k] - pivot[above[k].parent], scale, found)


def _ends(points: np.ndarray) -> np.ndarray:
    return np.stack([points.min(axis=0), points.max(axis=0), points.mean(axis=0)])


def _xyz(element: ET.Element, name: str) -> np.ndarray:
    """Three numbers of a child of an element."""
    child = element.find(name)
    return np.array("nan nan nan".split() if child is None else child.attrib["xyz"].split(), dtype=np.float64)


def _check_joint(
    place: str, joint: ET.Element, model: RobotJoint, origin: np.ndarray, scale: float, found: Findings
) -> None:
    """Type, place, axis and limits; what slides does so in metres when it is scaled."""
    name, kind, limit = joint.attrib["name"], urdf_type(model), joint.find("limit")
    found.of(place, joint.attrib["type"] == kind, f"{name} is {joint.attrib['type']}, not {kind}")
    found.near(place, f"origin of {name}", _xyz(joint, "origin"), origin, _NEAR)
    if kind == "fixed":
        return
    found.near(place, f"axis of {name}", turn_points(_xyz(joint, "axis")[None], _OUT_OF_RAW)[0], model.axis, _NEAR)
    if limit is not None and model.low is not None and model.high is not None:
        read = np.array([float(limit.attrib[end]) for end in ("lower", "upper")])
        unit, advance = (1.0, 1.0) if model.advance is None else (scale, model.advance)
        found.near(place, f"limits of {name}", read * unit, np.array([model.low, model.high]) * advance, _NEAR)
