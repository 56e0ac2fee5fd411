"""What GAPartNet's tools are given and make: annotated folders of PartNet-Mobility, and views rendered of these.

``dataset/<id>/`` is a folder of PartNet-Mobility with fixed handles split off as links, and the boxes of the parts;
``rendered_data/`` is what the render tool makes of it, which its converter reads. World: z up, the front to -x, the half
diagonal 1, in which depths are, too; the camera's axes are x right, y down, z forward.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ...annotate.states import joint_values, read_states
from ...errors import UserError
from ...export.containers import npz_bytes
from ...export.partnet.frame import DatasetFrame
from ...export.partnet.mobility import folder_frame, folder_order, folder_value, partnet_files
from ...records import dataclass
from ...robot.robots import Robots
from ...view.png import png_bytes
from ..clouds import norms
from ..entry import Entry
from ..pictures import Picture, pictures, turn_points
from ..pth import plain_pickle
from .parts import CLASSES, GAPart, gaparts, owners
from .points import CAMERAS, STATES
from .split_links import split_links

if TYPE_CHECKING:
    from ...runtime.batch import Batch

DATASET, RENDERED, LISTED = "dataset", "rendered_data", "meta/partnet_all_id_list.txt"
TARGETS = (*CLASSES[1:-1], "hinge_handle")  # as annotations and the render tool spell them
_VIEWS = replace(CAMERAS, width=800, height=800, points=1)
_WORLD = np.array([-1.0, -1.0, 1.0])  # from the object's axes: left and front are negative
_SIGNS = np.array([[-1, 1, 1], [1, 1, 1], [1, -1, 1], [-1, -1, 1], [-1, 1, -1], [1, 1, -1], [1, -1, -1], [-1, -1, -1]])
"""The corners of a box in the order of the annotations, along its own axes."""


@dataclass(frozen=True, slots=True)
class World:
    """From an object's frame (metres) to the world of its folder."""

    frame: DatasetFrame

    def points(self, points: np.ndarray) -> np.ndarray:
        return (points - self.frame.center) / self.frame.unit * _WORLD

    def turn(self, turn: np.ndarray) -> np.ndarray:
        """Rows (..., 3) that are directions in the object's frame, in the world."""
        return turn * _WORLD


