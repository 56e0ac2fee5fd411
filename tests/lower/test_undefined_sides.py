"""A comparison does not hold where one of its sides has no value, nor does its opposite."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
category Box {{
  param a, b : length in 1cm .. 3cm
  root part body : Cuboid(size = [a, b, 10cm])
  require {condition}
}}
"""


@pytest.mark.parametrize(
    "condition",
    [
        "sqrt(a - 2cm) != sqrt(b)",
        "not (sqrt(a - 2cm) == sqrt(b))",
        "not (sqrt(a - 2cm) == sqrt(b) and b > 1cm) and sqrt(a - 2cm) >= 0 * sqrt(b)",
        "log((a - 2cm) / 1cm) != 0.5",
        "((a - 2cm) / 1cm) ^ (1/2) != 0.5",
        "sqrt(a - 2cm) < sqrt(b) or not (sqrt(a - 2cm) < sqrt(b))",
    ],
)
def test_what_has_no_value_neither_equals_nor_differs(condition: str) -> None:
    session = Session.of_text(TEXT.format(condition=condition))
    batch = session.sampler.batch(np.arange(60), 0)
    told = [d.message for d in session.examine().diagnostics if d.code == "always-true"]
    assert told == []
    assert (batch.values()["a"] >= 0.02).all()


def test_a_division_by_what_may_be_0_neither_equals_nor_differs() -> None:
    text = TEXT.replace("length in 1cm .. 3cm", "count in 0 .. 2").replace("[a, b, 10cm]", "[1cm, 1cm, 10cm]")
    batch = Session.of_text(text.format(condition="a / b != 3")).sampler.batch(np.arange(60), 0)
    assert not ((batch.values()["a"] == 0) & (batch.values()["b"] == 0)).any()


def test_whole_numbers_still_differ() -> None:
    text = TEXT.replace("length in 1cm .. 3cm", "count in 0 .. 2").replace("[a, b, 10cm]", "[1cm, 1cm, 10cm]")
    batch = Session.of_text(text.format(condition="not (a / 2 == b / 2)")).sampler.batch(np.arange(60), 0)
    assert (batch.values()["a"] != batch.values()["b"]).all()
    assert (batch.state.attempt == 0).all()  # the draw leaves out the other's value
