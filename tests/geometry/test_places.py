"""Places on every patch of some rows, and which of them another row hides."""

import numpy as np

from artipg_dsl.geometry.places import spread

from . import scenes, shapes

BOX, ROUND = shapes.cuboid(), shapes.hollow_frustum()


def box(number, size, at, owner):
    return scenes.table(number, BOX, dict(zip(("size.x", "size.y", "size.z"), size, strict=True)), owner, [at])


def test_places_are_on_the_patches_of_chosen_rows_alone():
    sites = [box(0, (1.0, 1.0, 1.0), (0, 0, 0), [0, 1, 2]), box(1, (1.0, 1.0, 1.0), (5, 0, 0), [0, 1, 2])]
    chosen = [np.array([True, True, False]), np.array([False, True, True])]
    points = spread(sites, chosen, 1, 3, 60).points
    found = np.stack([points.site.ravel(), points.row.ravel(), points.patch.ravel()], axis=1)
    which, many = np.unique(found, axis=0, return_counts=True)
    assert which.tolist() == [[site, row, patch] for site, row in ((0, 1), (1, 1), (1, 2)) for patch in range(6)]
    assert (many == 10).all()
    centre = np.where(points.site == 0, 0.0, 5.0)
    assert np.allclose(np.abs(points.position[:, 0] - np.stack([centre, 0 * centre, 0 * centre], -1)[:, 0]).max(1), 0.5)


def test_each_patch_has_a_place_however_few_are_asked_for():
    sites = [box(0, (1.0, 2.0, 3.0), (0, 0, 0), [0])]
    points = spread(sites, [np.ones(1, dtype=bool)], 0, 1, 1).points
    assert points.patch.ravel().tolist() == list(range(6))
    assert np.allclose(points.position[:, 0], points.normal[:, 0] * np.array([0.5, 1.0, 1.5]))


def test_patches_without_area_have_no_places():
    """A cone has no face at its tip, and a whole ring none at its ends."""
    params = {"radius": 0.1, "top_radius": 0.0, "bore": 0.0, "top_bore": 0.0, "height": 0.2, "span": 2 * np.pi}
    points = spread([scenes.table(0, ROUND, params, [0], np.zeros(3))], [np.ones(1, dtype=bool)], 0, 1, 24).points
    assert 0 < len(np.unique(points.patch)) < 4 and np.isfinite(points.normal).all()


def test_what_lies_in_another_row_or_against_it_is_not_seen():
    """A peg in a plate: seen but for its foot, and the plate but for what the peg stands on."""
    sites = [box(0, (1.0, 1.0, 0.2), (0, 0, 0), [0]), box(1, (0.2, 0.2, 0.4), (0, 0, 0.3), [0])]
    found = spread(sites, [np.ones(1, dtype=bool)] * 2, 0, 1, 600)
    seen = found.seen(np.arange(len(found.points.site)))
    site, (x, y, z) = found.points.site.ravel(), found.points.position[:, 0].T
    under = (np.abs(x) < 0.1) & (np.abs(y) < 0.1) & np.isclose(z, 0.1)
    assert under[site == 0].any() and under[site == 1].any()
    assert np.array_equal(~seen, under)
