"""`check` warns of axes that nothing holds: of joints whose parent is elsewhere, of loops whose links lie apart along them."""

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


CRANK = """apg 1
use primitives {{ Cuboid }}
category Crank {{
  param long : length in 9cm .. 11cm
  root part body : Cuboid(size = [40cm, 1cm, 1cm])
  part crank : Cuboid(size = [4cm, 5mm, 1cm])
  align crank.center = [0, 1cm, 0]
  joint turn : revolute body -> crank about line(at = [0, 1cm, 0], along = y) range 0deg .. 60deg
  part rod : Cuboid(size = [long, 5mm, 1cm])
  align rod.center = [15mm + long / 2, 2cm, 0]
  joint knee : revolute crank -> rod about line(at = [15mm, 2cm, 0], along = y) range -90deg .. 90deg
  part block : Cuboid(size = [2cm, 5mm, 1cm])
  align block.center = [15mm + long, {}, 0]
  joint slide : prismatic body -> block along x range -9cm .. 9cm
  close line(at = rod.center + [long / 2, 0, 0], along = y) on line(at = block.center, along = y)
}}
"""


@pytest.mark.parametrize(("place", "told"), [("3cm", []), ("35mm", [("`rod` and `block` are 10 mm apart", 15)])])
def test_links_that_lie_apart_along_the_axis_of_a_loop_are_told(place: str, told: list[tuple[str, int]]) -> None:
    session = Session.of_text(CRANK.format(place), "crank.apg")
    session.advise()
    found = [d for d in session.report.diagnostics if d.code == "far-axis"]
    assert [(d.message.partition(" along")[0].partition("links of ")[2], d.span.line) for d in found if d.span] == told
