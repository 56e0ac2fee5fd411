"""Where2Act and Where2Explore: views of an object as it stands, and what came of leading a hand at a point of each.

``<split>/<object>_<category>_<state>_<primitive>_0/`` is one trial, as ``collect_data.py`` writes it and loaders read it.
World: z up, the front to -x, the half diagonal of the object 1; the camera is 5 from its middle, its axes are x forward, y left, z up.
What comes of a trial is computed in SAPIEN (``hand``), or said by the annotations (``foretold``).
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ... import random
from ...annotate.cameras import Cameras
from ...annotate.states import draw_values, own_joints
from ...errors import UserError
from ...export.partnet.frame import DatasetFrame
from ...export.partnet.mobility import folder_frame
from ...records import dataclass
from ...robot.model import RobotJoint
from ...robot.robots import Robots
from ...view.png import png_bytes
from ..entry import SPLITS, Entry
from ..pictures import Picture, pictures
from .foretold import Foretold
from .hand import LENGTH, MISSED, PLAIN, PRIMITIVES, RADIUS, Arena, Outcome, Trial

if TYPE_CHECKING:
    from ...runtime.batch import Batch

LIST = "data_tuple_list.txt"
SIZE, FOV, AWAY = 448, 35.0, 5.0  # pixels, degrees, half diagonals
STATES = ("closed", "random-closed-middle")
_WORLD = np.array([-1.0, -1.0, 1.0])  # from the object's axes
_ENDLESS = 10.0  # what collectors write for no limit
_AZIMUTH, _ELEVATION = 75.0, (30.0, 60.0)  # degrees, to either side of the front
_LANES = 8  # random numbers of a trial


@dataclass(frozen=True, slots=True)
class View:
    """An object as it stands in one of its ``states`` (number ``k``): ``values`` (J,) of the batch's joints, ``known`` those of SAPIEN by
    name, the ``picture``, the camera's ``pose`` (4, 4) in the world, and which of the pixels that show the object are of links
    that a hand is led at: ``moving`` (n,)."""

    k: int
    values: np.ndarray
    known: dict[str, float]
    picture: Picture
    pose: np.ndarray
    moving: np.ndarray


@dataclass(frozen=True, slots=True)
class Subject:
    """One object, a batch of its own: ``joint`` (L,) of each link the row of the joint that moves it, -1 for links that no hand is led at."""

    batch: Batch
    frame: DatasetFrame
    joints: dict[str, RobotJoint]
    joint: np.ndarray
    arena: Arena | Foretold

    @staticmethod
    def of(batch: Batch, *, simulated: bool) -> Subject:
        robot, own = Robots(batch).robot(0), own_joints(batch)
        frame = folder_frame(robot)
        arena = Arena(robot, frame.unit, own) if simulated else Foretold(batch, robot, frame.unit, own)
        joint = np.where(led_links(batch, arena.order), own, -1)
        return Subject(batch, frame, {known.name: known for known in robot.joints}, joint, arena)

    def world(self, points: np.ndarray) -> np.ndarray:
        """Points (..., 3) of the object's frame in the world."""
        return (points - self.frame.center) / self.frame.unit * _WORLD

    def scale(self, name: str) -> float:
        """Metres of what a value of 1 of a joint is in the world, 1 of one that turns."""
        joint = self.joints.get(name)  # none of one that SAPIEN alone has, of a ball or a screw
        return self.frame.unit if joint is not None and joint.traits.slides else 1.0

    def value(self, name: str, value: float) -> float:
        """A joint's value in radians, or in half diagonals."""
        return value / self.scale(name)

    def limits(self, name: str) -> tuple[float, float]:
        joint = self.joints.get(name)
        if joint is None or joint.low is None or joint.high is None:
            return -_ENDLESS, _ENDLESS
        return self.value(name, joint.low), self.value(name, joint.high)

    def states(self) -> Iterator[tuple[int, dict[str, float], np.ndarray]]:
        """The states that the object comes to rest in: their numbers, values in SAPIEN by name, and of the batch's joints (J,)."""
        rest, names = self.batch.rest(), list(self.batch.joints().name)
        coin = random.uniform(
            random.key(self.batch.seed, "where2act", "states"), _address(self.batch), np.arange(len(rest))
        )
        for k in range(len(STATES)):
            drawn = self.batch.settle(np.where(coin < 0.5, rest, draw_values(self.batch, 0)) if k else rest)
            given = dict(zip(names, drawn.tolist(), strict=True))
            settled = self.arena.settle({name: given.get(name, 0.0) for name in self.arena.order})
            if settled is not None:
                yield k, settled, np.array([settled.get(name, given[name]) for name in names])

    def view(self, k: int, known: dict[str, float], values: np.ndarray) -> View:
        share = random.uniform(random.key(self.batch.seed, "where2act", "views"), _address(self.batch), np.arange(2), k)
        azimuth = np.radians(_AZIMUTH * (2 * share[0] - 1))
        elevation = np.radians(_ELEVATION[0] + share[1] * (_ELEVATION[1] - _ELEVATION[0]))
        flat, middle = np.cos(elevation), tuple(self.frame.center.tolist())
        way = np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])
        eye = tuple((self.frame.center + AWAY * self.frame.unit * way).tolist())
        cameras = Cameras(count=1, width=SIZE, height=SIZE, fov=FOV, points=1, poses=((eye, middle, (0.0, 0.0, 1.0)),))
        (picture,) = pictures(self.batch, Robots(self.batch, physics=False), cameras, values[None])
        pose = np.eye(4)
        pose[:3, :3] = (np.stack([picture.turn[2], -picture.turn[0], -picture.turn[1]]) * _WORLD).T
        pose[:3, 3] = self.world(picture.eye)
        return View(k, values, known, picture, pose, self.joint[picture.link] >= 0)


