"""Points are uniform by area: chi-square tests with fixed seeds, within patches and over patches, and what they catch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

from artipg_dsl import random
from artipg_dsl.geometry import density, points
from artipg_dsl.geometry.block import block_of
from artipg_dsl.geometry.cells import Cells
from artipg_dsl.geometry.density import element_split
from artipg_dsl.geometry.patches import grid
from artipg_dsl.graph.primitive import Primitive
from artipg_dsl.session import Session

from . import scenes

BINS, FINE, N = 6, 8, 20_000
LOST = 1e-4  # chance of a false alarm, were the seeds drawn anew
KETTLE = Path(__file__).parents[2] / "benchmarks" / "lathe_kettle.apg"


def primitives(name: str | Path) -> list[Primitive]:
    return list(Session.of(name).lowering.program.primitives.values())


def drawn(primitive, seed: int) -> tuple[Cells, np.ndarray, points.PointSet]:
    """One instance of a primitive with the middle of its test values, its cells and the cell of each point."""
    params = {name: (low + high) / 2 for name, (low, high) in zip(primitive.parameters, ranges(primitive), strict=True)}
    sites = [scenes.table(0, primitive, params, [0], np.zeros(3))]
    made = points.sample(sites, 1, N, random.key(seed, "points"), np.zeros(1, dtype=np.uint64))
    cells = Cells(block_of(sites, 0, 1))
    cells.measure_bent()
    return cells, made.patch[0].astype(int), made


def ranges(primitive) -> list[tuple[float, float]]:
    from artipg_dsl.geometry.trial import draw_trial

    values = draw_trial(primitive)
    return [(float(values[name][0]), float(values[name][0])) for name in primitive.parameters]


def within(cells: Cells, cell: np.ndarray, made: points.PointSet) -> tuple[float, int]:
    """Chi-square over bins of (u, v) in all patches, each bin expected its share of the area; degrees of freedom."""
    (shelf,) = cells.rows.shelves
    middle = (np.arange(FINE * BINS) + 0.5) / (FINE * BINS)
    mesh = np.meshgrid(middle, middle, indexing="ij")
    total, freedom = 0.0, 0
    for patch in range(len(cells.area)):
        at = np.flatnonzero(cell == patch)
        if len(at) < 5 * BINS * BINS:
            continue
        element = grid(element_split(shelf.primitive, patch), shelf.params, *mesh)[0, ..., 0]
        share = element.reshape(BINS, FINE, BINS, FINE).sum(axis=(1, 3))
        expected = share / share.sum() * len(at)
        seen = np.histogram2d(made.u[0, at], made.v[0, at], BINS, ((0, 1), (0, 1)))[0]
        large = expected >= 5
        total += float(((seen - expected)[large] ** 2 / expected[large]).sum())
        freedom += int(large.sum()) - 1
    return total, freedom


@pytest.mark.parametrize("program", ["Microwave", KETTLE], ids=["Microwave", "kettle"])
def test_points_are_uniform_within_patches_and_over_them(program: str | Path) -> None:
    for primitive in primitives(program):
        cells, cell, made = drawn(primitive, 11)
        total, freedom = within(cells, cell, made)
        assert freedom > 0 and chi2.sf(total, freedom) > LOST, primitive.name
        assert chi2.cdf(total, freedom) > LOST, (
            f"{primitive.name}: not more even than chance either: draws are independent"
        )
        expected = N * cells.area / cells.area.sum()
        assert np.abs(np.bincount(cell, minlength=len(expected)) - expected).max() < 2.5, "allocated, not drawn"


def test_the_test_catches_points_that_crowd_in_the_middle_of_a_disc(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the inverse of the area element, a lid has as many points on its inner half radius as on its outer."""
    lid = next(p for p in primitives(KETTLE) if p.name == "Dome")
    assert chi2.sf(*within(*drawn(lid, 3))) > LOST
    monkeypatch.setattr(density.AreaPlacement, "place", lambda self, row, first, second: (first, second))
    assert chi2.sf(*within(*drawn(lid, 3))) < 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_what_is_left_of_a_face_is_uniform(seed: int) -> None:
    """A plate with a cylinder standing on it: the rest of its face, in rings and sectors about the cylinder."""
    from . import shapes

    box, tube = shapes.cuboid(), shapes.cylinder()
    sites = [
        scenes.table(0, box, {"size.x": 0.4, "size.y": 0.4, "size.z": 0.02}, [0], np.zeros(3)),
        scenes.table(1, tube, {"radius": 0.1, "top_radius": 0.1, "height": 0.1}, [0], [[0.0, 0.0, 0.06]]),
    ]
    made = points.sample(sites, 1, N, random.key(seed, "points"), np.zeros(1, dtype=np.uint64))
    top = made.position[0][(made.site[0] == 0) & (made.patch[0] == 5)]
    radius, angle = np.hypot(top[:, 0], top[:, 1]), np.arctan2(top[:, 1], top[:, 0])
    assert radius.min() >= 0.1 - 1e-9
    ring = radius < 0.2
    seen = np.histogram2d(radius[ring] ** 2, angle[ring], (6, 8), ((0.01, 0.04), (-np.pi, np.pi)))[0]
    expected = ring.sum() / seen.size
    assert chi2.sf(float(((seen - expected) ** 2 / expected).sum()), seen.size - 1) > LOST
    share = 0.03 * np.pi / (0.16 - 0.01 * np.pi)
    assert abs(ring.mean() - share) < 4 * np.sqrt(share / len(top))
