"""Joints in motion: where each link is for given joint values."""

from __future__ import annotations

import numpy as np

from .tables import JointTable, LinkTable

MatrixCells = list[np.ndarray]  # of matrices, row by row, or of vectors: an array of any shape for each


def rotation_about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Rotation matrices (k, 3, 3) about unit axes (k, 3) by angles (k,) (Rodrigues' formula)."""
    return np.stack(_turning(list(axis.T), angle), axis=-1).reshape(-1, 3, 3)


def _turning(axis: MatrixCells, angle: np.ndarray) -> MatrixCells:
    """The 9 cells of rotations about unit axes by angles (..., k)."""
    c, s = np.cos(angle), np.sin(angle)
    t = 1.0 - c
    x, y, z = axis
    return [
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


def carry(rotation: MatrixCells, vector: MatrixCells) -> MatrixCells:
    """Rotations, as 9 cells, times vectors, as 3, written out."""
    x, y, z = vector
    return [rotation[i] * x + rotation[i + 1] * y + rotation[i + 2] * z for i in (0, 3, 6)]


def apply(rotation: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 3) times vectors (..., 3), written out."""
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    columns = [rotation[..., i, 0] * x + rotation[..., i, 1] * y + rotation[..., i, 2] * z for i in range(3)]
    return np.stack(columns, axis=-1)


def multiply(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products (..., 3, 3) of matrices, written out."""
    return np.stack([apply(a, b[..., j]) for j in range(3)], axis=-1)


def follow(joints: JointTable, states: np.ndarray) -> np.ndarray:
    """Joint values (..., J) in which those that mimic another take the value that follows from it, along chains of any
    length."""
    values = np.array(states, dtype=np.float64)
    leads = np.flatnonzero(joints.mimic >= 0)
    leader = np.searchsorted(joints.owner, joints.owner)[leads] + joints.mimic[leads]
    for _ in range(len(leads)):
        before = values[..., leads]
        values[..., leads] = joints.multiplier[leads] * values[..., leader] + joints.offset[leads]
        if np.array_equal(before, values[..., leads], equal_nan=True):
            break
    for curve in joints.curves:
        values[..., curve.row] = curve.value(values[..., curve.leader])
    return values


def freedoms_of(joints: JointTable) -> tuple[np.ndarray, np.ndarray]:
    """What one unit of a joint's value does: the axis it turns about and the way it slides, (J, 3) each, 0 where it does not.

    Radians of a hinge, a screw or a ball, metres of a slide. A screw advances by its pitch a turn. The value of a ball
    joint, which has three freedoms, is the tilt of its axis about one direction square to it; the other two rest.
    """
    hinged, tilts = joints.that("turns")[:, None], joints.that("tilts")[:, None]
    turn = np.where(hinged, joints.axis, np.where(tilts, perpendicular_to(joints.axis), 0.0))
    return turn, joints.axis * joints.advance[:, None]


def perpendicular_to(axis: np.ndarray) -> np.ndarray:
    """Unit vectors (k, 3) square to unit vectors: towards the coordinate axis that is farthest from each, made square."""
    farthest = np.eye(3)[np.argmin(np.abs(axis), axis=1)] if len(axis) else axis
    along = axis[:, 0] * farthest[:, 0] + axis[:, 1] * farthest[:, 1] + axis[:, 2] * farthest[:, 2]
    rest = farthest - axis * along[:, None]
    return rest / np.sqrt(rest[:, 0] ** 2 + rest[:, 1] ** 2 + rest[:, 2] ** 2)[:, None]


class JointChains:
    """The joints between the links of a batch, with all that does not change when they move. ``only`` (J,) bool: links that
    no such joint moves stay where they are."""

    def __init__(self, links: LinkTable, joints: JointTable, only: np.ndarray | None = None):
        self.count = len(links.owner)
        first = np.searchsorted(links.owner, np.arange(int(links.owner[-1]) + 1)) if self.count else np.zeros(0, int)
        self.parent, self.child = first[joints.owner] + joints.parent, first[joints.owner] + joints.child
        self.axis, self.slide = (np.ascontiguousarray(way.T) for way in freedoms_of(joints))
        self.origin = np.ascontiguousarray(joints.origin.T)
        self.turning, self.sliding = (self.axis != 0.0).any(axis=0), (self.slide != 0.0).any(axis=0)
        chosen = np.ones(len(joints.owner), dtype=bool) if only is None else only
        self.levels = [at[chosen[at]] for at in joints_by_depth(self.count, self.parent, self.child)]

    def motion(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotation (..., L, 3, 3) and translation (..., L, 3) that carry each link from joint values 0 to ``values`` (..., J),
        mimics obeyed."""
        rotation, translation = self.cells(values)
        return np.stack(rotation, axis=-1).reshape(*rotation[0].shape, 3, 3), np.stack(translation, axis=-1)

    def cells(self, values: np.ndarray) -> tuple[MatrixCells, MatrixCells]:
        """The same, cell by cell: (..., L) each."""
        shape = (*values.shape[:-1], self.count)
        rotation, translation = (
            [np.full(shape, 1.0 if k % 4 == 0 else 0.0) for k in range(9)],
            [np.zeros(shape) for _ in "xyz"],
        )
        for at in self.levels:
            p, c = self.parent[at], self.child[at]
            value, origin = values[..., at], list(self.origin[:, at])
            turn = _turning(list(self.axis[:, at]), np.where(self.turning[at], value, 0.0))
            slide = np.where(self.sliding[at], value, 0.0)
            shift = [
                o - t + way * slide for o, t, way in zip(origin, carry(turn, origin), self.slide[:, at], strict=True)
            ]
            above = [cell[..., p] for cell in rotation]
            for j in range(3):
                for i, cell in enumerate(carry(above, turn[j::3])):
                    rotation[3 * i + j][..., c] = cell
            for cell, moved in zip(translation, carry(above, shift), strict=True):
                cell[..., c] = moved + cell[..., p]
        return rotation, translation


def link_motion(links: LinkTable, joints: JointTable, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation (..., L, 3, 3) and translation (..., L, 3) that carry each link from joint values 0 to ``states`` (..., J)."""
    return JointChains(links, joints).motion(follow(joints, states))


def joints_by_depth(count: int, parent: np.ndarray, child: np.ndarray) -> list[np.ndarray]:
    """The joints whose child links lie at each depth of the tree of ``count`` links, from the root on."""
    depth = np.zeros(count, dtype=np.int64)
    for _ in range(count):
        deeper = depth[parent] + 1
        if (depth[child] == deeper).all():
            break
        depth[child] = deeper
    return [np.flatnonzero(depth[child] == level) for level in range(1, int(depth.max(initial=0)) + 1)]
