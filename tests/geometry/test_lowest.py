"""How low turned primitives reach, against closed forms."""

import numpy as np
import pytest

from artipg_dsl.geometry.lowest import find_lowest

from .shipped import SHIPPED

LOT = np.random.default_rng(3)
UP = LOT.normal(size=(50, 3))
UP /= np.sqrt((UP**2).sum(axis=1, keepdims=True))
LENGTHS = LOT.uniform(0.1, 0.4, (3, 50))
ACROSS_Y, ACROSS_Z = np.hypot(UP[:, 0], UP[:, 2]), np.hypot(UP[:, 0], UP[:, 1])


@pytest.mark.parametrize(
    ("name", "params", "reach"),
    [
        ("Cuboid", {f"size.{a}": LENGTHS[k] for k, a in enumerate("xyz")}, (np.abs(UP.T) * LENGTHS).sum(axis=0) / 2),
        (
            "Cylinder",
            {"radius": LENGTHS[0], "top_radius": LENGTHS[0], "height": LENGTHS[1]},
            LENGTHS[0] * ACROSS_Z + LENGTHS[1] * np.abs(UP[:, 2]) / 2,
        ),
        (
            "TorusSector",
            {"radius": 1 + LENGTHS[0], "tube": LENGTHS[1], "flat": LENGTHS[1], "span": np.full(50, 2 * np.pi)},
            (1 + LENGTHS[0]) * ACROSS_Y + LENGTHS[1],
        ),
    ],
)
def test_the_lowest_point_is_that_of_the_solid(name: str, params: dict, reach: np.ndarray) -> None:
    found = find_lowest(SHIPPED[name], params, UP)
    assert found == pytest.approx(-reach, abs=5e-6)
    assert (found >= -reach - 1e-12).all()
