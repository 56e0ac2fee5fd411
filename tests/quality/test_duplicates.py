"""Near-duplicates, real sizes and lines."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.quality.card import program_lines
from artipg_dsl.quality.duplicates import find_near_duplicates, find_ranges, hash_structure
from artipg_dsl.quality.sizes import Real, compare_sizes, measure_extents, read_reference
from artipg_dsl.session import categories

from .programs import CHEST, sampled


def test_near_duplicates_of_one_parameter_are_those_within_two_percent() -> None:
    text = "category Box { param w : length in 10cm .. 20cm  root part body : Cuboid(size = [w, w, w]) }"
    _, batch = sampled(text, 80)
    width = batch.state.values[0]
    close = np.abs(width[:, None] - width[None, :]) <= 0.02 * 0.1
    expected = np.array([close[i, :i].any() for i in range(80)])
    found = find_near_duplicates(batch)
    assert 0 < expected.sum() < 80
    assert found.sum() == expected.sum()  # of two that are close it is the later one
    assert np.array_equal(found, expected)


def test_other_choices_counts_or_graphs_set_apart() -> None:
    _, batch = sampled(CHEST, 300)
    lid, drawers = (batch.state.values[k] for k, d in enumerate(batch.program.draws) if d.kind != "real")
    mark = hash_structure(batch)
    pairs = np.stack([lid, drawers], axis=1)
    assert len(np.unique(mark)) == len(np.unique(pairs, axis=0)) == 6
    assert find_near_duplicates(batch).any()
    assert not find_near_duplicates(batch, np.arange(300)).any()


def test_without_parameters_the_same_choices_are_the_same_object() -> None:
    _, batch = sampled("category Box { count n in 1 .. 3  root part body : Cuboid(size = [n * 1cm, 1cm, 1cm]) }", 20)
    assert find_near_duplicates(batch).sum() == 17


def test_extents_are_those_of_what_is_there() -> None:
    text = """
category Turned {
  root part body : Cuboid(size = [10cm, 20cm, 30cm])
  part ball : Cylinder(radius = 5cm, height = 10cm) turned 45deg about x
  align ball.center = [0, 0, 40cm]
  connect ball to body
}"""
    size = measure_extents(sampled(text, 2)[1])
    reach = (0.05 + 0.05) / np.sqrt(2) * 2  # a disc and a rod at 45 degrees, not a box at 45 degrees
    assert size[:, :2] == pytest.approx(np.array([[0.1, 0.2], [0.1, 0.2]]), abs=1e-5)
    assert size[:, 2] == pytest.approx(0.15 + 0.4 + reach / 2, abs=2e-3)


def test_comparison_with_real_sizes() -> None:
    size = np.array([[0.1, 0.4, 1.0], [0.2, 0.2, 2.0], [0.3, 0.1, 3.0], [0.4, 0.2, 4.0]])
    width, depth, height = compare_sizes(size, Real(width=(0.15, 0.2, 0.25), height=(0.5, 2.5, 3.5)))
    assert (width.axis, width.within, width.ratio) == ("width", 0.5, 1.0)
    assert (depth.real, depth.within, depth.ratio) == (None, None, None) and depth.ours[1] == pytest.approx(0.25)
    assert (height.within, height.ratio) == (0.75, 1.0)
    width, depth, _ = compare_sizes(size, Real(width=(0.15, 0.35, 0.45), depth=(0.05, 0.15, 0.25), turned=True))
    assert width.ours[1] == pytest.approx(0.35) and depth.ours[1] == pytest.approx(0.15)
    assert (width.within, depth.within) == (1.0, 1.0)
    assert all(e.real is None for e in compare_sizes(size, None))


def test_every_shipped_category_has_real_sizes_and_a_reason_for_its_graphs() -> None:
    known = read_reference()
    assert set(known) == set(categories())
    for real in known.values():
        assert real.width and real.depth and real.height and real.source and real.graphs and real.why


@pytest.mark.parametrize(
    "text, word",
    [
        ("{", "Expecting"),
        ('{"categories": {"Box": {"width": [3, 2, 1]}}}', "rising"),
        ('{"categories": {"Box": {"widht": [1, 2, 3]}}}', "widht"),
        ('{"categories": {"Box": {"width": 3}}}', "not a file of real sizes"),
        ('{"categories": []}', "not a file of real sizes"),
        ("[]", "not a file of real sizes"),
        ("{}", "categories"),
    ],
)
def test_a_reference_that_is_none_is_told(text: str, word: str, tmp_path: Path) -> None:
    file = tmp_path / "sizes.json"
    file.write_text(text)
    with pytest.raises(UserError, match=word) as error:
        read_reference(file)
    assert str(file) in error.value.message


def test_a_reference_of_ones_own(tmp_path: Path) -> None:
    file = tmp_path / "sizes.json"
    file.write_text(
        json.dumps({"categories": {"Lamp": {"height": [0.2, 0.3, 0.5], "graphs": 3, "why": "they say so"}}})
    )
    assert read_reference(file) == {"Lamp": Real(height=(0.2, 0.3, 0.5), graphs=3, why="they say so")}


def test_lines_that_count() -> None:
    assert program_lines("apg 1\n\n# a remark\n## a document\ncategory A {\n  param a # here\n}\n") == 4


def test_ranges_may_be_those_of_other_objects() -> None:
    text = """
category Box {
  param w : length in 10cm .. 20cm
  param d : length in 0.5 * w .. w
  root part body : Cuboid(size = [w, d, 5cm])
}"""
    _, batch = sampled(text, 200)
    ranges = find_ranges(batch)
    assert ranges[0] == (0.1, 0.2) and ranges[1] == (batch.state.values[1].min(), batch.state.values[1].max())
    found = find_near_duplicates(batch)
    assert np.array_equal(find_near_duplicates(batch, ranges=ranges), found) and 0 < found.sum()
    narrow = find_near_duplicates(batch, ranges=(ranges[0], (0.1, 0.1)))  # a point: only equal values are close
    assert narrow.sum() == 0
