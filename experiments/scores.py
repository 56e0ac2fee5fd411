"""How well points are told apart, and whether one way of training is better than another on the same objects."""

from __future__ import annotations

import numpy as np


def mean_iou(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """(K,): intersection over union of what moves and of what does not, (K, n) bool each, their mean; a class that both lack counts 1."""
    each = []
    for a, b in ((found, truth), (~found, ~truth)):
        both, either = (a & b).sum(axis=1), (a | b).sum(axis=1)
        each.append(np.where(either == 0, 1.0, both / np.maximum(either, 1)))
    return np.mean(each, axis=0)


def paired_test(one: np.ndarray, other: np.ndarray, rounds: int = 100_000, seed: int = 0) -> float:
    """The share of random signs of the differences (K,) whose mean is at least as far from 0: a two-sided permutation test."""
    difference = one - other
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(rounds, len(difference)))
    means = np.abs((signs * difference).mean(axis=1))
    return float((1 + (means >= abs(difference.mean()) - 1e-12).sum()) / (rounds + 1))
