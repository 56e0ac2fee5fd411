"""What a user holds goes to other processes and arrives the same, as loaders of training data send it."""

from __future__ import annotations

import multiprocessing as mp
import pickle
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.api import Samples, load, sample
from artipg_dsl.session import Session

CHEST = Path(__file__).parents[1] / "cli" / "programs" / "chest.apg"


@pytest.fixture(scope="module")
def made() -> Samples:
    return sample(CHEST, n=3, seed=5, set={"width": "45cm"})


def arrays(made: Samples) -> list[np.ndarray]:
    points = made.points(32)
    return [
        points.position,
        points.semantic,
        made.joints().origin,
        made.parts().low,
        made["width"],
        made.batch.log_weight,
    ]


def told(made: Samples) -> tuple[str, list[np.ndarray]]:
    return repr(made), arrays(made)


def equal(one: Samples, other: Samples) -> bool:
    return repr(one) == repr(other) and all(
        np.array_equal(a, b) for a, b in zip(arrays(one), arrays(other), strict=True)
    )


def test_samples_objects_and_mutants_arrive_the_same(made: Samples) -> None:
    mutants = made.mutate("cpa")
    for one in (made, made.object(1), mutants):
        again = pickle.loads(pickle.dumps(one))
        assert type(again) is type(one) and equal(again, one)
        assert again.annotations() == one.annotations()
    steps = [mutants.changes(number) for number in range(3)]
    assert [pickle.loads(pickle.dumps(mutants)).changes(number) for number in range(3)] == steps
    assert (
        pickle.loads(pickle.dumps(mutants)).correspondence().arrays().keys() == mutants.correspondence().arrays().keys()
    )


def test_what_arrives_can_be_worked_with(made: Samples) -> None:
    again = pickle.loads(pickle.dumps(made))
    assert equal(again.object(7), made.object(7))
    assert equal(again.mutate("cpa", variant=2), made.mutate("cpa", variant=2))


def test_tables_points_and_sessions_arrive(made: Samples) -> None:
    points = pickle.loads(pickle.dumps(made.points(16)))
    assert np.array_equal(points.position, made.points(16).position)
    assert np.array_equal(pickle.loads(pickle.dumps(made.joints())).axis, made.joints().axis)
    assert pickle.loads(pickle.dumps(Session.of(CHEST))).sampler.program.hash == made.batch.program.hash
    text = CHEST.read_text(encoding="utf-8")
    assert pickle.loads(pickle.dumps(Session.of_text(text))).sampler.program.hash == load(text).batch.program.hash


def test_spawned_workers_get_samples_as_loaders_do(made: Samples) -> None:
    """A DataLoader with the start method `spawn` pickles its data set to each worker."""
    with ProcessPoolExecutor(1, mp_context=mp.get_context("spawn")) as pool:
        name, found = pool.submit(told, made).result(timeout=120)
    assert name == repr(made) and all(np.array_equal(a, b) for a, b in zip(found, arrays(made), strict=True))