@dataclass(frozen=True, slots=True)
class Placed:
    """A part in the world: the link that it is in the annotated folder, ``axes`` (3, 3) as rows, ``center`` and ``size`` (3,)."""

    part: GAPart
    link: str
    axes: np.ndarray
    center: np.ndarray
    size: np.ndarray

    def corners(self) -> np.ndarray:
        """(8, 3), in the order of the annotations."""
        return self.center + turn_points(_SIGNS * self.size / 2, self.axes.T)

    def npcs(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the world in the part's coordinates."""
        return turn_points(points - self.center, self.axes) / norms(self.size)


@dataclass(frozen=True, slots=True)
class Subject:
    """An object: what its folder holds, and its parts with all joints at 0."""

    id: int
    world: World
    files: dict[str, bytes]
    parts: list[Placed]


def subjects(batch: Batch, entry: Entry) -> Iterator[tuple[Subject, Robots]]:
    """The objects of a batch, with the robots that they were made of."""
    assert entry.term is not None
    robots = Robots(batch)
    for i, parts in enumerate(gaparts(batch, entry.term)):
        robot = robots.robot(i)
        world, order = World(folder_frame(robot)), folder_order(robot)
        files = partnet_files(robots, i)
        leaves = {k: list(dict.fromkeys(_instances(robot.links[k]))) for k in order}
        mobility = json.loads(files["mobility_v2.json"])
        split: dict[int, tuple[int, int]] = {}  # fixed parts: the folder's link, and the leaf
        names = []
        for k, part in enumerate(parts):
            own = order.index(part.link)
            if part.instance >= 0 and part.instance in leaves[part.link]:
                split[k] = own, mobility[own]["parts"][leaves[part.link].index(part.instance)]["id"]
                names.append(f"link_{len(order) + len(split) - 1}")
            else:
                names.append(f"link_{own}")
        placed = [
            Placed(part, name, world.turn(part.axes), world.points(part.center), part.size / world.frame.unit)
            for part, name in zip(parts, names, strict=True)
        ]
        text, said = split_links(files["mobility.urdf"], files["semantics.txt"].decode(), list(split.values()))
        files["mobility_annotation_gapartnet.urdf"] = text
        files["mobility_texture_gapartnet.urdf"] = files["mobility.urdf"]
        files["semantics_gapartnet.txt"] = said.encode()
        files["link_annotation_gapartnet.json"] = _annotation(placed, len(order) + len(split))
        yield Subject(entry.id(int(batch.numbers[i])), world, files, placed), robots


def _instances(link: Any) -> list[int]:
    return [int(v.item.group.table.instance[v.item.row]) for v in link.visuals]


def _annotation(parts: Sequence[Placed], count: int) -> bytes:
    by_link = {part.link: part for part in parts}
    listed = []
    for k in range(count):
        name = f"link_{k}"
        part = by_link.get(name)
        category = TARGETS[part.part.kind - 1] if part else "others"
        corners = np.round(part.corners(), 9).tolist() if part else []
        listed.append({"link_name": name, "is_gapart": part is not None, "category": category, "bbox": corners})
    return (json.dumps(listed, indent=1) + "\n").encode()


@dataclass(frozen=True, slots=True)
class View:
    """What a rendered view holds, by the folder of ``rendered_data`` and the ending of its file."""

    name: str
    rgb: np.ndarray
    arrays: dict[str, dict[str, np.ndarray]]
    boxes: dict[str, Any]
    meta: dict[str, Any]


def views(batch: Batch, entry: Entry) -> Iterator[tuple[Subject, list[View]]]:
    """The objects, and the views of them that show a part: two in each of two states."""
    assert entry.term is not None
    values = joint_values(batch, read_states(STATES))
    poses = [batch.pose(state) for state in values]
    known = list(subjects(batch, entry))
    robots = known[0][1]
    made: list[list[View]] = [[] for _ in known]
    for picture in pictures(batch, robots, _VIEWS, values):
        subject = known[picture.i][0]
        owner = owners([placed.part for placed in subject.parts], picture.link, picture.instance)
        if (owner >= 0).any():
            row = int(robots.link_start[picture.i])
            turn, shift = poses[picture.state]
            moved = [_moved(placed, subject.world, turn[row:], shift[row:]) for placed in subject.parts]
            state = _joint_state(robots, picture, values[picture.state], subject.world.frame)
            made[picture.i].append(_view(entry, subject, picture, owner, moved, state))
    yield from zip((subject for subject, _ in known), made, strict=True)


def _moved(placed: Placed, world: World, turn: np.ndarray, shift: np.ndarray) -> Placed:
    """A part where its link has come to."""
    part = placed.part
    center = turn_points(part.center[None], turn[part.link])[0] + shift[part.link]
    axes = turn_points(part.axes, turn[part.link])
    return Placed(part, placed.link, world.turn(axes), world.points(center), placed.size)


def _joint_state(robots: Robots, picture: Picture, values: np.ndarray, frame: DatasetFrame) -> dict[str, float]:
    """Values of the joints of the annotated folder."""
    robot, order = robots.robot(picture.i), folder_order(robots.robot(picture.i))
    own = values[int(robots.joint_start[picture.i]) :]
    found = {f"joint_{k}": 0.0 for k in range(len(order))}
    for joint, value in zip(robot.joints, own.tolist(), strict=False):
        if joint.kind not in ("fixed", "ball"):
            found[f"joint_{order.index(joint.child)}"] = value * folder_value(joint, frame)
    return found


def _view(
    entry: Entry,
    subject: Subject,
    picture: Picture,
    owner: np.ndarray,
    moved: Sequence[Placed],
    state: dict[str, float],
) -> View:
    assert entry.term is not None
    shape, unit = picture.depth.shape, subject.world.frame.unit
    row, column = picture.pixel.T
    semantic, instance = (np.full(shape, -2, dtype=np.int32) for _ in range(2))
    npcs = np.zeros((*shape, 3), dtype=np.float32)
    semantic[row, column] = instance[row, column] = -1
    world = subject.world.points(picture.position)
    boxes = {}
    for number, k in enumerate(np.unique(owner[owner >= 0]).tolist()):
        part, at = moved[k], owner == k
        semantic[row[at], column[at]], instance[row[at], column[at]] = part.part.kind - 1, number
        npcs[row[at], column[at]] = part.npcs(world[at])
        pose = {"R": part.axes, "T": part.center, "S": part.size, "scaler": float(norms(part.size))}
        boxes[part.link] = {
            "bbox": part.corners(),
            "category_id": part.part.kind - 1,
            "instance_id": number,
            "pose_RTS_param": pose,
        }
    focal, half = _VIEWS.focal, _VIEWS.width / 2 - 0.5  # readers take the middle of a pixel for its number
    meta = {
        "model_id": subject.id,
        "category": entry.term.name,
        "camera_idx": picture.view,
        "render_idx": picture.state,
        "width": _VIEWS.width,
        "height": _VIEWS.height,
        "joint_qpos": state | {f"joint_{k}": 0.0 for k in range(len(state), _count(subject))},
        "camera_pos": subject.world.points(picture.eye).tolist(),
        "camera_intrinsic": [focal, 0.0, half, 0.0, focal, half, 0.0, 0.0, 1.0],
        "world2camera_rotation": subject.world.turn(picture.turn).T.ravel().tolist(),
        "camera2world_translation": subject.world.points(picture.eye).tolist(),
        "target_gaparts": list(TARGETS),
        "use_raytracing": False,
        "replace_texture": False,
    }
    arrays: dict[str, dict[str, np.ndarray]] = {
        "depth": {"depth_map": (picture.depth / unit).astype(np.float32)},
        "segmentation": {"semantic_segmentation": semantic, "instance_segmentation": instance},
        "npcs": {"npcs_map": npcs},
    }
    name = f"{entry.term.name}_{subject.id}_{picture.view}_{picture.state}"
    return View(name, picture.rgb, arrays, {"bbox_pose_dict": boxes}, meta)


def _count(subject: Subject) -> int:
    return len(json.loads(subject.files["link_annotation_gapartnet.json"]))


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """The annotated folder of each object, and the views of it."""
    for subject, seen in views(batch, entry):
        for name, data in subject.files.items():
            yield f"{DATASET}/{subject.id}/{name}", data
        for view in seen:
            yield f"{RENDERED}/rgb/{view.name}.png", png_bytes(view.rgb)
            for kind, arrays in view.arrays.items():
                yield f"{RENDERED}/{kind}/{view.name}.npz", npz_bytes(arrays, pack=True)
            yield f"{RENDERED}/bbox/{view.name}.pkl", plain_pickle(view.boxes)
            yield f"{RENDERED}/metafile/{view.name}.json", (json.dumps(view.meta) + "\n").encode()


def index(entries: Sequence[Entry]) -> dict[str, bytes]:
    """The list of ids with their categories. Raises UserError where two categories have come to one id."""
    lines: dict[int, str] = {}
    for entry in entries:
        assert entry.term is not None
        for number in entry.numbers.tolist():
            id = entry.id(number)
            if id in lines:
                raise UserError(f"{entry.category} has an id, {id}, of another category", "choose a folder of its own")
            lines[id] = f"{entry.term.name} {id}\n"
    return {LISTED: "".join(lines.values()).encode()}
