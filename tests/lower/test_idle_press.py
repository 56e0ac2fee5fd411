"""`check` warns of what is labelled `press` and can only move outwards."""

import pytest

from artipg_dsl.session import Session

BELL = """apg 1
use primitives {{ Cuboid }}
use vocabularies {{ affordance }}
category Bell {{
  param width : length in 5cm .. 9cm
  root part base : Cuboid(size = [9cm, width, 3cm])
  part key : Cuboid(size = [4cm, 2cm, 1cm])
  align key.bottom = base.top + 4mm
  joint ring : {joint}
  label affordance.press on key.{face}
}}
"""


@pytest.mark.parametrize(
    ("joint", "face", "told"),
    [
        ("prismatic base -> key along z range -3mm .. 0mm", "top", False),
        ("prismatic base -> key along z range 0mm .. 3mm", "top", True),
        ("prismatic base -> key along z range -3mm .. 0mm", "bottom", True),
        ("prismatic base -> key along z range -3mm .. 3mm", "top", False),
        ("prismatic base -> key along z range 0mm .. 3mm rest 3mm", "top", False),
        ("revolute base -> key about key.back.bottom range 0deg .. 4deg", "top", True),
        ("revolute base -> key about line(at = key.center, along = y) range 0deg .. 4deg", "top", False),
        ("continuous base -> key about line(at = key.center, along = z)", "front", False),
    ],
)
def test_what_is_pressed_and_only_lifts_is_told(joint: str, face: str, told: bool) -> None:
    session = Session.of_text(BELL.format(joint=joint, face=face), "bell.apg")
    session.advise()
    assert not session.report.failed
    found = [d for d in session.report.diagnostics if d.code == "idle-press"]
    assert len(found) == told
    assert all(d.span is not None and d.span.text.startswith("label affordance.press") for d in found)
