"""Attachments are counted per case of the guards, and optional parts need guards that ensure them."""

import pytest

from .helpers import HEAD, check_text, codes

CATEGORY = """
category Chest {{
  param hinged : choice left | right | top
  param soft : bool = true
  count feet in 2 .. 4 = 3
  root part body : Cuboid(size = [40cm, 60cm, 30cm])
  part lid : Handle = BarHandle | BowHandle | BracketHandle{none}
  {statements}
}}
"""


def findings(tmp_path, statements: str, optional: bool) -> list[str]:
    text = CATEGORY.format(statements=statements, none=" | none" if optional else "")
    return codes(check_text(tmp_path, HEAD + text)[0])


COVERED = [
    "connect lid to body",
    "when lid is BarHandle { connect lid to body } else { connect lid.mount to body.front at center }",
    "when lid is BarHandle { connect lid to body }\n when lid is BowHandle { connect lid to body }\n"
    "when lid is BracketHandle { connect lid to body }",
    "when hinged == left { connect lid to body } else when hinged == right { connect lid to body }\n"
    "else { connect lid to body }",
    "when hinged != left { connect lid to body }\n when hinged == left { connect lid to body }",
    "when feet == 2 { connect lid to body }\n when feet > 2 { connect lid to body }",
    "when soft and feet == 2 { connect lid to body }\n when not soft or feet != 2 { connect lid to body }",
    "when feet == 1 + 1 { connect lid to body } else { connect lid to body }",
    "repeat pin[k] in 0 ..< 1 { connect lid to body }",
]


@pytest.mark.parametrize("optional", [False, True])
@pytest.mark.parametrize("statements", COVERED)
def test_exactly_one_attachment_in_every_case(tmp_path, statements, optional):
    assert findings(tmp_path, statements, optional) == []


OPEN = [
    "when lid is BarHandle { connect lid to body }",
    "when hinged == left { connect lid to body }\n when hinged == top { connect lid to body }",
    "when feet == 2 { connect lid to body }\n when feet > 3 { connect lid to body }",
    "when soft { when feet > 2 { connect lid to body } } else { connect lid to body }",
]


@pytest.mark.parametrize("statements", OPEN)
def test_a_case_without_attachment_is_found(tmp_path, statements):
    assert findings(tmp_path, statements, optional=True) == ["no-attachment"]


TWICE = [
    "connect lid to body\n joint swing : revolute body -> lid about body.left.back range 0deg .. 90deg",
    "connect lid to body\n when soft { connect lid to body }",
    "when feet > 2 { connect lid to body }\n when feet < 4 { connect lid to body }",
    "when lid is BarHandle { connect lid to body }\n when not (lid is BowHandle) { connect lid to body }\n"
    "when lid is BowHandle { connect lid to body }",
]


# `lid` stands outside of the repeat: each element would make a link and a joint of its own for the one part
TWICE += [
    "repeat pin[k] in 0 ..< 2 { joint swing : revolute body -> lid about body.left.back range 0deg .. 90deg }",
    "repeat pin[k] in 0 ..< feet { connect lid to body }",
    "repeat pin[k] mirror across y { connect lid to body }",
    "repeat row[r] in 0 ..< 1 { repeat pin[k] in 0 ..< 2 { connect lid to body } }",
    "repeat pin[k] in 0 ..< 2 { when k == 0 { connect lid to body } else { connect lid to body } }",
]


@pytest.mark.parametrize("statements", TWICE)
def test_a_case_with_two_attachments_is_found(tmp_path, statements):
    assert findings(tmp_path, statements, optional=True) == ["two-attachments"]


ENSURED = [
    "when lid { require lid.size.z < 3cm }",
    "require lid.size.z < 3cm",
    "let a = lid.size.z if lid else 0cm",
    "when lid is BarHandle { align body.top = lid.neck.top }",
    "when lid is BarHandle or lid is BowHandle { align body.top = lid.top }",
    "when not (lid is BowHandle) and lid { align body.top = lid.top }",
    "when soft and lid { align body.top = lid.top }",
    "when not lid { } else { align body.top = lid.top }",
    "part badge : Cuboid\n connect lid.mount to badge.front at center\n connect badge to body",
]


@pytest.mark.parametrize("statements", ENSURED)
def test_guards_that_ensure_an_optional_part(tmp_path, statements):
    joined = statements if "connect lid" in statements else "connect lid to body\n" + statements
    assert findings(tmp_path, joined, optional=True) == []


