"""How points move with each joint that drives them, against differences of places in random joint states.

Every category with ``ARTIPG_EVERY=1 pytest tests/annotate/test_jacobian.py``.
"""

from __future__ import annotations

import os

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.jacobian import find_jacobian, find_rates
from artipg_dsl.annotate.rebind import rebind
from artipg_dsl.annotate.states import draw_values
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session, categories

SOME = ("Foldingrack", "Globe", "Scissors")  # a closed loop, a chain of turning joints, a pair that mimics
CATEGORIES = categories() if os.environ.get("ARTIPG_EVERY") == "1" else SOME
STEP = 1e-6


def batch_of(category: str, count: int = 2) -> Batch:
    return Session.of(category).sampler.batch(np.arange(count), seed=11)


@pytest.mark.parametrize("category", CATEGORIES)
def test_velocities_are_differences_of_places(category: str) -> None:
    batch = batch_of(category)
    states = np.stack([draw_values(batch, k) for k in range(2)])
    states[1] = (states[0] + states[1]) / 2
    points = sample_points(batch, 64, states, motion=True)
    assert points.drivers is not None and points.velocities is not None
    assert points.velocities.shape == (len(batch), 2, 64, points.drivers.shape[2], 3)
    link = np.searchsorted(batch.links().owner, np.arange(len(batch)))[:, None] + points.link

    def at(values: np.ndarray) -> np.ndarray:
        """The points of the first state, carried to another one."""
        (turn, shift), (other, way) = batch.pose(states[0]), batch.pose(values)
        own = np.einsum("...ji,...j->...i", turn[link], points.position[:, 0] - shift[link])
        return np.einsum("...ij,...j->...i", other[link], own) + way[link]

    base = np.searchsorted(batch.joints().owner, np.arange(len(batch)))
    for k, state in enumerate(states):
        assert np.abs(at(state) - points.position[:, k]).max() < 1e-9
        settled = batch.settle(state)
        drivers, _, _ = find_rates(batch, settled)
        if batch.gates is not None:  # what waits does not move
            drivers = np.where(np.isin(drivers, batch.gates.joint[batch.gates.held(settled)]), -1, drivers)
        for slot in range(drivers.shape[1]):
            moving = drivers[:, slot][drivers[:, slot] >= 0]
            step = np.zeros(len(state))
            step[moving] = STEP
            speed = (at(state + step) - at(state - step)) / (2 * STEP)
            number = np.where(drivers[:, slot] >= 0, drivers[:, slot] - base, -2)
            mine = (points.drivers == number[:, None, None])[..., None]
            told = np.where(mine, points.velocities[:, k], 0.0).sum(axis=2)
            assert np.abs(speed - told).max() < 2e-5 * np.abs(points.position).max()


def test_what_follows_is_no_driver_and_moves_along() -> None:
    batch = batch_of("Foldingrack")
    assert batch.loops is not None
    state = draw_values(batch, 0)
    drivers, rate, depends = find_rates(batch, batch.settle(state))
    followers = batch.loops.variable[batch.loops.follows]
    assert len(followers) and not np.isin(followers, drivers).any()
    assert depends[followers].any(axis=1).all() and (np.abs(rate[followers]).max(axis=1) > 1e-6).all()


def test_points_bound_again_have_the_same_velocities() -> None:
    batch = batch_of("Foldingrack", 2)
    states = np.stack([draw_values(batch, 0), draw_values(batch, 1)])
    points = sample_points(batch, 40, states, motion=True)
    again = rebind(batch, points, states, motion=True)
    assert again.velocities is not None and np.array_equal(again.velocities, points.velocities)
    assert np.array_equal(again.drivers, points.drivers)


def test_alone_and_in_a_batch_the_same_bits() -> None:
    whole, one = batch_of("Foldingrack", 4), Session.of("Foldingrack").sampler.batch(np.array([2]), seed=11)
    links = np.flatnonzero(whole.links().owner == 2)
    found, alone = find_jacobian(whole), find_jacobian(one)
    width = alone.driver.shape[1]
    assert (found.driver[links][:, width:] == -1).all()
    for name in ("driver", "turn", "shift"):
        assert getattr(found, name)[links][:, :width].tobytes() == getattr(alone, name).tobytes()
