"""NPCS and ANCSH: views of an object in many states, part by part, each point with its place in the object that is shut.

The folder is the data set's root: ``hdf5/<class>/<object>/<state>/<view>.h5``, ``urdf/<class>/<object>/``, ``pickle/``, ``splits/`` and
``render/<class>/<object>/``, whose name alone the loaders read. Lengths are metres; the object's frame is ours with all joints at 0.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...annotate.cameras import Cameras
from ...annotate.states import joint_values, read_states
from ...errors import UserError
from ...export.containers import hdf5_bytes
from ...export.decimals import numbers
from ...export.mesh_obj import obj_bytes
from ...records import dataclass
from ...robot.model import RobotJoint
from ...robot.primitives import Shape
from ...robot.robots import Robots
from ..clouds import norms
from ..entry import SPLITS, Entry
from ..gapartnet.parts import FINE
from ..pictures import pictures, turn_points
from ..pieces import Pieces
from ..pth import plain_pickle
from ..words import Term

if TYPE_CHECKING:
    from ...runtime.batch import Batch

STATES = "rest,random:3"
CAMERAS = Cameras(count=2, width=256, height=256, fov=35.0, azimuth=(-60.0, 60.0), elevation=(10.0, 60.0), points=1)
LEAST = 10  # points of a part: views that show fewer of any are left out
_MESHES = ("none_motion", "dof_rootd_Aa001_r", "dof_rootd_Aa002_r")  # the names that loaders look for
_TO_CAMERA = np.array([-1.0, -1.0, 1.0])  # x left, y up, z forward


@dataclass(frozen=True, slots=True)
class Subject:
    """An object as it is written: ``owner`` (L,) the part that each link belongs to, ``links`` the link that each part is, ``joints``
    those of all parts but the first, ``shapes`` the mesh of each, in the object's frame with all joints at 0."""

    i: int
    owner: np.ndarray
    links: tuple[int, ...]
    joints: tuple[RobotJoint, ...]
    pivots: np.ndarray
    shapes: tuple[Shape, ...]

    @staticmethod
    def of(pieces: Pieces) -> Subject | None:
        """None for an object that has too few links that are parts."""
        above = {joint.child: joint for joint in pieces.robot.joints}
        moving = list(pieces.moving())[: int(pieces.term.data["parts"]) - 1]
        if len(moving) + 1 < pieces.term.data["parts"]:
            return None
        links = (0, *moving)
        owner = np.array([_carrier(link, above, links) for link in range(len(pieces.robot.links))])
        shapes = []
        for part in range(len(links)):
            seen = [shape for link in np.flatnonzero(owner == part).tolist() for _, shape in pieces.of(link)]
            starts = np.cumsum([0, *(len(shape.vertices) for shape in seen)])
            faces = [np.asarray(shape.faces) + start for shape, start in zip(seen, starts, strict=False)]
            shapes.append(Shape(_MESHES[part], np.concatenate([s.vertices for s in seen]) + 0.0, np.concatenate(faces)))
        pivots = np.stack([pieces.robot.links[link].origin if part else np.zeros(3) for part, link in enumerate(links)])
        return Subject(pieces.i, owner, links, tuple(above[k] for k in moving), pivots, tuple(shapes))

    def parent(self, part: int) -> int:
        """The part that carries one."""
        return int(self.owner[self.joints[part - 1].parent])

    def corners(self) -> np.ndarray:
        """Boxes (K + 1, 2, 3): of the object, then of each part."""
        own = [np.stack([s.vertices.min(axis=0), s.vertices.max(axis=0)]) for s in self.shapes]
        whole = np.stack([np.min([box[0] for box in own], axis=0), np.max([box[1] for box in own], axis=0)])
        return np.stack([whole, *own])


def _carrier(link: int, above: dict[int, RobotJoint], links: Sequence[int]) -> int:
    while link not in links:
        link = above[link].parent
    return links.index(link)


