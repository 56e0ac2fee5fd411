"""The nearest of points in many sets: compiled code finds what SciPy does, at the same distances to the bit."""

import numpy as np
import pytest

from artipg_dsl.geometry.nearest import Nearest
from artipg_dsl.native.near import Forest

from .machine import bits, needs_compiler

pytestmark = needs_compiler


@pytest.mark.parametrize("axes", [3, 6])
def test_what_is_nearest_is_found(machine, axes):
    """Sets of many points and of few, one of copies of one point, and one that is asked for though it has none."""
    chance = np.random.default_rng(axes)
    points, of = chance.random((9_000, axes)), np.sort(chance.integers(4, size=9_000) ** 2)
    points[of == 9] = points[of == 9][:1]
    asked, sets = 1.4 * chance.random((2_000, axes)) - 0.2, chance.choice([0, 1, 4], size=2_000)
    forest, trees = Forest(machine, points, of), Nearest(points, of, 1e3)
    for within in (np.inf, 0.1):
        (apart, found), (distance, index) = forest.nearest(asked, sets, within=within), trees.find(asked, sets, within)
        assert bits(apart[:, 0]) == bits(distance) and bits(found[:, 0]) == bits(index)
    assert 0.0 < np.isinf(distance).mean() < 1.0
    assert bits(forest.nearest(asked, sets, 12)[1]) == bits(trees.several(asked, sets, 12))
    copies, _ = forest.nearest(asked[:5], np.full(5, 9), 2)
    assert (copies[:, 0] == copies[:, 1]).all()
    assert np.isinf(forest.nearest(asked[:5], np.array([2, 3, 8, 10, 99]))[0]).all()


def test_few_points_are_not_filled_up(machine):
    forest = Forest(machine, np.eye(3), np.array([0, 0, 1]))
    apart, found = forest.nearest(np.zeros((1, 3)), np.array([0]), 4)
    assert sorted(found[0, :2].tolist()) == [0, 1] and (found[0, 2:] == 3).all() and np.isinf(apart[0, 2:]).all()
