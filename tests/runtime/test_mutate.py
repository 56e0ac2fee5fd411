"""Mutation: what is kept, what changes, and that mutants are as valid as samples."""

import numpy as np
import pytest

from artipg_dsl.runtime.mutate import changes, mutate, structural
from artipg_dsl.runtime.sample import Statistics


@pytest.fixture(scope="module")
def batch(microwave):
    return microwave.batch(np.arange(120), seed=2)


def kinds(before, after, index):
    return {c.kind for c in changes(before, after, index)}


def test_without_operations_nothing_changes(microwave, batch):
    same = mutate(microwave, batch, operations=())
    assert all(not changes(batch, same, i) for i in range(len(batch)))
    for a, b in zip(batch.sites(), same.sites(), strict=True):
        assert np.array_equal(a.translation, b.translation)


def test_apa_swaps_templates_and_keeps_what_the_role_inherits(microwave, batch):
    mutant = mutate(microwave, batch, operations=("apa",), only="handle")
    number = next(k for k, d in enumerate(microwave.program.draws) if d.address == "handle")
    assert number in structural(microwave.program)
    assert (mutant.state.values[number] != batch.state.values[number]).all()
    sizes = [k for k, d in enumerate(microwave.program.draws) if d.address.startswith("handle.size")]
    kept = np.ones(len(batch), dtype=bool)
    for k in sizes:
        kept &= np.abs(mutant.state.values[k] - batch.state.values[k]) < 1e-12
    assert kept.mean() > 0.5  # the others had to adapt to the new template
    other = next(k for k, d in enumerate(microwave.program.draws) if d.address == "width")
    assert np.array_equal(mutant.state.values[other], batch.state.values[other])


def test_dpa_changes_counts_and_kept_ranks_keep_their_draws(microwave, batch):
    mutant = mutate(microwave, batch, operations=("dpa",))
    changed = [i for i in range(len(batch)) if "recounted" in kinds(batch, mutant, i)]
    assert len(changed) > 0.75 * sum(any(c == "count" for c in _count_rows(batch, i)) for i in range(len(batch)))
    assert all(not kinds(batch, mutant, i) & {"swapped", "varied"} for i in range(len(batch)))


def _count_rows(batch, index):
    for draw in batch.program.draws:
        if (batch.owner(draw.column.scope) == index).any():
            yield draw.kind


def test_cpa_stays_within_the_declared_step(microwave, batch):
    mutant = mutate(microwave, batch, operations=("cpa",))
    number, draw = next((k, d) for k, d in enumerate(microwave.program.draws) if d.address == "width")
    assert draw.vary is not None and draw.vary[0]
    before, after = batch.state.values[number], mutant.state.values[number]
    assert (np.abs(after - before) <= draw.vary[1].constant * before + 1e-12).all()
    assert (after != before).all()
    half = mutate(microwave, batch, operations=("cpa",), strength=0.1).state.values[number]
    assert np.abs(half - before).max() < 0.15 * np.abs(after - before).max()


def test_mutants_are_valid_in_their_own_right(microwave, batch):
    statistics = Statistics()
    mutant = mutate(microwave, batch, statistics=statistics)
    assert not mutant.state.failed.any()
    assert statistics.first_valid > 0.9 * len(batch)
    for number, draw in enumerate(microwave.program.draws):
        if draw.kind == "choice":
            continue
        low, high = mutant.read([draw.low, draw.high], draw.column.scope)
        value = mutant.state.values[number]
        assert (value >= low - 1e-9).all() and (value <= high + 1e-9).all()


def test_a_mutant_is_the_same_alone_and_in_a_batch_and_variants_differ(microwave, batch):
    mutant = mutate(microwave, batch, variant=3)
    alone = mutate(microwave, microwave.batch(np.array([37]), seed=2), variant=3)
    assert alone.drawn(0) == mutant.drawn(37)
    assert mutate(microwave, batch, variant=4).drawn(37) != mutant.drawn(37)
    again = mutate(microwave, mutant, variant=3)
    assert again.drawn(37) != mutant.drawn(37)


def test_unrelated_draws_are_left_alone(microwave, batch):
    mutant = mutate(microwave, batch, operations=("cpa",), only="border")
    for i in range(20):
        assert {c.path for c in changes(batch, mutant, i) if c.kind == "varied"} == {"border"}


def test_unknown_operations_are_refused(microwave, batch):
    with pytest.raises(ValueError, match="apa, dpa, cpa"):
        mutate(microwave, batch, operations=("xpa",))
