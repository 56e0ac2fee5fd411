"""How far candidates are off, before they are measured finely."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.fit.measure import Surface, agreement, roughly, surfaces
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


def test_words_that_a_map_never_uses_count_for_nothing() -> None:
    """A file calls its door and the handle on it a door. Where the map has no word for handles, the door agrees all the same."""
    points = np.arange(8.0)[:, None] * [1.0, 0.0, 0.0]
    ours = Surface(points, points, np.array([1, 1, 2, 2, 3, 3, 0, 1]))
    names, theirs = ("unlabelled", "body", "door", "handle"), np.array([1, 1, 2, 2, 2, 2, 2, 0])
    told = agreement(points, points, theirs, ours, np.array([1, 2]), names)
    assert told == {"body": 1.0, "door": pytest.approx(2 / 3, abs=1e-4)}
    told = agreement(points, points, theirs, ours, np.array([1, 2, 3]), names)
    assert told == {"body": 1.0, "door": pytest.approx(2 / 5), "handle": 0.0}


def test_words_of_parts_that_touch_are_told_apart() -> None:
    """The top of a body and the underside of its lid, in one plane."""
    points = np.tile(np.arange(8.0)[:, None] * [1.0, 0.0, 0.0], (2, 1))
    words, normals = np.repeat([1, 2], 8), np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], 8, axis=0)
    ours = Surface(points[::-1], normals[::-1], words[::-1])
    told = agreement(points, normals, words, ours, np.array([1, 2]), ("unlabelled", "body", "lid"))
    assert told == {"body": 1.0, "lid": 1.0}
