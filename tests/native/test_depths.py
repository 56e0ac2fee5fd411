"""What of clouds can be seen: compiled code draws the depth pictures that NumPy does, to the last bit."""

import numpy as np
import pytest

from artipg_dsl.fit import outer
from artipg_dsl.native import depths

from .machine import bits, needs_compiler

pytestmark = needs_compiler


def boxes(count: int, n: int) -> np.ndarray:
    """Points on boxes within boxes."""
    chance = np.random.default_rng(n)
    points = chance.random((count, n, 3)) - 0.5
    points[np.arange(count)[:, None], np.arange(n), chance.integers(3, size=(count, n))] = 0.5
    points[:, : n // 3] *= 0.4
    return points * chance.uniform(0.2, 2.0, (count, 1, 3))


@pytest.mark.parametrize("hidden", [False, True])
def test_the_same_is_seen(using, monkeypatch, hidden):
    clouds, points = boxes(3, 3_000), 0.9 * boxes(40, 500)
    target, calls, found = np.arange(40) % 3, [], []
    for word in ("pictures", "sides"):
        original = getattr(depths, word)
        monkeypatch.setattr(depths, word, lambda *a, of=original, called=word: calls.append(called) or of(*a))
    for backend in ("numpy", "c"):
        using(backend)
        assert (backend == "c") or not calls
        screens = outer.Screens(clouds, outer.spacing(clouds))
        seen = screens.outer(points, target) if hidden else outer.outer(points)
        found.append((seen, outer.towards(clouds[0], 0.02), screens.least, screens.front))
    for one, other in zip(*found, strict=True):
        assert bits(one) == bits(other)
    assert set(calls) == {"pictures", "sides"} and 0.1 < found[0][0].mean() < 1.0
