"""What a formula says at a point is a number, and a degree lies in 0 .. 1: otherwise the label is reported with its line."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.api import load
from artipg_dsl.errors import UserError
from artipg_dsl.runtime.kernels import State
from artipg_dsl.sampling.known import make_batch
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.sampling.statistics import Exhausted, Statistics
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid }
use vocabularies { affordance }
category Block {
  root part body : Cuboid(size = [20cm, 20cm, 4cm])
  SAY
}
"""


def points(said: str):  # noqa: ANN201
    sampler = Session.of_text(TEXT.replace("SAY", said), "block.apg").sampler
    first = State(1, np.arange(3) + 7, np.zeros(3, dtype=np.int64))  # drawn, and looked at no further
    batch = make_batch(sampler.program, sampler.plan, first)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return sample_points(batch, 256)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (
            "field f : ratio on body = sqrt(p.x / 1m)",
            "block.apg:6: the field `f` has no value at some point of object 7",
        ),
        ("field f : ratio on body = 1 / (p.x - 10cm) * 1m", "the field `f` has no value"),
        ("field f : vec on body = n * log(p.y / 1m)", "the field `f` has no value"),
        (
            "label affordance.push on body = sqrt(p.x / 1m)",
            "the label `push` is not a degree from 0 to 1 at some point of object 7",
        ),
        ("label affordance.push on body = 1 + p.x / 1m", "the label `push` is not a degree from 0 to 1"),
    ],
)
def test_what_is_no_number_at_a_point_is_reported(said: str, message: str) -> None:
    with pytest.raises(UserError, match=message.replace("(", r"\(")):
        points(said)


@pytest.mark.parametrize(
    ("said", "name"),
    [
        ("field f : ratio on body where p.x >= 0 = sqrt(p.x / 1m)", "field.f"),
        ("field f : ratio on body = sqrt(p.x / 1m) if p.x > 0 else 0", "field.f"),
        ("label affordance.push on body where p.x > 0 = min(1, 1cm / p.x)", "affordance.push"),
        ("label affordance.push on body = 1 - abs(p.x) / (size.x / 2)", "affordance.push"),
    ],
)
def test_what_is_not_taken_need_not_have_a_value(said: str, name: str) -> None:
    found = points(said).labels[name]
    told = found[~np.isnan(found)]
    assert len(told) and (told >= 0.0).all() and (told <= 1.0).all()


# ---------------------------------------------------------------- drawn again

SOMETIMES = [
    ("field f : ratio on body = sqrt(q + 1/2 + p.x / size.x)", "block.apg:7: the field `f` has no value at some point"),
    ("field f : vec on body = n * log(q + 1/2 + p.y / 1m)", "block.apg:7: the field `f` has no value at some point"),
    (
        "label affordance.push on body = q + 1/2 + p.x / size.x / 4",
        "block.apg:7: the label `push` is not a degree from 0 to 1 at some point",
    ),
]


def sometimes(said: str) -> Sampler:
    return Session.of_text(TEXT.replace("SAY", "param q : ratio in -1 .. 1\n  " + said), "block.apg").sampler


@pytest.mark.parametrize("checked", [True, False])
@pytest.mark.parametrize(("said", "words"), SOMETIMES)
def test_objects_in_which_a_label_has_no_value_are_drawn_again(said: str, words: str, checked: bool) -> None:
    sampler, counted = sometimes(said), Statistics()
    batch = sampler.batch(np.arange(16), 3, checked=checked, statistics=counted)
    assert 0 < counted.first_valid < 16 and counted.unsound[words] == counted.attempts - 16
    for number in (64, 1000):
        assert len(sample_points(batch, number).labels)
    for k in range(16):
        alone = sampler.batch(np.array([k]), 3, checked=checked)
        assert alone.drawn(0) == batch.drawn(k)


def test_a_label_that_never_has_a_value_leaves_no_object() -> None:
    with pytest.raises(Exhausted) as found:
        sometimes("field f : ratio on body = sqrt(p.x / 1m)").batch(np.arange(4), 0)
    assert set(found.value.statistics.unsound) == {"block.apg:7: the field `f` has no value at some point"}


@pytest.mark.parametrize("checked", [True, False])
def test_mutants_and_the_python_interface_give_none_either(checked: bool) -> None:
    text = TEXT.replace("SAY", f"param q : ratio in -1 .. 1 vary 100%\n  {SOMETIMES[0][0]}")
    samples = load(text, 12, 3, checked=checked)
    for one in (samples, samples.mutate(), samples.mutate(variant=1, strength=2.0)):
        assert len(one.points(256).labels)
