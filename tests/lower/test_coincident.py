"""`check` warns of elements of a repeat that fill the same space."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

STOOL = """apg 1
use primitives {{ Cuboid, Cylinder }}
template Pair {{
  part lower : Cylinder(radius = 1cm, height = 20cm)
  part upper : Cylinder(radius = 1cm, height = 20cm)
  align upper.bottom = lower.top
}}
category Stool {{
  count legs in 2 .. 4
  root part seat : Cuboid(size = [30cm, 30cm, 3cm])
  repeat row[i] {form} {{
    part leg : {leg}
    connect leg.top on seat.bottom{place}
  }}
}}
"""
ABOUT = "about line(at = seat.center, along = z)"
ROUND, SQUARE = "Cylinder(radius = 1cm, height = 4cm)", "Cuboid(size = [2cm, 2cm, 4cm])"
CROSSED = "Cuboid(size = [2cm, 20cm, 4cm]) turned 20deg about z"


@pytest.mark.parametrize(
    ("form", "leg", "place", "told"),
    [
        ("in 0 ..< legs", ROUND, "", True),
        ("in 0 ..< legs", "Pair", "", True),  # of a template, the part is told once
        ("in 0 ..< legs", ROUND, " at x = i * 3cm, y = 0", False),
        ("in 0 ..< legs spread seat along y margin 2cm", ROUND, "", False),
        ("in 0 ..< legs spread seat along y margin 2cm", ROUND, " at x = 0, y = 0", True),
        (f"ring 3 {ABOUT}", ROUND, "", True),  # however it is turned about itself
        (f"ring 4 {ABOUT}", SQUARE, "", True),
        (f"ring 3 {ABOUT}", CROSSED, "", False),
        (f"ring 3 {ABOUT}", ROUND, " at x = 5cm, y = 0", False),
        ("mirror across y", ROUND, "", True),
        ("mirror across y", CROSSED, "", False),
        ("mirror across y", ROUND, " at x = 0, y = 5cm", False),
    ],
)
def test_what_is_in_one_place_is_told(form: str, leg: str, place: str, told: bool) -> None:
    session = Session.of_text(STOOL.format(form=form, leg=leg, place=place))
    session.advise()
    found = [d for d in session.report.diagnostics if d.code == "coincident"]
    assert [d.span.line for d in found if d.span] == [12] * told
