"""Patches told flat from bent, solids told convex, fractions compared two at a time."""

import numpy as np

from artipg_dsl.geometry.flat import BENT, PARALLEL, PLANAR, convex, shapes
from artipg_dsl.geometry.hidden import _SIGNS, pack_fractions
from artipg_dsl.geometry.patches import surfaces

from . import shapes as made


def kinds(primitive):
    return dict(zip([s.name for s in surfaces(primitive)], shapes(primitive).tolist(), strict=True))


def test_faces_of_a_box_are_parallelograms():
    assert set(kinds(made.cuboid()).values()) == {PARALLEL}


def test_a_cylinder_is_bent_everywhere():
    assert set(kinds(made.cylinder()).values()) == {BENT}


def test_a_trapezoid_is_planar_and_a_twisted_quad_is_bent():
    x, y, z = made.size()
    u, v = made.var("u"), made.var("v")
    box = made.cuboid()
    bottom = box.patches[4]
    slanted = made.patch("bottom", ((u - 0.5) * x, (0.5 - v) * y * (u + 1.0), -z / 2))
    twisted = made.patch("bottom", ((u - 0.5) * x, (0.5 - v) * y, -z / 2 + u * v * z))
    for patch, kind in ((bottom, PARALLEL), (slanted, PLANAR), (twisted, BENT)):
        patches = (*box.patches[:4], patch, box.patches[5])
        assert shapes(made.cuboid(patches=patches))[4] == kind


def test_convex_is_what_has_no_pieces_and_no_hollow():
    assert convex(made.cuboid()) and convex(made.cylinder()) and convex(made.rounded_cuboid())
    assert not convex(made.sleeve())
    assert not convex(made.sleeve(pieces=()))


def test_packed_fractions_tell_every_place_within_bounds():
    generator = np.random.default_rng(0)
    u, v, low_u, low_v, high_u, high_v = generator.random((6, 20_000))
    within = (low_u <= u) & (u <= high_u) & (low_v <= v) & (v <= high_v)
    spot = pack_fractions(u, v)
    told = (((spot - pack_fractions(low_u, low_v)) | (pack_fractions(high_u, high_v) - spot)) & _SIGNS) == 0
    assert told[within].all() and within.sum() > 100
    assert (told & ~within).sum() < 20  # rounding alone
