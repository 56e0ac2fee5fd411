"""A strict inequality leaves its end out where the values are counted or listed."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
category Box {{
  root part body : Cuboid(size = [1cm, 1cm, 1cm])
  {}
}}
"""


@pytest.mark.parametrize(
    ("declared", "required", "holds"),
    [
        ("count a in 0 .. 4", "a * 5cm < 15cm", lambda a: a < 3),
        ("count a in 0 .. 4", "a / 2 > 1", lambda a: a > 2),
        ("count a in 0 .. 4", "mod(a, 2) < 1", lambda a: a % 2 < 1),
        ("count a in 0 .. 4", "hypot(a, 3) < 5", lambda a: a < 4),
        ("param a : ratio in 0 .. 1", "floor(4 * a) / 2 < 1", lambda a: a < 0.5),
        ("param a : choice p | q", "(1cm if a == p else 2cm) < 2cm", lambda a: a == 0),
        ("param a : length in 1cm .. 2cm ~ values(1cm, 15mm, 2cm)", "a < 2cm", lambda a: a < 0.02),
    ],
)
def test_the_end_is_left_out(declared: str, required: str, holds: Callable[[np.ndarray], np.ndarray]) -> None:
    sampler = Session.of_text(TEXT.format(f"{declared}\n  require {required}"), "box.apg").sampler
    values = sampler.batch(np.arange(200), 0).state.values[0]
    assert holds(values).all() and len(np.unique(values)) > (not declared.startswith("param a : choice"))


@pytest.mark.parametrize(
    ("required", "holds"),
    [
        ("not (sqrt(a) <= 1)", lambda a: a >= 1),
        ("not (sqrt(a) > 1)", lambda a: (a >= 0) & (a <= 1)),
        ("not (a <= 1 or log(a) > 1)", lambda a: (a >= 1) & (a <= np.e)),
        ("not (not (log(a) <= 1) and a < 10)", lambda a: (a > 0) & (a <= np.e)),
    ],
)
def test_the_opposite_of_what_has_no_value_does_not_hold(
    required: str, holds: Callable[[np.ndarray], np.ndarray]
) -> None:
    text = TEXT.format(f"param a : ratio in -4 .. 4\n  require {required}")
    values = Session.of_text(text, "box.apg").sampler.batch(np.arange(200), 0).state.values[0]
    assert holds(values).all() and np.ptp(values) > 0.5


def test_equal_constants_are_not_less() -> None:
    session = Session.of_text(TEXT.format("require 5cm > 5cm"), "box.apg")
    _ = session.lowering
    assert [d.code for d in session.report.diagnostics] == ["impossible"]


def test_a_formula_that_repeats_itself_is_looked_at_once() -> None:
    """Each value names the one before it twice: walked as a tree, that is 2^60 steps, which never end."""
    lets = "\n  ".join(f"let v{k + 1} = max(v{k}, 3 - v{k})" for k in range(60))
    session = Session.of_text(TEXT.format(f"count v0 in 0 .. 4\n  {lets}\n  require v60 < 9"), "box.apg")
    assert session.lowering is not None
