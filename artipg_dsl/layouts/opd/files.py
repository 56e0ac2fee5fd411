"""OPD and OPDMulti: pictures of an object with the parts that open, how each moves and where, in the camera's frame.

``objects/<category>-<shard>.h5`` and ``.json`` hold the views as they are made, of which ``opd_lists`` makes the files that loaders read.
Lengths are those of the object's folder of PartNet-Mobility (the half diagonal 1), the object's frame its raw frame (y up, z to the
front); the camera's axes are x right, y up, z to the back, as OPDSynth has them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ...annotate.cameras import Cameras
from ...annotate.states import joint_values, read_states
from ...errors import UserError
from ...export.partnet.frame import DatasetFrame
from ...export.partnet.mobility import folder_frame, folder_order, folder_value
from ...records import dataclass
from ...robot.model import RobotJoint
from ...robot.robots import Robots
from ..clouds import partnet_axes
from ..entry import Entry
from ..hdf5 import rows_h5
from ..pictures import Picture, pictures, turn_points
from ..pieces import Pieces, Shut
from ..words import Term
from .outlines import outlines

if TYPE_CHECKING:
    from ...runtime.batch import Batch

OBJECTS = "objects"
CLASSES = ("drawer", "door", "lid")  # in the order of their numbers, from 1 on
STATES = "rest,random:2"
CAMERAS = Cameras(
    count=2,
    width=256,
    height=256,
    fov=50.0,
    azimuth=(-60.0, 60.0),
    elevation=(5.0, 60.0),
    distance=(1.05, 1.5),
    points=1,
)
LEAST = 16  # pixels: a part that shows less is not told of
_SHUT = 1e-6  # degrees or lengths
DEPTH = 1000.0  # depths are in thousandths of a length
_LARGEST = 100_000_000  # of object numbers: ids have to fit into 32 bits
TYPES = {"revolute": "rotation", "continuous": "rotation", "prismatic": "translation"}
_OPEN_GL = np.array([1.0, -1.0, -1.0])  # from the axes x right, y down, z forward


@dataclass(frozen=True, slots=True)
class Part:
    """A link that opens, by a joint in a ``row`` of the batch with an ``origin`` in the object's frame. ``name`` is its number in the
    object's folder, ``unit`` what a value of 1 is there, in degrees or lengths."""

    link: int
    label: str
    name: str
    joint: RobotJoint
    shut: Shut
    row: int
    origin: np.ndarray
    unit: float

    @staticmethod
    def of(pieces: Pieces, link: int, label: str, joint: RobotJoint, unit: float) -> Part:
        robot, first = pieces.robot, int(pieces.robots.joint_start[pieces.i])
        origin = joint.origin + robot.links[joint.parent].origin
        row = first + [known.name for known in robot.joints].index(joint.name)
        return Part(link, label, str(folder_order(robot).index(link)), joint, Shut.of(joint), row, origin, unit)

    def opened(self, values: np.ndarray) -> float:
        """How far it is open with the batch's joints at ``values`` (J,), in degrees or lengths."""
        return abs(float(values[self.row]) - self.shut.value) * self.unit


@dataclass(frozen=True, slots=True)
class Subject:
    """An object: ``parts`` that open, ``owner`` (L,) the one that carries each link, -1 for none, ``box`` (2, 3) raw, all joints at 0."""

    i: int
    id: int
    frame: DatasetFrame
    box: np.ndarray
    parts: tuple[Part, ...]
    owner: np.ndarray

    @staticmethod
    def of(pieces: Pieces, entry: Entry) -> Subject | None:
        """None for an object of which nothing opens."""
        frame = folder_frame(pieces.robot)
        above = {joint.child: joint for joint in pieces.robot.joints}
        parts = [
            Part.of(pieces, link, label, above[link], _unit(above[link], frame))
            for link, label in pieces.moving().items()
        ]
        if not parts:
            return None
        links = [part.link for part in parts]
        owner = np.array([_carrier(link, above, links) for link in range(len(pieces.robot.links))])
        raw = frame.points(pieces.corners())
        box = np.stack([raw.min(axis=0), raw.max(axis=0)])
        return Subject(pieces.i, _id_of(entry, pieces.robot.number), frame, box, tuple(parts), owner)


