"""What the floor asks of joints that move what an object stands on, such as the hinge of a step ladder.

The feet are what ``require stable`` calls so, at rest. They carry the object as springs of one stiffness under all of them
would, so that forces and moments are in balance. Between two sides, as of a ladder, no other forces are.
"""

from __future__ import annotations

import numpy as np

from ..geometry.runs import changes
from ..geometry.vectors import cross
from ..runtime.batch import Batch
from ..runtime.motion import apply
from ..validity.bodies import gather
from ..validity.feet import find_feet
from ..validity.mass import Mass
from ..validity.tree import Tree
from .dynamics import GRAVITY

_WIDTH = 1e-4  # metres: how wide feet in one line count as


def find_thrust(batch: Batch, mass: Mass) -> np.ndarray:
    """The torque (J,), N m, of a slide the force, N, along each joint's value by which the floor pushes what it moves.

    ``mass``: of all links in the object's frame with the joints at 0. 0 for what moves no feet, for wheels, which roll, and
    for balls; and in objects of which the text does not say that they stand.
    """
    joints, stands = batch.joints(), np.zeros(len(batch), dtype=bool)
    for statement in batch.program.stable:
        stands[batch.owner(statement.scope)] = True
    thrust = np.zeros(len(joints.owner))
    if not stands[joints.owner].any():
        return thrust
    tree = Tree(batch)
    link, place = _feet(tree, stands)
    owner = tree.links.owner
    force = _forces(owner[link], place, *_weights(owner, mass, tree, len(batch)))
    for level in range(tree.chain.shape[1]):
        joint = tree.joint_above(link, level)
        on = np.flatnonzero(joint >= 0)
        at = joint[on]
        axis = tree.axis[at]
        turned = cross(axis, place[on] - tree.origin[at])[:, 2] + tree.advance[at] * axis[:, 2]
        thrust += np.bincount(at, force[on] * np.where(tree.slides[at], axis[:, 2], turned), len(thrust))
    rolls = np.array([kind in ("continuous", "ball") for kind in joints.kind], dtype=bool)
    return np.where(rolls, 0.0, thrust)


def _feet(tree: Tree, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Links (n,) and corners (n, 3) of the boxes of what stands on the floor, piece by piece, of the objects ``chosen`` (B,) bool.

    Boxes, since pieces may repeat corners, more in one batch than in another."""
    body = gather(tree.batch, tree.first, tree.turn, tree.shift)
    feet = find_feet(tree, body)
    own = chosen[body.owner[feet.piece]]
    piece, point = feet.piece[own], feet.point[own]
    begin = np.flatnonzero(changes(piece))
    low, high, link = np.minimum.reduceat(point, begin), np.maximum.reduceat(point, begin), body.link[piece[begin]]
    ends = np.stack([low, high], axis=1)
    corners = np.stack([ends[:, (0, 0, 1, 1), 0], ends[:, (0, 1, 0, 1), 1], ends[:, (0, 0, 0, 0), 2]], axis=-1)
    return np.repeat(link, 4), corners.reshape(-1, 3)


def _weights(owner: np.ndarray, mass: Mass, tree: Tree, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Weight (B,), N, and centre of mass (B, 2) of the objects at rest."""
    total = np.bincount(owner, mass.mass, count)
    placed = (apply(tree.turn, mass.center) + tree.shift) * mass.mass[:, None]
    center = np.stack([np.bincount(owner, placed[:, k], count) for k in (0, 1)], axis=-1)
    return total * GRAVITY, center / np.maximum(total, 1e-12)[:, None]


def _forces(owner: np.ndarray, place: np.ndarray, weight: np.ndarray, center: np.ndarray) -> np.ndarray:
    """The force (n,), N, on each of the feet at ``place`` (n, 3), so that those of one object balance its weight."""
    count = len(weight)
    many = np.maximum(np.bincount(owner, minlength=count), 1)

    def mean(value: np.ndarray) -> np.ndarray:
        return np.bincount(owner, value, count) / many

    x, y = place[:, 0] - mean(place[:, 0])[owner], place[:, 1] - mean(place[:, 1])[owner]
    off_x, off_y = center[:, 0] - mean(place[:, 0]), center[:, 1] - mean(place[:, 1])
    xx, xy, yy = mean(x * x) + _WIDTH**2, mean(x * y), mean(y * y) + _WIDTH**2
    scale = xx * yy - xy * xy
    slope_x, slope_y = (yy * off_x - xy * off_y) / scale, (xx * off_y - xy * off_x) / scale
    share = (weight / many)[owner]
    return share * (1.0 + slope_x[owner] * x + slope_y[owner] * y)
