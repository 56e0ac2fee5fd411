"""Candidates whose elements are yet to be put together are rivals of others, which a mean distance would prefer."""

from __future__ import annotations

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit import decide as decisions
from artipg_dsl.fit.compare import Candidates, Targets
from artipg_dsl.fit.model import Changes, Model, Placed
from artipg_dsl.fit.pose import Frame, pose, targets
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.repeats import held
from artipg_dsl.fit.search import Effort, _rivals, taken

SHELF = """
apg 1
use primitives { Cuboid }
role Filling { inherit size : length[3] }
template Leaf : Filling {
  part sheet : Cuboid(size = [2cm, size.y, size.z])
  align sheet.front = front
}
template Rows : Filling {
  count rows in 2 .. 4 = 2
  repeat row[r] in 0 ..< rows split box along z {
    part board : Cuboid(size = [size.x, size.y, 2cm])
    align board.bottom = row.bottom
    part sheet : Cuboid(size = [2cm, size.y, row.size.z - 3cm]) | none
    when sheet {
      align sheet.front = front
      align sheet.bottom = row.bottom + 2cm
    }
  }
}
category Shelf {
  param width : length in 60cm .. 100cm = 80cm
  root part wall : Cuboid(size = [2cm, width, 120cm])
  part filling : Filling(size = [30cm, width, 120cm]) = Leaf | Rows
  connect filling.back on wall.front
}
"""
N = 2


@pytest.fixture(scope="module")
def shelves() -> tuple[Model, Candidates, Targets]:
    """Two shelves with rows, as candidates."""
    samples = apg.load(SHELF, n=5, seed=3)
    model = Model(samples.job.sampler)
    some = np.flatnonzero(held(model, samples.batch)[:, 0])[:N]
    points = samples.points(20_000)
    posed = [
        pose(
            Cloud(points.position[k], points.normal[k], np.full(20_000, -1), ()),
            Frame(front="x", unit="m"),
            ".npz",
            1.0,
        )
        for k in some
    ]
    batch, placed = model.assembled([(samples.batch, some)]), Placed(np.ones(N), np.zeros((N, 3)))
    return model, Candidates(batch, np.arange(N), placed, np.zeros(N)), targets(posed)


def changed(model: Model, found: Candidates, name: str) -> Candidates:
    """The candidates with the next value of the draw of a name."""
    number = next(k for k in model.discrete if model.program.draws[k].column.name == name)
    every, old = np.arange(N), found.batch.state.values[number]
    other = np.where(old == old.max(), old - 1.0, old + 1.0)
    return replace(found, batch=model.altered(found.batch, every, Changes(every, np.full(N, number), every, other)))


def test_what_has_repeats_that_the_best_has_not_is_a_rival(shelves: tuple[Model, Candidates, Targets]) -> None:
    model, rows, clouds = shelves
    leaf = replace(changed(model, rows, "filling"), score=np.ones(N))
    assert not held(model, leaf.batch).any()
    rows = replace(rows, score=np.array([1.4, 1.6]))
    assert _rivals(model, rows, leaf, clouds).target.tolist() == [0]
    assert not len(_rivals(model, leaf, rows, clouds))
    two_sides, last = replace(clouds, of=np.zeros(N, dtype=np.int64)), np.array([1])
    assert not len(_rivals(model, taken(model, rows, last), taken(model, leaf, np.array([0])), two_sides))


@pytest.mark.slow
def test_a_rival_is_taken_once_its_elements_are_put_together(shelves: tuple[Model, Candidates, Targets]) -> None:
    model, true, clouds = shelves
    leaf, other = changed(model, true, "filling"), taken(model, changed(model, true, "filling.rows"), np.array([1]))
    with mock.patch.object(decisions, "varied", lambda _, own, now, clouds: now):
        found = decisions.decide(model, clouds, leaf, Effort(rounds=0, copies=16), other)
    assert held(model, found.batch)[:, 0].tolist() == [False, True]
    assert model.structures(found.batch)[1] == model.structures(true.batch)[1]
    assert found.target.tolist() == [0, 1]
