"""`check` warns of links that overlap at rest, whatever is drawn."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
category Chest {{
  param gap : length in -1cm .. 1cm
  count knobs in 0 .. 2
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  part lid : Cuboid(size = [9cm, 9cm, 1cm])
  align lid.center.x = body.center.x
  align lid.center.y = body.center.y
  align lid.bottom = body.top + {gap}
  joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
  {more}
}}
"""
KNOBS = """repeat knob[k] in 0 ..< knobs spread body along y {
    part grip : Cuboid(size = [1cm, 1cm, 1cm])
    align grip.center.y = knob.center.y
    align grip.center.z = body.center.z
    align grip.back = body.front - 1mm
    joint slide : prismatic body -> grip along x range 0cm .. 1cm
  }"""


@pytest.mark.parametrize(
    ("gap", "more", "told"),
    [
        ("1mm", "", []),
        ("-5mm", "", [("body", "lid")]),
        ("gap", "", []),
        ("-5mm", 'allow overlap lid, body because "pressed together"', []),
        ("1mm", KNOBS, [("body", "knob.grip")]),
    ],
    ids=["apart", "always", "now and then", "allowed", "where they are there"],
)
def test_links_that_overlap_in_all_objects_are_warned_of(gap: str, more: str, told: list[tuple[str, str]]) -> None:
    session = Session.of_text(TEXT.format(gap=gap, more=more), "chest.apg")
    session.advise()
    assert not session.report.failed, session.report.diagnostics
    found = [d for d in session.report.diagnostics if d.code == "colliding-links"]
    assert [tuple(sorted(d.message.split("`")[1:4:2])) for d in found] == told
    assert all(d.severity == "warning" and d.span is not None for d in found)
