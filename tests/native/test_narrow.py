"""Convex bodies: compiled code says what NumPy says of them, to the last bit."""

import numpy as np
import pytest

from artipg_dsl.geometry import collide
from artipg_dsl.geometry.collide import Corners
from artipg_dsl.geometry.quadrature import volume_inertia
from artipg_dsl.geometry.sites import weigh
from artipg_dsl.session import Session
from artipg_dsl.validity.bodies import Pieces, Placed

from .machine import bits, needs_compiler

pytestmark = needs_compiler


def both(using, function):
    found = []
    for name in ("numpy", "c"):
        using(name)
        found.append(function())
    return found


def same(one, other):
    return [bits(a) for a in one] == [bits(b) for b in other]


@pytest.mark.parametrize("round_", [0.0, 0.5, 1.0])
def test_points_of_tetrahedra_nearest_the_origin(using, round_):
    """Of all kinds: ordinary ones, flat ones, with corners that coincide, with the origin within or on a face."""
    lots = np.random.Generator(np.random.PCG64(1))
    simplex = lots.normal(size=(6000, 4, 3)) + lots.uniform(0, 2, (6000, 1, 1)) * lots.normal(size=(6000, 1, 3))
    simplex = np.round(simplex / round_) * round_ if round_ else simplex
    simplex[::5, 3] = simplex[::5, 2]
    simplex[::7, 1] = simplex[::7, 0]
    simplex[::9] = simplex[::9, :1]
    one, other = both(using, lambda: collide._closest(simplex))
    assert same(one, other)
    assert len(np.unique((one[1] > 0).sum(axis=1))) >= 3


def bodies(lots, count):
    return lots.normal(size=(count, 8, 3)) * lots.uniform(0.2, 1.0, (count, 1, 3)) + lots.normal(size=(count, 1, 3))


@pytest.mark.parametrize("near", [0.0, 0.5, 0.99])
def test_bodies_that_overlap_and_bodies_that_do_not(using, near):
    lots = np.random.Generator(np.random.PCG64(2))
    first, second = bodies(lots, 3000), bodies(lots, 3000)
    second[::10] = first[::10] + (2.0, 0.0, 0.0)
    second[1::10] = first[1::10]
    first[2::10] = np.round(first[2::10])
    second[2::10] = np.round(second[2::10])
    one, other = both(using, lambda: collide.separate(Corners(first), Corners(second), near))
    assert same(one, other) and 0.1 < one[0].mean() < 0.9


@pytest.mark.parametrize("margin", [5e-7, 1e-3])
def test_faces_moved_inwards(using, margin):
    """Pieces whose faces run outwards and inwards, flat and pointed ones, and corners that no face has."""
    lots = np.random.Generator(np.random.PCG64(3))
    cube = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    faces = np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4]]
    )
    points = cube * 10.0 ** lots.uniform(-4, 0, (500, 1, 3)) + lots.normal(size=(500, 1, 3))
    points[::7, :, 2] = 0.5
    points[1::9] = np.round(points[1::9], 1)
    every = faces + 8 * np.arange(500)[:, None, None]
    every[::3] = every[::3, :, ::-1]
    first = 8 * np.arange(500)
    one, other = both(using, lambda: collide.inset(points.reshape(-1, 3), first, every.reshape(-1, 3), margin))
    assert bits(one) == bits(other) and (one != points.reshape(-1, 3)).any()


def pieces(lots, kinds=(4, 8, 16), count=200):
    corners = [lots.normal(size=(count, many, 3)) for many in kinds]
    kind = lots.integers(0, len(kinds), 500)
    slot = lots.integers(0, count, 500)
    ends = [(corners[k][s].min(axis=0), corners[k][s].max(axis=0)) for k, s in zip(kind, slot, strict=True)]
    low, high = (np.array(end) for end in zip(*ends, strict=True))
    every = np.zeros(500, dtype=np.int64)
    return Pieces(corners, [], [], kind, slot, low, high, every, every, every, every, every, every, every)


@pytest.mark.parametrize("how", ["rest", "turned", "swept"])
def test_pieces_that_move(using, how):
    lots = np.random.Generator(np.random.PCG64(3))
    some = pieces(lots)
    piece, other = lots.integers(0, 500, (2, 2000))
    turn = np.linalg.qr(lots.normal(size=(2000, 3, 3)))[0]
    shift, end = 3.0 * lots.normal(size=(2, 2000, 3))
    moved = {
        "rest": Placed(some, piece),
        "turned": Placed(some, piece, turn, shift),
        "swept": Placed(some, piece, ends=(shift, end)),
    }[how]
    one, two = both(using, lambda: collide.separate(moved, Placed(some, other)))
    assert same(one, two)
    assert 0.02 < one[0].mean() < 0.99 or how == "rest"


def test_no_pairs(using):
    nobody = Corners(np.zeros((0, 8, 3)))
    one, other = both(using, lambda: collide.overlap(nobody, nobody))
    assert len(one) == len(other) == 0


@pytest.mark.parametrize("category", [pytest.param("USB", marks=pytest.mark.slow), "Chair"])
def test_moments_of_solids(using, category):
    """The moments of all primitives, for each row by itself and for one of those that are alike."""
    found = []
    for name in ("numpy", "c"):
        using(name)
        tables = [table for table in Session.of(category).sampler.batch(np.arange(3), 3).sites() if len(table)]
        weigh(tables)
        found.append([[bits(column) for column in table.moments] for table in tables])
        weighed = [[bits(column) for column in volume_inertia(t.primitive, t.params)] for t in tables]
        assert weighed == found[-1]
    assert found[0] == found[1]
