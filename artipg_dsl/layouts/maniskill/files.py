"""ManiSkill: folders of PartNet-Mobility under numbers, and the lists of its tasks that name them.

``data/partnet_mobility/dataset/<id>/`` is where its loaders look below ``MS_ASSET_DIR``; ``assets/partnet_mobility/meta/`` has the lists in
place of those in its package; ``objects/`` keeps what each object is in. A list takes a cabinet of which all links that move so are wanted:
the task chooses among them without looking further, and fails at one without a handle. It sets all joints of a cabinet, the others too, to
their lower limits, so each needs one, at which it is shut, and none that is wanted may wait for another.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import UserError
from ...export.partnet.frame import DatasetFrame
from ...export.partnet.mobility import folder_frame, folder_order, partnet_files
from ...export.partnet.words import JOINTS
from ...robot.model import RobotJoint
from ...robot.robots import Robots
from ..entry import SPLITS, Entry
from ..pieces import Pieces, Shut
from ..words import Term

if TYPE_CHECKING:
    from ...runtime.batch import Batch

DATASET, META, OBJECTS = "data/partnet_mobility/dataset", "assets/partnet_mobility/meta", "objects"
HINGES = ("revolute", "continuous")
LISTS = {"cabinet_drawer": ("prismatic",), "cabinet_door": HINGES, "faucet": HINGES}
"""The lists, and the URDF's types of the joints that the task of each takes to be its own."""
_WANTED = {"cabinet_drawer": "drawer", "cabinet_door": "door", "faucet": "switch"}
_TO_WORLD = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # from the raw frame


def list_name(kind: str, split: str) -> str:
    return f"{META}/info_{kind}_{split}.json"


def urdf_type(joint: RobotJoint) -> str:
    """The type of a joint in the folder's URDF."""
    return JOINTS[joint.hinge][1]


def told(pieces: Pieces, files: dict[str, bytes], id: int) -> dict[str, dict[str, Any]]:
    """What the lists say of an object, by list; none that it is not fit for."""
    robot, order = pieces.robot, folder_order(pieces.robot)
    frame, parts = folder_frame(robot), pieces.moving()
    mobility = json.loads(files["mobility_v2.json"])
    shut = all(joint.limited and Shut.of(joint).sign > 0 for joint in robot.joints if urdf_type(joint) != "fixed")
    handled = {k: any("handle" in part["name"] for part in mobility[n]["parts"]) for n, k in enumerate(order)}
    found: dict[str, dict[str, Any]] = {}
    for kind in ("faucet",) if pieces.term.name == "faucet" else ("cabinet_drawer", "cabinet_door"):
        joints = [joint for joint in robot.joints if urdf_type(joint) in LISTS[kind]]
        wanted = [joint for joint in joints if parts.get(joint.child) == _WANTED[kind]]
        if kind == "faucet":
            if wanted:
                labels = {order.index(link): part for link, part in parts.items()}
                found[kind] = _faucet(files, labels, frame)
        elif wanted == joints and joints and shut and all(handled[j.child] and _free(j, robot.joints) for j in joints):
            found[kind] = {"num_target_links": len(joints), "partnet_mobility_id": id, "scale": frame.unit}
    return found


def _free(joint: RobotJoint, joints: Sequence[RobotJoint]) -> bool:
    """Whether a joint moves while the others are at their lower limits: a drawer behind a door does not."""
    low = {other.name: -np.inf if other.low is None else other.low for other in joints}
    return all(start <= low[name] <= end for name, start, end in joint.gates)


def _faucet(files: dict[str, bytes], labels: dict[int, str], frame: DatasetFrame) -> dict[str, Any]:
    """The box in the world, how far below and beside the origin it reaches in metres, and what each link is."""
    raw = json.loads(files["bounding_box.json"])
    ends = np.array([raw["min"], raw["max"]]) @ _TO_WORLD.T
    low, high = ends.min(axis=0), ends.max(axis=0)
    semantics = [line.split() for line in files["semantics.txt"].decode().splitlines()]
    for k, label in labels.items():
        semantics[k][2] = label
    return {
        "bbox": {"min": low.tolist(), "max": high.tolist()},
        "offset": (-low * frame.unit).tolist(),
        "scale": frame.unit,
        "semantics": semantics,
    }


def subjects(
    batch: Batch, entry: Entry
) -> Iterator[tuple[int, int, dict[str, bytes], dict[str, dict[str, Any]], Robots]]:
    """Of each object its place in the batch, its id, the files of its folder, what the lists say of it, and the robots."""
    assert entry.term is not None
    robots = Robots(batch)
    for i, number in enumerate(batch.numbers.tolist()):
        files = partnet_files(robots, i, points=False)
        yield i, entry.id(number), files, told(Pieces(robots, i, entry.term), files, entry.id(number)), robots


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """The folders of objects that any list takes, and what these say of them."""
    known: dict[str, Any] = {}
    for i, id, folder, lists, _ in subjects(batch, entry):
        if lists:
            known[str(id)] = {"split": entry.split(int(batch.numbers[i]))} | lists
            yield from ((f"{DATASET}/{id}/{name}", data) for name, data in folder.items())
    yield f"{OBJECTS}/{entry.category}-{shard}.json", (json.dumps(known) + "\n").encode()


def index(entries: Sequence[Entry], folder: Path) -> dict[str, bytes]:
    """The lists of all tasks by split. Raises UserError where no list takes any object of a category."""
    lists: dict[str, dict[str, Any]] = {list_name(kind, split): {} for kind in LISTS for split in SPLITS}
    for entry in entries:
        taken = False
        for shard in range(len(entry.chunks())):
            known = json.loads((folder / OBJECTS / f"{entry.category}-{shard}.json").read_bytes())
            for id, own in known.items():
                for kind in (kind for kind in LISTS if kind in own):
                    held = lists[list_name(kind, own["split"])]
                    if id in held:
                        raise UserError(
                            f"{entry.category} has an id, {id}, of another category", "choose a folder of its own"
                        )
                    held[id], taken = own[kind], True
        if not taken:
            raise UserError(
                f"no object of {entry.category} is one that ManiSkill's tasks take",
                "all its drawers, or all its doors, need handles and wait for no other joint, nothing else may slide, or turn, and all "
                "joints open from a lower limit on; more objects (-n), or a --map with other words",
            )
    return {name: (json.dumps(held, indent=1) + "\n").encode() for name, held in lists.items()}


def check_term(term: Term) -> str | None:
    """What is wrong with a map, if anything: it names a part that the task does not have, or says of no link that it is one."""
    known = term.data["parts"]
    unknown = [part for part in term.parts.values() if part not in known]
    if unknown:
        return f"there is no part `{unknown[0]}`: the parts are {', '.join(known)}"
    other = [key for key in term.parts if "/" not in key]
    if other or not term.parts:
        return f'`{other[0]}` is not of the form "door/revolute"' if other else "no word of it is a part"
    return None
