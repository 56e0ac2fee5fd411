"""`check` warns of what is wrong with every object besides overlaps: what nothing holds, loops that stay open, parts too near."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.diagnostics.model import Diagnostic
from artipg_dsl.session import Session
from artipg_dsl.validity.faults import find_faults

CHEST = """apg 1
use primitives {{ Cuboid }}
category Chest {{
  param away : length in 1cm .. 3cm
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  part drawer : Cuboid(size = [5cm, 9cm, 1cm])
  align drawer.back = body.front + {away}
  joint slide : prismatic body -> drawer along x range 0cm .. 1cm
  {more}
}}
"""
REVERSED = """repeat dial[k] in 0 ..< 2 spread body along x margin 2cm {
    part disc : Cuboid(size = [1cm, 1cm, 1cm])
    align disc.center.x = dial.center.x
    when k == 0 {
      joint turn : prismatic body -> disc along z range away .. 0cm
    } else {
      joint turn : prismatic body -> disc along z range 0cm .. away
    }
  }"""
SWING = """apg 1
use primitives {{ Cuboid }}
category Swing {{
  root part beam : Cuboid(size = [20cm, 1cm, 1cm])
  repeat arm[k] in 0 ..< 2 spread beam along x margin 2cm {{
    part bar : Cuboid(size = [1cm, 5mm, 20cm])
    align bar.center.x = arm.center.x
    align bar.top = beam.top
    align bar.right = beam.left + 1mm
    joint sway : revolute beam -> bar about line(at = bar.top.center - [0, 0, 5mm], along = y) range -20deg .. 20deg
  }}
  part seat : Cuboid(size = [20cm, 1cm, 1cm])
  align seat.bottom = arm[0].bar.bottom
  align seat.right = arm[0].bar.left + 1mm
  joint level : revolute arm[0].bar -> seat about line(at = arm[0].bar.bottom.center + [0, 0, 5mm], along = y) range -20deg .. 20deg
  close line(at = arm[1].bar.bottom.center + [0, 0, 5mm], along = y) on line(at = seat.bottom.center + [8cm, 0, {low}], along = y)
}}
"""


def _advised(text: str, name: str = "programs/some.apg") -> list[Diagnostic]:
    session = Session.of_text(text, name)
    session.advise()
    assert not session.report.failed, session.report.diagnostics
    return session.report.diagnostics


def _told(text: str, name: str = "programs/some.apg") -> list[tuple[str, int]]:
    found = [d for d in _advised(text, name) if d.code == "never-valid"]
    assert all(d.severity == "warning" and d.message.endswith(", in every object examined") for d in found)
    return [(d.message.removesuffix(", in every object examined"), d.span.line) for d in found if d.span]


def test_a_category_without_any_surface_is_told() -> None:
    text = "apg 1\ntemplate Nothing { }\ncategory T {\n  root part body : Nothing\n}\n"
    assert _told(text) == [("no part of `T` has a surface", 3)]


@pytest.mark.parametrize(
    ("away", "more", "told"),
    [
        ("1mm", "", []),
        ("away", "", []),  # near enough now and then
        ("4cm", "", [("nothing holds `drawer`: the link that carries it is not within 2 cm", 6)]),
        ("1cm", "clear drawer from body by 5mm", []),
        ("1cm", "clear drawer from body by 2cm", [("`clear drawer from body by 2cm` does not hold at rest", 9)]),
    ],
    ids=["near", "now and then", "far", "clear", "too near"],
)
def test_what_is_wrong_with_all_objects_is_warned_of(away: str, more: str, told: list[tuple[str, int]]) -> None:
    assert _told(CHEST.format(away=away, more=more))[:1] == told


@pytest.mark.parametrize("name", ["a chest: 2nd.apg", "a:1: b.apg"])
def test_a_fault_carries_its_place_whatever_the_file_is_called(name: str) -> None:
    chest = CHEST.format(away="1cm", more="clear drawer from body by 2cm")
    assert _told(chest, name)[:1] == [("`clear drawer from body by 2cm` does not hold at rest", 9)]
    text = CHEST.format(away="4cm", more="clear drawer from body by 9cm")
    batch = Session.of_text(text, name).sampler.batch(np.arange(2), 0, checked=False)
    held, near, *_ = find_faults(batch).others
    assert (held.part, held.where, held.objects.tolist()) == ("drawer", None, [0, 1])
    assert near.part is None and near.where is not None and (near.where.file, near.where.line) == (name, 9)
    assert near.words == f"{name}:9: {near.what}"


@pytest.mark.parametrize(("low", "told"), [("5mm", []), ("60cm", [("this loop does not close at rest", 16)])])
def test_a_loop_that_does_not_close_is_warned_of_where_it_is_stated(low: str, told: list[tuple[str, int]]) -> None:
    assert _told(SWING.format(low=low))[-1:] == told


def test_how_far_apart_a_loop_is_and_what_it_ties_is_told() -> None:
    """A place of numbers alone lies on the root."""
    *_, unclosed = (d for d in _advised(SWING.format(low="60cm")) if d.code == "never-valid")
    assert "595.0 mm apart with all joints at 0" in str(unclosed.hint)
    tied = (
        SWING.replace("seat.bottom.center + [8cm, 0, {low}]", "[8cm, 0, -19cm]").replace("{{", "{").replace("}}", "}")
    )
    (rigid,) = [d for d in _advised(tied) if d.code == "rigid-loop"]
    assert "the link of `arm.bar` to that of `beam`" in str(rigid.hint)


@pytest.mark.parametrize(
    ("demand", "hint"),
    [("abs(away - 1cm) == 1cm", "write `align`"), ("abs(sin(away * 1rad / 1mm) * away) >= 29mm", "widen the ranges")],
)
def test_an_equation_that_is_demanded_is_told_apart_from_a_range_that_is_too_narrow(demand: str, hint: str) -> None:
    session = Session.of_text(CHEST.format(away="1mm", more=f"require {demand}"), "programs/some.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "none-drawn"]
    assert found.severity == "error" and hint in str(found.hint) and demand in found.message


def test_a_range_that_is_reversed_where_it_may_be_absent_is_told_at_its_line() -> None:
    session = Session.of_text(CHEST.format(away="1mm", more=REVERSED), "programs/some.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "none-drawn"]
    assert found.span.text.startswith("joint turn") and found.hint == "swap the ends, or correct one"
    assert "the length of the range of the joint `dial.turn`: the low end must not" in found.message


def test_a_size_that_equations_make_negative_is_named() -> None:
    session = Session.of_text(
        """apg 1
