"""The surface of a real object in the frame of the object that was fitted to it: what details are bound from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..details.binding import Real
from ..geometry.vectors import dot
from .outer import spacing, towards
from .pose import UNITS, Frame, pose, turn
from .reading import read_cloud


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
