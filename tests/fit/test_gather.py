"""Candidates put together of others are what they would be, had they been evaluated again."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.fit.model import Model
from artipg_dsl.fit.states import tables
from artipg_dsl.sampling.known import evaluate_again
from artipg_dsl.session import Session


@pytest.mark.some
@pytest.mark.parametrize("name", ["Chair", "StorageFurniture", "Laptop"])
def test_what_is_gathered_is_what_is_evaluated(name: str) -> None:
    model, chance = Model(Session.of(name).sampler), np.random.default_rng(0)
    one, other = model.drawn(np.arange(60), 0), model.drawn(np.arange(60, 80), 0)
    valid = np.flatnonzero(~one.state.failed)
    some, rest = chance.permutation(valid)[:30], np.repeat(np.flatnonzero(~other.state.failed)[:5], 2)
    place = chance.permutation(40)
    made = model.assembled([(one, some), (other, rest)], [place[:30], place[30:]])
    numbers = np.empty(40, dtype=np.int64)
    numbers[place] = np.concatenate([one.numbers[some], other.numbers[rest]])
    again = evaluate_again(model.drawn(np.arange(80), 0), numbers, plan=model.plan)
    assert (made.numbers == numbers).all() and (model.structures(made) == model.structures(again)).all()
    for scope in model.plan.scopes:
        for field in ("size", "parent", "rank", "owner", "address", "start", "count"):
            assert np.array_equal(*(getattr(batch.rowmap.rows(scope), field) for batch in (made, again))), field
        wanted = [expr for expr, of in model.plan.outputs if of is scope]
        for left, right in zip(made.read(wanted, scope), again.read(wanted, scope), strict=True):
            assert left.dtype == right.dtype and left.tobytes() == right.tobytes()
    for number, value in again.state.values.items():
        assert np.array_equal(value, made.state.values[number])  # 0 may have another sign
    for left, right in zip(tables(made), again.sites(), strict=True):
        columns = (
            ("owner", "mirror", "rank") if name == "Laptop" else ("owner", "rotation", "translation", "mirror", "rank")
        )
        assert all(np.array_equal(getattr(left, column), getattr(right, column)) for column in columns)
        assert all(np.array_equal(left.params[key], value) for key, value in right.params.items())
    free, freed = model.freedoms(made), model.freedoms(again)
    assert np.array_equal(free.value, freed.value) and np.array_equal(free.low, freed.low)


def test_what_was_gathered_can_be_evaluated_further() -> None:
    """Values that its plan does not have are those of its own draws."""
    model = Model(Session.of("Chair").sampler)
    drawn = model.drawn(np.arange(40), 0)
    at = np.flatnonzero(~drawn.state.failed)[::2]
    made = model.assembled([(drawn, at)])
    part = model.program.parts[0]
    assert (part.low[0], part.scope) not in model.plan.outputs
    sampled = model.sampler.batch(drawn.numbers[at], 0)
    assert np.array_equal(made.read(part.low, part.scope), sampled.read(part.low, part.scope))
