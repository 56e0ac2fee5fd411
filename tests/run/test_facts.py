"""What is known of real objects: the objects that are left, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.errors import UserError
from artipg_dsl.fit.choices import choices_of
from artipg_dsl.fit.fitting import fit, usual_size
from artipg_dsl.fit.model import Model
from artipg_dsl.fit.pose import Frame, Posed, pose
from artipg_dsl.fit.reading import Cloud
from artipg_dsl.run.facts import apply_facts, read_facts
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session
from tests.fit.helpers import BOARD

N = 40
SHELF = """
apg 1
use primitives { Cuboid }
template Low  { param size : length[3]  count pegs in 1 .. 2 = 1  param lean : ratio in 0 .. 1 = 0.5
  part body : Cuboid(size = size) }
template High { param size : length[3]  count pegs in 3 .. 6 = 4
  part body : Cuboid(size = size) }
category Shelf {
  param width : length in 40cm .. 80cm = 60cm ~ normal(60cm, 5cm)
  param gap   : length in 1cm .. 5cm = 2cm ~ values(1cm, 2cm, 5cm)
  param tint  : choice red | green | blue = red ~ values(red, red, green, green, green, blue)
  count columns in 1 .. 4 = 2
  require columns * gap <= 12cm
  root part base : Low(size = [40cm, width, 5cm]) | High(size = [40cm, width, 5cm])
  repeat column[i] in 0 ..< columns split base along y {
    part post : Cuboid(size = [1cm, 1cm, 30cm])
    connect post.bottom on base.top
    align post.back = base.back
    count rows in 1 .. 3 = 2
    repeat cell[j] in 0 ..< rows {
      param kind : choice open | shut | glazed = open
      when kind == glazed { count panes in 1 .. 3 = 1 }
      part crate : Cuboid(size = [3cm, 2cm, 4cm])
      connect crate.back on post.front
      align crate.center.y = post.center.y
      align crate.bottom = post.bottom + 1cm + j * 6cm
    }
  }
}
"""


@pytest.fixture(scope="module")
def shelf() -> Sampler:
    return Session.of_text(SHELF).sampler


def drawn(sampler: Sampler, facts: dict[str, Any]) -> list[dict[str, Any]]:
    made = Sampler(apply_facts(sampler.program, facts, "known"))
    batch = made.batch(np.arange(N), 7)
    return [batch.drawn(k) for k in range(N)]


def test_without_facts_a_program_is_as_it_was(shelf: Sampler) -> None:
    batch = shelf.batch(np.arange(N), 7)
    assert drawn(shelf, {}) == [batch.drawn(k) for k in range(N)]


def test_values_options_and_ranges(shelf: Sampler) -> None:
    found = drawn(shelf, {"width": "50cm .. 55cm", "columns": 3, "tint": "green | blue", "gap": None})
    assert all(0.5 <= one["width"] <= 0.55 and one["columns"] == 3 for one in found)
    tints = [one["tint"] for one in found]
    assert set(tints) == {"green", "blue"} and tints.count("green") > tints.count("blue")  # by their weights
    assert len({one["width"] for one in found}) == N and {one["gap"] for one in found} > {0.01}
    assert {one["gap"] for one in drawn(shelf, {"gap": "2cm .. 5cm"})} == {0.02, 0.05}
    assert {one["width"] for one in drawn(shelf, {"width": 0.45})} == {0.45}
    assert all(one["width"] <= 0.45 for one in drawn(shelf, {"width": "10cm .. 45cm"}))  # as far as the program goes


def test_what_is_said_of_elements(shelf: Sampler) -> None:
    found = drawn(shelf, {"column.rows": [2, None, 1]})
    assert {one["columns"] for one in found} == {3}
    assert {(one["column.rows"][0], one["column.rows"][2]) for one in found} == {(2, 1)}
    assert {one["column.rows"][1] for one in found} == {1, 2, 3}
    found = drawn(shelf, {"column.cell.kind": [["shut", "open | glazed"], ["glazed"]]})
    assert {tuple(one["column.rows"]) for one in found} == {(2, 1)}
    assert {tuple(one["column.cell.kind"]) for one in found} == {("shut", x, "glazed") for x in ("open", "glazed")}
    found = drawn(shelf, {"column.cell.kind": ["shut", None]})  # all cells of the first column
    assert {one["columns"] for one in found} == {2}
    assert all(set(one["column.cell.kind"][: one["column.rows"][0]]) == {"shut"} for one in found)
    assert {one["column.rows"][0] for one in found} == {1, 2, 3}
    assert {kind for one in drawn(shelf, {"column.cell.kind": "shut"}) for kind in one["column.cell.kind"]} == {"shut"}


def test_an_alternative_that_cannot_have_a_value_is_excluded(shelf: Sampler) -> None:
    found = drawn(shelf, {"base.pegs": 5})
    assert {(one["base"], one["base.pegs"]) for one in found} == {("High", 5)}
    found = drawn(shelf, {"base.pegs": "2 .. 3"})
    assert {(one["base"], one["base.pegs"]) for one in found} <= {("Low", 2), ("High", 3)}
    found = drawn(shelf, {"base=High/base.pegs": 3})  # by its address: of the other nothing is said
    assert {(one["base"], one["base.pegs"]) for one in found} == {("High", 3), ("Low", 1), ("Low", 2)}


@pytest.mark.parametrize(
    ("facts", "told"),
    [
        ({"colums": 2}, "draws no `colums`.*did you mean `columns`"),
        ({"columns": 9}, "`columns` cannot be 9: it lies in 1 .. 4"),
        ({"columns": 1.5}, "is a count"),
        ({"columns": [2, 3]}, "`columns` is a list, but has one value"),
        ({"column.rows": [[1], [2]]}, "`column.rows` is a list, but has a list at most"),
        ({"column.cell.kind": [[["open"]]]}, "has a list in a list at most"),
        ({"column.rows": [1, 1, 1, 1, 1]}, "`columns` cannot be 5"),
        ({"columns": 3, "column.rows": [1, 1]}, "`column.rows` has 2 elements, but `columns` is told otherwise"),
        ({"tint": "rde"}, "cannot be `rde`.*did you mean `red`"),
        ({"tint": "red | rde"}, "cannot be `rde`"),
        ({"width": 45}, "it lies in 40cm .. 80cm"),
        ({"width": "50 .. 60"}, "has no unit"),
        ({"width": "60cm .. 50cm"}, "is empty"),
        ({"width": "50cm .."}, "cannot be ``: a number"),
        ({"gap": 0.03}, "none of its values"),
        ({"width": "10cm .. 20cm"}, "`width`: this range lies beside its distribution"),
        ({"columns": 4, "gap": "5cm"}, "no Shelf is left under `columns \\* gap <= 12cm`"),
        ({"base.lean": 0.5, "base": "Hihg"}, "did you mean `High`"),
    ],
)
def test_what_is_refused(shelf: Sampler, facts: dict[str, Any], told: str) -> None:
    with pytest.raises(UserError, match=f"^known: .*{told}"):
        apply_facts(shelf.program, facts, "known")


def test_choices_are_told_as_facts(shelf: Sampler) -> None:
    batch = shelf.batch(np.arange(N), 7)
    numbers = range(len(shelf.program.draws))
    for k in range(N):
        found = choices_of(batch, k, numbers)
        kinds, drawn = found["column.cell.kind"], batch.drawn(k)
        assert [len(column) for column in kinds] == found["column.rows"] == drawn["column.rows"]
        assert [kind for column in kinds for kind in column] == drawn["column.cell.kind"]
        panes = found.get("column.cell.panes", [[None] * len(column) for column in kinds])
        glazed = [[kind == "glazed" for kind in column] for column in kinds]
        assert [[pane is not None for pane in column] for column in panes] == glazed
        assert "width" not in found and (found["tint"], found["base.pegs"]) == (drawn["tint"], drawn["base.pegs"])
    for k in range(3):
        found = choices_of(batch, k, numbers)
        same = Sampler(apply_facts(shelf.program, found, "known")).batch(np.arange(4), 1)
        assert [choices_of(same, j, numbers) for j in range(4)] == [found] * 4


def test_facts_of_each_beside_those_of_all(shelf: Sampler) -> None:
    program, names = shelf.program, ["a", "b"]
    own = {"b": {"tint": "blue", "column.rows": np.array([1, 2])}}
    found = read_facts({"tint": "red", "columns": 2}, own, program, names)
    assert found == {"a": {"tint": "red", "columns": 2}, "b": {"tint": "blue", "columns": 2, "column.rows": [1, 2]}}
    assert read_facts({}, {"a": {}}, program, names) == {"a": {}} and read_facts({}, None, program, names) == {}
    for wrong, told in (
        ({"c": {}}, "no object is called c .those to be fitted are `a` and `b`"),
        ({"a": 3}, "facts: a is 3, and no facts"),
        ({"b": {"tint": "pink"}}, "facts: b: `tint` cannot be `pink`"),
    ):
        with pytest.raises(UserError, match=told):
            read_facts({}, wrong, program, names)
    with pytest.raises(UserError, match="what is set: `columns` cannot be 7"):
        read_facts({"columns": "7"}, None, program, names)


def clouds(model: Model, batch: Batch, points: int) -> list[Posed]:
    """The objects of a batch as clouds."""
    said = sample_points(batch, points)
    found = []
    for at, normal in zip(said.position, said.normal, strict=True):
        cloud = Cloud(at, normal, np.zeros(points, dtype=np.int64), ("",))
        found.append(pose(cloud, Frame(front="x", unit="m"), ".npz", usual_size(model)))
    return found


@pytest.mark.slow
def test_a_fit_has_what_is_known_though_the_cloud_speaks_against_it() -> None:
    sampler = Session.of_text(BOARD).sampler
    batch = Sampler(apply_facts(sampler.program, {"foot": "none", "cap": "none"}, "")).batch(np.arange(1), 1)
    width = batch.drawn(0)["width"]
    for known in ({}, {"foot": "Cuboid", "width": [width + 0.02]}):
        if known:
            known["width"] = f"{100 * width + 2}cm .. 80cm"
        model = Model(Sampler(apply_facts(sampler.program, known, "known")))
        (found,) = fit(model, clouds(model, batch, 4000))
        assert found.values["foot"] == ("Cuboid" if known else "none") and found.values["cap"] == "none"
        assert found.values["width"] == pytest.approx(width + (0.02 if known else 0.0), abs=1e-3)
        assert found.told["valid"]


def test_facts_that_leave_next_to_nothing_are_told() -> None:
    text = BOARD.replace("root part", "require not foot or sin(90deg * 1000 * width / 1m) >= 0.9999999999\n  root part")
    sampler = Session.of_text(text).sampler
    model = Model(Sampler(apply_facts(sampler.program, {"foot": "Cuboid"}, "known")))
    with pytest.raises(UserError, match="of 20000 objects that were drawn of Board, none is as it is known to be"):
        usual_size(model)
