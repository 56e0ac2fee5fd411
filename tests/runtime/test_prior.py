"""Weights of objects, resampling to the declared distributions, and preferences."""

import numpy as np
import pytest

from artipg_dsl.errors import UsageError
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.run.request import read_sampling
from artipg_dsl.sampling.module import to_module
from artipg_dsl.sampling.prior import CANDIDATES, count_effective
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.sampling.statistics import ATTEMPTS, Statistics
from artipg_dsl.session import Session

HEAD = "apg 1\nuse primitives { Cuboid }\ncategory C {\n"
TAIL = "\n root part body : Cuboid(size = [5cm, 5cm, 1cm])\n}\n"
COUPLED = """
  param a : length in 1cm .. 10cm = 2cm
  param b : length in 1cm .. 10cm = 2cm ~ normal(5cm, 2cm)
  param c : length in 1cm .. 10cm = 2cm ~ lognormal(4cm, 0.5)
  param d : length in 1cm .. 8cm = 2cm ~ values(2cm, 4cm, 6cm, 8cm)
  count n in 1 .. 6 = 2
  param kind : choice small | large = small
  require a + b <= 9cm
  require n * a <= 20cm
  require c <= 2 * a
  require d <= a + b
  require kind == small or n * c >= 6cm
"""


def sampler(text: str) -> Sampler:
    return Session.of_text(HEAD + text + TAIL).sampler


def columns(batch) -> dict[str, np.ndarray]:
    return {d.column.name: batch.state.values[k] for k, d in enumerate(batch.program.draws)}


def by_rejection(count: int) -> dict[str, np.ndarray]:
    """The declared distributions of ``COUPLED``, restricted to what is valid, drawn independently with NumPy alone."""
    rng = np.random.default_rng(0)
    a = rng.uniform(0.01, 0.1, count)
    b = rng.normal(0.05, 0.02, count)
    c = 0.04 * np.exp(0.5 * rng.normal(size=count))
    d, n, kind = rng.choice([0.02, 0.04, 0.06, 0.08], count), rng.integers(1, 7, count), rng.integers(0, 2, count)
    ok = (
        (b >= 0.01)
        & (b <= 0.1)
        & (c >= 0.01)
        & (c <= 0.1)
        & (a + b <= 0.09)
        & (n * a <= 0.2)
        & (c <= 2 * a)
        & (d <= a + b)
    )
    ok &= (kind == 0) | (n * c >= 0.06)
    return {name: value[ok] for name, value in zip("a b c d n kind".split(), (a, b, c, d, n, kind), strict=True)}


def distance(first: np.ndarray, second: np.ndarray, weight: np.ndarray | None = None) -> float:
    """Kolmogorov and Smirnov's distance of two samples, the first one weighted."""
    weight = np.ones(len(first)) if weight is None else weight
    marks = np.unique(np.concatenate([np.round(first, 9), np.round(second, 9)]))
    order = np.argsort(np.round(first, 9), kind="stable")
    total = np.concatenate([[0.0], np.cumsum(weight[order])]) / weight.sum()
    ours = total[np.searchsorted(np.round(first, 9)[order], marks, side="right")]
    theirs = np.searchsorted(np.sort(np.round(second, 9)), marks, side="right") / len(second)
    return float(np.abs(ours - theirs).max())


def test_weights_and_resampling_give_the_declared_distributions():
    program, reference = sampler(COUPLED), by_rejection(600_000)
    plain = program.batch(np.arange(8000), 3)
    resampled = program.batch(np.arange(4000), 3, candidates=64)
    weight = np.exp(plain.log_weight - plain.log_weight.max())
    shifted = max(distance(v, reference[k]) for k, v in columns(plain).items())
    weighted = max(distance(v, reference[k], weight) for k, v in columns(plain).items())
    chosen = max(distance(v, reference[k]) for k, v in columns(resampled).items())
    assert shifted > 0.15  # drawing in sequence does shift these
    assert weighted < 0.06 and chosen < 0.05
    assert not resampled.state.failed.any()


def test_the_weight_of_given_values_is_their_likelihood():
    program = sampler(COUPLED)
    numbers = {d.column.name: k for k, d in enumerate(program.program.draws)}
    given = {numbers["c"]: 0.05, numbers["n"]: 2.0}
    found = columns(program.batch(np.arange(4000), 1, given=given, candidates=64))
    rng = np.random.default_rng(1)
    a, b = rng.uniform(0.01, 0.1, 400_000), rng.normal(0.05, 0.02, 400_000)
    d = rng.choice([0.02, 0.04, 0.06, 0.08], 400_000)
    ok = (b >= 0.01) & (a + b <= 0.09) & (a >= 0.025) & (d <= a + b)
    assert (
        distance(found["a"], a[ok]) < 0.05 and distance(found["b"], b[ok]) < 0.05 and distance(found["d"], d[ok]) < 0.05
    )
    assert set(found["c"]) == {0.05} and set(found["n"]) == {2.0}


