"""Steps of damped least squares: what has not changed is not asked again, and how near they come to the truth."""

from __future__ import annotations

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit import refine as steps
from artipg_dsl.fit.compare import Candidates, compare
from artipg_dsl.fit.model import Changes, Model
from artipg_dsl.fit.pose import targets
from artipg_dsl.fit.search import Effort
from artipg_dsl.geometry import points as geometry

from .helpers import N
from .test_decide import clouds, still
from .test_fitting import clouds as posed


def test_derivatives_of_what_has_not_moved_are_kept(model: Model, samples: apg.Samples) -> None:
    batch = model.assembled([(samples.batch, np.arange(N))])
    now = compare(batch, np.arange(N), still(N), clouds(samples).targets.first(256), 200)
    free, none = model.freedoms(batch), np.zeros((N, 0, 3, 200))
    whole = steps.derivatives(model, batch, now, free, none, np.ones(N, dtype=bool))
    assert all(np.abs(one).max() > 0.01 for one in whole)
    changed = np.arange(N) == 1
    before = np.where(changed[:, None, None, None], 7.0, whole)
    with mock.patch.object(steps, "_moved", side_effect=steps._moved) as moved:
        again = steps.derivatives(model, batch, now, free, before, changed)
    assert np.unique(moved.call_args.args[2].owner).tolist() == [1]
    assert again.tobytes() == whole.tobytes()


def test_most_of_an_object_is_near_however_far_the_rest_is(model: Model, samples: apg.Samples) -> None:
    batch = model.assembled([(samples.batch, np.arange(N))])
    near = clouds(samples).targets.first(1024)
    far = replace(near, points=near.points + np.where(np.arange(1024) % 10 == 0, 1.0, 0.0)[:, None])
    off, rest = (compare(batch, np.arange(N), still(N), own, 512) for own in (near, far))
    assert (rest.score > 1.3 * off.score).all()
    assert (rest.within(0.75) < 0.3 * rest.score).all() and (rest.within(0.75) < 0.3 * rest.within(0.95)).all()


def test_what_a_scan_does_not_show_counts_for_little(model: Model, samples: apg.Samples) -> None:
    """A cloud without what is in front: the true object is half as far off if the cloud is a scan."""
    batch = model.assembled([(samples.batch, np.arange(N))])
    clean = clouds(samples).targets.first(1024)
    behind = np.argsort(clean.points[:, :, 0], axis=1)[:, :700][:, np.arange(1024) % 700]
    every = np.arange(N)[:, None]
    columns = {name: getattr(clean, name)[every, behind] for name in ("points", "normals", "word", "link")}
    holed = replace(clean, **columns, noise=np.zeros(N))
    scan = replace(holed, noise=np.full(N, 4e-3))
    whole, hole, shown = (compare(batch, np.arange(N), still(N), own, 512).score for own in (clean, holed, scan))
    assert (hole > whole + 0.004).all() and (shown < 0.5 * hole).all()


def test_rows_that_stand_still_are_left_out(model: Model, samples: apg.Samples) -> None:
    batch = model.assembled([(samples.batch, np.arange(N))])
    now = compare(batch, np.arange(N), still(N), clouds(samples).targets.first(256), 200)
    free, none = model.freedoms(batch), np.zeros((N, 0, 3, 200))
    evaluate = geometry.evaluate_flat
    with mock.patch.object(geometry, "evaluate_flat", side_effect=evaluate) as asked:
        whole = steps.derivatives(model, batch, now, free, none, np.ones(N, dtype=bool))
    given, *bound = asked.call_args.args
    every = steps._moved(model, batch, free)[0].sites()
    assert 0 < sum(map(len, given)) < 0.8 * sum(map(len, every))
    assert np.unique(bound[2]).max() < max(map(len, given))
    assert all(np.abs(one).max() > 0.01 for one in whole)


def test_roots_are_the_same_whatever_is_solved_beside_them() -> None:
    chance = np.random.default_rng(3)
    many = np.array([44, 90, 61, 44])
    matrix, slope = np.zeros((4, 90, 90)), np.zeros((4, 90))
    for k, size in enumerate(many):
        some = chance.normal(size=(size, 200))
        matrix[k, :size, :size], slope[k, :size] = some @ some.T, chance.normal(size=size)
    found = steps._roots(matrix, slope, many)
    for k, size in enumerate(many):
        own = slice(k, k + 1)
        alone = steps._roots(matrix[own, :size, :size], slope[own, :size], many[own])
        assert found[k, :size].tobytes() == alone[0].tobytes() and not found[k, size:].any()
        assert np.allclose(matrix[k, :size, :size] @ alone[0], slope[k, :size])


@pytest.mark.slow
def test_the_last_steps_find_numbers_to_a_thousandth_of_their_range() -> None:
    samples, chance = apg.sample("Bottle", n=2, seed=3), np.random.default_rng(1)
    model, every = Model(samples.job.sampler), np.arange(2)
    true = model.assembled([(samples.batch, every)])
    free = model.freedoms(true)
    value = np.clip(free.value + 0.02 * chance.normal(size=len(free)) * free.width, free.low, free.high)
    moved = model.altered(true, every, Changes(free.owner, free.draw, free.row, value))
    asked = targets(posed(samples, model))
    found = steps.refine(model, asked, Candidates(moved, every, still(2), np.zeros(2)), Effort().last)
    off = np.abs(model.freedoms(found.batch).value - free.value) / free.width
    assert np.median(np.abs(value - free.value) / free.width) > 0.005
    assert np.median(off) < 0.0012


def test_gaps_count_whole_within_the_noise_of_a_cloud(model: Model, samples: apg.Samples) -> None:
    batch = model.assembled([(samples.batch, np.arange(N))])
    asked = replace(clouds(samples).targets.first(256), noise=np.array([0.0, 0.002, 0.05]))
    given = Candidates(batch, np.arange(N), still(N), np.zeros(N))
    with mock.patch.object(steps, "_trust", side_effect=steps._trust) as trusted:
        steps.refine(model, asked, given, steps.Schedule(2, 128, (0.03, 0.001)))
    widths = np.unique([call.args[1] for call in trusted.call_args_list], axis=0)
    assert widths.tolist() == [[0.001, 0.004, 0.1], [0.03, 0.03, 0.1]]
