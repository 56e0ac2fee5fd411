"""Convex hulls: compiled code and NumPy tell the same corners and faces."""

import numpy as np
import pytest

from artipg_dsl.geometry import wrap
from artipg_dsl.geometry.hulls import fits, hull_of
from artipg_dsl.geometry.wrap import wrap_all

from .machine import bits, needs_compiler


def sets():
    lots = np.random.Generator(np.random.PCG64(11))
    turn = 0.1 * np.arange(9)
    for k in range(60):
        yield lots.normal(size=(4 + 5 * k, 3)) * lots.uniform(0.001, 1.0, size=3)
        yield np.round(lots.uniform(size=(30, 3)), 1)  # many in one plane, on one line, and twice
        radii, heights = 1.0 - 0.1 * (np.arange(6) % 2), np.linspace(0.0, lots.uniform(0.1, 2.0), 6)
        ring = [(r * np.cos(a + k), r * np.sin(a + k), h) for r, h in zip(radii, heights, strict=True) for a in turn]
        yield np.array(ring)  # steps of a wall


@needs_compiler
def test_hulls_are_the_same(machine, using):
    every = list(sets())
    found = []
    for name in ("numpy", "c"):
        using(name)
        found.append([tuple(map(bits, pair)) for pair in wrap_all(every)])
    assert found[0] == found[1]


@needs_compiler
def test_the_same_points_fit(machine, using):
    """Points that are moved by next to nothing up to far out of a face, one of them inside the hull, and some that are no numbers."""
    lots = np.random.Generator(np.random.PCG64(12))
    points = np.concatenate([lots.normal(size=(20, 3)), np.zeros((1, 3))])
    hull = hull_of(points)
    moved = points + 10.0 ** lots.uniform(-9, 0.5, (400, 1, 1)) * lots.normal(size=(400, *points.shape))
    moved[0, 3], moved[1, 5, 2], moved[2] = np.nan, np.nan, 0.0
    found = []
    for name in ("numpy", "c"):
        using(name)
        found.append(fits(moved, hull))
    assert (
        bits(found[0]) == bits(found[1])
        and 100 < found[0].sum() < 300
        and found[0][:3].tolist() == [False, False, True]
    )


@needs_compiler
def test_most_hulls_are_found_by_compiled_code(machine, using, monkeypatch):
    left = []
    plain = wrap._beyond_doubt
    monkeypatch.setattr(wrap, "_beyond_doubt", lambda points: left.append(len(points)) or plain(points))
    using("c")
    every = list(sets())
    wrap_all(every)
    assert len(left) < len(every) / 5


@needs_compiler
@pytest.mark.parametrize("bend", [0.0, 1e-5, -1e-5])
def test_pieces_need_no_qhull_where_faces_hardly_bend(using, monkeypatch, bend):
    """Not even where the points are moved by as much as they bend."""
    monkeypatch.setattr(wrap, "_hull", lambda _: pytest.fail("Qhull was asked"))
    using("c")
    box = np.array([(x, y, z) for x in (0.0, 3.0) for y in (0.0, 2.0) for z in (0.0, 1.0)])
    box[7, 2] += bend
    assert len(hull_of(box).faces) == 12
