"""Which triangles are nearest in a picture: compiled code finds those that NumPy finds."""

import numpy as np

from artipg_dsl.native import covers
from artipg_dsl.view.raster_cpu import rasterise

from .machine import bits, needs_compiler

pytestmark = needs_compiler


def test_the_same_triangles_are_nearest(using, monkeypatch):
    chance = np.random.default_rng(4)
    triangles = chance.uniform(-8.0, 40.0, (200, 1, 2)) + chance.normal(0.0, 5.0, (200, 3, 2))
    nearness = chance.uniform(-0.1, 1.0, (200, 3))  # behind the eye as well
    triangles[:20], nearness[:20] = triangles[20:40], nearness[20:40]  # one over the other
    triangles[40:60, 2] = triangles[40:60, 1]  # seen from the edge
    cover, calls, found = covers.cover, [], []
    monkeypatch.setattr(covers, "cover", lambda *a: calls.append(len(a[1])) or cover(*a))
    for backend in ("numpy", "c"):
        using(backend)
        found.append(rasterise(triangles, nearness, 32))
    assert calls == [200]
    for one, other in zip(*found, strict=True):
        assert bits(one) == bits(other)
    assert 50 < len(np.unique(found[0][0])) and 0.5 < (found[0][0] >= 0).mean() < 1.0