OPTIONAL = [
    "align body.top = lid.top",
    "let a = lid.size.z",
    "when soft { align body.top = lid.top }",
    "when lid or soft { align body.top = lid.top }",
    "when lid { } else { align body.top = lid.top }",
    "when lid { align body.top = lid.neck.top }",
    "part badge : Cuboid\n connect badge.back on lid.front",
]


@pytest.mark.parametrize("statements", OPTIONAL)
def test_an_optional_part_outside_such_guards(tmp_path, statements):
    found = findings(tmp_path, "connect lid to body\n" + statements, optional=True)
    assert found == ["optional-outside-when"]


def test_one_name_in_exclusive_branches_is_one_part_afterwards(tmp_path):
    text = (
        "connect lid to body\n connect pad to body\n"
        "when soft { part pad : Cylinder(radius = 1cm, height = 1cm) } else { part pad : Cuboid }\n"
    )
    assert findings(tmp_path, text + "align pad.top = body.top", optional=False) == []
    assert findings(tmp_path, text + "align pad.axis.origin.z = body.top", optional=False) == ["optional-outside-when"]


OPTIONAL_SLOT = """
role Pad {{ slot face  slot dial ?  port eye ? : frame }}
template Plain : Pad {{ part face : Cuboid(size = [1cm, 1cm, 1cm]) }}
template Round : Pad {{
  part face : Cuboid(size = [1cm, 1cm, 1cm])
  repeat knob[i] in 0 ..< 2 {{ part dial : Cylinder(radius = 1cm, height = 1cm) }}
  port eye = frame(at = face.front.center, out = x, up = z)
}}
material steel {{ density 7850kg/m3 }}
category Oven {{
  root part body : Cuboid(size = [40cm, 60cm, 30cm])
  part pad : Pad = {alternatives}
  connect pad to body
  {statements}
}}
"""


@pytest.mark.parametrize(
    "alternatives, statements, found",
    [
        ("Plain | Round", "material steel on pad.dial", []),
        ("Plain", "material steel on pad.dial", []),
        ("Plain | Round", "when pad is Round { align pad.eye.origin.z = body.center.z }", []),
        ("Plain | Round", "align pad.eye.origin.z = body.center.z", ["optional-outside-when"]),
        ("Plain", "align pad.dial.top = body.top", ["optional-outside-when"]),
        ("Plain", "material steel on pad.dail", ["unknown-member"]),
    ],
)
def test_what_a_role_offers_as_optional(tmp_path, alternatives, statements, found):
    text = OPTIONAL_SLOT.format(alternatives=alternatives, statements=statements)
    assert codes(check_text(tmp_path, HEAD + text)[0]) == found


STYLE = """
role Front {{ inherit size : length[3]  inherit pull : style Handle }}
template Door : Front {{
  part handle : pull(size = [_, 2cm, 10cm])
  connect handle.mount to frame(at = front.center, out = x, up = z)
  {statement}
}}
template Peg {{ part rod : Cuboid(size = [1cm, 1cm, 1cm]) }}
category Chest {{
  style grip : Handle = BarHandle weight 2 | BowHandle | none
  style peg : Peg = Peg
  root part body : Cuboid(size = [40cm, 60cm, 30cm])
  part door : Front(pull = {pull}) = Door
  connect door.back on body.front
}}
"""


@pytest.mark.parametrize(
    "pull, statement, found",
    [
        ("grip", "require handle.size.z <= 0.5 * size.z", []),
        ("BarHandle", "when handle { align handle.center.z = center.z }", []),
        ("grip", "align handle.center.z = center.z", []),
        ("grip", "align center.z = handle.center.z", ["optional-outside-when"]),
        ("grip", "require handle.nose.size.z <= 1cm", ["unknown-member"]),
        ("peg", "", ["wrong-role"]),
        ("3cm", "", ["wrong-type"]),
    ],
)
def test_styles_handed_to_templates(tmp_path, pull, statement, found):
    text = STYLE.format(pull=pull, statement=statement)
    assert codes(check_text(tmp_path, HEAD + text)[0]) == found


@pytest.mark.parametrize("target", ["5cm", "(body.left + body.right) / 2", "body.size", "body", "body.center"])
def test_what_is_no_face_is_told_once(tmp_path, target):
    assert findings(tmp_path, f"connect lid.left on {target}", False) == ["wrong-type"]