@dataclass(frozen=True, slots=True)
class Frame:
    """A view: ``points`` (n, 3) of each part in the camera's frame (x left, y up, z forward), ``coords`` (n, 3) the same with the
    joints at 0, in the object's."""

    place: str
    rgb: np.ndarray
    mask: np.ndarray
    points: tuple[np.ndarray, ...]
    coords: tuple[np.ndarray, ...]


def subjects(batch: Batch, term: Term) -> Iterator[tuple[Subject, list[Frame]]]:
    """The objects that have all parts, and views of them that show all of these. What is no part stands still."""
    robots = Robots(batch, resolution=FINE, physics=False)
    known = [Subject.of(Pieces(robots, i, term)) for i in range(len(batch))]
    moved = np.zeros(len(robots.joints.owner), dtype=bool)
    for subject in filter(None, known):
        first = int(robots.joint_start[subject.i])
        children = robots.joints.child[first : int(robots.joint_start[subject.i + 1])]
        moved[first : first + len(children)] = np.isin(children, subject.links[1:])
    values = np.where(moved, joint_values(batch, read_states(STATES)), 0.0)
    values = np.stack([batch.settle(state) for state in values])
    poses = [batch.pose(state) for state in values]
    found: dict[int, tuple[Subject, list[Frame]]] = {s.i: (s, []) for s in known if s is not None}
    for picture in pictures(batch, robots, CAMERAS, values):
        if picture.i not in found:
            continue
        subject, frames = found[picture.i]
        part = subject.owner[picture.link]
        row = int(robots.link_start[picture.i]) + np.array(subject.links)[part]
        turn, shift = poses[picture.state]
        still = turn_points(picture.position - shift[row], np.swapaxes(turn[row], 1, 2))
        counts = np.bincount(part, minlength=len(subject.links))
        if counts.min() < LEAST:
            continue
        mask = np.zeros(picture.depth.shape, dtype=np.uint8)
        mask[picture.pixel[:, 0], picture.pixel[:, 1]] = 1
        places = [np.flatnonzero(part == k) for k in range(len(subject.links))]
        frames.append(
            Frame(
                f"{picture.state:04d}/{picture.view}",
                picture.rgb,
                mask,
                tuple((picture.camera[at] * _TO_CAMERA).astype(np.float32) for at in places),
                tuple(still[at].astype(np.float32) for at in places),
            )
        )
    yield from found.values()


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """The views, the meshes and the URDF of each object that has all parts, and what the lists of all need of it."""
    assert entry.term is not None
    name, names = entry.term.name, object_names(entry)
    for subject, frames in subjects(batch, entry.term):
        token = names[int(batch.numbers[subject.i])]
        for frame in frames:
            yield f"hdf5/{name}/{token}/{frame.place}.h5", hdf5_bytes(_h5_arrays(frame), pack=True)
        for shape in subject.shapes:
            yield f"urdf/{name}/{token}/{shape.name}.obj", obj_bytes([shape])
        yield f"urdf/{name}/{token}/syn.urdf", _urdf_text(subject, f"urdf/{name}/{token}").encode()
        corners = subject.corners()
        known = {
            "factors": (1 / norms(corners[:, 1] - corners[:, 0])).tolist(),
            "corners": corners.tolist(),
            "frames": [frame.place for frame in frames],
        }
        yield f"render/{name}/{token}/object.json", (json.dumps(known) + "\n").encode()


def object_names(entry: Entry) -> dict[int, str]:
    """The names of objects by their numbers. Loaders know by heart what objects that are not seen in training are called, and training
    divides by the number of their views, and of the others in ``test``: the first of ``test`` are called so, but not all."""
    assert entry.term is not None
    test = entry.numbers[entry.splits()["test"]].tolist()
    own = {number: entry.token(number) for number in entry.numbers.tolist()}
    return own | dict(zip(test[:-1], entry.term.data["unseen"], strict=False))


