"""Faces that instances of a piece share: convex for each of them, whichever way they bend."""

import numpy as np
import pytest

from artipg_dsl.geometry.hulls import NoHullError, distinct_hulls, distinct_together, fits, hull_of, which_fits

BOX = np.array([(x, y, z) for x in (0.0, 3.0) for y in (0.0, 2.0) for z in (0.0, 1.0)])
RIDGE, VALLEY = BOX.copy(), BOX.copy()  # the top bends along one of its diagonals or along the other
RIDGE[7, 2] += 1e-5
VALLEY[7, 2] -= 1e-5
FLAT = BOX * (1, 1, 0) + BOX[:, :1] * (0, 0, 1)


@pytest.mark.parametrize("points", [RIDGE, VALLEY])
def test_faces_that_hardly_bend_bend_the_right_way(points: np.ndarray) -> None:
    """Points that are moved by as much would bend the other way."""
    hull = hull_of(points)
    assert fits(points[None], hull).all()
    other = VALLEY if points is RIDGE else RIDGE
    assert not fits(other[None], hull).any()


def test_sets_are_looked_at_together_and_alone_alike() -> None:
    same, several = np.stack([BOX, 2 * BOX + 1, BOX * (1, 5, 2)]), np.stack([RIDGE, VALLEY])
    together = distinct_together([same, several, RIDGE[None], same[:1]])
    assert together[0] == together[3] == distinct_hulls(same) and together[2] == distinct_hulls(RIDGE[None])
    assert together[1] is None
    two = distinct_hulls(several)
    assert which_fits(several, two).tolist() == [0, 1] and which_fits(several, two[1:]).tolist() == [1, 0]


def test_points_without_a_hull_are_told() -> None:
    assert distinct_together([FLAT[None], BOX[None]]) == [None, None]
    assert distinct_together([BOX[None] * np.nan, BOX[None]])[1] == distinct_hulls(BOX[None])
    with pytest.raises(NoHullError, match="lie in one plane"):
        hull_of(FLAT)
    with pytest.raises(NoHullError, match="not finite"):
        hull_of(BOX * np.nan)
