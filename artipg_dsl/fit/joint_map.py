"""Which joint of a URDF is which of the object that was fitted to it, so that values of one can be carried over to the other.

Links belong together as in ``links``: where most points of each lie on the other. Of several joints on the way to a link that nearest to
the root counts.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from .. import random
from ..geometry import points as geometry
from ..records import dataclass
from ..runtime.batch import Batch
from .bodies import Bodies
from .links import Held, Moving, links_of_rows, together
from .match import features
from .states import moved

_COMPARED = 8192  # points of the structure that links are told by


@dataclass(frozen=True, slots=True, eq=False)
class Real:
    """A real object in the frame of the object that was fitted to it: ``points``, ``normals`` (n, 3), ``body`` (n,) that each lies on, -1 for
    none, and its ``bodies``."""

    points: np.ndarray
    normals: np.ndarray
    body: np.ndarray
    bodies: Bodies


def map_joints(batch: Batch, states: np.ndarray, row: int, real: Real) -> dict[str, Any]:
    """Of each joint of a real object, by name, the ``joint`` of the object of a row that is the same, None where none is: its value is ``at`` +
    ``by`` times that of the real one. ``states`` (J,) are the values of the joints where the real ones are at 0."""
    twist, named = real.bodies.twist, real.bodies.joints
    moving = Moving.of(batch)[row : row + 1]
    mine = _links(batch, states, row, real)
    across = np.sqrt((np.ptp(real.points, axis=0) ** 2).sum())[None]
    held = Held.of(moving, mine[None], real.body[None], twist[None], across)
    same = together(moving, held.count, twist[None], across)[0]
    joints = batch.joints()
    own = np.flatnonzero(joints.owner == row)
    above = {int(joints.child[j]): int(j) for j in own}
    found: dict[str, Any] = {}
    for body in np.flatnonzero((twist != 0.0).any(axis=1) & np.isfinite(twist).all(axis=1)).tolist():
        ours = moving.twist[0]
        links = np.flatnonzero(same[:, body] & (ours != 0.0).any(axis=1) & np.isfinite(ours).all(axis=1))
        found[named[body]] = None
        if len(links):
            j, by = above[int(links[0])], _ratio(twist[body], ours[links[0]])
            found[named[body]] = {"joint": joints.name[j], "at": round(float(states[j]), 6), "by": float(f"{by:.6g}")}
    return found


def _ratio(real: np.ndarray, ours: np.ndarray) -> float:
    """By how much a joint moves where another, of the same axis, moves by 1; their twists (6,) each."""
    way = slice(0, 3) if ours[:3].any() else slice(3, 6)
    length = float(np.sqrt((real[way] ** 2).sum()))
    return length if float((real[way] * ours[way]).sum()) > 0.0 else -length


def _links(batch: Batch, states: np.ndarray, row: int, real: Real) -> np.ndarray:
    """(n,) the link of the object of a row that each point of a real one lies on, or the first above it that moves."""
    address = batch.state.objects.astype(np.uint64)
    made = geometry.sample(moved(batch, states), len(batch), _COMPARED, random.key(0, "joints"), address, outside=True)
    links = links_of_rows(batch)
    begin = np.cumsum([0, *map(len, links)])
    across = np.array(np.sqrt((np.ptp(real.points, axis=0) ** 2).sum()))
    ours, theirs = (
        features(points, normals, across)
        for points, normals in ((made.position[row], made.normal[row]), (real.points, real.normals))
    )
    near = cKDTree(ours).query(theirs)[1]
    return np.asarray(np.concatenate(links)[begin[made.site[row]] + made.row[row]][near])
