"""Numbers that move a surface along itself, which has no gradient, are found by trying them."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit.compare import Candidates
from artipg_dsl.fit.focus import differing
from artipg_dsl.fit.model import Changes, Model, Placed
from artipg_dsl.fit.refine import PLACE, refine
from artipg_dsl.fit.search import Effort
from artipg_dsl.fit.vary import Ways, varied

from .helpers import FOOTED, SIZELESS, N
from .test_decide import clouds, still

_SHORT = 0.08  # metres


@pytest.fixture(scope="module")
def footed() -> tuple[apg.Samples, Model]:
    samples = apg.load(FOOTED, n=N, seed=3)
    return samples, Model(samples.job.sampler)


def number(model: Model, name: str) -> int:
    return next(k for k in model.smooth if model.program.draws[k].column.name == name)


def shortened(model: Model, true: Candidates) -> Candidates:
    """With shorter feet, the rest where it was."""
    every, old = np.arange(N), true.batch.state.values
    lift, height = number(model, "lift"), number(model, "height")
    short = np.minimum(old[lift] - 0.04, _SHORT)
    value = np.concatenate([old[lift] - short, old[height] - short])
    draw = np.repeat([lift, height], N)
    batch = model.altered(true.batch, every, Changes(np.tile(every, 2), draw, np.tile(every, 2), value))
    shift = np.stack([np.zeros(N), np.zeros(N), short], axis=1)
    return Candidates(batch, every, Placed(np.ones(N), shift), np.zeros(N))


def as_candidates(model: Model, samples: apg.Samples) -> Candidates:
    every = np.arange(N)
    return Candidates(model.assembled([(samples.batch, every)]), every, still(N), np.zeros(N))


@pytest.mark.slow
def test_what_least_squares_leave_is_found(footed: tuple[apg.Samples, Model]) -> None:
    samples, model = footed
    true, cloud = as_candidates(model, samples), clouds(samples)
    wrong, lift = shortened(model, true), number(model, "lift")
    right, was = (one.batch.state.values[lift] for one in (true, wrong))
    assert (right - was > 0.02).all()
    refined = refine(model, cloud.targets, wrong, Effort().last)
    assert np.abs(refined.batch.state.values[lift] - right).max() > 0.02
    found = varied(model, cloud.targets, wrong, cloud)
    off = np.abs(found.batch.state.values[lift] - right)
    assert (off < 0.5 * (right - was)).all()
    ended = refine(model, cloud.targets, found, Effort().last)
    for name in ("lift", "height"):
        drawn = number(model, name)
        assert np.abs(ended.batch.state.values[drawn] - true.batch.state.values[drawn]).max() < 0.004


def test_all_follows_so_that_the_rest_stays(footed: tuple[apg.Samples, Model]) -> None:
    samples, model = footed
    wrong = shortened(model, as_candidates(model, samples))
    ways = Ways.of(model, clouds(samples).targets, wrong)
    lift, height = number(model, "lift"), number(model, "height")
    mine, other = (np.flatnonzero(ways.free.draw == drawn) for drawn in (lift, height))
    width = ways.free.width
    grown = ways.way[mine, PLACE + ways.free.place[other]] * width[other]
    assert np.allclose(grown, width[mine], rtol=0.02)
    assert np.allclose(ways.way[mine, PLACE - 2], -width[mine], rtol=0.02)
    at, moves = ways.tried(np.array([0.1]))
    assert set(mine) <= set(at.tolist()) and not set(np.flatnonzero(ways.free.draw == number(model, "width"))) & set(at)
    own = np.flatnonzero(np.isin(at, mine) & (moves[np.arange(len(at)), PLACE + ways.free.place[at]] > 0.0))
    copies = ways.copies(model, wrong, ways.free.owner[at[own]], moves[own])
    by = copies.placed.shift - wrong.placed.shift[copies.of]
    change = differing(wrong.batch, copies.batch, copies.of, by, np.full(len(own), 1e-3))
    paths = [table.path for table in wrong.batch.sites()]
    begin = np.cumsum([0, *(len(table) for table in wrong.batch.sites())])
    gone = {paths[int(np.searchsorted(begin, row, side="right")) - 1] for row in change.old[1]}
    assert gone == {path for path in paths if "stem" in path}


def test_what_is_right_stays_to_the_byte(footed: tuple[apg.Samples, Model]) -> None:
    samples, model = footed
    true, cloud = as_candidates(model, samples), clouds(samples)
    found = varied(model, cloud.targets, true, cloud)
    assert model.fingerprints(found.batch).tolist() == model.fingerprints(true.batch).tolist()
    assert found.placed.shift.tobytes() == true.placed.shift.tobytes()


def test_a_candidate_is_moved_likewise_whatever_stands_beside_it(footed: tuple[apg.Samples, Model]) -> None:
    samples, model = footed
    cloud = clouds(samples)
    wrong = shortened(model, as_candidates(model, samples))
    whole = varied(model, cloud.targets, wrong, cloud)
    one = np.array([1])
    alone = Candidates(model.assembled([(wrong.batch, one)]), np.zeros(1, int), wrong.placed.take(one), np.zeros(1))
    found = varied(model, cloud.targets.take(one), alone, type(cloud)(cloud.targets.take(one)))
    assert model.fingerprints(found.batch).tolist() == model.fingerprints(whole.batch)[1:2].tolist()


def test_objects_without_numbers_are_left_alone() -> None:
    samples = apg.load(SIZELESS, n=N, seed=1)
    model = Model(samples.job.sampler)
    assert not len(model.smooth)
    true, cloud = as_candidates(model, samples), clouds(samples)
    found = varied(model, cloud.targets, true, cloud)
    assert model.fingerprints(found.batch).tolist() == model.fingerprints(true.batch).tolist()
