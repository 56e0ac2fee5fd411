"""Choices and counts that the mean distance hardly sees are found by the whole cloud."""

from __future__ import annotations

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit import decide as decisions
from artipg_dsl.fit.alternatives import alternatives, odds_of
from artipg_dsl.fit.compare import Candidates
from artipg_dsl.fit.decide import decide, inclined, nested_sets
from artipg_dsl.fit.develop import apart
from artipg_dsl.fit.evidence import Clouds, Copies, weigh, weigh_again, weigh_change
from artipg_dsl.fit.focus import differing, lifted
from artipg_dsl.fit.model import Changes, Model, Placed
from artipg_dsl.fit.pose import Frame, pose, targets
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.search import Effort, taken
from artipg_dsl.fit.tries import tries
from artipg_dsl.runtime.batch import Batch

from .helpers import CLOSED, HOUSING, SIDED, SWAPPED, N


def clouds(samples: apg.Samples, noise: float = 0.0) -> Clouds:
    points, chance, posed = samples.points(20_000), np.random.default_rng(2), []
    for place in points.position:
        across = np.sqrt((np.ptp(place, axis=0) ** 2).sum())
        place = place[chance.permutation(len(place))]
        at = place + chance.normal(size=place.shape) * noise * across / np.sqrt(3.0)
        posed.append(pose(Cloud(at, None, np.full(len(at), -1), ()), Frame(front="x", unit="m"), ".npz", 1.0))
    return Clouds(targets(posed))


def still(count: int) -> Placed:
    return Placed(np.ones(count), np.zeros((count, 3)))


def knobs(model: Model) -> int:
    return next(k for k in model.discrete if model.program.draws[k].column.name == "knobs")


def with_another(model: Model, samples: apg.Samples) -> tuple[Candidates, Candidates]:
    """The samples as candidates, and with other numbers of knobs."""
    every, number = np.arange(N), knobs(model)
    true = model.assembled([(samples.batch, every)])
    other = np.where(true.state.values[number] == 1.0, 3.0, true.state.values[number] - 1.0)
    wrong = model.altered(true, every, Changes(every, np.full(N, number), every, other))
    return tuple(Candidates(batch, every, still(N), np.zeros(N)) for batch in (true, wrong))  # type: ignore[return-value]


@pytest.mark.some
@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_a_wrong_count_of_small_parts_is_mended(model: Model, samples: apg.Samples, noise: float) -> None:
    true, wrong = with_another(model, samples)
    found = decide(model, clouds(samples, noise).targets, wrong, Effort())
    assert found.batch.state.values[knobs(model)].tolist() == true.batch.state.values[knobs(model)].tolist()
    assert found.target.tolist() == [0, 1, 2]


def test_what_is_right_is_left_alone(model: Model, samples: apg.Samples) -> None:
    true, _ = with_another(model, samples)
    found = decide(model, clouds(samples).targets, true, Effort())
    for number in (*model.discrete, *model.smooth):
        assert found.batch.state.values[number].tolist() == true.batch.state.values[number].tolist()


def test_large_changes_are_developed_where_little_else_is_gained(model: Model, samples: apg.Samples) -> None:
    _, wrong = with_another(model, samples)
    asked: list[list[int]] = []
    gains = np.array([-20.0, -500.0, 0.0])  # by target

    def better(_: Model, found: Candidates, *others: object) -> tuple[Candidates, np.ndarray]:
        return found, gains[found.target]

    def developed(_: Model, own: object, found: Candidates, *others: object) -> Candidates:
        asked.append(found.target.tolist())
        return taken(model, found, np.zeros(0, dtype=np.int64))

    with mock.patch.multiple(decisions, _better=better, developed=developed):
        decide(model, clouds(samples).targets, wrong, Effort(rounds=3))
    assert asked == [[0, 2], [0], [0, 1]]  # in the last round, all that are left


def test_the_cloud_speaks_for_the_true_object(model: Model, samples: apg.Samples) -> None:
    (true, wrong), cloud = with_another(model, samples), clouds(samples)
    told = [weigh(one.batch, one.target, one.placed, cloud).total for one in (true, wrong)]
    assert (told[0] + 12.0 < told[1]).all()


def test_a_part_that_changes_is_weighed_alone(model: Model, samples: apg.Samples) -> None:
    (true, wrong), cloud = with_another(model, samples), clouds(samples)
    every = np.arange(N)
    for origin, copy, sign in ((true, wrong, 1.0), (wrong, true, -1.0)):
        base = weigh(origin.batch, every, still(N), cloud)
        change = differing(origin.batch, copy.batch, every)
        copies = Copies(copy.batch, every, every, still(N))
        own = Copies(origin.batch, every, every, still(N))
        for told in (weigh_change(copies, cloud, base, change), weigh_again(copies, own, cloud, base, change)):
            assert (sign * told.loss > 12.0).all()
        same = differing(origin.batch, origin.batch, every)
        assert not same.anywhere(N).any()


