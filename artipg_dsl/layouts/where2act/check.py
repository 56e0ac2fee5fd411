"""Where2Act's files read back as its loaders do, and compared with the model.

What physics has made of a trial is not made again: what is compared is that the point ends where the joints have come to, and
that these are within their limits. What annotations say of a trial is compared.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...runtime.motion import link_motion
from ...view.png import read_png
from ..entry import Entry
from ..findings import Findings
from ..hdf5 import read_h5
from .files import LIST, SIZE, Subject, View, aims, camera_points, mask_of, name_of
from .foretold import Foretold
from .hand import PRIMITIVES

if TYPE_CHECKING:
    from ...runtime.batch import Batch

_NEAR = 1e-5  # half diagonals
_SETTLED = 1e-3  # rad, half diagonals: as an object comes to rest on another machine
_OVER = 0.02  # rad, half diagonals: limits give a little
_FILES = ("cam_XYZA.h5", "interaction_mask.png", "rgb.png", "viz_target_pose.png", "result.json")


def check_simulated(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as the loaders do, and compare with the model; what physics has made of a trial is not made again."""
    _check(folder, entry, Subject.of(batch, simulated=True), found)


def check_foretold(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as the loaders do, and compare with the model and with what it says of each trial."""
    _check(folder, entry, Subject.of(batch, simulated=False), found)


def _check(folder: Path, entry: Entry, subject: Subject, found: Findings) -> None:
    number = int(subject.batch.numbers[0])
    split = folder / entry.split(number)
    listed = (split / LIST).read_text(encoding="utf-8").split() if (split / LIST).exists() else []
    own = [name for name in listed if name.partition("_")[0] == entry.token(number)]
    due = []
    for k, known, values in subject.states() if (subject.joint >= 0).any() else ():
        view = subject.view(k, known, values)
        for pixel, primitive, trial, forward, toward in aims(subject, view):
            name = name_of(entry, number, k, primitive)
            due.append(name)
            place = f"{split.name}/{name}"
            if not found.of(place, name in own, f"not in {LIST}"):
                continue
            words = name.split("_")
            found.of(place, len(words) == 5 and words[3] in PRIMITIVES, "loaders part names into five words by `_`")
            if all(found.of(place, (split / name / file).is_file(), f"{file} is missing") for file in _FILES):
                told = json.loads((split / name / "result.json").read_bytes())
                _check_view(place, split / name, subject, view, found)
                _check_trial(place, told, subject, view, pixel, found)
                if isinstance(subject.arena, Foretold):
                    out = subject.arena.run(trial, known)
                    ends = np.array([subject.value(word, out.values[word]) for word in subject.arena.order])
                    found.near(place, "joint values at the end", np.array(told["final_joint_angles"]), ends, 1e-6)
                    found.of(place, told["fault"] == out.fault, f"the fault is {told['fault']!r}, not {out.fault!r}")
                for word, way in (("gripper_direction", toward), ("gripper_forward_direction", forward)):
                    found.near(place, word, np.array(told[f"{word}_world"]), way, 1e-6)
                    found.near(place, word, np.array(told[f"{word}_camera"]), way @ view.pose[:3, :3], 1e-6)
    for name in set(own) - set(due):
        found.of(f"{split.name}/{name}", False, "is no trial of the model")


def _check_view(place: str, folder: Path, subject: Subject, view: View, found: Findings) -> None:
    read = read_h5(folder / "cam_XYZA.h5")
    pixel = np.stack([read["id1"], read["id2"]], axis=-1).astype(np.int64)
    if found.same(place, "pixels", pixel, view.picture.pixel):
        found.near(place, "points", read["pc"], camera_points(subject, view.picture), _NEAR)
    for name, shape in (
        ("interaction_mask.png", (SIZE, SIZE)),
        ("rgb.png", (SIZE, SIZE, 3)),
        ("viz_target_pose.png", (SIZE, SIZE, 3)),
    ):
        image = read_png((folder / name).read_bytes())
        if not found.of(place, image.shape == shape, f"{name} is {image.shape}, not {shape}"):
            continue
        if name == "interaction_mask.png":
            found.same(place, "pixels of the mask", image > 127, mask_of(view) > 0)


def _check_trial(place: str, told: dict[str, Any], subject: Subject, view: View, pixel: int, found: Findings) -> None:
    found.of(place, told["pixel_locs"] == view.picture.pixel[pixel].tolist(), "another pixel than the model's")
    found.near(place, "the camera", np.array(told["camera_metadata"]["mat44"]), view.pose, _NEAR)
    order = subject.arena.order
    if not found.of(place, told["joint_names"] == order, "other joints than the model's"):
        return
    link = int(view.picture.link[pixel])
    name = subject.batch.joints().name[subject.joint[link]]
    at = told["target_object_part_joint_id"]
    found.of(place, order[at] == name, f"joint {at} is not the one that moves the point")
    begun = np.array([subject.value(word, view.known[word]) for word in order])
    found.near(place, "joint values at the start", np.array(told["joint_angles"]), begun, _SETTLED)
    limits = np.array([subject.limits(word) for word in order])
    found.near(
        place, "limits", np.stack([told["joint_angles_lower"], told["joint_angles_upper"]], axis=-1), limits, _NEAR
    )
    final = np.array(told["final_joint_angles"])
    within = (final >= limits[:, 0] - _OVER) & (final <= limits[:, 1] + _OVER) | (limits[:, 1] >= 10.0)
    found.of(place, bool(within.all()), "a joint has left its limits")
    ends = told["start_target_part_qpos"] == told["joint_angles"][at] and told["final_target_part_qpos"] == final[at]
    found.of(place, ends, "the values of the part are not those of its joint")
    start = subject.world(view.picture.position[pixel])
    found.near(place, "where it is touched", np.array(told["touch_position_world_xyz_start"]), start, _SETTLED)
    values, names = view.values.copy(), list(subject.batch.joints().name)
    for word, value in zip(order, final.tolist(), strict=True):
        if word in names:
            values[names.index(word)] = value * subject.scale(word)
    (turn, shift) = subject.batch.pose(view.values)
    now, there = link_motion(subject.batch.links(), subject.batch.joints(), values)  # whatever gates say
    local = turn[link].T @ (view.picture.position[pixel] - shift[link])
    end = subject.world(now[link] @ local + there[link])
    found.near(place, "where the point comes to", np.array(told["touch_position_world_xyz_end"]), end, _SETTLED)