def led_links(batch: Batch, order: Sequence[str]) -> np.ndarray:
    """(L,) bool: links of one object that a hand is led at: a joint moves them, and SAPIEN, whose joints are ``order``, moves all that
    carry them as the file says, which leaves out balls, screws, followers and loops."""
    joints, links = batch.joints(), batch.links()
    above = {int(child): row for row, child in enumerate(joints.child)}
    follows = np.asarray(joints.mimic) >= 0
    if batch.loops is not None:
        follows[batch.loops.variable[batch.loops.variable >= 0]] = True
    found = own_joints(batch) >= 0
    for link in range(len(links.owner)):
        at = link
        while at in above:
            row = above[at]
            kind = joints.kind[row]
            plain = kind in PLAIN and joints.name[row] in order and not follows[row]
            found[link] &= kind == "fixed" or plain
            at = int(joints.parent[row])
    return found


def _address(batch: Batch) -> np.ndarray:
    return np.asarray(batch.numbers).astype(np.uint64)


def aims(subject: Subject, view: View) -> Iterator[tuple[int, str, Trial, np.ndarray, np.ndarray]]:
    """The trials of a view, one for each primitive: its pixel among those that show the object, and forward and toward in the world."""
    at = np.flatnonzero(view.moving)
    if not len(at):
        return
    key, address = random.key(subject.batch.seed, "where2act", "trials"), _address(subject.batch)
    turn, shift = subject.batch.pose(view.values)
    for number, primitive in enumerate(PRIMITIVES):
        share = random.uniform(key, address, number * _LANES + np.arange(5), view.k)
        pixel = int(at[int(share[0] * len(at))])
        link, normal = int(view.picture.link[pixel]), view.picture.normal[pixel]
        toward = _sphere(share[1], share[2])
        toward *= -1.0 if toward @ (normal * _WORLD) > 0 else 1.0
        side = np.cross(toward, _sphere(share[3], share[4]))
        side /= np.sqrt(side @ side)
        forward = np.cross(side, toward)
        lead = {"pushing": toward, "pulling": -toward}.get(primitive, forward if primitive.endswith("left") else side)
        point = turn[link].T @ (view.picture.position[pixel] - shift[link])
        trial = Trial(primitive, link, point, turn[link].T @ normal, toward * _WORLD, lead * _WORLD)
        yield pixel, primitive, trial, forward, toward


def _sphere(one: float, other: float) -> np.ndarray:
    """A direction, even over the sphere, of two numbers in 0 .. 1."""
    z, angle = 2 * one - 1, 2 * np.pi * other
    flat = np.sqrt(1 - z * z)
    return np.array([flat * np.cos(angle), flat * np.sin(angle), z])


def told(
    subject: Subject, view: View, pixel: int, trial: Trial, forward: np.ndarray, toward: np.ndarray, out: Outcome
) -> dict[str, Any]:
    """What ``result.json`` holds."""
    order, axes = subject.arena.order, view.pose[:3, :3]
    target = order.index(subject.batch.joints().name[subject.joint[trial.link]])
    limits = [subject.limits(name) for name in order]
    start, end = subject.world(out.start), subject.world(out.end)
    normal = view.picture.normal[pixel] * _WORLD
    angles, final = ([subject.value(name, known[name]) for name in order] for known in (view.known, out.values))
    return {
        "object_state": STATES[view.k],
        "camera_metadata": {"mat44": view.pose.tolist(), "fov": float(np.radians(FOV)), "width": SIZE, "height": SIZE},
        "pixel_locs": view.picture.pixel[pixel].tolist(),
        "joint_names": order,
        "joint_angles": angles,
        "final_joint_angles": final,
        "joint_angles_lower": [low for low, _ in limits],
        "joint_angles_upper": [high for _, high in limits],
        "target_object_part_joint_id": target,
        "start_target_part_qpos": angles[target],
        "final_target_part_qpos": final[target],
        "direction_camera": (normal @ axes).tolist(),
        "direction_world": normal.tolist(),
        "gripper_direction_camera": (toward @ axes).tolist(),
        "gripper_direction_world": toward.tolist(),
        "gripper_forward_direction_camera": (forward @ axes).tolist(),
        "gripper_forward_direction_world": forward.tolist(),
        "position_world": start.tolist(),
        "touch_position_world_xyz_start": start.tolist(),
        "touch_position_world_xyz_end": end.tolist(),
        "result": "VALID" if out.fault in ("", MISSED) else "CONTACT_ERROR",
        "fault": out.fault,
    }