def test_what_differs_is_named(model: Model, samples: apg.Samples) -> None:
    true, wrong = with_another(model, samples)
    found = differing(true.batch, wrong.batch, np.arange(N))
    begin = np.cumsum([0, *(len(table) for table in true.batch.sites())])
    paths = [table.path for table in true.batch.sites()]
    gone = {paths[int(np.searchsorted(begin, row, side="right")) - 1] for row in found.old[1]}
    assert found.anywhere(N).all() and len(gone) == 1 and "cap" in gone.pop()


def test_changes_of_several_copies_are_put_together(model: Model, samples: apg.Samples) -> None:
    true, wrong = with_another(model, samples)
    number = next(k for k in model.smooth if model.program.draws[k].column.name == "depth")
    one = np.array([1])
    deep = model.altered(true.batch, one, Changes(np.zeros(1, int), np.array([number]), one, np.array([0.37])))
    several = model.assembled([(wrong.batch, one), (deep, np.zeros(1, int))])
    both = model.merged(true.batch, several, np.array([1, 1]), np.array([0, 1]))
    expected = true.batch.state.values[number].copy()
    expected[1] = 0.37
    assert both.state.values[number].tolist() == expected.tolist()
    counts = both.state.values[knobs(model)]
    assert counts[1] == wrong.batch.state.values[knobs(model)][1]
    assert counts[[0, 2]].tolist() == true.batch.state.values[knobs(model)][[0, 2]].tolist()


def test_every_other_value_is_tried(model: Model, samples: apg.Samples) -> None:
    true, _ = with_another(model, samples)
    told = alternatives(model, true.batch)
    copy, draw, row, value = told.copy, told.draw, told.row, told.value
    mine = draw == knobs(model)
    assert (value[mine] != true.batch.state.values[knobs(model)][row[mine]]).all()
    assert set(copy.tolist()) == {0, 1, 2}


def test_counts_far_off_are_tried(model: Model, samples: apg.Samples) -> None:
    true, _ = with_another(model, samples)
    told = alternatives(model, true.batch)
    copy, draw, value = told.copy, told.draw, told.value
    counts = true.batch.state.values[knobs(model)]
    for own in range(N):
        tried = value[(draw == knobs(model)) & (copy == own)]
        assert {*tried.tolist(), counts[own]} >= {1.0, 2.0, 3.0}


def test_changes_are_tried_together_the_likeliest_first() -> None:
    """Of three changes of one candidate, the first of them large, and one of another."""
    of, joined = nested_sets(np.array([0, 0, 0, 2]), np.array([False, True, True, True]))
    told = [(own, tuple(np.flatnonzero(row).tolist())) for own, row in zip(of.tolist(), joined, strict=True)]
    assert told == [(0, (0,)), (0, (0, 1)), (0, (0, 1, 2)), (2, (3,)), (0, (1,)), (0, (1, 2))]


def without(boards: apg.Samples, model: Model, name: str) -> tuple[np.ndarray, Batch, Batch]:
    """The numbers of the boards that have a part, they all, and those ones without it."""
    true = model.assembled([(boards.batch, np.arange(12))])
    number = next(k for k in model.discrete if model.program.draws[k].column.name == name)
    has = np.flatnonzero(true.state.values[number] == 0.0)
    assert 0 < len(has) < 12
    every = np.arange(len(has))
    return has, true, model.altered(true, has, Changes(every, np.full(len(has), number), has, np.ones(len(has))))


@pytest.mark.slow
def test_what_stands_on_a_new_foot_stays(boards: apg.Samples) -> None:
    model = Model(boards.job.sampler)
    has, true, wrong = without(boards, model, "foot")
    by = lifted(true, wrong, has)
    assert by.round(9).tolist() == [[0.0, 0.0, 0.05]] * len(has)
    found = Candidates(wrong, np.arange(len(has)), still(len(has)).moved(by), np.zeros(len(has)))
    better = decide(model, clouds(boards).targets.take(has), found, Effort(developed=0, once=0))
    assert (model.structures(better.batch) == model.structures(true)[has]).all()
    assert np.abs(better.placed.shift).max() < 1e-9


@pytest.mark.slow
def test_changes_that_the_rest_does_not_fit_yet_are_developed(boards: apg.Samples) -> None:
    """A board as high as the true one with its cap has to become lower when it gets one."""
    model = Model(boards.job.sampler)
    has, true, wrong = without(boards, model, "cap")
    (height,) = (k for k in model.smooth if model.program.draws[k].column.name == "height")
    every = np.arange(len(has))
    higher = Changes(every, np.full(len(has), height), every, true.state.values[height][has] + 0.02)
    found = Candidates(model.altered(wrong, every, higher), every, still(len(has)), np.zeros(len(has)))
    right = []
    for effort in (Effort(), Effort(developed=0, once=0)):
        better = decide(model, clouds(boards).targets.take(has), found, effort)
        right.append(int((model.structures(better.batch) == model.structures(true)[has]).sum()))
    assert right == [len(has), 0]