use primitives { Cuboid, Cylinder }
category Stool {
  root part seat : Cuboid(size = [30cm, 30cm, 3cm])
  part foot : Cylinder(height = 2cm)
  connect foot.top on seat.bottom at center
  align foot.front = seat.back + 12cm
}
"""
    )
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "none-drawn"]
    assert found.hint == "equations determine `foot.radius`: give it a value, or correct them"


FOLLOWER = """apg 1
use primitives { Cuboid }
category Pair {
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  part one : Cuboid(size = [1cm, 2cm, 2cm])
  align one.back = body.front + 1mm
  joint lead : prismatic body -> one along x range 0cm .. 2cm
  part other : Cuboid(size = [1cm, 2cm, 2cm])
  align other.front = body.back - 1mm
  joint follow : prismatic body -> other along -x range 0cm .. 3cm mimic MIMIC
}
"""


@pytest.mark.parametrize(
    ("mimic", "code", "told"),
    [
        ("lead", None, ""),
        ("1.5 * lead", None, ""),
        ("3cm - lead", None, ""),
        ("2 * lead", "bad-mimic", "`follow` is taken through 0 .. 4cm, and its range is 0 .. 3cm"),
        ("lead + 2cm", "bad-mimic", "`follow` is taken through 2cm .. 4cm, and its range is 0 .. 3cm"),
        ("lead + 4cm", "never-valid", "the range of `follow` does not contain its rest value"),
    ],
)
def test_followers_that_leave_their_range(mimic: str, code: str | None, told: str) -> None:
    session = Session.of_text(FOLLOWER.replace("MIMIC", mimic), "programs/some.apg")
    session.advise()
    found = {d.code: (d.message, d.span.line) for d in session.report.diagnostics if d.span}
    about = {c: at for c, at in found.items() if c in ("bad-mimic", "never-valid")}
    if code is None:
        assert not about
    else:
        assert told in about[code][0] and about[code][1] == 10


@pytest.mark.parametrize(
    ("mimic", "hint"), [("-lead", "change the sign of its factor"), ("-2 * lead", "widen its range")]
)
def test_a_factor_with_the_wrong_sign(mimic: str, hint: str) -> None:
    (found,) = (d for d in _advised(FOLLOWER.replace("MIMIC", mimic)) if d.code == "bad-mimic")
    assert str(found.hint).startswith(hint)


def test_room_to_go_the_wrong_way() -> None:
    """Taken through one half of its range alone, a follower of the wrong sign would be within it as well."""
    text = FOLLOWER.replace("0cm .. 3cm mimic MIMIC", "-3cm .. 3cm mimic {}")
    for mimic, told in (("-lead", "-2cm .. 0"), ("lead", "0 .. 2cm"), ("lead - 1cm", None)):
        found = [d for d in _advised(text.replace("{}", mimic)) if d.code == "bad-mimic"]
        assert [f"through {told} alone" in d.message for d in found] == [True] * (told is not None)


def test_a_limited_follower_of_a_joint_without_end() -> None:
    endless = "joint lead : continuous body -> one about line(at = one.center, along = x)"
    text = FOLLOWER.replace("joint lead : prismatic body -> one along x range 0cm .. 2cm", endless)
    session = Session.of_text(text.replace("MIMIC", "lead * (1mm / 1turn)"), "programs/some.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "bad-mimic"]
    assert "`follow` follows `lead`, which turns without end, and its range is 0 .. 3cm" in found.message


def _rare(text: str) -> Diagnostic | None:
    found = [d for d in _advised(text) if d.code in ("rarely-valid", "colliding-links", "never-valid")]
    assert [d.code for d in found] in ([], ["rarely-valid"])
    return found[0] if found else None


@pytest.mark.parametrize(("low", "told"), [("-5mm", None), ("-4cm", "in 5 of 8 objects examined")])
def test_what_makes_half_of_the_objects_invalid_is_told(low: str, told: str | None) -> None:
    """A gap that is drawn: below 0 the drawer is in the body, at rest or when its joint draws it there."""
    text = CHEST.format(away="away - 1cm", more="").replace("1cm .. 3cm", f"1cm + ({low}) .. 2cm")
    found = _rare(text)
    if told is None:
        assert found is None
    else:
        assert found is not None and found.message == f"`body` and `drawer` collide at rest, {told}"


@pytest.mark.parametrize(("foot", "falls"), [("1cm .. 2cm", True), ("8cm .. 9cm", False)])
def test_a_foot_that_is_too_narrow_is_told(foot: str, falls: bool) -> None:
    found = _rare(f"""apg 1
