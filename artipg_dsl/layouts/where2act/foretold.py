"""A hand whose trials are not simulated: what comes of them is what annotations say (``forecast``).

Of trials on all categories 97 % come out as in SAPIEN (``benchmarks/trials.py``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ...runtime.motion import follow, link_motion
from .forecast import BLOCKED, Scene, foretell, weights
from .hand import PLAIN, Outcome, Trial

if TYPE_CHECKING:
    from ...robot.model import Robot
    from ...runtime.batch import Batch

_FALLS = 64  # steps over the range of a joint that its load moves
_STEPS = 4 * _FALLS  # after which what still moves has not come to rest
_ENDLESS = 2 * np.pi


class Foretold:
    """One object, a batch of its own, as ``hand.Arena`` has it in SAPIEN. ``unit`` in metres; ``groups`` (L,): links of one number
    move as one. Values of joints are by name, those of ``order``: hinges and slides."""

    def __init__(self, batch: Batch, robot: Robot, unit: float, groups: np.ndarray):
        joints = batch.joints()
        self.batch, self.robot, self.unit, self.groups = batch, robot, unit, groups
        self.names = list(joints.name)
        self.order = [n for n, k in zip(joints.name, joints.kind, strict=True) if k in PLAIN]
        self._scene = Scene.of(batch, robot, batch.rest())

    def settle(self, values: Mapping[str, float]) -> dict[str, float] | None:
        """Where the joints come to rest from there by themselves: what carries more than it rubs, or is drawn by more, goes on to an end
        of its range, or to where it is less. None where there is no such end."""
        joints, state = self.batch.joints(), self._state(values)
        low, high = np.asarray(joints.low), np.asarray(joints.high)
        free = np.asarray(joints.mimic) < 0
        free &= np.isin(joints.name, self.order)
        step = np.where(np.isnan(high - low), _ENDLESS, high - low) / _FALLS
        least, before = step / _FALLS, np.zeros(len(step))
        for _ in range(_STEPS):
            scene = self._at(state)
            way = -np.sign(scene.weighs) * (np.abs(scene.weighs) > scene.rubs) * free
            if self.batch.gates is not None:
                way[self.batch.gates.joint[self.batch.gates.held(state)]] = 0.0
            step = np.where(way * before < 0, step / 2, step)  # it has gone too far
            way[step < least] = 0.0
            before = np.where(way != 0.0, way, before)
            gone = np.fmin(np.fmax(state + way * step, low), high)  # a limit that is not there is nan
            moved = (way != 0.0) & (gone != state)
            if not moved.any():
                return dict(zip(self.names, state.tolist(), strict=True))
            state = self.batch.settle(np.where(moved, gone, state))
        return None

    def run(self, trial: Trial, values: Mapping[str, float]) -> Outcome:
        """One trial from these joint values, at which the object is still."""
        state = self._state(values)
        told = foretell(self._at(state), [trial], self.unit, self.groups)
        row, gone = told.paths.row[0], told.paths.gone[0]
        after = state.copy()
        after[row[row >= 0]] += gone[row >= 0]
        joints = self.batch.joints()
        after = np.fmin(np.fmax(after, joints.low), joints.high)
        after = follow(joints, after) if self.batch.loops is None else self.batch.loops.settle(after)
        start, end = (self._place(trial, known) for known in (state, after))
        fault = BLOCKED if told.why[0] == BLOCKED else ""
        return Outcome(fault, dict(zip(self.names, after.tolist(), strict=True)), start, end)

    def _state(self, values: Mapping[str, float]) -> np.ndarray:
        return np.array([values.get(name, rest) for name, rest in zip(self.names, self.batch.rest(), strict=True)])

    def _at(self, state: np.ndarray) -> Scene:
        return replace(self._scene, state=state, weighs=weights(self.batch, self.robot, state))

    def _place(self, trial: Trial, state: np.ndarray) -> np.ndarray:
        turn, shift = link_motion(self.batch.links(), self.batch.joints(), state)
        return turn[trial.link] @ trial.point + shift[trial.link]
