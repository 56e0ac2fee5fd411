"""`check` warns of drawers that are pulled out of what holds them, and of nothing else that comes off."""

import pytest

from artipg_dsl.session import Session

CHEST = """apg 1
use bodies {{ OpenBox }}
use primitives {{ Cuboid }}
use vocabularies {{ semantic }}
category Chest {{
  param width : length in 30cm .. 50cm
  root part body : OpenBox(size = [30cm, width, 20cm], wall = 1cm)
  part insert : Cuboid
  joint pull : prismatic body -> insert {way}
  label semantic.body on body
  label semantic.{word} on insert
}}
"""
INSIDE = "in body.inner gap 1mm along {} range {}"


@pytest.mark.parametrize(
    ("way", "word", "told"),
    [
        (INSIDE.format("x", "0cm .. 24cm"), "drawer", None),
        (INSIDE.format("x", "0cm .. 35cm"), "drawer", "61 mm farther"),  # 28.9 cm long, its front in that of the body
        (INSIDE.format("-x", "-35cm .. 0cm"), "drawer", "61 mm farther"),
        (INSIDE.format("x", "0cm .. 35cm"), "lid", None),
        ("in body.inner fit left, right, top, bottom gap 1mm along x range 0cm .. 35cm", "drawer", None),
    ],
)
def test_drawers_that_leave_what_holds_them(way: str, word: str, told: str | None) -> None:
    if "fit" in way:  # a front that lies before the body, which nothing guides at rest either
        way += "\n  align insert.back = body.front + 1mm\n  align insert.size.x = 2cm"
    session = Session.of_text(CHEST.format(way=way, word=word), "chest.apg")
    session.advise()
    assert not session.report.failed
    found = [d for d in session.report.diagnostics if d.code == "unguided"]
    assert [d.span.text[:10] for d in found if d.span] == ["joint pull"] * (told is not None)
    assert all(told is not None and told in d.message for d in found)
