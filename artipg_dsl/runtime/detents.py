"""Joints that catch in positions: switches, dials, slip joints.

A joint with n positions catches at n values, evenly spaced: from its low end to its high end, or over a turn, from 0 on,
where it has no ends. It can be anywhere between on its way, and is never left there.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .tables import JointTable


def rest_caught(joints: JointTable) -> JointTable:
    """The same joints, at rest in the position nearest to the value that is given."""
    return joints if np.isnan(joints.positions).all() else replace(joints, rest=caught(joints, joints.rest))


def caught(joints: JointTable, values: np.ndarray) -> np.ndarray:
    """Joint values (..., J), those with positions in the nearest one, of two the lower."""
    first, step, lowest, highest = _places(joints)
    place = np.clip(np.ceil((values - first) / step - 0.5), lowest, highest)
    return np.where(np.isnan(step), values, first + place * step)


def in_positions(joints: JointTable, shares: np.ndarray, values: np.ndarray) -> np.ndarray:
    """``values`` (J,), those with positions in one of them, each as often as any other where ``shares`` (J,) are uniform in 0 .. 1."""
    first, step, _, _ = _places(joints)
    return np.where(np.isnan(step), values, first + np.floor(shares * joints.positions) * step)


def _places(joints: JointTable) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The first position, the distance between two, nan where there are none, and the numbers of the lowest and highest, (J,) each."""
    ends = ~np.isnan(joints.low) & ~np.isnan(joints.high)
    step = np.where(ends, (joints.high - joints.low) / (joints.positions - 1.0), 2.0 * np.pi / joints.positions)
    lowest, highest = np.where(ends, 0.0, -np.inf), np.where(ends, joints.positions - 1.0, np.inf)
    return np.where(ends, joints.low, 0.0), np.where(step > 0.0, step, np.nan), lowest, highest
