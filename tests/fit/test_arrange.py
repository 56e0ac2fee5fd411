"""Elements of repeats are put together anew: their number, where they end, and what is in each."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations
from unittest import mock

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.fit import arrange
from artipg_dsl.fit.arrange import rearranged
from artipg_dsl.fit.compare import Candidates
from artipg_dsl.fit.evidence import Clouds
from artipg_dsl.fit.model import Changes, Model, Placed
from artipg_dsl.fit.pose import Frame, pose, targets
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.fit.repeats import Layout, Places, contents_of, find_repeats, relaid
from artipg_dsl.fit.search import Effort

RACK = """
apg 1
use primitives { Cuboid }
category Rack {
  param width  : length in 60cm .. 100cm = 80cm
  param height : length in 120cm .. 200cm = 160cm
  root part wall : Cuboid(size = [2cm, width, height])
  count columns in 2 .. 3 = 2
  repeat column[c] in 0 ..< columns split wall along y {
    part post : Cuboid(size = [30cm, 2cm, wall.size.z])
    connect post.back on wall.front
    align post.right = column.right
    align post.bottom = wall.bottom
    count rows in 1 .. 4 = 2
    repeat cell[r] in 0 ..< rows split column along z weight share {
      param share : ratio in 1 .. 2.5 = 1
      part board : Cuboid(size = [28cm, cell.size.y - 4cm, 2cm])
      connect board.back on wall.front
      align board.center.y = cell.center.y
      align board.bottom = cell.bottom
      part rear : Cuboid(size = [5mm, cell.size.y - 4cm, cell.size.z - 1mm])
      connect rear.back on wall.front
      align rear.center.y = cell.center.y
      align rear.center.z = cell.center.z
      part front : Cuboid(size = [2cm, cell.size.y - 4cm, cell.size.z - 3cm]) | none
      when front {
        connect front.back on board.front
        align front.center.y = cell.center.y
        align front.bottom = board.top
      }
    }
  }
}
"""
N = 2


@pytest.fixture(scope="module")
def racks() -> tuple[Model, Candidates, Clouds]:
    samples = apg.load(RACK, n=N, seed=3)
    posed = [
        pose(Cloud(place, normal, np.full(len(place), -1), ()), Frame(front="x", unit="m"), ".npz", 1.0)
        for place, normal in zip(
            *(getattr(samples.points(20_000), name) for name in ("position", "normal")), strict=True
        )
    ]
    model, every = Model(samples.job.sampler), np.arange(N)
    true = model.assembled([(samples.batch, every)])
    still = Placed(np.ones(N), np.zeros((N, 3)))
    return model, Candidates(true, every, still, np.zeros(N)), Clouds(targets(posed))


def test_repeats_are_found_with_what_places_and_fills_them(racks: tuple[Model, Candidates, Clouds]) -> None:
    model, _, _ = racks
    names = [draw.column.name for draw in model.program.draws]
    column, cell = find_repeats(model)
    assert (names[column.count], column.weight) == ("columns", -1)
    assert (names[cell.count], names[cell.weight]) == ("column.rows", "column.cell.share")
    assert {names[k] for k in column.inside} == {"column.rows", "column.cell.share", "column.cell.front"}
    assert [names[k] for k in cell.inside] == ["column.cell.front"]
    assert column.holds(cell) and not cell.holds(column) and not cell.holds(cell)


def test_elements_keep_what_they_hold_where_they_are_put(racks: tuple[Model, Candidates, Clouds]) -> None:
    """All columns in the opposite order, with their cells: what is in the first is then in the last."""
    model, true, _ = racks
    column = find_repeats(model)[0]
    batch, every = true.batch, np.arange(N)
    places, rows = Places.of(batch, column), batch.rowmap.rows(column.scope)
    layout = Layout(every, every, rows.count, np.zeros((N, 0)))
    turned = rows.count[rows.parent] - 1 - rows.rank
    contents = contents_of(model, batch, column, np.arange(rows.size), rows.owner, turned)
    made = relaid(model, batch, every, np.full(N, 7), column, places, layout, contents)
    assert not made.state.failed.any()
    for number in column.inside:
        scope = model.program.draws[number].column.scope
        above, now = (one.rowmap.up(scope, column.scope) for one in (batch, made))
        before = np.lexsort((np.arange(len(above)), turned[above], batch.owner(scope)))
        assert np.array_equal(batch.state.values[number][before], made.state.values[number])
        assert np.array_equal(turned[above][before], made.rowmap.rows(column.scope).rank[now])


@pytest.mark.slow
def test_rows_of_several_columns_are_found_at_once(racks: tuple[Model, Candidates, Clouds]) -> None:
    """Each of five columns begins with one row; at least four of them get their three or four, with what is in their cells."""
    model, true, clouds = racks
    rows, front = (
        next(k for k in model.discrete if model.program.draws[k].column.name == name)
        for name in ("column.rows", "column.cell.front")
    )
    wanted = true.batch.state.values[rows]
    owner = true.batch.owner(model.program.draws[rows].column.scope)
    assert len(wanted) == 5 and (wanted > 2.0).all()
    changes = Changes(owner, np.full(5, rows), np.arange(5), np.ones(5))
    wrong = replace(true, batch=model.altered(true.batch, np.arange(N), changes))
    found = rearranged(model, clouds.targets, wrong, clouds, Effort())
    assert found.target.tolist() == [0, 1]
    now = found.batch.state.values[rows]
    assert (now == wanted).sum() >= 4
    column = model.program.draws[rows].column.scope
    scope = model.program.draws[front].column.scope
    mine, theirs = ((now == wanted)[one.batch.rowmap.up(scope, column)] for one in (found, true))
    assert np.array_equal(found.batch.state.values[front][mine], true.batch.state.values[front][theirs])


@pytest.mark.slow
def test_what_is_right_stays_so(racks: tuple[Model, Candidates, Clouds]) -> None:
    model, true, clouds = racks
    found = rearranged(model, clouds.targets, true, clouds, Effort(copies=32))
    assert (model.structures(found.batch) == model.structures(true.batch)[found.target]).all()


@pytest.mark.slow
def test_each_is_put_together_as_it_would_be_alone(racks: tuple[Model, Candidates, Clouds]) -> None:
    model, true, clouds = racks
    columns = next(k for k in model.discrete if model.program.draws[k].column.name == "columns")
    every = np.arange(N)
    other = 5.0 - true.batch.state.values[columns]
    wrong = replace(true, batch=model.altered(true.batch, every, Changes(every, np.full(N, columns), every, other)))
    effort = Effort(copies=32)
    found = rearranged(model, clouds.targets, wrong, clouds, effort)
    assert found.target.tolist() == [0, 1]
    last = np.array([1])
    own, batch = clouds.targets.take(last), model.assembled([(wrong.batch, last)])
    alone = Candidates(batch, np.zeros(1, dtype=np.int64), wrong.placed.take(last), np.zeros(1))
    one = rearranged(model, own, alone, Clouds(own), effort)
    assert np.array_equal(model.fingerprints(one.batch), model.fingerprints(found.batch)[1:])


def test_a_room_is_divided_at_all_choices_of_its_planes() -> None:
    planes = np.full((2, arrange._PLANES), np.nan)
    planes[0, :3] = 0.2, 0.5, 0.8
    with mock.patch.object(arrange, "_planes", return_value=planes):
        ends, many = arrange._parted(*[mock.Mock()] * 4)
    for row, some in enumerate(([0.2, 0.5, 0.8], [])):
        there = np.flatnonzero(~np.isnan(ends[row]).any(axis=1))
        found = [tuple(ends[row, k][np.isfinite(ends[row, k])].tolist()) for k in there]
        assert found == [(0.0, *one, 1.0) for n in range(len(some) + 1) for one in combinations(some, n)]
        assert [len(one) - 1 for one in found] == many[there].tolist()


def test_a_room_is_divided_into_equal_parts_as_well_where_a_scan_hides_its_planes() -> None:
    planes = np.full((3, arrange._PLANES), np.nan)
    planes[:, 0] = 0.4
    own, found, places = mock.Mock(), mock.Mock(), mock.Mock()
    own.scanned, found.target, places.owner = np.array([True, False]), np.array([1, 0]), np.array([0, 1, 1])
    with mock.patch.object(arrange, "_planes", return_value=planes):
        ends, many = arrange._divided(own, found, places, mock.Mock(), 4)
        own.scanned = np.zeros(2, dtype=bool)
        clean, few = arrange._divided(own, found, places, mock.Mock(), 4)

    def ways(ends: np.ndarray, many: np.ndarray, row: int) -> list[list[float]]:
        there = np.flatnonzero(~np.isnan(ends[row]).any(axis=1))
        assert (np.isfinite(ends[row, there]).sum(axis=1) == many[there] + 1).all()
        return [ends[row, k][np.isfinite(ends[row, k])].tolist() for k in there]

    equal = [[k / n for k in range(n + 1)] for n in (2, 3, 4)]
    whole, parted = [0.0, 1.0], [0.0, 0.4, 1.0]
    assert ways(ends, many, 0) == ways(clean, few, 0) == [whole, parted]
    assert ways(ends, many, 1) == ways(ends, many, 2) == [whole, *equal, parted]


def test_medians_are_those_of_each_group() -> None:
    values, of = np.random.default_rng(2).normal(size=(40, 3)), np.arange(40) % 7 // 2 * 2  # none of 1, 3 and 5
    found = arrange._medians(values, of, 7, np.inf)
    for k in range(7):
        right = np.median(values[of == k], axis=0) if (of == k).any() else np.full(3, np.inf)
        assert found[k].tobytes() == right.tobytes()
