"""`check` warns of joints that turn about an axis which their parent cannot hold."""

import pytest

from artipg_dsl.session import Session

DESK = """apg 1
use primitives {{ Cuboid, HollowFrustum }}
category Desk {{
  param width : length in 30cm .. 50cm
  root part case : Cuboid(size = [30cm, width, 80cm])
  part ring : HollowFrustum(radius = 2cm, bore = 1cm, height = 1cm)
  connect ring.back on case.front
  align ring.center.z = case.center.z
  part flap : Cuboid(size = [20cm, 9cm, 1cm])
  align flap.back = case.front + {off}
  align flap.bottom = case.bottom + 20cm
  joint open : {joint}
}}
"""


@pytest.mark.parametrize(
    ("off", "joint", "told"),
    [
        ("1mm", "revolute case -> flap about flap.back.top range 0deg .. 60deg", False),
        ("1mm", "revolute case -> flap about flap.front.top range -60deg .. 0deg", True),
        ("1mm", "continuous case -> flap about line(at = flap.front.center, along = x)", False),
        (
            "1mm",
            "revolute case -> flap about line(at = flap.left.center + [0, 1m, 0], along = x) range 0deg .. 9deg",
            True,
        ),
        # above the ring, whose axis it shares: the ring holds it
        ("1cm", "revolute case -> flap about line(at = ring.center, along = z) range -9deg .. 9deg", False),
        ("1mm", "prismatic case -> flap along x range 0cm .. 9cm", False),
    ],
)
def test_an_axis_that_nothing_holds_is_told(off: str, joint: str, told: bool) -> None:
    session = Session.of_text(DESK.format(off=off, joint=joint), "desk.apg")
    session.advise()
    assert not session.report.failed
    found = [d for d in session.report.diagnostics if d.code == "far-axis"]
    assert len(found) == told
    assert all(d.span is not None and d.span.text.startswith("joint open :") for d in found)
