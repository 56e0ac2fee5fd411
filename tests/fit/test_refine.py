"""Steps of damped least squares: what has not changed is not asked again."""

from __future__ import annotations

from unittest import mock

import numpy as np

import artipg_dsl as apg
from artipg_dsl.fit import refine as steps
from artipg_dsl.fit.compare import compare
from artipg_dsl.fit.model import Model
from artipg_dsl.geometry import points as geometry

from .helpers import N
from .test_decide import clouds, still


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