def _unit(joint: RobotJoint, frame: DatasetFrame) -> float:
    """What a value of 1 of a joint is, in degrees or lengths of a frame."""
    return folder_value(joint, frame) * (1.0 if joint.traits.slides else float(np.degrees(1.0)))


def _carrier(link: int, above: dict[int, RobotJoint], links: list[int]) -> int:
    """The number of the part that carries a link, -1 for none."""
    while link not in links and link in above:
        link = above[link].parent
    return links.index(link) if link in links else -1


def _id_of(entry: Entry, number: int) -> int:
    """The id of an object: a number, unlike that of any other category's, which loaders keep in 32 bits. Raises UserError."""
    assert entry.term is not None
    if number >= _LARGEST:
        raise UserError(f"object {number} is too many for the ids of OPD", f"numbers are below {_LARGEST}")
    return int(entry.term.data["number"]) * _LARGEST + number


@dataclass(frozen=True, slots=True)
class Shot:
    """A view: ``rgb`` (H, W, 3) uint8, ``depth`` (H, W) float32 in thousandths of a length, what is ``told`` of it; of the
    n pixels that show the object ``pixel`` (n, 2) and ``raw`` (n, 3), where the surface is in the object's frame; ``masks`` of the parts, and
    ``joints``, (2, 3) each: origin and axis in the object's frame."""

    subject: Subject
    name: str
    rgb: np.ndarray
    depth: np.ndarray
    told: dict[str, Any]
    pixel: np.ndarray
    raw: np.ndarray
    masks: tuple[np.ndarray, ...]
    joints: tuple[np.ndarray, ...]


def shots(batch: Batch, entry: Entry) -> Iterator[Shot]:
    """The views that show a part that opens; two in each of three states of the joints, at rest and two at random."""
    assert entry.term is not None
    robots = Robots(batch, physics=False)
    known = [Subject.of(Pieces(robots, i, entry.term), entry) for i in range(len(batch))]
    values = np.stack([batch.settle(state) for state in joint_values(batch, read_states(STATES))])
    poses = [batch.pose(state) for state in values]
    for picture in pictures(batch, robots, CAMERAS, values):
        subject = known[picture.i]
        if subject is None:
            continue
        owner = subject.owner[picture.link]
        masks = []
        for k in range(len(subject.parts)):
            mask = np.zeros(picture.depth.shape, dtype=bool)
            mask[tuple(picture.pixel[owner == k].T)] = True
            masks.append(mask)
        shown = [k for k, mask in enumerate(masks) if mask.sum() >= LEAST]
        if not shown:
            continue
        row = int(robots.link_start[picture.i])
        turn, shift = poses[picture.state]
        told = [
            _part(
                part,
                masks[k],
                _motion(subject, part, picture, turn[row:], shift[row:]),
                part.opened(values[picture.state]),
            )
            for k, part in ((k, subject.parts[k]) for k in shown)
        ]
        frame = subject.frame
        yield Shot(
            subject,
            f"{subject.id}-{picture.state}-{picture.view}",
            picture.rgb,
            (picture.depth / frame.unit * DEPTH).astype(np.float32),
            {
                "split": entry.split(int(batch.numbers[picture.i])),
                "camera": {
                    "intrinsic": columns(CAMERAS.intrinsics()),
                    "extrinsic": columns(extrinsic(subject, picture)),
                },
                "parts": told,
                "open": {part.name: short(part.opened(values[picture.state])) for part in subject.parts},
            },
            picture.pixel,
            frame.points(picture.position),
            tuple(masks[k] for k in shown),
            tuple(_joint(subject.parts[k], frame, turn[row:], shift[row:]) for k in shown),
        )


