"""`check` warns of keypoints and grasps that lie far off the link that they are on."""

from artipg_dsl.session import Session

STOOL = """apg 1
use primitives { Cuboid }
category Stool {
  param width : length in 30cm .. 50cm
  root part seat : Cuboid(size = [30cm, width, 3cm])
  part knob : Cuboid(size = [3cm, 3cm, 3cm])
  connect knob.bottom on seat.top at center
  keypoint beside on seat at [0, 0, 20cm]
  keypoint above on seat at [0, 0, 5m]
  keypoint far on knob
  part lid : Cuboid(size = [4cm, 4cm, 4mm])
  align lid.bottom = seat.bottom - 1cm
  joint open : revolute seat -> lid about lid.top.back range 0deg .. 9deg
  keypoint within on lid at [0, 0, 2cm]
  keypoint beyond on lid at [0, 0, 6cm]
  grasp near on seat { at [0, width / 2, 0]  approach -y  close z  opening 3cm }
  grasp away on knob { at [0, 3m, 0]  approach -y  close z  opening 3cm }
}
"""


def test_what_lies_far_off_is_told_at_its_place() -> None:
    session = Session.of_text(STOOL)
    session.advise()
    found = [d for d in session.report.diagnostics if d.code == "far-off"]
    assert [d.span.text.split(" on ")[0] for d in found if d.span] == [
        "keypoint above",
        "keypoint beyond",
        "grasp away",
    ]
    assert "lies 500cm off the link of `seat`, on which it is, and which is about 50cm across" in found[0].message
