"""Samples of the racks, and their details."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.api import Samples
from artipg_dsl.details.binding import Real, bind
from artipg_dsl.details.record import Details, join

from .raised import PROGRAM, RAISED, surface

MANY = 8000  # points of a surface


@pytest.fixture(scope="module")
def samples() -> Samples:
    return apg.load(PROGRAM, n=2, seed=1)


@pytest.fixture(scope="module")
def details(samples: Samples) -> Details:
    """Of both samples: their surface raised."""
    made = []
    for number in range(2):
        batch = samples.job.batch([number])
        found, mixed = surface(batch, MANY, 3), np.random.default_rng(1).permutation(MANY)
        normal = found.normal[0][mixed]
        points = found.position[0][mixed] + RAISED * normal
        made.append(
            bind(batch, Real(f"rack{number}", points, normal, np.zeros(MANY, dtype=np.int64), ("all",)), MANY // 2)
        )
    return join(made)
