"""Parts that a hand can use, as GAPartNet has them: which there are, and the oriented box of each.

A part is a link that moves in a way that has a class, without what lies on it that is a part of its own (a fixed handle).
Its axes are those of the data set: z out of the surface, for a door x along the hinge and y from the hinge to the free edge,
else x along the longer edge.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...annotate.poses import PartPoses, part_poses
from ...geometry.resolution import Resolution
from ...records import dataclass
from ...robot.robots import Robots
from ..clouds import norms
from ..pieces import Pieces
from ..words import Term

if TYPE_CHECKING:
    from ...runtime.batch import Batch

CLASSES = (
    "others",
    "line_fixed_handle",
    "round_fixed_handle",
    "slider_button",
    "hinge_door",
    "slider_drawer",
    "slider_lid",
    "hinge_lid",
    "hinge_knob",
    "revolute_handle",
)
FINE = Resolution(tolerance=2e-5)
_LONG = 1.5  # a fixed handle this many times as long as wide is a line
_BEHIND = 0.25  # of what carries it: a handle further than that behind its middle is on its back
_HINGED = ("hinge_door", "hinge_lid")
_TURNED = ("hinge_knob", "revolute_handle")
_PRESSED = ("slider_button",)
_FIXED = ("line_fixed_handle", "round_fixed_handle")


@dataclass(frozen=True, slots=True)
class GAPart:
    """``kind``: the number of its class; the ``link`` that it moves with, and the part ``instance`` that it is, -1 for the whole
    link; rows of ``axes`` (3, 3) are its own at joint values 0, ``center`` (3,) and ``size`` (3,) its box."""

    kind: int
    link: int
    instance: int
    axes: np.ndarray
    center: np.ndarray
    size: np.ndarray

    def npcs(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) at joint values 0 in the part's coordinates: the diagonal of its box is 1."""
        local = (points - self.center) @ self.axes.T
        return np.clip(local, -self.size / 2, self.size / 2) / norms(self.size)


def owners(parts: Sequence[GAPart], link: np.ndarray, instance: np.ndarray) -> np.ndarray:
    """The part (n,) that points on links and part instances belong to, -1 for none: a fixed handle is not of the door."""
    found = np.full(len(link), -1)
    for k, part in sorted(enumerate(parts), key=lambda entry: entry[1].instance >= 0):
        found[(link == part.link) & ((part.instance < 0) | (instance == part.instance))] = k
    return found


def gaparts(batch: Batch, term: Term) -> list[list[GAPart]]:
    """The parts of each object of a batch."""
    robots = Robots(batch, resolution=FINE, physics=False)
    poses = part_poses(batch, np.zeros(len(robots.joints.owner)))
    return [list(_Object(Pieces(robots, i, term), poses).parts()) for i in range(len(batch))]


