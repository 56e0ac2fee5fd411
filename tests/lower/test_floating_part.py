"""`check` warns of a part that touches nothing of its link, whatever is drawn."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
template Lid {{
  part plate : Cuboid(size = [9cm, 9cm, 1cm])
  part knob : Cuboid(size = [1cm, 1cm, 1cm])
  connect knob to plate
  align knob.bottom = plate.top + {}
}}
category Box {{
  param gap : length in -5cm .. 5cm
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  {}
}}
"""
LID = "part lid : Lid\n  connect lid.bottom on body.top"


@pytest.mark.parametrize(
    ("raised", "outer", "told"),
    [
        ("0cm", LID, []),
        ("2cm", LID, ["lid.knob"]),
        ("0cm", "part lid : Lid\n  connect lid to body\n  align lid.bottom = body.top + 3cm", ["lid.plate"]),
        ("0cm", "part lid : Lid\n  connect lid to body\n  align lid.bottom = body.top + gap", []),
        (
            "0cm",
            "part lid : Lid\n  align lid.bottom = body.top + 3cm\n  joint j : prismatic body -> lid along z range 0 .. 5cm",
            [],
        ),
        (
            "0cm",
            'part lid : Lid\n  connect lid to body\n  align lid.bottom = body.top + 3cm\n  allow floating lid because "a rod"',
            [],
        ),
    ],
    ids=["held", "within a template", "far above", "now and then", "another link", "allowed"],
)
def test_a_part_that_floats_in_all_objects_is_warned_of(raised: str, outer: str, told: list[str]) -> None:
    session = Session.of_text(TEXT.format(raised, outer), "box.apg")
    session.advise()
    assert not session.report.failed, session.report.diagnostics
    found = [d for d in session.report.diagnostics if d.code == "floating-part"]
    assert [d.message.split("`")[1] for d in found] == told
    assert all(d.severity == "warning" and d.span is not None for d in found)


@pytest.mark.parametrize(("carrier", "told"), [("lid", []), ("body", ["that of `body`"])])
def test_the_warning_names_the_link_that_the_part_is_on(carrier: str, told: list[str]) -> None:
    """A knob that touches the lid, which moves: where it is attached to the body, that is the mistake."""
    outer = f"""part lid : Lid
  align lid.bottom = body.top + 1mm
  joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
  part pull : Cuboid(size = [1cm, 5mm, 5mm])
  connect pull to {carrier}
  align pull.back = lid.plate.front
  align pull.center.z = lid.plate.center.z"""
    session = Session.of_text(TEXT.format("0cm", outer), "box.apg")
    session.advise()
    found = [d.message for d in session.report.diagnostics if d.code == "floating-part"]
    assert [message.rpartition(", ")[2] for message in found] == told


@pytest.mark.parametrize(
    ("where", "told"),
    [
        ("connect pin.bottom on arm.top", "nothing places it along y, where it is centred by default"),
        ("connect pin.bottom on arm.top at x = 0", "nothing places it along y, where it is centred by default"),
        ("connect pin.bottom on arm.top at center gap 1mm", "it is 1 mm along z from `arm`: bring the two together"),
        ("connect pin to body\n  align pin.bottom = body.top + 5mm", "it is 5 mm along z from `body`"),
        ("connect pin.bottom on body.top gap 5mm", "it is 5 mm along z from `body`"),
        ("connect pin.bottom on body.top at y = -9cm gap 5mm", "it is 40 mm along y and 5 mm along z from `body`"),
    ],
    ids=["one axis of two", "one axis", "a gap", "a gap and two axes", "a gap of faces", "two gaps"],
)
def test_the_hint_tells_along_what_nothing_places_the_part(where: str, told: str) -> None:
    outer = f"""part arm : Cuboid(size = [2cm, 20cm, 2cm])
  connect arm.right on body.left
  align arm.bottom = body.top - 1cm
  part pin : Cuboid(size = [1cm, 1cm, 1cm])
  {where}
  part lid : Lid
  connect lid.top on body.bottom"""
    session = Session.of_text(TEXT.format("0cm", outer), "box.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "floating-part"]
    assert (found.hint or "").startswith(told)


def test_elements_that_float_are_measured() -> None:
    """The first tooth touches the body, the others stand behind it one by one."""
    outer = """repeat tooth[k] in 0 ..< 3 {
    part pin : Cuboid(size = [1cm, 5mm, 1cm])
    connect pin to body
    align pin.left = body.right - k * 1cm
    align pin.center.z = body.center.z
  }
  part lid : Lid
  connect lid.bottom on body.top"""
    session = Session.of_text(TEXT.format("0cm", outer), "box.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "floating-part"]
    assert (found.hint or "").startswith("it is 10 mm along y from `body`")


@pytest.mark.parametrize(
    ("raised", "lifted", "blamed"),
    [("2cm", "0cm", "part knob"), ("0cm", "2cm", "part lid"), ("2cm", "2cm", "part lid")],
    ids=["a part of it", "as a whole", "both"],
)
def test_the_warning_stands_at_the_innermost_part_that_floats_as_a_whole(raised: str, lifted: str, blamed: str) -> None:
    session = Session.of_text(TEXT.format(raised, LID + f" gap {lifted}"), "box.apg")
    session.advise()
    found = [d.span for d in session.report.diagnostics if d.code == "floating-part" and d.span is not None]
    assert [span.source.line(span.line).split(":")[0].strip() for span in found] == [blamed]


def test_a_part_in_the_hollow_of_another_floats() -> None:
    """Its box lies in that of the other: only the solids tell them apart."""
    text = """apg 1
use primitives { Cuboid }
use bodies { OpenBox }
category Box {
  root part body : OpenBox(size = [30cm, 50cm, 25cm], wall = 12mm)
  part ball : Cuboid(size = [1cm, 1cm, 1cm])
  connect ball to body
  align ball.center = [5cm, 0, 0]
}
"""
    session = Session.of_text(text, "box.apg")
    session.advise()
    found = [d for d in session.report.diagnostics if d.code == "floating-part"]
    assert [d.message for d in found] == ["`ball` touches nothing else of its link, that of `body`"]
