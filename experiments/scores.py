"""How well points are told apart, and whether one way of training is better than another on the same objects."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree


def mean_iou(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """(K,): intersection over union of what moves and of what does not, (K, n) bool each, their mean; a class that both lack counts 1."""
    each = []
    for a, b in ((found, truth), (~found, ~truth)):
        both, either = (a & b).sum(axis=1), (a | b).sum(axis=1)
        each.append(np.where(either == 0, 1.0, both / np.maximum(either, 1)))
    return np.mean(each, axis=0)


def f1_score(found: np.ndarray, truth: np.ndarray) -> float:
    """Harmonic mean of precision and recall of what was found, bool arrays of one shape; 1 if nothing was to be found, and nothing was."""
    both, all_of_both = int((found & truth).sum()), int(found.sum()) + int(truth.sum())
    return 2 * both / all_of_both if all_of_both else 1.0


def _apart(found: np.ndarray, truth: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """For each of K pairs of clouds the distances of either's points from the nearest of the other."""
    return [(cKDTree(b).query(a)[0], cKDTree(a).query(b)[0]) for a, b in zip(found, truth, strict=True)]


def chamfer_l1(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """(K,) half the sum of both mean distances between clouds (K, n, 3), (K, m, 3), as SnowflakeNet and PoinTr have it without their factor."""
    return np.array([(a.mean() + b.mean()) / 2 for a, b in _apart(found, truth)])


def f_score(found: np.ndarray, truth: np.ndarray, near: float) -> np.ndarray:
    """(K,) harmonic mean of the shares of found points near the truth and of true points near what was found."""
    shares = [((a < near).mean(), (b < near).mean()) for a, b in _apart(found, truth)]
    return np.array([2 * p * r / max(p + r, 1e-12) for p, r in shares])


def paired_test(one: np.ndarray, other: np.ndarray, rounds: int = 100_000, seed: int = 0) -> float:
    """The share of random signs of the differences (K,) whose mean is at least as far from 0: a two-sided permutation test."""
    difference = one - other
    signs = np.random.default_rng(seed).choice([-1.0, 1.0], size=(rounds, len(difference)))
    means = np.abs((signs * difference).mean(axis=1))
    return float((1 + (means >= abs(difference.mean()) - 1e-12).sum()) / (rounds + 1))