def extrinsic(subject: Subject, picture: Picture) -> np.ndarray:
    """From the camera's frame to the object's (4, 4)."""
    made = np.eye(4)
    made[:3, :3] = partnet_axes(picture.turn).T * _OPEN_GL
    made[:3, 3] = subject.frame.points(picture.eye)
    return made


def _part(part: Part, mask: np.ndarray, motion: dict[str, Any], opened: float) -> dict[str, Any]:
    """What is said of a part that a view shows."""
    row, column = np.nonzero(mask)
    low, high = np.array([column.min(), row.min()]), np.array([column.max() + 1, row.max() + 1])
    return {
        "category_id": CLASSES.index(part.label) + 1,
        "segmentation": outlines(mask),
        "bbox": [*low.astype(float).tolist(), *(high - low).astype(float).tolist()],
        "area": int(mask.sum()),
        "motion": motion | {"value": short(opened), "isClosed": opened < _SHUT},
    }


def _motion(subject: Subject, part: Part, picture: Picture, turn: np.ndarray, shift: np.ndarray) -> dict[str, Any]:
    """How a part moves, in the camera's frame: as the object stands there, and with all joints at 0; positive values open."""
    parent, axis = part.joint.parent, part.joint.axis * part.shut.sign
    still = np.stack([axis, part.origin])
    moved = turn_points(still, turn[parent]) + np.stack([np.zeros(3), shift[parent]])
    limited = part.joint.limited
    made: dict[str, Any] = {
        "partId": part.name,
        "label": part.label,
        "type": TYPES[part.joint.kind],
        "rangeMin": 0.0 if limited else None,
        "rangeMax": short(part.shut.reach * part.unit) if limited else None,
    }
    for word, (along, pivot) in (("current", moved), ("initial", still)):
        seen = turn_points(np.stack([along, (pivot - picture.eye) / subject.frame.unit]), picture.turn) * _OPEN_GL
        made |= {f"{word}_axis": short(seen[0]), f"{word}_origin": short(seen[1])}
    return made


def _joint(part: Part, frame: DatasetFrame, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Origin and axis of a joint (2, 3) in the raw frame, where the link that carries it stands."""
    parent = part.joint.parent
    origin = (turn[parent] * part.origin).sum(axis=1) + shift[parent]
    axis = (turn[parent] * part.joint.axis * part.shut.sign).sum(axis=1)
    return np.stack([frame.points(origin), partnet_axes(axis)])


def columns(matrix: np.ndarray) -> list[float]:
    """A matrix column by column."""
    found: list[float] = short(matrix.T.ravel())
    return found


def short(values: np.ndarray | float) -> Any:
    """Numbers with nine decimals, as plain data."""
    return (np.round(np.asarray(values), 9) + 0.0).tolist()


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """The views of a chunk in two files, which ``opd_lists`` puts together with those of others."""
    made, term = list(shots(batch, entry)), entry.term
    assert term is not None
    place = f"{OBJECTS}/{entry.category}-{shard}"
    if made:
        depth = np.stack([shot.depth for shot in made])[..., None]
        yield f"{place}.h5", rows_h5({"images": np.stack([shot.rgb for shot in made]), "depth": depth})
    known = {str(shot.subject.id): {"category": term.name, "box": short(shot.subject.box)} for shot in made}
    told = {"objects": known, "views": [{"name": shot.name} | shot.told for shot in made]}
    yield f"{place}.json", (json.dumps(told) + "\n").encode()


def check_term(term: Term) -> str | None:
    """What is wrong with a map, if anything: no link opens by it, or it names a class or a joint that there is not."""
    if not term.parts:
        return "no word of it is a part"
    for key, value in term.parts.items():
        kind = key.partition("/")[2]
        if value not in CLASSES:
            return f"there is no part `{value}`: the parts are {', '.join(CLASSES)}"
        if kind not in TYPES:
            return f'`{key}` is not of the form "door/revolute": joints are {", ".join(TYPES)}'
    return None
