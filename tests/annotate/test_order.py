"""Points stand in a drawn order: the first k of n are a sample of the surface, as good as any other k."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl import random


def odds(values: np.ndarray, k: int) -> float:
    """How far the first k of n values in a row (P, n) are from a random choice of k: chi-square by its freedom."""
    total = freedom = 0.0
    n = values.shape[1]
    for row in values:
        _, which, count = np.unique(row, return_inverse=True, return_counts=True)
        had = np.bincount(which[:k], minlength=len(count))
        expected = count * k / n
        usual = expected >= 5
        spread = expected * (1 - k / n)  # of a choice without putting back
        total += float(((had - expected)[usual] ** 2 / spread[usual]).sum())
        freedom += max(int(usual.sum()) - 1, 1)
    return total / freedom


@pytest.fixture(scope="module")
def samples() -> apg.Samples:
    return apg.sample("Microwave", n=12, seed=3, checked=False)


@pytest.mark.parametrize("how", [{}, {"per": "link"}, {"spread": "blue"}], ids=["object", "link", "blue"])
def test_a_prefix_is_a_sample(samples: apg.Samples, how: dict[str, str]) -> None:
    points = samples.points(2048, **how)
    for name in ("semantic", "primitive", "link"):
        if how != {"per": "link"} or name == "primitive":
            assert odds(getattr(points, name), 1024) < 1.6, name
    assert len(np.unique(points.semantic[0, :256])) >= 0.7 * len(np.unique(points.semantic[0]))


def test_clouds_of_views_too(samples: apg.Samples) -> None:
    views = samples.views(2, width=160, height=120, points=1024)
    assert odds(views.cloud["link"].reshape(-1, 1024), 256) < 1.8
    rows = views.cloud["pixel"][..., 0].reshape(-1, 1024)
    assert odds(rows // 20, 256) < 1.8


def test_an_object_alone_has_the_order_that_it_has_in_a_batch() -> None:
    whole = apg.sample("Kettle", numbers=[3, 37, 40], seed=5, checked=False).points(500)
    alone = apg.sample("Kettle", numbers=[37], seed=5, checked=False).points(500)
    for name in (
        "position",
        "normal",
        "semantic",
        "instance",
        "link",
        "npcs",
        "primitive",
        "element",
        "patch",
        "u",
        "v",
    ):
        assert getattr(whole, name)[1].tobytes() == getattr(alone, name)[0].tobytes(), name
    assert all(whole.labels[name][1].tobytes() == alone.labels[name][0].tobytes() for name in whole.labels)


@pytest.mark.parametrize("n", [1, 2, 3, 1000, 20_000])
def test_orders_are_permutations_and_addressed(n: int) -> None:
    streams = random.streams(random.key(1, "points"), np.arange(7, dtype=np.uint64), 5)
    found = random.orders(streams, n)
    assert np.array_equal(np.sort(found, axis=1), np.tile(np.arange(n), (7, 1)))
    assert np.array_equal(found[4:5], random.orders(streams[4:5], n))
    if n >= 1000:
        assert len(np.unique(found[:, 0])) > 3
        assert abs(np.corrcoef(found[0], np.arange(n))[0, 1]) < 4 / np.sqrt(n)
