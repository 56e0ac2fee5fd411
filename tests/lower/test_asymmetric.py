"""`check` warns of a symmetry that the box of the part does not have."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

TABLE = """apg 1
use primitives {{ Cuboid, Cylinder }}
use solids {{ Prism }}
category Table {{
  param wide : length in 30cm .. 60cm
  root part foot : Cuboid(size = [30cm, 30cm, 5cm])
  part top : {top}
  connect top to foot
  align top.bottom = foot.top
  symmetry top : {symmetry}
}}
"""
LYING = "Cylinder(radius = 5cm, height = 60cm) along x"


@pytest.mark.parametrize(
    ("top", "symmetry", "told"),
    [
        ("Cuboid(size = [20cm, 40cm, 3cm])", "turn 4 about z", "about its z: across it, it is 20 by 40 cm"),
        ("Cuboid(size = [20cm, 40cm, 3cm])", "turn 2 about z", None),
        ("Cuboid(size = [40cm, 40cm, 3cm])", "turn 4 about z", None),
        ("Cuboid(size = [2 * wide, 40cm, 3cm])", "any about z", "about its z"),
        ("Cuboid(size = [wide, wide, 3cm])", "turn 8 about z", None),
        (LYING, "any about z", None),  # its own z lies along x
        (LYING, "any about x", "about its x: across it, it is 10 by 60 cm"),
        (LYING, "turn 3 about x", "after 1/3 of a turn about its x: across it, it is 10 by 60 cm"),
        ("Cuboid(size = [20cm, 40cm, 3cm])", "turn 5 about z", "after 1/5 of a turn"),
        ("Prism(sides = 3, radius = 10cm, height = 3cm)", "turn 3 about z", None),  # their boxes are no squares
        ("Prism(sides = 5, radius = 10cm, height = 3cm)", "turn 5 about z", None),
        ("Prism(sides = 6, radius = 10cm, height = 3cm)", "turn 6 about z", None),
        ("Prism(sides = 7, radius = 10cm, height = 3cm)", "turn 7 about z", None),
        ("Prism(sides = 10, radius = 10cm, height = 3cm)", "turn 10 about z", None),
        ("Prism(sides = 6, radius = 10cm, height = 3cm)", "turn 4 about z", "after a quarter turn"),
        ("Prism(sides = 6, radius = 10cm, height = 3cm)", "turn 5 about z", "after 1/5 of a turn"),
    ],
)
def test_a_symmetry_that_the_box_does_not_have_is_told(top: str, symmetry: str, told: str | None) -> None:
    session = Session.of_text(TABLE.format(top=top, symmetry=symmetry))
    session.advise()
    found = [d for d in session.report.diagnostics if d.code == "bad-symmetry"]
    assert len(found) == (told is not None)
    for diagnostic in found:
        assert told is not None and told in diagnostic.message and diagnostic.span is not None
        assert diagnostic.span.line == 7