def simulated_files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """The trials of an object in SAPIEN."""
    return _files(Subject.of(batch, simulated=True), entry)


def foretold_files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """The trials of an object as annotations say."""
    return _files(Subject.of(batch, simulated=False), entry)


def _files(subject: Subject, entry: Entry) -> Iterator[tuple[str, bytes]]:
    """The trials of an object: one for each primitive, in each state that it comes to rest in and that shows what a hand is led at."""
    batch = subject.batch
    number = int(batch.numbers[0])
    for k, known, values in subject.states() if (subject.joint >= 0).any() else ():
        view = subject.view(k, known, values)
        seen = {
            "cam_XYZA.h5": _points(subject, view),
            "interaction_mask.png": png_bytes(mask_of(view)),
            "rgb.png": png_bytes(view.picture.rgb),
        }
        for pixel, primitive, trial, forward, toward in aims(subject, view):
            out = subject.arena.run(trial, known)
            place = f"{entry.split(number)}/{name_of(entry, number, k, primitive)}"
            for name, data in seen.items():
                yield f"{place}/{name}", data
            yield f"{place}/viz_target_pose.png", png_bytes(_with_finger(subject, view, pixel, toward))
            result = told(subject, view, pixel, trial, forward, toward, out)
            yield f"{place}/result.json", (json.dumps(result) + "\n").encode()


def name_of(entry: Entry, number: int, state: int, primitive: str) -> str:
    """Of a trial's folder: five words, as loaders part them by ``_``. The last counts trials alike, of which there is one: training begins
    with those below 5."""
    return f"{entry.token(number)}_{entry.category.replace('_', '')}_{state}_{primitive}_0"


def index(entries: Sequence[Entry], folder: Path) -> dict[str, bytes]:
    """The trials of each split. Raises UserError where a category has none."""
    found, lacking = {}, {entry.category for entry in entries}
    for split in SPLITS:
        own = {token: entry.category for entry in entries for token in entry.tokens(split)}
        names = sorted(path.parent.name for path in (folder / split).glob("*/result.json"))
        listed = [name for name in names if name.partition("_")[0] in own]
        lacking -= {own[name.partition("_")[0]] for name in listed}
        found[f"{split}/{LIST}"] = "".join(f"{name}\n" for name in listed).encode()
    if lacking:
        raise UserError(
            f"there is no trial of {', '.join(sorted(lacking))}: nothing that a hand is led at moves and is seen",
            "take more objects, or a category with hinges or sliders",
        )
    return found


def camera_points(subject: Subject, picture: Picture) -> np.ndarray:
    """(n, 3): what pixels show, in the camera's frame (x forward, y left, z up)."""
    x, y, z = picture.camera.T / subject.frame.unit
    return np.stack([z, -x, -y], axis=-1)


def mask_of(view: View) -> np.ndarray:
    mask = np.zeros((SIZE, SIZE), dtype=np.uint8)
    mask[tuple(view.picture.pixel[view.moving].T)] = 255
    return mask


def _points(subject: Subject, view: View) -> bytes:
    import h5py  # extra: as of HDF5 layouts

    stream = io.BytesIO()
    with h5py.File(stream, "w", track_order=True) as file:
        row, column = view.picture.pixel.T.astype(np.uint64)
        points = camera_points(subject, view.picture).astype(np.float32)
        for name, array in (("id1", row), ("id2", column), ("pc", points)):
            file.create_dataset(
                name, data=array, compression="gzip", compression_opts=1, shuffle=True, track_times=False
            )
    return stream.getvalue()


def _with_finger(subject: Subject, view: View, pixel: int, toward: np.ndarray) -> np.ndarray:
    """The picture with the finger where it touches the point."""
    tip = (
        camera_points(subject, view.picture)[pixel] + RADIUS * (view.picture.normal[pixel] * _WORLD) @ view.pose[:3, :3]
    )
    along = -toward @ view.pose[:3, :3]
    focal, middle = SIZE / 2 / np.tan(np.radians(FOV / 2)), SIZE / 2 - 0.5
    row, column = np.mgrid[:SIZE, :SIZE]
    ray = np.stack([np.full(row.shape, 1.0), (middle - column) / focal, (middle - row) / focal], axis=-1)
    length = np.sqrt((ray * ray).sum(axis=-1, keepdims=True))
    ray /= length
    # the nearest places of each ray and of the finger's middle line
    across, level = ray @ along, ray @ tip
    reach = np.clip((across * level - tip @ along) / np.maximum(1 - across * across, 1e-12), 0.0, LENGTH)
    spot = tip + reach[..., None] * along
    near = (ray * spot).sum(axis=-1)
    off = spot - near[..., None] * ray
    hit = (off * off).sum(axis=-1) < RADIUS * RADIUS
    depth = view.picture.depth / subject.frame.unit * length[..., 0]
    shown = hit & ((depth == 0) | (near < depth + RADIUS))
    rgb = view.picture.rgb.copy()
    rgb[shown] = (70, 70, 75)
    return rgb
