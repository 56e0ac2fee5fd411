"""Elements of repeats keep their order and stand the right way round: margins, gaps and weights leave room for them."""

from __future__ import annotations

import pytest

import artipg_dsl
from artipg_dsl.session import Session

ROW = """use primitives {{ Cuboid }}
category T {{
  root part body : Cuboid(size = [10cm, 30cm, 5cm])
  param d : length in 1cm .. 20cm
  count n in 1 .. 3
  repeat row[i] in 0 ..< {count} {form} {{
    part peg : Cuboid(size = [1cm, 1cm, 1cm])
    connect peg.bottom on body.top
    align peg.center.y = row.center.y
  }}
}}"""


@pytest.mark.parametrize(
    ("form", "message"),
    [
        (
            "spread body along y margin 16cm",
            "the room between the margins of `row` is -2cm, but it must not be negative",
        ),
        (
            "split body along y gap 16cm",
            "what the gaps leave to the elements of `row` is -2cm, but it must not be negative",
        ),
        (
            "split body along y each -2cm .. 20cm",
            "the least size of an element of `row` is -2cm, but sizes must not be negative and are at most 1 km",
        ),
        (
            "split body along y weight i - 5",
            "the weight of an element of `row` is at most -3, but a weight must be finite and not negative",
        ),
    ],
)
def test_elements_without_room_are_an_error(form: str, message: str) -> None:
    session = Session.of_text(ROW.format(form=form, count=3))
    assert session.lowering is None
    (found,) = session.report.diagnostics
    assert (found.code, found.message) == ("illegal-value", message)


@pytest.mark.parametrize(("form", "most"), [("spread body along y margin d", 0.15), ("split body along y gap d", 0.3)])
def test_an_object_whose_elements_have_no_room_is_drawn_again(form: str, most: float) -> None:
    some = artipg_dsl.load(ROW.format(form=form, count="n"), n=60, checked=False)
    crowded = some["n"] > 1
    assert (some["d"][crowded] * (some["n"][crowded] - 1 if "gap" in form else 1) <= most + 1e-9).all()
    assert (some["d"][~crowded] > most).any() or "gap" in form
    alone = artipg_dsl.load(ROW.format(form=form, count="n"), set={"n": 1, "d": "19cm"})
    assert alone["d"].tolist() == pytest.approx([0.19])