def _h5_arrays(frame: Frame) -> dict[str, np.ndarray]:
    """A file of HDF5: ``gt_points/<k>`` and ``gt_coords/<k>`` of part k."""
    made = {"rgb": frame.rgb, "mask": frame.mask}
    made |= {f"gt_points/{k}": points for k, points in enumerate(frame.points)}
    return made | {f"gt_coords/{k}": points for k, points in enumerate(frame.coords)}


def _urdf_text(subject: Subject, folder: str) -> str:
    """Links ``base_link``, ``1`` ..., joints ``<parent>_<child>``; meshes are in the object's frame, shifted by minus the pivot."""
    lines = ['<?xml version="1.0" ?>', f'<robot name="{folder.rpartition("/")[2]}">']
    for part, shape in enumerate(subject.shapes):
        lines += [
            f'  <link name="{_link_name(part)}">',
            "    <visual>",
            f'      <origin rpy="0 0 0" xyz="{numbers(-subject.pivots[part])}"/>',
            f'      <geometry><mesh filename="{folder}/{shape.name}.obj"/></geometry>',
            "    </visual>",
            "  </link>",
        ]
    for part, joint in enumerate(subject.joints, 1):
        parent = subject.parent(part)
        lines += [
            f'  <joint name="{parent}_{part}" type="{joint.kind}">',
            f'    <origin rpy="0 0 0" xyz="{numbers(subject.pivots[part] - subject.pivots[parent])}"/>',
            f'    <parent link="{_link_name(parent)}"/>',
            f'    <child link="{_link_name(part)}"/>',
            f'    <axis xyz="{numbers(joint.axis)}"/>',
        ]
        if joint.low is not None and joint.high is not None:
            lines.append(f'    <limit lower="{numbers([joint.low])}" upper="{numbers([joint.high])}"/>')
        lines.append("  </joint>")
    return "\n".join([*lines, "</robot>", ""])


def _link_name(part: int) -> str:
    return str(part) if part else "base_link"


def index(entries: Sequence[Entry], folder: Path) -> dict[str, bytes]:
    """Lists of views by class, and sizes and boxes of all objects. Raises UserError where no object of a category has all parts."""
    classes: dict[str, tuple[Term, dict[str, Any], dict[str, list[str]]]] = {}
    for entry in entries:
        assert entry.term is not None
        name, known, listed = entry.term.name, dict[str, Any](), {split: list[str]() for split in SPLITS}
        for number, token in object_names(entry).items():
            place = folder / "render" / name / token / "object.json"
            if place.exists():
                known[token] = json.loads(place.read_text("utf-8"))
                listed[entry.split(number)] += [f"hdf5/{name}/{token}/{frame}.h5" for frame in known[token]["frames"]]
        classes[name] = entry.term, known, listed
        if not known:
            raise UserError(
                f"no object of {entry.category} has the {entry.term.data['parts']} parts of {name}",
                "more objects (-n), or a --map whose parts its objects have",
            )
    files: dict[str, bytes] = {}
    for name, (term, known, listed) in sorted(classes.items()):
        factors = {token: own["factors"] for token, own in sorted(known.items())}
        corners = {
            token: [[np.array([end]) for end in box] for box in own["corners"]] for token, own in sorted(known.items())
        }
        files[f"pickle/{name}.pkl"] = plain_pickle(factors)
        files[f"pickle/{name}_corners.pkl"] = plain_pickle(corners)
        for experiment in term.data["experiments"]:
            for split in SPLITS:
                text = "".join(f"{line}\n" for line in listed[split])
                files[f"splits/{name}/{experiment}/{split}.txt"] = text.encode()
    return files


def check_term(term: Term) -> str | None:
    """What is wrong with a map, if anything: it says of no link that it is a part, or calls it otherwise."""
    if not term.parts:
        return "no word of it is a part"
    other = [key for key, value in term.parts.items() if value != "part" or "/" not in key]
    return f'`{other[0]}` is not of the form "door/revolute": "part"' if other else None