use primitives {{ Cuboid }}
category Chest {{
  param foot : length in {foot}
  root part body : Cuboid(size = [10cm, 10cm, 10cm])
  part leg : Cuboid(size = [foot, foot, 50cm])
  connect leg.top on body.bottom
  align leg.front = body.front
  require stable else "it tips over"
}}
""")
    assert falls == (found is not None)
    if found is not None:
        assert found.message == "it tips over, in every object examined" and "it stands on `leg`" in str(found.hint)


@pytest.mark.parametrize(
    ("foot", "label", "more", "falls"),
    [
        ("1cm .. 2cm", "leg", "", True),
        ("1cm .. 2cm", "shaft", "", False),  # a tool stands on nothing
        ("8cm .. 9cm", "leg", "", False),
        ("1cm .. 9cm", "leg", "", False),
        ("1cm .. 2cm", "leg", "when hung == no { require stable }", False),
    ],
)
def test_objects_that_fall_off_their_feet_are_told(foot: str, label: str, more: str, falls: bool) -> None:
    found = _advised(f"""apg 1
use primitives {{ Cuboid }}
vocabulary semantic {{ body leg shaft }}
category Chest {{
  param foot : length in {foot}
  param hung : choice yes | no
  root part body : Cuboid(size = [10cm, 10cm, 10cm])
  part leg : Cuboid(size = [foot, foot, 50cm])
  connect leg.top on body.bottom
  align leg.front = body.front
  label semantic.body on body
  label semantic.{label} on leg
  {more}
}}
""")
    assert falls == ("missing-stable" in {d.code for d in found})


@pytest.mark.parametrize(
    ("ring", "angle", "told"),
    [
        ("n", "k * 1turn / n", True),
        ("4", "20deg + k * 90deg", True),
        ("4", "k * 30deg", False),
        ("4", "20deg", False),
        ("n", "-k * 1turn / n", False),  # it keeps its direction
        ("2", "k * 180deg", False),
    ],
)
def test_what_a_ring_has_turned_already_is_told(ring: str, angle: str, told: bool) -> None:
    found = _advised(f"""apg 1
use primitives {{ Cuboid }}
category Wheel {{
  count n in 3 .. 5
  root part hub : Cuboid(size = [10cm, 10cm, 10cm])
  repeat arm[k] ring {ring} about line(at = hub.center, along = z) {{
    part bar : Cuboid(size = [9cm, 1cm, 1cm]) turned {angle} about z
    connect bar to hub
    align bar.center = [9cm, 0, 0]
  }}
}}
""")
    assert [d.span.text for d in found if d.span and d.code == "turned-again"] == [f"turned {angle} about z"] * told
