"""`check` warns of links that overlap at rest, or collide while a joint moves, whatever is drawn."""

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


HANDLE = """part handle : Cuboid(size = [9cm, 1cm, 1cm])
  connect handle.bottom on body.top"""


@pytest.mark.parametrize(
    ("gap", "more", "told"),
    [
        ("1mm", "", []),
        ("-5mm", "", [("body", "lid")]),
        ("gap", "", []),
        ("2mm", HANDLE, [("handle", "lid")]),
        ("-5mm", 'allow overlap lid, body because "pressed together"', []),
        ("1mm", KNOBS, [("body", "knob[0].grip")]),
    ],
    ids=["apart", "always", "now and then", "the part and not its link", "allowed", "where they are there"],
)
def test_links_that_overlap_in_all_objects_are_warned_of(gap: str, more: str, told: list[tuple[str, str]]) -> None:
    session = Session.of_text(TEXT.format(gap=gap, more=more), "chest.apg")
    session.advise()
    assert not session.report.failed, session.report.diagnostics
    found = [d for d in session.report.diagnostics if d.code == "colliding-links"]
    assert [tuple(sorted(d.message.split("`")[1:4:2])) for d in found] == told
    assert all(d.severity == "warning" and d.span is not None for d in found)


def test_a_part_is_told_with_the_link_that_it_moves_with() -> None:
    session = Session.of_text(TEXT.format(gap="2mm", more=HANDLE), "chest.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "colliding-links"]
    assert found.message.endswith("(`handle` is on the link of `body`)")
    assert found.span is not None and found.span.text == "handle"
    assert "`allow overlap handle, lid because" in str(found.hint)


INNER = "template Cap {{ part plate : Cuboid(size = [1cm, 1cm, 1cm]) {} }}\n"
RISES = """part knob : Cap
  align knob.bottom = body.top - 1mm
  joint rise : prismatic body -> knob along z range 0mm .. 1mm"""
MEETS = """part pin : Cuboid(size = [1mm, 1mm, 1mm])
  align pin.top = plate.top
  joint draw : prismatic plate -> pin along z range 0mm .. 1mm"""


@pytest.mark.parametrize(
    ("gap", "inner", "more", "there"),
    [("-5mm", "", "", "lid"), ("2cm", "", RISES, "knob"), ("2cm", MEETS, RISES.replace("- 1mm", "+ 1mm"), "pin")],
    ids=["the later", "the part that a template makes", "within a template"],
)
def test_the_warning_stands_where_the_place_is_told(gap: str, inner: str, more: str, there: str) -> None:
    text = TEXT.format(gap=gap, more=more).replace("category", INNER.format(inner) + "category")
    session = Session.of_text(text, "chest.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "colliding-links"]
    assert found.span is not None and found.span.text == there


def test_a_part_that_not_all_objects_have() -> None:
    """The divider fills its column, drawers included; objects with one column have none, and the links of both all the same."""
    text = """apg 1
use primitives { Cuboid }
category Case {
  count columns in 1 .. 2
  root part body : Cuboid(size = [20cm, 40cm, 2cm])
  repeat column[c] in 0 ..< columns split body along y gap 1cm {
    when column.gap {
      part divider : Cuboid(size = [20cm, 1cm, 9cm])
      connect divider.bottom on body.top
      align divider.left = column.left
    }
    part drawer : Cuboid(size = [18cm, _, 5cm])
    align drawer.left = column.left
    align drawer.right = column.right
    align drawer.bottom = body.top + 1mm
    joint pull : prismatic body -> drawer along x range 0 .. 9cm
  }
}
"""
    session = Session.of_text(text, "case.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "colliding-links"]
    assert found.message.startswith("`column[1].divider` and `column[1].drawer` overlap with all joints at rest")


MOVES = """apg 1
use primitives {{ Cuboid }}
category Chest {{
  param gap : length in 1mm .. 3mm
  param tall : length in 1cm .. 4cm
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  part lid : Cuboid(size = [9cm, 9cm, 1cm])
  align lid.center.x = body.center.x
  align lid.center.y = body.center.y
  align lid.bottom = body.top + gap
  joint open : {joint}
  {more}
}}
"""
POST = """part post : Cuboid(size = [1cm, 1cm, {tall}])
  connect post.bottom on body.top
  align post.left = body.left
  align post.front = body.back"""


@pytest.mark.parametrize(
    ("joint", "more", "told"),
    [
        ("revolute body -> lid about lid.back.bottom range 0deg .. 60deg", "", None),
        (
            "revolute body -> lid about lid.bottom.back range 0deg .. 60deg",
            "",
            "`lid.back.bottom` for `lid.bottom.back`",
        ),
        ("revolute body -> lid about lid.back.bottom range -60deg .. 0deg", "", "the signs of its range"),
        ("prismatic body -> lid along z range -2cm .. 0cm", "", "let it slide the other way"),
        ("prismatic body -> lid along z range -2cm .. 2cm", "", "leave room where it moves"),
        (
            "revolute body -> lid about lid.back.bottom range 0deg .. 60deg",
            POST.format(tall="4cm"),
            "leave room where it moves",
        ),
        ("prismatic body -> lid along -x range 0cm .. 5cm", POST.format(tall="tall"), "let it slide the other way"),
        ("prismatic body -> lid along -x range 0cm .. 5cm", POST.format(tall="1mm + 0.3 * (tall - 1cm)"), None),
        (
            "revolute body -> lid about lid.bottom.back range 0deg .. 60deg",
            'allow overlap lid, body because "it is soft"',
            None,
        ),
    ],
    ids=["opens", "axis", "signs", "slides", "both ways", "post", "always", "now and then", "allowed"],
)
def test_links_that_collide_while_a_joint_moves_are_warned_of(joint: str, more: str, told: str | None) -> None:
    session = Session.of_text(MOVES.format(joint=joint, more=more), "chest.apg")
    session.advise()
    assert not session.report.failed, session.report.diagnostics
    found = [d for d in session.report.diagnostics if d.code == "colliding-links"]
    assert len(found) == (told is not None)
    for one in found:
        assert one.span is not None and one.span.text.startswith("joint open : ")
        assert " collide while `open` moves, at " in one.message and str(told) in str(one.hint)


CHAIN = """apg 1
use primitives { Cuboid }
category Blind {
  root part head : Cuboid(size = [2cm, 30cm, 2cm])
  part cord : Cuboid(size = [1cm, 1cm, 1cm])
  align cord.back = head.front + 1mm
  joint pull : prismatic head -> cord along -z range 0cm .. 5cm
  part slat : Cuboid(size = [2cm, 30cm, 2mm])
  part rung : Cuboid(size = [2cm, 1mm, 2mm])
  connect rung.right on slat.left
  align slat.top = head.bottom - 1cm
  align rung.top = slat.top
  joint lift : prismatic head -> slat along z range 0cm .. 5cm mimic pull
}
"""


def test_what_a_follower_moves_is_told_with_it() -> None:
    """The axis of the joint that leads has nothing to do with it, though to its other side nothing would meet."""
    session = Session.of_text(CHAIN, "blind.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "colliding-links"]
    assert str(found.hint).startswith("`lift` moves them, which follows it: check its `mimic`")
    session = Session.of_text(CHAIN.replace("mimic pull", ""), "blind.apg")
    session.advise()
    (found,) = [d for d in session.report.diagnostics if d.code == "colliding-links"]
    assert str(found.hint).startswith("to the other side they would not meet")


def test_on_which_link_two_elements_of_a_part_are_is_told_once() -> None:
    from artipg_dsl.advice.meeting import _on_links
    from artipg_dsl.validity.stuck import Stuck

    said = _on_links(Stuck(("row.pipe", "row.pipe"), ("row[1].clamp", "row[2].clamp")))
    assert said == " (`row.clamp` is on the link of `row.pipe`)"


TOUCH = """apg 1
use primitives {{ Cuboid, Cylinder, HollowFrustum }}
category Tower {{
  param bore : length in 1cm .. 2cm
  root part base : HollowFrustum(radius = 3cm, bore = bore, height = 9cm)
  part rod : {}
}}
"""
LID = """Cuboid(size = [6cm, 6cm, 5mm])
  align rod.bottom = base.top"""


@pytest.mark.parametrize(
    ("rod", "told"),
    [
        ("Cylinder(radius = bore, height = 9cm)\n  joint move : prismatic base -> rod along z range 0cm .. 3cm", True),
        (
            "Cylinder(radius = bore - 0.2mm, height = 9cm)\n  joint move : prismatic base -> rod along z range 0cm .. 3cm",
            False,
        ),
        (f"{LID}\n  joint move : continuous base -> rod about base.axis", True),
        (f"{LID}\n  joint move : prismatic base -> rod along z range 0cm .. 3cm", False),
        (f"{LID}\n  joint move : revolute base -> rod about rod.back.bottom range 0deg .. 60deg", False),
        (f"{LID} + 0.2mm\n  joint move : continuous base -> rod about base.axis", False),
        (
            f'{LID}\n  joint move : continuous base -> rod about base.axis\n  allow overlap base, rod because "felt"',
            False,
        ),
        (f"{LID} + (0mm if bore < 12mm else 1mm)\n  joint move : continuous base -> rod about base.axis", False),
    ],
    ids=[
        "a rod in its bore",
        "with a gap",
        "a cap that turns",
        "that is lifted",
        "that opens",
        "off",
        "allowed",
        "some",
    ],
)
def test_links_that_touch_where_they_move_on_one_another(rod: str, told: bool) -> None:
    session = Session.of_text(TOUCH.format(rod), "tower.apg")
    session.advise()
    assert not session.report.failed, session.report.diagnostics
    found = [d for d in session.report.diagnostics if d.code == "touching-links"]
    assert [d.span.text.split(" :")[0] for d in found if d.span] == ["joint move"] * told