@pytest.mark.slow
def test_what_the_cloud_hides_does_not_speak_against_a_part() -> None:
    """A floor behind the plate of a tray, which the few points of a copy leave visible."""
    housings = apg.load(HOUSING, n=12, seed=1)
    model = Model(housings.job.sampler)
    has, true, wrong = without(housings, model, "tray")
    every, cloud = np.arange(len(has)), Clouds(clouds(housings).targets.take(has))
    found = Candidates(wrong, every, still(len(has)), np.zeros(len(has)))
    copies = Copies(model.assembled([(true, has)]), every, every, still(len(has)))
    told = weigh_change(copies, cloud, weigh(wrong, every, still(len(has)), cloud), apart(found, copies))
    assert (told.loss < 0.0).all()


@pytest.mark.slow
def test_what_nothing_shows_is_as_it_mostly_is() -> None:
    """Three of four boxes have something in them."""
    boxes = apg.load(CLOSED, n=4, seed=1)
    model, every = Model(boxes.job.sampler), np.arange(4)
    batch = model.assembled([(boxes.batch, every)])
    (number,) = model.discrete
    told = Changes(every, np.full(4, number), every, np.array([1.0, 1.0, 0.0, 0.0]))
    few = model.altered(batch, every, Changes(every, told.draw, every, np.array([0.0, 1.0, 1.0, 0.0])))
    assert odds_of(few, told).round(9).tolist() == np.log([3.0, 1.0, 1 / 3, 1.0]).round(9).tolist()
    found = Candidates(few, every, still(4), np.zeros(4))
    better = inclined(model, clouds(boxes).targets, found, Effort())
    assert better.batch.state.values[number].tolist() == [1.0] * 4


def test_candidates_do_not_depend_on_their_company(model: Model, samples: apg.Samples) -> None:
    _, wrong = with_another(model, samples)
    cloud = clouds(samples)
    together = weigh(wrong.batch, np.arange(N), still(N), cloud).total
    alone = model.assembled([(wrong.batch, np.array([1]))])
    assert weigh(alone, np.array([1]), still(1), cloud).total == together[1]


@pytest.mark.slow
def test_what_is_not_there_comes_on_either_side() -> None:
    """A knob that a door lacks was thought to be on the left, and is on the right; the side itself shows nothing."""
    doors = apg.load(SIDED, n=12, seed=1)
    model = Model(doors.job.sampler)
    has, true, wrong = without(doors, model, "knob")
    (side,) = (k for k in model.discrete if model.program.draws[k].column.name == "side")
    every = np.arange(len(has))
    other = 1.0 - true.state.values[side][has]
    wrong = model.altered(wrong, every, Changes(every, np.full(len(has), side), every, other))
    told = list(tries(model, wrong, 2, 1))
    assert not any((one.draw == side).any() for one in told)
    sides = {(int(of), float(at)) for one in told for of, at in zip(one.of, one.batch.state.values[side], strict=True)}
    assert sides == {(k, at) for k in range(len(has)) for at in (0.0, 1.0)}
    found = Candidates(wrong, every, still(len(has)), np.zeros(len(has)))
    better = decide(model, clouds(doors).targets.take(has), found, Effort(developed=0, once=0))
    assert (model.structures(better.batch) == model.structures(true)[has]).all()


def test_equal_parts_that_change_places_do_not_differ() -> None:
    """Two plates that stand on either side, one of which has the handle."""
    pairs = apg.load(SWAPPED, n=2, seed=1)
    model, every = Model(pairs.job.sampler), np.arange(2)
    batch = model.assembled([(pairs.batch, every)])
    (number,) = model.discrete
    other = model.altered(batch, every, Changes(every, np.full(2, number), every, 1.0 - batch.state.values[number]))
    assert not differing(batch, other, every).anywhere(2).any()
    assert differing(batch, batch, every[::-1]).anywhere(2).all()


def test_closely_a_point_belongs_to_what_it_is_likeliest_for(model: Model, samples: apg.Samples) -> None:
    true, _ = with_another(model, samples)
    targets = replace(clouds(samples).targets, noise=np.full(N, 2e-3))
    told = [
        weigh(true.batch, true.target, true.placed, Clouds(targets, closely=closely)).cloud for closely in (False, True)
    ]
    assert (told[1] <= told[0]).all() and (told[1] < told[0]).any()
