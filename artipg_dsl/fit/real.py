"""The surface of a real object in the frame of the object that was fitted to it: what details are bound from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from .. import random
from ..annotate.states import rest_values
from ..details.binding import Real
from ..errors import UserError
from ..geometry import points as geometry
from ..geometry.vectors import dot
from ..runtime.batch import Batch
from ..runtime.motion import apply
from .match import features
from .outer import spacing, towards
from .pose import AXES, UNITS, Frame, pose, turn
from .sources import File, Held
from .states import moved

_COMPARED = 8192  # points of the structure that links are told by
_LARGEST = 1e9  # of the numbers of a record
_SKEW = 1e-3  # what rounding leaves between the axes of a matrix, and more


def check_record(record: Mapping[str, Any]) -> None:
    """Raises UserError for a record that lacks what binding needs of it, or whose values cannot be meant: records may be edited by hand."""
    name, frame = record.get("name"), record.get("frame")

    def refuse(key: str, wanted: str) -> None:
        raise UserError(f"`{key}` in the record of {name} is not {wanted}", "undo the change, or fit it again")

    if not isinstance(record.get("file"), str) or "to_object" not in record or frame is None:
        raise UserError(f"the record of {name} is missing or damaged", "fit it again")
    if not (
        isinstance(frame, Mapping)
        and frame.get("up") in AXES
        and frame.get("front") in AXES
        and frame["up"][-1] != frame["front"][-1]
        and frame.get("unit", "") in (None, *UNITS)
    ):
        refuse("frame", "two axes that are square to each other and a unit or null")
    if not _is_matrix(record["to_object"]):
        refuse("to_object", "a matrix of four rows of four numbers that turns, shifts and scales")
    joints = record.get("joints")
    if joints is not None and not (isinstance(joints, Mapping) and all(map(_is_number, joints.values()))):
        refuse("joints", "a number for each name of a joint")


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < _LARGEST


def _is_matrix(rows: Any) -> bool:
    if not (isinstance(rows, list) and len(rows) == 4 and all(isinstance(row, list) and len(row) == 4 for row in rows)):
        return False
    if not all(_is_number(value) for row in rows for value in row) or rows[3] != [0, 0, 0, 1]:
        return False
    linear = np.array(rows, dtype=np.float64)[:3, :3]
    square = linear.T @ linear
    even = float(np.trace(square)) / 3.0
    return even > 0.0 and bool(np.abs(square - even * np.eye(3)).max() < _SKEW * even) and np.linalg.det(linear) > 0.0


def read_real(source: File | Held, record: Mapping[str, Any]) -> Real:
    """The outer surface of a real object; ``record`` is what ``apgc fit`` has written of it. Normals point to where the surface is seen from,
    since the faces of many meshes are doubled. Raises UserError for one that cannot be read, and for a record that ``check_record`` refuses."""
    check_record(record)
    frame = record["frame"]
    unit = frame["unit"]
    asked = Frame(frame["up"], frame["front"], unit or "auto", unit is None)
    posed = pose(source.read(), asked, source.suffix, None)
    matrix = np.asarray(record["to_object"], dtype=np.float64)
    places = posed.points / UNITS[posed.unit]
    points = np.stack([(places * matrix[k, :3]).sum(axis=1) + matrix[k, 3] for k in range(3)], axis=-1)
    turned = turn(frame["up"], frame["front"])
    normals = np.stack([(posed.normals * turned[k]).sum(axis=1) for k in range(3)], axis=-1)
    facing = dot(towards(points, float(spacing(points[None])[0])), normals)
    normals = np.where((facing < 0.0)[:, None], -normals, normals)
    return Real(record["name"], points, normals, posed.label, posed.names)


def closed(batch: Batch, real: Real, joints: Mapping[str, float]) -> Real:
    """The surface with its joints at 0, where details are bound: each point goes with the link of the structure that is nearest to it,
    by place and normal, with the one object of a batch at the values ``joints`` by name. Raises UserError for a name that it does not have."""
    values = posed_as(batch, joints, real.name)
    rotation, translation = batch.pose(values)
    sites = moved(batch, values)
    address = np.asarray(batch.numbers).astype(np.uint64)
    made = geometry.sample(sites, 1, _COMPARED, random.key(batch.seed, "closed"), address, outside=True)
    ours, theirs = (
        features(p, n, np.array(real.diagonal))
        for p, n in ((made.position[0], made.normal[0]), (real.points, real.normals))
    )
    near = cKDTree(ours).query(theirs)[1]
    begin = np.cumsum([0, *(len(table) for table in sites)])
    link = np.concatenate([table.link for table in sites])[begin[made.site[0]] + made.row[0]][near]
    back = np.swapaxes(rotation[link], -1, -2)
    return replace(real, points=apply(back, real.points - translation[link]), normals=apply(back, real.normals))


def posed_as(batch: Batch, joints: Mapping[str, float], record: str) -> np.ndarray:
    """The values (J,) of the joints of the one object of a batch that has those of its ``record`` by name, others at rest. Raises UserError
    for a name that it does not have."""
    values, names = rest_values(batch).copy(), batch.joints().name
    for name, value in joints.items():
        if name not in names:
            raise UserError(f"the object has no joint `{name}`, which the record of {record} moves", "fit it again")
        values[names.index(name)] = value
    return batch.settle(values)
