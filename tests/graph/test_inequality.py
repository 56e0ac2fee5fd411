"""Requirements that no linear form holds still narrow the draws: first attempts are valid, and nothing valid is lost."""

import numpy as np
import pytest

from artipg_dsl.sampling.statistics import Statistics
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
category Box {{
  param a : length in 1cm .. 10cm
  param b : length in 1cm .. 10cm
  param k : ratio in -1 .. 1
  root part body : Cuboid(size = [a, b, 10cm])
  {}
}}
"""
EXACT = {
    "require a * a + b * b <= 7cm * 7cm": lambda a, b, k: a * a + b * b <= 0.0049,
    "require hypot(a, b) <= 6cm": lambda a, b, k: np.hypot(a, b) <= 0.06,
    "require sqrt(b / 1m) <= a / 10cm": lambda a, b, k: np.sqrt(b) <= a / 0.1,
    "require a / b <= 0.3": lambda a, b, k: a / b <= 0.3,
    "require abs(a - b) <= 5mm": lambda a, b, k: abs(a - b) <= 0.005,
    "require max(a, b) <= 3cm": lambda a, b, k: np.maximum(a, b) <= 0.03,
    "require max(a, b) >= 9cm": lambda a, b, k: np.maximum(a, b) >= 0.09,
    "require k * a >= 2cm": lambda a, b, k: k * a >= 0.02,
    "require (a + b) * (b + a / 2) <= 9cm * 9cm": lambda a, b, k: (a + b) * (b + a / 2) <= 0.0081,
    "require b * (b + a) <= 20cm * 1cm": lambda a, b, k: b * (b + a) <= 0.002,
    "require a + 1cm * k * k <= b": lambda a, b, k: a + 0.01 * k * k <= b,
    "require a * b >= 50cm * 1cm": lambda a, b, k: a * b >= 0.005,
}


@pytest.mark.parametrize("requirement", EXACT)
def test_every_first_attempt_is_valid(requirement: str) -> None:
    statistics = Statistics()
    batch = Session.of_text(TEXT.format(requirement)).sampler.batch(np.arange(300), 0, statistics=statistics)
    assert statistics.first_valid == 300
    a, b, k = (batch.values()[name] for name in ("a", "b", "k"))
    assert EXACT[requirement](a, b, k).mean() > 0.99  # but for the last bit


@pytest.mark.parametrize("requirement", EXACT)
def test_no_valid_value_is_excluded(requirement: str) -> None:
    """Any valid values, given to the draws, lie within their conditional ranges."""
    lots = np.random.default_rng(0).random((3, 60_000))
    a, b, k = 0.01 + 0.09 * lots[0], 0.01 + 0.09 * lots[1], 2.0 * lots[2] - 1.0
    inside = np.flatnonzero(EXACT[requirement](a, b, k))[:500]
    sampler = Session.of_text(TEXT.format(requirement)).sampler
    given = {n: {"a": a, "b": b, "k": k}[d.column.name][inside] for n, d in enumerate(sampler.program.draws)}
    statistics = Statistics()
    sampler.batch(np.arange(len(inside)), 0, given=given, statistics=statistics)
    assert statistics.first_valid == len(inside) > 100
