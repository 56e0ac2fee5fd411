"""Joints from their roots: every chain of links ends at one, and every chain of joints that follow one another at one that
moves by itself. A chain that comes back to itself is refused here, before anything walks along it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import UserError
from .tables import JointTable


class Ring(UserError):
    """Links of an object that hang on one another, or joints that follow one another."""


def lead_by_heads(joints: JointTable) -> JointTable:
    """The same joints, each that follows one that follows another following the head of the chain itself, at rest too."""
    base = np.searchsorted(joints.owner, joints.owner)
    leader = np.where(joints.mimic >= 0, base + joints.mimic, -1)
    multiplier, offset = joints.multiplier, joints.offset
    for _ in range(_rounds(len(leader))):
        rows = np.flatnonzero((leader >= 0) & (np.append(leader, -1)[leader] >= 0))
        if not len(rows):
            break
        via = leader[rows]
        multiplier, offset, leader = multiplier.copy(), offset.copy(), leader.copy()
        offset[rows] += multiplier[rows] * offset[via]
        multiplier[rows] *= multiplier[via]
        leader[rows] = leader[via]
    else:
        row = leader[rows[0]]
        raise Ring(
            f"the joint `{joints.name[row]}` follows itself",
            hint="one of the joints of the ring must move independently",
        )
    led = np.flatnonzero(leader >= 0)
    rest = joints.rest.copy()
    rest[led] = multiplier[led] * rest[leader[led]] + offset[led]
    mimic = np.where(leader >= 0, leader - base, -1)
    return replace(joints, mimic=mimic, multiplier=multiplier, offset=offset, rest=rest)


def root_joints(joints: JointTable, numbers: np.ndarray) -> JointTable:
    """The joints, where no link hangs on itself. ``numbers`` (B,) are the numbers of the objects, for the message."""
    size = int(max(joints.parent.max(initial=0), joints.child.max(initial=0))) + 1
    above = np.full(len(numbers) * size, -1, dtype=np.int64)
    above[joints.owner * size + joints.child] = joints.owner * size + joints.parent
    for _ in range(_rounds(size)):
        above = np.where(above >= 0, np.append(above, -1)[above], -1)
    held = above[joints.owner * size + joints.child] >= 0
    if held.any():
        ring = np.isin(joints.owner * size + joints.child, above[above >= 0])
        row = int(np.flatnonzero(ring)[0])
        raise Ring(
            f"the links of object {numbers[joints.owner[row]]} form a ring: "
            f"the link that the joint `{joints.name[row]}` moves is attached to itself",
            hint="joints form a tree: attach one part of the ring to the root, or to a part that is attached to it",
        )
    return joints


def _rounds(size: int) -> int:
    """How often a chain of so many is followed, twice as far each time, to be at its end."""
    return int(size).bit_length() + 1
