"""Joints that move only while others are open: which wait for which, and what they do while they may not move."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..records import dataclass
from .referred import Referred

if TYPE_CHECKING:
    from .batch import Batch


@dataclass(frozen=True, slots=True, eq=False)
class Gates:
    """G comparisons: the joint ``joint`` (G,) moves only while the value of ``gate`` (G,), both rows of the joint table, lies in
    ``low`` .. ``high`` (G,), -inf and inf where there is no such end. ``level`` (G,) is 0 for gates that wait for nothing, 1 for those
    that wait for joints which do, and so on. ``rest`` (J,) is where joints stay.
    """

    joint: np.ndarray
    gate: np.ndarray
    low: np.ndarray
    high: np.ndarray
    level: np.ndarray
    rest: np.ndarray

    def held(self, values: np.ndarray) -> np.ndarray:
        """Which comparisons (..., G) do not hold at joint values (..., J)."""
        at = values[..., self.gate]
        return (at < self.low) | (at > self.high)

    def settle(self, values: np.ndarray) -> np.ndarray:
        """Joint values (..., J) with every joint at rest whose gates are not all open, the outermost first."""
        flat = np.array(values, dtype=np.float64)
        flat = flat.reshape(flat.size // max(1, len(self.rest)), len(self.rest))  # there may be no joint at all
        for level in range(int(self.level.max(initial=-1)) + 1):
            rows = np.flatnonzero(self.level == level)
            state, held = np.nonzero(self.held(flat)[:, rows])
            joint = self.joint[rows[held]]
            flat[state, joint] = self.rest[joint]
        return flat.reshape(np.shape(values))

    def open(self, values: np.ndarray, moves: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """Joint values (..., J) with the gates of the joints that ``moves`` (J,) bool names open: one that is not goes as far as
        it can within ``low`` .. ``high`` (J,), what it waits for before."""
        values, asked = np.array(values, dtype=np.float64), moves.copy()
        for level in range(int(self.level.max(initial=-1)), -1, -1):
            rows = np.flatnonzero((self.level == level) & asked[self.joint])
            shut = self.held(values)[..., rows]
            gate = self.gate[rows]
            asked[gate] = True
            wide = np.where(np.isfinite(self.low[rows]), high[gate], low[gate])
            wide = np.where(
                np.isfinite(wide), wide, np.where(np.isfinite(self.low[rows]), self.low[rows], self.high[rows])
            )
            values[..., gate] = np.where(shut, wide, values[..., gate])
        return values


def gates_of(batch: Batch) -> Gates | None:
    """The comparisons of a batch, None for programs without any."""
    program, joints, instances = batch.program, batch.joints(), batch.joint_instances
    if not any(joint.gates for joint in program.joints):
        return None
    referred = Referred(batch.rowmap, instances, [joint.scope for joint in program.joints], batch.read)
    base = np.searchsorted(joints.owner, np.arange(len(batch)))
    found: list[tuple[np.ndarray, ...]] = [(np.zeros(0, dtype=np.int64),) * 2 + (np.zeros(0),) * 2]
    for number, stated in enumerate(program.joints):
        owner = batch.owner(stated.scope)
        rows = instances.place[instances.starts[number] + np.arange(len(owner))]
        for condition in stated.gates:
            other = referred.numbers(stated.scope, condition.joint)
            low, high = (
                np.full(len(rows), end) if expr is None else batch.read([expr], stated.scope)[0]
                for expr, end in ((condition.low, -np.inf), (condition.high, np.inf))
            )
            there = other >= 0
            found.append((rows[there], (base[owner] + other)[there], low[there], high[there]))
    own, other, low, high = (np.concatenate(column) for column in zip(*found, strict=True))
    depth = np.zeros(len(joints.owner), dtype=np.int64)
    for _ in range(len(program.joints)):
        deeper = depth.copy()
        np.maximum.at(deeper, own, depth[other] + 1)
        if np.array_equal(deeper, depth):
            break
        depth = deeper
    rest = np.where(np.isnan(joints.rest), 0.0, joints.rest)
    return Gates(own, other, low, high, depth[own] - 1, rest)
