"""An argument that lies outside the range of its parameter whatever is drawn is told; one that may lie inside takes effect."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

FEET = """
use primitives { Cuboid }
template Foot {
  param high : length in 5mm .. 40mm = 20mm
  param plan : length[2] in [1cm, 2cm] .. [3cm, 6cm] = [2cm, 3cm]
  param lip  : length in 1mm .. high = 2mm
  count pads in 1 .. 4 = 1
  let rest = plan.x / 2
  part block : Cuboid(size = [plan.x, plan.y, high])
  require lip < 1m and pads < 9 and rest > 0
}
role Leg {
  inherit reach : length in 5cm .. 20cm
}
template Post : Leg {
  param thick : length in 5mm .. 2cm = 1cm
  part bar : Cuboid(size = [thick, thick, reach])
}
"""
STOOL = """category Stool {
  param wide  : length in 1m .. 2m
  param some  : length in 3cm .. 6cm
  count many in 5 .. 6
  let deep = 20cm
  root part seat : Cuboid(size = [wide, 30cm, 3cm])
"""


def warned(part: str) -> list[tuple[str, str]]:
    made = Session.of_text(f"apg 1{FEET}{STOOL}  {part}\n}}\n", "stool.apg")
    assert made.lowering is not None
    found = [d for d in made.report.diagnostics if d.code == "argument-outside-range"]
    assert all(d.severity == "warning" and d.notes for d in found)
    return [(d.span.text if d.span else "", d.message) for d in found]


@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("high = wide", "`Foot` has `high` in 5mm .. 40mm, and this is at least 100cm"),
        ("high = wide / 1000", "`Foot` has `high` in 5mm .. 40mm, and this is at most 2mm"),
        ("high = deep", "`Foot` has `high` in 5mm .. 40mm, and this is 20cm"),
        ("high = seat.size.y", "`Foot` has `high` in 5mm .. 40mm, and this is 30cm"),
        ("plan = [some / 2, wide]", "`Foot` has `plan` in [1cm, 2cm] .. [3cm, 6cm], and this is at least 100cm"),
        ("pads = many", "`Foot` has `pads` in 1 .. 4, and this is at least 5"),
        ("high = 2cm, lip = some", "`Foot` has `lip` in 1mm .. high, and this is at least 3cm"),
    ],
)
def test_an_argument_that_is_never_in_its_range(argument: str, message: str) -> None:
    text = argument.split("2cm, ")[-1] if argument.startswith("high = 2cm") else argument
    assert warned(f"part foot : Foot({argument})\n  connect foot.top on seat.bottom") == [(text, message)]


@pytest.mark.parametrize("argument", ["high = some", "high = wide / 50", "plan = [some / 2, some]", "lip = some"])
def test_an_argument_that_may_lie_in_its_range_takes_effect(argument: str) -> None:
    assert warned(f"part foot : Foot({argument})\n  connect foot.top on seat.bottom") == []


def test_arguments_of_roles_and_alternatives() -> None:
    part = "part leg : Leg(reach = wide) = Post(thick = some) | none\n  connect leg.top on seat.bottom"
    assert warned(part) == [
        ("reach = wide", "`Leg` has `reach` in 5cm .. 20cm, and this is at least 100cm"),
        ("thick = some", "`Post` has `thick` in 5mm .. 2cm, and this is at least 3cm"),
    ]


def test_what_the_text_alone_shows_is_told_once() -> None:
    part = "part foot : Foot(high = 20m)\n  connect foot.top on seat.bottom"
    assert warned(part) == [("high = 20m", "`Foot` has `high` in 5mm .. 40mm")]


@pytest.mark.parametrize(
    ("low", "argument", "told"),
    [
        ("-6mm", "radius = much, height = some", ["radius = much"]),
        ("-6mm", "radius = some, height = some, top_radius = much", ["top_radius = much"]),
        ("0mm", "radius = much, height = some", []),
        ("-6mm", "radius = 7mm + much, height = some", []),
    ],
)
def test_a_range_below_what_is_above_0(low: str, argument: str, told: list[str]) -> None:
    text = FEET.replace("{ Cuboid }", "{ Cuboid, Cylinder }")
    more = f"param much : length in {low} .. 10mm\n  part peg : Cylinder({argument})\n  connect peg.top on seat.bottom"
    made = Session.of_text(f"apg 1{text}{STOOL}  {more}\n}}\n", "stool.apg")
    assert made.lowering is not None
    found = [d for d in made.report.diagnostics if d.code == "argument-outside-range"]
    assert [d.span.text for d in found if d.span] == told
    assert all("the range of `much` begins at -6mm" in d.message and d.notes for d in found)
