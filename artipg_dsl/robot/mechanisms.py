"""Joints that move together: what follows another, by a mimic or round a closed loop, and how fast."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..runtime.loops import leaders_of

if TYPE_CHECKING:
    from ..runtime.batch import Batch


def find_mechanisms(batch: Batch) -> tuple[np.ndarray, np.ndarray]:
    """For each joint (J,) the joint that leads it, itself where none does, and how many times as fast as that it moves.

    Of what a loop determines it is the mean over the leader's range: a joint may move fast where another hardly does.
    """
    joints = batch.joints()
    leader, ratio = leaders_of(joints)
    if batch.loops is None:
        return leader, ratio
    leader = batch.loops.driven(leader)
    rest = batch.rest()
    low, high = (batch.settle(np.where(np.isnan(end), rest, end)) for end in (joints.low, joints.high))
    way = (high - low)[leader]
    mean = (high - low) / np.where(way == 0.0, 1.0, way)
    return leader, np.where((leader == np.arange(len(leader))) | (way == 0.0), 1.0, mean)
