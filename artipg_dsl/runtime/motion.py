"""Joints in motion: where each link is for given joint values."""

from __future__ import annotations

import numpy as np

from .tables import JointTable, LinkTable


def rotation_about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotation matrices (k, 3, 3) about unit axes (k, 3) by angles (k,) (Rodrigues' formula)."""
    c, s = np.cos(angle), np.sin(angle)
    t = 1.0 - c
    x, y, z = axis[:, 0], axis[:, 1], axis[:, 2]
    cells = [
        x * x * t + c,
        x * y * t - z * s,
        x * z * t + y * s,
        x * y * t + z * s,
        y * y * t + c,
        y * z * t - x * s,
        x * z * t - y * s,
        y * z * t + x * s,
        z * z * t + c,
    ]
    return np.stack(cells, axis=-1).reshape(-1, 3, 3)


def apply(rotation: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Matrices (k, 3, 3) times vectors (k, 3), written out."""
    columns = [
        rotation[:, i, 0] * vector[:, 0] + rotation[:, i, 1] * vector[:, 1] + rotation[:, i, 2] * vector[:, 2]
        for i in range(3)
    ]
    return np.stack(columns, axis=-1)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products (k, 3, 3) of matrices, written out."""
    return np.stack([apply(a, b[:, :, j]) for j in range(3)], axis=-1)


def follow(joints: JointTable, states: np.ndarray) -> np.ndarray:
    """Joint values in which those that mimic another take the value that follows from it, along chains of any length."""
    values = np.array(states, dtype=np.float64)
    leads = np.flatnonzero(joints.mimic >= 0)
    leader = np.searchsorted(joints.owner, joints.owner)[leads] + joints.mimic[leads]
    for _ in range(len(leads)):
        before = values[leads]
        values[leads] = joints.multiplier[leads] * values[leader] + joints.offset[leads]
        if np.array_equal(before, values[leads], equal_nan=True):
            break
    return values


def freedoms(joints: JointTable) -> tuple[np.ndarray, np.ndarray]:
    """What one unit of a joint's value does: the axis it turns about and the way it slides, (J, 3) each, 0 where it does not.

    Radians of a hinge, a screw or a ball, metres of a slide. A screw advances by its pitch a turn. The value of a ball
    joint, which has three freedoms, is the tilt of its axis about one direction square to it; the other two rest.
    """
    kind = np.array(joints.kind, dtype=object)
    hinged = np.isin(kind, ("revolute", "continuous", "screw"))[:, None]
    turn = np.where(hinged, joints.axis, np.where((kind == "ball")[:, None], square(joints.axis), 0.0))
    advance = np.where(kind == "screw", np.nan_to_num(joints.pitch) / (2.0 * np.pi), (kind == "prismatic") * 1.0)
    return turn, joints.axis * advance[:, None]


def square(axis: np.ndarray) -> np.ndarray:
    """Unit vectors (k, 3) square to unit vectors: towards the coordinate axis that is farthest from each, made square."""
    farthest = np.eye(3)[np.argmin(np.abs(axis), axis=1)] if len(axis) else axis
    along = axis[:, 0] * farthest[:, 0] + axis[:, 1] * farthest[:, 1] + axis[:, 2] * farthest[:, 2]
    rest = farthest - axis * along[:, None]
    return rest / np.sqrt(rest[:, 0] ** 2 + rest[:, 1] ** 2 + rest[:, 2] ** 2)[:, None]


class Chains:
    """The joints between the links of a batch, with all that does not change when they move."""

    def __init__(self, links: LinkTable, joints: JointTable):
        self.joints, self.count = joints, len(links.owner)
        first = np.searchsorted(links.owner, np.arange(int(links.owner[-1]) + 1)) if self.count else np.zeros(0, int)
        self.parent, self.child = first[joints.owner] + joints.parent, first[joints.owner] + joints.child
        self.axis, self.slide = freedoms(joints)
        self.turning, self.sliding = (self.axis != 0.0).any(axis=1), (self.slide != 0.0).any(axis=1)
        self.levels = [(at, self.parent[at], self.child[at]) for at in levels(self.count, self.parent, self.child)]

    def motion(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotation (L, 3, 3) and translation (L, 3) that carry each link from joint values 0 to ``values`` (J,), mimics obeyed."""
        rotation, translation = np.tile(np.eye(3), (self.count, 1, 1)), np.zeros((self.count, 3))
        turn = rotation_about(self.axis, np.where(self.turning, values, 0.0))
        shift = self.joints.origin - apply(turn, self.joints.origin)
        shift = shift + self.slide * np.where(self.sliding, values, 0.0)[:, None]
        for at, p, c in self.levels:
            rotation[c] = product(rotation[p], turn[at])
            translation[c] = apply(rotation[p], shift[at]) + translation[p]
        return rotation, translation


def link_motion(links: LinkTable, joints: JointTable, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation (L, 3, 3) and translation (L, 3) that carry each link from joint values 0 to ``states`` (J,)."""
    return Chains(links, joints).motion(follow(joints, states))


def levels(count: int, parent: np.ndarray, child: np.ndarray) -> list[np.ndarray]:
    """The joints whose child links lie at each depth of the tree of ``count`` links, from the root on."""
    depth = np.zeros(count, dtype=np.int64)
    for _ in range(count):
        deeper = depth[parent] + 1
        if (depth[child] == deeper).all():
            break
        depth[child] = deeper
    return [np.flatnonzero(depth[child] == level) for level in range(1, int(depth.max(initial=0)) + 1)]
