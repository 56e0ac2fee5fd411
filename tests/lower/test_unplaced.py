"""`check` warns of a part that nothing places along any axis."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
template Lid {{
  part plate : Cuboid(size = [9cm, 9cm, 1cm])
  part knob : Cuboid(size = [1cm, 1cm, 1cm])
  {}
}}
category Box {{
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  part lid : Lid
  {}
}}
"""
KNOB, LID = "connect knob.bottom on plate.top", "connect lid.bottom on body.top"


@pytest.mark.parametrize(
    ("inner", "outer", "told"),
    [
        (KNOB, LID, []),
        ("", LID, ["knob"]),
        (KNOB, "connect lid to body", ["lid"]),
        ("align knob.center.x = plate.center.x", LID, []),
        (KNOB, "connect lid to body\n  align lid.center = body.center", []),
        (KNOB, "joint j : prismatic body -> lid along z range 0 .. 5cm", ["lid"]),
        (
            KNOB,
            LID
            + "\n  repeat k[i] in 0 ..< 3 spread body along y { part b : Cuboid(size = [1cm, 1cm, 1cm])\n connect b to body }",
            [],
        ),
    ],
    ids=[
        "all placed",
        "in a template",
        "attached alone",
        "one axis",
        "in the middle on purpose",
        "by a joint",
        "an element",
    ],
)
def test_a_part_in_the_middle_by_default_is_warned_of(inner: str, outer: str, told: list[str]) -> None:
    session = Session.of_text(TEXT.format(inner, outer), "box.apg")
    session.advise()
    found = [d for d in session.report.diagnostics if d.code == "unplaced"]
    assert [d.message.split("`")[1] for d in found] == told
    assert all(d.severity == "warning" and d.span is not None for d in found)
    assert not session.report.failed
    jointed = "joint" in outer and told == ["lid"]  # a second attachment would be an error
    assert all((d.hint or "").startswith("place it with `align`, or by faces in its joint") == jointed for d in found)


@pytest.mark.parametrize(
    ("outer", "told"),
    [
        ("connect lid to body", "`connect lid.seat to ...`"),
        (
            "joint j : prismatic body -> lid along z range 0 .. 5cm",
            "by its port and another in its joint, as in `... -> lid.seat`",
        ),
    ],
    ids=["connected", "by a joint"],
)
def test_a_part_with_a_port_is_placed_by_it(outer: str, told: str) -> None:
    session = Session.of_text(
        TEXT.format(KNOB + "\n  port rim : point = plate.center\n  port seat = plate.bottom", outer), "box.apg"
    )
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "unplaced"]
    assert told in (found.hint or "")
