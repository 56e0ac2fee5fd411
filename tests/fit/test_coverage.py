"""Holes of clouds are no evidence of absence: what lies in one stays as it is."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit.coverage import Coverage, Sight
from artipg_dsl.fit.decide import decide
from artipg_dsl.fit.evidence import Clouds, Copies, beside, weigh, weigh_again, weigh_change
from artipg_dsl.fit.focus import differing
from artipg_dsl.fit.model import Model
from artipg_dsl.fit.pose import Frame, pose, targets
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.search import Effort
from artipg_dsl.geometry.nearest import Nearest

from .helpers import N
from .test_decide import clouds, knobs, still, with_another, without


def without_fronts(samples: apg.Samples) -> Clouds:
    """The clouds without the foremost surface, where the knobs are, and 6 cm of the sides."""
    posed = []
    for place in samples.points(20_000).position:
        kept = np.flatnonzero(place[:, 0] < place[:, 0].max() - 0.07)
        cloud = Cloud(place[kept], None, np.full(len(kept), -1), ())
        posed.append(pose(cloud, Frame(front="x", unit="m"), ".npz", 1.0))
    return Clouds(targets(posed))


def losses(model: Model, samples: apg.Samples, cloud: Clouds) -> np.ndarray:
    """What is lost by another number of knobs, and by the right one after that: (there or back, coarsely or finely, object)."""
    every, found = np.arange(N), []
    true, wrong = with_another(model, samples)
    for origin, copy in ((true, wrong), (wrong, true)):
        base = weigh(origin.batch, every, still(N), cloud)
        change, copies = differing(origin.batch, copy.batch, every), Copies(copy.batch, every, every, still(N))
        own = Copies(origin.batch, every, every, still(N))
        told = weigh_change(copies, cloud, base, change), weigh_again(copies, own, cloud, base, change)
        found.append([one.loss for one in told])
    return np.array(found)


@pytest.mark.slow
def test_a_hole_says_little_of_what_lies_in_it(
    model: Model, samples: apg.Samples, monkeypatch: pytest.MonkeyPatch
) -> None:
    little = losses(model, samples, without_fronts(samples))
    monkeypatch.setattr(Coverage, "at", lambda self, places, of: np.ones(len(places)))
    assert (np.abs(little) <= 0.15 * np.abs(losses(model, samples, without_fronts(samples)))).all()
    monkeypatch.undo()
    there, back = losses(model, samples, clouds(samples))
    assert (there > 12.0).all() and (back < -12.0).all()


@pytest.mark.slow
def test_whole_candidates_are_compared_where_the_cloud_was_seen(
    boards: apg.Samples, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = Model(boards.job.sampler)
    has, true, wrong = without(boards, model, "cap")
    every, right = np.arange(len(has)), model.assembled([(true, has)])

    def loss(kept: float) -> np.ndarray:
        """Of boards without their caps, by clouds without the uppermost 20 cm or with them."""
        posed = []
        for place in boards.points(20_000).position[has]:
            place = place[place[:, 2] <= place[:, 2].max() - kept]
            cloud = Cloud(place, None, np.full(len(place), -1), ())
            posed.append(pose(cloud, Frame(front="x", unit="m"), ".npz", 1.0))
        cloud = Clouds(targets(posed))
        was, now = (weigh(one, every, still(len(has)), cloud) for one in (right, wrong))
        return beside(now, was, every)

    little = loss(0.2)
    monkeypatch.setattr(Coverage, "at", lambda self, places, of: np.ones(len(places)))
    assert (np.abs(little) <= 0.05 * np.abs(loss(0.2))).all()
    monkeypatch.undo()
    assert (loss(0.0) > 12.0).all()


@pytest.mark.slow
def test_what_lies_in_a_hole_stays(model: Model, samples: apg.Samples) -> None:
    true, wrong = with_another(model, samples)
    for one in (true, wrong):
        found = decide(model, without_fronts(samples).targets, one, Effort(rounds=1))
        assert found.batch.state.values[knobs(model)].tolist() == one.batch.state.values[knobs(model)].tolist()


def test_coverage_is_that_of_the_surface_beside() -> None:
    x = np.linspace(0.0, 1.0, 101)
    sheet = np.zeros((2, 101, 6))
    sheet[:, :, 0], sheet[:, :, 5] = x, 0.06
    seen = np.broadcast_to(x < 0.5, (2, 101))
    coverage = Coverage.of(sheet, np.array([[True] * 101, [False] * 101]), seen)
    asked = np.zeros((4, 6))
    asked[:, 0], asked[:, 5] = (0.1, 0.5, 0.9, 0.9), 0.06
    told = coverage.at(asked, np.array([0, 0, 0, 1]))
    assert told[0] == 1.0 and 0.3 < told[1] < 0.7 and told[2] == 0.0
    assert told[3] == 1.0  # nothing is known of a surface that shares nothing
    assert coverage.at(asked[:0], np.zeros(0, dtype=int)).shape == (0,)


@pytest.mark.parametrize(("lost", "asked"), [(3, False), (4, True)])
def test_a_surface_that_was_seen_is_not_asked(lost: int, asked: bool) -> None:
    """Of twelve neighbours three that were not seen say nothing."""
    sheet, seen = np.zeros((1, 50, 6)), np.arange(50)[None] >= lost
    coverage = Coverage.of(sheet, np.ones((1, 50), dtype=bool), seen)
    assert (coverage.tree is not None) == asked
    assert coverage.at(sheet[0, :2], np.zeros(2, dtype=int)).tolist() == [1.0, 1.0] or asked


def test_a_few_points_are_fewer_neighbours() -> None:
    few = np.zeros((2, 3, 6))
    few[1, :, 0] = 5.0
    coverage = Coverage.of(few, np.ones((2, 3), dtype=bool), np.array([[True, True, False], [False, False, False]]))
    assert coverage.at(np.zeros((2, 6)), np.array([0, 1])).tolist() == pytest.approx([(2.0 / 3.0 - 0.25) / 0.5, 0.0])
    assert Nearest(np.zeros((2, 1)), np.array([0, 1]), 1e3).several(np.zeros((1, 1)), np.array([1]), 3).tolist() == [
        [1, 0, 2]
    ]


def test_sparse_clouds_reach_farther() -> None:
    sight = Sight(Nearest(np.zeros((2, 6)), np.array([0, 1]), 1e3), np.array([0.0, 0.02]))
    places = np.zeros((4, 6))
    places[:, 0] = 0.03, 0.05, 0.03, 0.05
    assert sight.at(places, np.array([0, 0, 1, 1])).tolist() == [True, False, True, True]
