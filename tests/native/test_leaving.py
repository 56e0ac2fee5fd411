"""What can be seen from without: compiled code finds the rays that leave which NumPy finds."""

import pytest

from artipg_dsl.api import sample
from artipg_dsl.native import leaving

from .machine import bits, needs_compiler

pytestmark = needs_compiler


@pytest.mark.some
@pytest.mark.parametrize("category", ["Microwave", "Kettle"])
def test_the_same_is_seen(using, monkeypatch, category):
    free, calls, found = leaving.free, [], []
    monkeypatch.setattr(leaving, "free", lambda *a: calls.append(a[4][2] is not None) or free(*a))
    for backend in ("numpy", "c"):
        using(backend)
        points = sample(category, 2, seed=5).points(500, surface="outside")
        found.append((points.position, points.normal, points.patch))
        assert bool(calls) == (backend == "c")
    for one, other in zip(*found, strict=True):
        assert bits(one) == bits(other)
    assert set(calls) == {False, True}, "from hollow surfaces rays are asked once more"
