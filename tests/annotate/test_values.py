"""What a formula says at a point is a number, and a degree lies in 0 .. 1: otherwise the label is reported with its line."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.errors import UserError
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
    batch = Session.of_text(TEXT.replace("SAY", said), "block.apg").sampler.batch(np.arange(3) + 7, seed=1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return sample_points(batch, 256)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ("field f : ratio on body = sqrt(p.x / 1m)", "block.apg:6: the field `f` has no value at a point of object 7"),
        ("field f : ratio on body = 1 / (p.x - 10cm) * 1m", "the field `f` has no value"),
        ("field f : vec on body = n * log(p.y / 1m)", "the field `f` has no value"),
        ("label affordance.push on body = sqrt(p.x / 1m)", "the label `push` is not a degree from 0 to 1 at a point of object 7"),
        ("label affordance.push on body = 1 + p.x / 1m", "the label `push` is not a degree from 0 to 1"),
    ],
)  # fmt: skip
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
)  # fmt: skip
def test_what_is_not_taken_need_not_have_a_value(said: str, name: str) -> None:
    found = points(said).labels[name]
    told = found[~np.isnan(found)]
    assert len(told) and (told >= 0.0).all() and (told <= 1.0).all()
