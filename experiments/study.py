"""What all experiments share: ways of training (arms), judged on real objects that a network has not seen, fold by fold, with several seeds.

What is compared are means over the seeds, object by object (``scores.paired_test``).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from .clouds import Clouds
from .scores import paired_test

Network = TypeVar("Network")
Scores = dict[str, np.ndarray]


@dataclass(frozen=True, slots=True)
class Arm:
    """A way of training, which all take as many steps of as many clouds: as many of each of the ``sources``; ``warped``: half of the
    clouds are warped locally."""

    sources: tuple[str, ...]
    warped: bool = False


@dataclass(frozen=True, slots=True)
class Metric:
    """``title`` in tables, where it is told times ``scale`` with ``digits``; ``better``: "higher" or "lower"."""

    title: str
    better: str
    scale: float = 100.0
    digits: int = 1


def folds_of(real: Clouds, folds: int) -> np.ndarray:
    """(K,) the fold in which each cloud is held out: objects in turn, so that those of a category are spread, an object with all its clouds."""
    return np.unique(real.origin, return_inverse=True)[1] % folds


def run(
    real: Clouds,
    sources: Mapping[str, Clouds],
    arms: Mapping[str, Arm],
    train: Callable[[Arm, Sequence[Clouds], list[int]], Network],
    judge: Callable[[Network, Clouds, int], Scores],
    seeds: int,
    folds: int,
    tell: Callable[[str], None] = print,
) -> dict[str, Scores]:
    """Per arm and metric (seeds, K): every cloud of ``real``, by a network that has seen neither its object nor anything made from it.

    ``train(arm, clouds of each source, numbers of a seed)`` gives a network, ``judge(network, clouds, seed)`` the metrics (k,) of some
    objects. An arm that sees nothing made from a real object is trained once for all folds.
    """
    found: dict[str, Scores] = {arm: {} for arm in arms}
    fold = folds_of(real, folds)
    for seed in range(seeds):
        for k in range(folds):
            held = np.flatnonzero(fold == k)
            for name, arm in arms.items():
                once = not any(sources[s].of_real for s in arm.sources)
                if once and k:
                    continue
                tested = np.arange(len(real)) if once else held
                seen = [left for s in arm.sources if len(left := sources[s].without(real.origin[held]))]
                network = train(arm, seen, [seed] if once else [seed, k])
                for metric, values in judge(network, real.take(tested), seed).items():
                    found[name].setdefault(metric, np.zeros((seeds, len(real))))[seed, tested] = values
                means = ", ".join(
                    f"{metric} {values[seed, tested].mean():.4f}" for metric, values in found[name].items()
                )
                tell(f"seed {seed}{'' if once else f', fold {k}'}: {name}: {means}")
    return found


def by_object(real: Clouds, found: Mapping[str, Scores]) -> tuple[list[str], dict[str, Scores]]:
    """The names of the real objects (N), and their means over their clouds: per arm and metric (seeds, N)."""
    _, first, which = np.unique(real.origin, return_index=True, return_inverse=True)
    share = (which == np.arange(len(first))[:, None]) / np.bincount(which)[:, None]
    means = {
        arm: {metric: (values[:, None] * share).sum(axis=-1) for metric, values in scores.items()}
        for arm, scores in found.items()
    }
    return [real.names[k] for k in first], means


def summarise(
    names: Sequence[str], found: Mapping[str, Scores], metrics: Mapping[str, Metric], pairs: Sequence[tuple[str, str]]
) -> dict[str, Any]:
    """What is written to the file of results: each arm's means, and paired tests over the objects."""
    arms: dict[str, Any] = {}
    for arm, scores in found.items():
        arms[arm] = {
            metric: {
                "mean": _short(values.mean()),
                "over_seeds": [_short(v) for v in values.mean(axis=1)],
                "objects": dict(zip(names, map(_short, values.mean(axis=0)), strict=True)),
            }
            for metric, values in scores.items()
        }
    return {
        "metrics": {
            name: {"title": m.title, "better": m.better, "scale": m.scale, "digits": m.digits}
            for name, m in metrics.items()
        },
        "arms": arms,
        "pairs": [
            {
                "one": one,
                "other": other,
                "metric": metric,
                **compare(found[one][metric], found[other][metric], told.better),
            }
            for metric, told in metrics.items()
            for one, other in pairs
        ],
    }


def compare(one: np.ndarray, other: np.ndarray, better: str) -> dict[str, Any]:
    """Two arms (seeds, K) on the same objects: mean difference, on how many objects the first is better, two-sided p."""
    a, b = one.mean(axis=0), other.mean(axis=0)
    sign = 1.0 if better == "higher" else -1.0
    return {
        "difference": _short((a - b).mean()),
        "better_on": int((sign * (a - b) > 0).sum()),
        "of": len(a),
        "p": round(paired_test(a, b), 4),
    }


def _short(value: float) -> float:
    return float(f"{value:.5g}")