class _Object:
    """What is asked of one object."""

    def __init__(self, pieces: Pieces, poses: PartPoses):
        self.pieces, self.poses = pieces, poses
        everything = self.pieces.corners()
        self.middle = (everything.min(axis=0) + everything.max(axis=0)) / 2

    def parts(self) -> Iterator[GAPart]:
        """Links that move in a way that has a class, then what is a part by its word. A handle that turns is one with its rose,
        which stays with what carries it."""
        pieces = self.pieces
        moving = pieces.moving()
        turned = {k for link, name in moving.items() if name in _TURNED for k, _ in pieces.of(link)}
        for link in range(len(pieces.robot.links)):
            carrier, seen = None, [(k, shape.vertices) for k, shape in pieces.of(link)]
            apart = [k for k in pieces.apart(link) if k not in turned]
            own = [corners for k, corners in seen if k not in apart]
            if link in moving and own:
                carrier = self._moving(link, moving[link], np.concatenate(own))
                yield carrier
            for k in apart:
                corners = np.concatenate([held for number, held in seen if number == k])
                yield self._fixed(link, k, pieces.term.parts[pieces.word(k)], corners, carrier)

    def _moving(self, link: int, name: str, corners: np.ndarray) -> GAPart:
        joint = next(joint for joint in self.pieces.robot.joints if joint.child == link)
        ends = joint.high or 0.0, -(joint.low or 0.0)  # how far it goes from where it is shut
        axis = joint.axis * (1.0 if ends[0] >= ends[1] else -1.0)
        frame = self._frame(link)
        center = (corners.min(axis=0) + corners.max(axis=0)) / 2
        if name in _HINGED:
            x = nearest(frame, axis)
            arm = center - self.pieces.robot.links[link].origin
            y = nearest(frame, arm - (arm @ x) * x, x)
            return _boxed(name, link, -1, np.stack([x, y, np.cross(x, y)]), corners)
        out = -axis if name in _PRESSED else axis
        if name in _TURNED:
            out = axis if axis @ (center - self.middle) >= 0 else -axis
        return _boxed(name, link, -1, facing(frame, nearest(frame, out), corners), corners)

    def _fixed(self, link: int, instance: int, name: str, corners: np.ndarray, carrier: GAPart | None) -> GAPart:
        frame = self.poses.rotation[self.pieces.first + instance]
        center = (corners.min(axis=0) + corners.max(axis=0)) / 2
        extent = np.ptp(corners @ frame, axis=0)
        out = center - self.middle
        if carrier is not None:
            side = (center - carrier.center) @ carrier.axes[2]
            out = carrier.axes[2] * (-1.0 if side < -_BEHIND * carrier.size[2] else 1.0)
        z = nearest(frame, out, frame[:, int(extent.argmax())])
        axes = facing(frame, z, corners)
        size = np.ptp(corners @ axes.T, axis=0)
        if name in _FIXED:
            name = _FIXED[0] if size[0] > _LONG * size[1] else _FIXED[1]
        return _boxed(name, link, instance, axes, corners)

    def _frame(self, link: int) -> np.ndarray:
        """Axes (3, 3), as columns, of the part that a link is; the object's where it is none."""
        table, part, rows = self.pieces.robots.parts, self.pieces.part(link), self.pieces.rows
        at = np.flatnonzero((np.asarray(table.definition[rows]) == part) & (np.asarray(table.link[rows]) == link))
        return self.poses.rotation[self.pieces.first + int(at[0])] if part >= 0 and len(at) else np.eye(3)


def nearest(frame: np.ndarray, direction: np.ndarray, but: np.ndarray | None = None) -> np.ndarray:
    """Of the columns of a frame and their opposites the one nearest to a direction, not along ``but``."""
    along = direction @ frame
    if but is not None:
        along = np.where(np.abs(but @ frame) > 0.9, 0.0, along)
    k = int(np.abs(along).argmax())
    return frame[:, k] * (1.0 if along[k] >= 0 else -1.0)


def facing(frame: np.ndarray, z: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Axes as rows: z as given, x along the longer edge of the other two."""
    others = [frame[:, k] for k in range(3) if abs(frame[:, k] @ z) < 0.9]
    x = max(others, key=lambda axis: float(np.ptp(corners @ axis)))
    return np.stack([x, np.cross(z, x), z])


def _boxed(name: str, link: int, instance: int, axes: np.ndarray, corners: np.ndarray) -> GAPart:
    local = corners @ axes.T
    low, high = local.min(axis=0), local.max(axis=0)
    return GAPart(CLASSES.index(name), link, instance, axes, (low + high) / 2 @ axes, high - low)


def check_term(term: Term) -> str | None:
    """What is wrong with a map, if anything: it names a part that there is not."""
    unknown = [part for part in term.parts.values() if part not in CLASSES[1:]]
    if not term.parts:
        return "no word of it is a part"
    return f"there is no part `{unknown[0]}`: the parts are {', '.join(CLASSES[1:])}" if unknown else None
