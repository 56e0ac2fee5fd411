"""`check` warns of repeats whose elements have places by which nothing goes, and of joints that no label says how to move."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

RACK = """apg 1
use primitives {{ Cuboid, Cylinder }}
category Rack {{
  root part body : Cuboid(size = [30cm, 40cm, 2cm])
  repeat peg[k] in 0 ..< 3 {form} {{
    part pin : Cylinder(radius = 1cm, height = 5cm)
    connect pin.bottom on body.top
    {place}
  }}
  {more}
}}
"""
OWN = "align pin.center.y = (k - 1) * 12cm"


def _told(text: str, code: str) -> list[str]:
    session = Session.of_text(text, "rack.apg")
    session.advise()
    assert not session.report.failed, session.report.diagnostics
    return [d.message for d in session.report.diagnostics if d.code == code]


@pytest.mark.parametrize(
    ("form", "place", "more", "idle"),
    [
        ("pitch 10cm along y", OWN, "", True),
        ("spread body along y margin 3cm", OWN, "", True),
        ("pitch 10cm along y margin 1cm", "align pin.center.x = k * 1cm", "", False),  # centred along y
        ("pitch 10cm along y", "align pin.center.y = peg.center.y + 1cm", "", False),
        ("pitch 10cm along y", OWN, "keypoint end on body at [0, peg[last].center.y, 0]", False),
        ("", OWN, "", False),
    ],
)
def test_places_of_elements_by_which_nothing_goes(form: str, place: str, more: str, idle: bool) -> None:
    told = _told(RACK.format(form=form, place=place, more=more), "unused")
    said = "nothing goes by where the elements of `peg` lie: other equations place its parts along y"
    assert told == [said] * idle


BOX = """apg 1
use primitives { Cuboid }
use vocabularies { affordance }
category Box {
  root part body : Cuboid(size = [30cm, 40cm, 20cm])
  part door : Cuboid(size = [1cm, 40cm, 20cm])
  align door.back = body.front + 1mm
  joint open : revolute body -> door about door.left.back range 0deg .. 90deg
  part bolt : Cuboid(size = [1cm, 4cm, 1cm])
  align bolt.back = door.front + 1mm
  joint slide : prismatic door -> bolt along y range 0cm .. 2cm
  part sign : Cuboid(size = [1cm, 4cm, 1cm])
  align sign.top = body.bottom - 1mm
  joint held : fixed body -> sign
  part wheel : Cuboid(size = [1cm, 4cm, 4cm])
  align wheel.front = body.back - 1mm
  joint lead : revolute body -> wheel about line(at = wheel.center, along = x) range 0deg .. 90deg
  LABEL
}
"""


@pytest.mark.parametrize(
    ("label", "mimic", "told"),
    [
        ("", "", []),
        ("label affordance.slide on bolt", "", ["lead"]),  # the door carries the bolt
        ("label affordance.pull on door", "", ["slide", "lead"]),
        ("label affordance.slide on bolt", " mimic lead * (2cm / 90deg)", []),
    ],
)
def test_joints_that_no_label_says_how_to_move(label: str, mimic: str, told: list[str]) -> None:
    text = BOX.replace("LABEL", label).replace("range 0cm .. 2cm", f"range 0cm .. 2cm{mimic}")
    found = _told(text, "missing-affordance")
    assert [message.split("`")[1] for message in found] == told
