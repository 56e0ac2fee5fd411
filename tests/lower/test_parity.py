"""Regions of lines and quarters of ellipses in closed form: the side and at most the distance of the general way."""

import numpy as np
import pytest

from artipg_dsl.graph import expr as E
from artipg_dsl.graph.formula import compile_formula

from .test_operators import lowered

POT = """
primitive Pot {
  param belly : length > 0  test 7cm .. 12cm
  param mouth : length > 0  test 3cm .. 14cm               # wider or narrower than the belly
  param height : length > 0  test 9cm .. 20cm
  param wall : length > 0  test 1mm .. 4mm
  curve base   (v in 0 .. 1) = [belly * v, 0mm]
  curve skin   (v in 0turn .. 0.25turn) = [mouth + (belly - mouth) * cos(v), height * sin(v)]
  curve floor  (v in 0 .. 1) = [(belly - wall) * v, wall]
  curve lining (v in 0turn .. 0.25turn) = [mouth - wall + (belly - mouth) * cos(v), wall + (height - wall) * sin(v)]
  solid = lathe([base, skin], [floor, lining]) about z
}
"""
RING = """
primitive Ring {
  param long  : length > 0  test 3cm .. 6cm
  param broad : length > 0  test 3cm .. 5cm
  curve outer (u in 0turn .. 1turn) = [long * cos(u), broad * sin(u)]
  curve inner (u in 0turn .. 1turn) = [0.7 * long * cos(u), 0.8 * broad * sin(u)]
  solid = extrude(outer, inner) along z from 0 to 1cm
}
"""


def inside(text):
    primitive = lowered(text).primitive
    return compile_formula((primitive.inside,), (*primitive.parameters, "p.x", "p.y", "p.z")), primitive


def pot(belly, mouth, height, wall):
    v = np.linspace(0, np.pi / 2, 1500)
    skin = [mouth + (belly - mouth) * np.cos(v), height * np.sin(v)]
    lining = [mouth - wall + (belly - mouth) * np.cos(v), wall + (height - wall) * np.sin(v)]
    return [np.concatenate([[[0.0, 0.0]], np.transpose(skin), np.transpose(lining)[::-1], [[0.0, wall]]])]


def ring(long, broad):
    u = np.linspace(0, 2 * np.pi, 3000)
    return [np.stack([a * long * np.cos(u), b * broad * np.sin(u)], axis=1) for a, b in ((1.0, 1.0), (0.7, 0.8))]


def crossings(polygon, x, y):
    """How often a ray to +x from places (m,) crosses a polygon (n, 2), and how near its corners are."""
    (x0, y0), (x1, y1) = polygon.T[:, :, None], np.roll(polygon, -1, axis=0).T[:, :, None]
    passed = (y0 <= y) != (y1 <= y)
    at = x0 + (y - y0) * (x1 - x0) / np.where(y1 == y0, 1.0, y1 - y0)
    return (passed & (x < at)).sum(axis=0), np.sqrt(((x0 - x) ** 2 + (y0 - y) ** 2).min(axis=0))


@pytest.mark.parametrize("text, outline", [(POT, pot), (RING, ring)], ids=["pot", "ring"])
def test_the_closed_form_agrees_with_fine_polygons(text, outline):
    closed, primitive = inside(text)
    rng = np.random.default_rng(5)
    for _ in range(6):
        values = [rng.uniform(low, high) for low, high in primitive.test]
        p = rng.uniform(-0.15, 0.15, (3, 600))
        p[2] = rng.uniform(-0.02, 0.22, 600) if text is POT else 0.005
        x, y = (np.hypot(p[0], p[1]), p[2]) if text is POT else (p[0], p[1])
        found = [crossings(polygon, x, y) for polygon in outline(*values)]
        within, near = sum(f[0] for f in found) % 2 == 1, np.minimum.reduce([f[1] for f in found])
        value = closed(*values, *p)[0]
        sure = near > 1e-3
        assert ((value < 0) == within)[sure].all() and within.any()
        assert (np.abs(value) <= near + 1e-3).all() and (np.abs(value) > 0.15 * np.minimum(near, 5e-3) - 1e-3).all()


def test_levels_of_corners_are_crossed_once():
    closed, primitive = inside(POT)
    values = [np.full(7, v) for v in (0.1, 0.05, 0.15, 0.002)]
    x = np.array([0.0, 0.03, 0.0485, 0.0495, 0.06, 0.09, 0.11])
    top = closed(*values, x, 0 * x, np.full(7, 0.15))[0]
    assert (top > 0)[[0, 1, 4, 5, 6]].all() and (np.abs(top[2:4]) < 1e-3).all()
    floor = closed(*values, x, 0 * x, np.full(7, 0.001))[0]
    assert (floor < 0)[:6].all() and floor[6] > 0
    below = closed(*values, x, 0 * x, np.full(7, -1e-9))[0]
    assert (below > 0).all()


def test_other_curves_are_left_to_the_general_way():
    egg = RING.replace("long * cos(u), broad", "long * cos(u) + 5mm * cos(2 * u), broad", 1)
    assert len(list(E.nodes(lowered(RING).primitive.inside))) < len(list(E.nodes(lowered(egg).primitive.inside))) / 4