def test_a_program_without_requirements_weighs_nothing():
    batch = sampler("param a : length in 1cm .. 10cm = 2cm ~ normal(5cm, 2cm)\n count n in 1 .. 3 = 2").batch(
        np.arange(20), 0
    )
    assert not batch.log_weight.any()


def test_weights_and_choices_do_not_depend_on_the_batch():
    program = sampler(COUPLED)
    whole = program.batch(np.arange(300), 5, candidates=16)
    parts = [program.batch(np.array(some), 5, candidates=16) for some in ([7], range(100, 300), [299, 3])]
    for part in parts:
        at = part.numbers
        assert np.array_equal(part.state.attempt, whole.state.attempt[at])
        assert np.array_equal(part.log_weight, whole.log_weight[at])
        for name, value in columns(part).items():
            assert np.array_equal(value, columns(whole)[name][at])


def test_statistics_tell_the_effective_number_of_candidates():
    counted = Statistics()
    sampler(COUPLED).batch(np.arange(50), 0, statistics=counted, candidates=CANDIDATES)
    assert counted.candidates == CANDIDATES and counted.objects == 50 and counted.attempts >= 50 * CANDIDATES
    assert 50 < counted.effective < counted.candidates_valid <= counted.attempts
    assert np.allclose(
        count_effective(np.array([[0.0, 0.0, -np.inf], [-np.inf] * 3, [0.0, -800.0, -900.0]])), [2.0, 0.0, 1.0]
    )


@pytest.mark.parametrize("text", ["", "before", "prior:", "prior:1", "prior:x", "sequential:3", "prior:100000"])
def test_another_sampling_is_refused(text):
    assert read_sampling("prior") == CANDIDATES and read_sampling("prior:8") == 8 and read_sampling("sequential") == 0
    with pytest.raises(UsageError, match="unknown sampling"):
        read_sampling(text)


PREFERRED = "param a : length in 1cm .. 10cm = 2cm\n param b : length in 1cm .. 10cm = 2cm\n prefer a >= b weight 2"


def test_an_object_that_a_preference_is_against_is_rarer_by_its_weight():
    program, counted = sampler(PREFERRED), Statistics()
    for candidates in (0, 64):
        found = columns(program.batch(np.arange(6000), 0, statistics=counted, candidates=candidates))
        share = float((found["a"] < found["b"]).mean())
        assert abs(share / (1 - share) - np.exp(-2.0)) < 0.03
        assert candidates or (counted.first_valid == 6000 and counted.declined > 2000)


def test_a_preference_never_keeps_an_object_from_being_made():
    program, counted = sampler("param a : length in 1cm .. 10cm = 2cm\n prefer a >= 11cm weight 1000"), Statistics()
    batch = program.batch(np.arange(3), 0, statistics=counted)
    assert not batch.state.attempt.any()  # the first valid attempt, since none is preferred
    assert counted.first_valid == 3 and counted.attempts == 3 * ATTEMPTS


def test_a_preference_counts_for_each_row():
    text = "repeat post[i] in 0 ..< 2 { param h : length in 1cm .. 2cm = 1cm  prefer h >= 1.5cm weight 0.7 }"
    found = sampler(text).batch(np.arange(6000), 0).state.values[0].reshape(-1, 2)
    low = (found < 0.015).sum(axis=1)
    counts = np.bincount(low, minlength=3) / len(low)
    odds = np.exp(-0.7 * np.arange(3)) * np.array([1, 2, 1])
    assert np.abs(counts - odds / odds.sum()).max() < 0.02


def test_preferences_are_in_the_text_form_and_in_modules():
    program = sampler(PREFERRED).program
    assert to_text(from_text(to_text(program))) == to_text(program)
    space: dict = {}
    exec(compile(to_module(program, "0"), "<module>", "exec"), space)
    batch = Sampler(program).batch(np.arange(40), 4)
    state, _, _ = space["evaluate_valid"](range(40), 4)
    assert np.array_equal(state.attempt, batch.state.attempt) and batch.state.attempt.any()


def test_a_preference_cannot_weigh_less_than_nothing():
    session = Session.of_text(HEAD + PREFERRED.replace("weight 2", "weight -1") + TAIL)
    assert session.lowering is None and "must be above 0" in session.report.diagnostics[0].message
