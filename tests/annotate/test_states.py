"""Objects in other joint values: which are chosen, how points move, what shards and annotations then hold."""

from __future__ import annotations

import numpy as np
import pytest
from export.fake_batch import FakeBatch

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.states import REST, joint_values, open_values, read_states, rest_values, state_table, twist
from artipg_dsl.errors import UsageError
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session


@pytest.fixture(scope="module")
def sampler() -> Sampler:
    return Session.of("Microwave").sampler


@pytest.fixture(scope="module")
def batch(sampler: Sampler) -> Batch:
    return sampler.batch(np.arange(12), seed=3)


def test_states_are_read_from_text() -> None:
    assert read_states("rest") == REST and REST.only_rest and str(REST) == "rest"
    several = read_states("rest, open,random:4")
    assert several.count == 6 and str(several) == "rest,open,random:4" and not several.only_rest


@pytest.mark.parametrize("text", ["", "shut", "random", "random:0", "random:x", "rest:2", "random:4,", "random:99999"])
def test_what_is_no_state_is_told_in_words(text: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_states(text)
    assert caught.value.hint and (not text or text.split(",")[-1].strip() in caught.value.message)


def test_random_values_are_within_limits_and_fill_them(sampler: Sampler) -> None:
    many = sampler.batch(np.arange(200), seed=3)
    joints = many.joints()
    values = joint_values(many, read_states("random:5"))
    free = np.array([kind == "continuous" for kind in joints.kind])
    assert free.any() and not free.all()
    low, high = np.where(free, -np.pi, joints.low), np.where(free, np.pi, joints.high)
    assert (values >= low).all() and (values <= high).all()
    share = ((values - low) / (high - low)).ravel()
    counts = np.bincount((share * 10).astype(int), minlength=10)
    expected = share.size / 10
    assert ((counts - expected) ** 2 / expected).sum() < 27.9  # chi-square, 9 degrees of freedom, 0.1 %


def test_values_of_an_object_are_its_own(sampler: Sampler, batch: Batch) -> None:
    alone = sampler.batch(np.array([7]), seed=3)
    at = batch.joints().owner == 7
    few, more = (joint_values(alone, read_states(f"random:{k}")) for k in (3, 5))
    assert few.tobytes() == joint_values(batch, read_states("random:3"))[:, at].tobytes()
    assert more[:3].tobytes() == few.tobytes(), "further states leave the first as they are"
    mixed = joint_values(alone, read_states("random:1,rest,random:2"))
    assert mixed[[0, 2, 3]].tobytes() == few.tobytes() and mixed[1].tobytes() == rest_values(alone).tobytes()


def test_a_joint_that_mimics_follows() -> None:
    batch = FakeBatch(3, mimic=True)
    values = joint_values(batch, read_states("open,random:2"))
    assert (values[:, 1::2] == 0.002 * values[:, 0::2]).all() and (values[:, 0::2] > 0).all()
    assert values[0, 0::2] == pytest.approx(open_values(batch)[0::2])


@pytest.mark.parametrize(
    ("category", "text", "told"),
    [
        ("Scissors", "half_1.open=10deg", "the joint `half_1.open` follows `half_0.open`"),
        ("Globe", "spin=50%", "the joint `spin` has no end to share the way to"),
        ("Microwave", "open=170deg", "`open=170deg` is out of reach: the joint moves from 0deg to 120deg at most"),
        ("Microwave", "open=120%", "`open=120%` is more than the whole way"),
    ],
)
def test_names_that_would_move_nothing(category: str, text: str, told: str) -> None:
    batch = Session.of(category).sampler.batch(np.arange(1), 5)
    with pytest.raises(UsageError, match=told):
        joint_values(batch, read_states(text))


def test_values_that_some_objects_reach_are_clipped_in_the_others() -> None:
    batch = Session.of("Microwave").sampler.batch(np.arange(8), 5)
    joints, asked = batch.joints(), np.deg2rad(105.0)
    doors = np.asarray(joints.name) == "open"
    values = joint_values(batch, read_states("open=105deg"))[0, doors]
    assert (values == np.minimum(asked, joints.high[doors])).all() and len(np.unique(values < asked)) == 2


def test_a_table_of_states_ends_in_nan(batch: Batch) -> None:
    values = joint_values(batch, read_states("random:2"))
    table = state_table(batch, values)
    joints = batch.joints()
    counts = np.bincount(joints.owner)
    assert table.shape == (12, 2, counts.max()) and counts.min() < counts.max(), "some have no tray"
    for i, count in enumerate(counts):
        assert (table[i, :, :count] == values[:, joints.owner == i]).all() and np.isnan(table[i, :, count:]).all()


def test_points_in_several_states_are_those_of_each(batch: Batch) -> None:
    values = joint_values(batch, read_states("rest,open,random:2"))
    points = sample_points(batch, 100, values)
    assert points.position.shape == points.normal.shape == (12, 4, 100, 3) and points.motion is None
    assert points.semantic.shape == (12, 100)
    rest = sample_points(batch, 100)
    assert points.position[:, 0].tobytes() == rest.position.tobytes()
    for k in range(4):
        one = sample_points(batch, 100, values[k])
        assert points.position[:, k].tobytes() == one.position.tobytes()
        assert points.normal[:, k].tobytes() == one.normal.tobytes()


@pytest.mark.slow
def test_motion_is_the_derivative_by_the_points_own_joint(batch: Batch) -> None:
    values = joint_values(batch, read_states("random:1"))
    joints, links = batch.joints(), batch.links()
    start = np.searchsorted(links.owner, np.arange(len(batch)))
    for state in values:
        here = sample_points(batch, 200, state, motion=True)
        expected = np.zeros_like(here.position)
        for number in range(int(joints.number.max()) + 1):  # each object's own, one after the other
            at = np.flatnonzero(joints.number == number)
            there, back = (sample_points(batch, 200, state + d * (joints.number == number)) for d in (1e-6, -1e-6))
            child = np.full(len(batch), -1)
            child[joints.owner[at]] = joints.child[at]
            own = here.link == child[:, None]
            expected[own] = ((there.position - back.position) / 2e-6)[own]
        assert here.motion == pytest.approx(expected, abs=1e-7)
        still = (here.motion == 0).all(axis=-1)
        assert still.any() and (~still).any() and len(start) == len(batch)


def test_motion_along_a_slide_is_its_axis() -> None:
    made = twist(FakeBatch(2))
    assert (made.turn[[2, 5]] == 0).all() and (made.shift[[2, 5]] == [-1, 0, 0]).all()
    assert (made.turn[[1, 4]] == [0, 0, 1]).all() and (made.turn[[0, 3]] == 0).all() and (made.shift[[0, 3]] == 0).all()
