"""Sampling from the declared distributions, restricted to what is valid.

Drawing in sequence, each variable in the range that the ones before leave it, never draws in vain, but it draws objects
whose ranges are narrow more often than their declaration says: by the inverse of the weight that ``Batch.log_weight`` tells.
Here every object considers several attempts and takes one with a probability proportional to its weight (sampling and
importance resampling: Rubin 1987), by the largest of log-weight plus Gumbel noise, which is addressed like every draw: an
object does not depend on which others are made. What is left of the shift falls with one over the number of candidates.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..random import key, uniform
from ..runtime.batch import Batch
from ..runtime.kernels import State
from ..runtime.plan import Plan

CANDIDATES = 32  # attempts that an object considers
MOST_CANDIDATES = 4096
_ROUNDS = 4  # times so many, where none of them is valid
BLOCK = 4096  # attempts evaluated together


class Resampling:
    """Chooses the attempt of each object. ``made(numbers, attempts)`` gives a batch, ``colliding`` its objects at fault."""

    def __init__(
        self,
        plan: Plan,
        seed: int,
        given: dict[int, float],
        candidates: int,
        made: Callable[[np.ndarray, np.ndarray], Batch],
        colliding: Callable[[Batch], np.ndarray] | None,
    ):
        self.plan, self.seed, self.given, self.candidates = plan, seed, given, candidates
        self.made, self.colliding = made, colliding
        self.states: list[State] = []  # what was evaluated, to be counted
        self.effective = 0.0
        self.valid = 0

    def attempts(self, numbers: np.ndarray) -> np.ndarray:
        """The attempt (len(numbers),) chosen for each object; -1 where no candidate is valid. A few at a time."""
        found = np.full(len(numbers), -1, dtype=np.int64)
        for block in range(_ROUNDS):
            left = np.flatnonzero(found < 0)
            if len(left):
                found[left] = self.among(numbers[left], block * self.candidates)
        return found

    def among(self, numbers: np.ndarray, first: int) -> np.ndarray:
        """The choice among the candidates from attempt ``first`` on."""
        count = self.candidates
        objects = np.repeat(numbers, count)
        attempt = np.tile(np.arange(first, first + count), len(numbers))
        state = State(self.seed, objects, attempt, dict(self.given), weigh=True)
        self.plan.bare.function(state)
        self.states.append(state)
        score = np.where(state.failed, -np.inf, state.log_weight - state.leaning).reshape(-1, count)
        self.valid += int((~state.failed).sum())
        self.effective += float(count_effective(score).sum())
        lot = uniform(key(self.seed, "prior"), objects.astype(np.uint64), 0, attempt)
        return self.best(numbers, first, score - np.log(-np.log(lot)).reshape(-1, count))

    def best(self, numbers: np.ndarray, first: int, score: np.ndarray) -> np.ndarray:
        """The candidate of the highest score, of those that do not collide."""
        found = np.full(len(numbers), -1, dtype=np.int64)
        left = np.arange(len(numbers))
        while len(left):
            left = left[np.isfinite(score[left]).any(axis=1)]
            found[left] = first + np.argmax(score[left], axis=1)
            if self.colliding is None or not len(left):
                break
            struck = left[self.colliding(self.made(numbers[left], found[left]))]
            score[struck, found[struck] - first] = -np.inf
            found[struck] = -1
            left = struck
        return found


def count_effective(log_weights: np.ndarray) -> np.ndarray:
    """The effective sample size (sum w)^2 / sum w^2 of each row of log-weights (rows, candidates); 0 where all are -inf."""
    top = log_weights.max(axis=1, keepdims=True)
    weight = np.exp(log_weights - np.where(np.isfinite(top), top, 0.0))
    square = (weight * weight).sum(axis=1)
    return np.where(square > 0.0, weight.sum(axis=1) ** 2 / np.where(square > 0.0, square, 1.0), 0.0)
