"""How far candidates are off, before they are measured finely."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.fit.measure import roughly, surfaces
from artipg_dsl.session import Session
from tests.cli.helpers import CHEST


def test_depth_pictures_tell_about_what_rays_do() -> None:
    batch = Session.of_text(Path(CHEST).read_text()).sampler.batch(np.arange(3), seed=2)
    scale, shift = np.array([1.0, 2.0, 1.0]), np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    (whole, outside), (same, rays) = (f(batch, batch.sites(), scale, shift) for f in (roughly, surfaces))
    for a, b, one, other in zip(whole, same, outside, rays, strict=True):
        assert a.points.tobytes() == b.points.tobytes()
        assert np.ptp(one.points, axis=0) == pytest.approx(np.ptp(other.points, axis=0), abs=0.01)
        assert one.points.mean(axis=0) == pytest.approx(other.points.mean(axis=0), abs=0.03)
