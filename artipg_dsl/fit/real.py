"""The surface of a real object in the frame of the object that was fitted to it: what details are bound from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
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
from .pose import UNITS, Frame, pose, turn
from .reading import read_cloud
from .states import moved

_COMPARED = 8192  # points of the structure that links are told by


def read_real(path: Path, record: Mapping[str, Any]) -> Real:
    """The outer surface of a file; ``record`` is what ``apgc fit`` has written of it. Normals point to where the surface is seen from, since
    the faces of many meshes are doubled. Raises UserError for a file that cannot be read."""
    frame = record["frame"]
    unit = frame["unit"]
    asked = Frame(frame["up"], frame["front"], unit or "auto", unit is None)
    posed = pose(read_cloud(path), asked, path.suffix.lower(), 1.0)
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
    values, names = rest_values(batch).copy(), batch.joints().name
    for name, value in joints.items():
        if name not in names:
            raise UserError(f"the object has no joint `{name}`, which the record of {real.name} moves", "fit it again")
        values[names.index(name)] = value
    values = batch.settle(values)
    rotation, translation = batch.pose(values)
    sites = moved(batch, values)
    address = np.asarray(batch.numbers).astype(np.uint64)
    made = geometry.sample(sites, 1, _COMPARED, random.key(batch.seed, "closed"), address, outside=True)
    one = np.array([real.diagonal])
    ours, theirs = (
        features(p[None], n[None], one)[0] for p, n in ((made.position[0], made.normal[0]), (real.points, real.normals))
    )
    near = cKDTree(ours).query(theirs)[1]
    begin = np.cumsum([0, *(len(table) for table in sites)])
    link = np.concatenate([table.link for table in sites])[begin[made.site[0]] + made.row[0]][near]
    back = np.swapaxes(rotation[link], -1, -2)
    return replace(real, points=apply(back, real.points - translation[link]), normals=apply(back, real.normals))
