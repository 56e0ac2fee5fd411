"""Another name for what a file declares."""

import re

import pytest

from artipg_dsl.lsp.analysis import Analysis
from artipg_dsl.lsp.rename import Refused, rename
from artipg_dsl.source import Source

from .texts import SHELVES, STAND

ROLES = """apg 1
use primitives { Cuboid }
role Foot {
  inherit height : length in 1cm .. 6cm
  slot felt ?
}
primitive Loop {
  param r : length > 0  test 1cm .. 2cm
  curve skin (v in 0 .. 1) = [2 * r + r * cos(v * 1turn), r * sin(0.5turn)]
  solid = lathe(skin) about z
}
template Block : Foot {
  param side : length[2] in [1cm, 1cm] .. [2cm, 2cm]
  part felt : Cuboid(size = [side.x, side.y, height])
}
category Stool {
  param tall : length in 2cm .. 3cm  ## of its feet
  param shape : choice plain | fine
  root part seat : Cuboid(size = [30cm, 30cm, 3cm])
  part foot : Foot(height = tall) = Block
  connect foot to seat
  align foot.top = seat.bottom
  repeat side[i] in 0 ..< 2 {
    let far = (i - 1/2) * tall
    part bar : Cuboid(size = [1cm, 1cm, tall])
    connect bar to seat
    align bar.center = [far, 0, seat.bottom - tall]
  }
  let reach(a) = a * 2
  keypoint sole on foot.felt
  grasp hold on seat for t in -1 .. 1 { at [t * tall, 0, 0]  approach -x  close y  opening 3cm }
  when shape == fine { require reach(tall) > 1cm }
}
"""


def analysis(text):
    return Analysis(Source("/x/stool.apg", text), {})


def after(text, place, name):
    """The text with a name changed."""
    edits = rename(analysis(text), text.index(place), name)
    for edit in sorted(edits, key=lambda edit: -edit.span.start):
        text = text[: edit.span.start] + edit.text + text[edit.span.end :]
    return text


@pytest.mark.parametrize(
    ("place", "name", "changed", "kept"),
    [
        ("seat :", "board", 6, 0),
        ("foot.top", "leg", 4, 0),
        ("Block :", "Brick", 2, 0),
        ("Foot {", "Support", 3, 0),
        ("height :", "rise", 3, 0),
        ("side :", "plan", 3, 2),  # the repeat of that name, and `was side`
        ("side[i]", "end", 1, 3),
        ("bar :", "rod", 3, 0),
        ("reach(a)", "twice", 2, 0),
        ("a) =", "length_of", 2, 0),
        ("a * 2", "length_of", 2, 0),
        ("i] in", "k", 2, 0),
        ("i - 1/2", "k", 2, 0),
        ("t in -1", "s", 2, 0),
        ("v in 0", "w", 2, 0),
        ("v * 1turn", "w", 2, 0),
        ("Stool", "Chair", 1, 0),
        ("felt ?", "pad", 3, 0),  # what its templates bind
        ("felt :", "pad", 3, 0),
        ("felt\n", "pad", 3, 0),
    ],
)
def test_a_name_is_changed_where_it_means_the_same(place, name, changed, kept):
    text, old = after(ROLES, place, name), re.match(r"\w+", place).group()
    assert len(re.findall(rf"\b{name}\b", text)) == changed
    assert len(re.findall(rf"\b{old}\b", text)) == kept
    assert not analysis(text).failed


def test_what_is_drawn_is_said_to_have_been_the_old_one():
    text = after(ROLES, "tall :", "long")
    assert "param long : length in 2cm .. 3cm was tall  ## of its feet" in text and text.count("tall") == 1
    assert "param look : choice plain | fine was shape\n" in after(ROLES, "shape :", "look")
    assert "param high : length in 2cm .. 3cm was tall  ##" in after(text, "long :", "high")


@pytest.mark.parametrize(
    ("place", "name", "why"),
    [
        ("length in 1cm", "x1", "is not declared by a statement"),
        ("fine\n", "rich", "is not declared by a statement"),
        ("Cuboid }", "Box", "`Cuboid` is declared in the library"),
        ("primitives", "solids", "a module is called as its file"),
        ("felt ?", "side", "`side` cannot be its name: "),
        ("seat :", "part", "`part` is a word of the language and cannot be used as a name"),
        ("seat :", "2nd", "`2nd` cannot be its name: "),
        ("seat :", "a b", "`a b` cannot be its name: "),
        ("seat :", "foot", "`foot` cannot be its name: "),
        ("tall :", "far", "`far` cannot be its name: "),
        ("tall :", "i", "`i` cannot be its name: "),
        ("apg 1", "x", "there is no name"),
    ],
)
def test_what_cannot_be_is_refused_in_words(place, name, why):
    with pytest.raises(Refused) as caught:
        after(ROLES, place, name)
    assert why in str(caught.value)


def test_a_file_with_errors_is_put_right_first():
    with pytest.raises(Refused, match=r"stool\.apg has errors: put them right first"):
        after(ROLES.replace("connect foot to seat", ""), "seat :", "board")


def test_files_beside_are_changed_along(texts):
    stand, shelves = texts.analysis(STAND), Analysis(Source(str(texts.shelves), SHELVES), {})
    edits = rename(stand, STAND.index("depth ="), "deep", [shelves])
    found = [(edit.span.source.name, edit.span.line, edit.text) for edit in edits]
    own, other = str(texts.stand), str(texts.shelves)
    assert found == [(own, 11, "deep"), *((other, line, "deep") for line in (6, 8, 9)), (other, 6, " was depth")]


def test_what_a_role_of_the_library_names_keeps_its_name():
    text = "apg 1\nuse handles { Handle }\nuse primitives { Cuboid }\ntemplate Bar : Handle {\n  part grip : Cuboid(size = size)\n"
    text += "  port mount = grip.back\n}\n"
    for place in ("grip :", "mount ="):
        with pytest.raises(Refused, match="is a name of the role `Handle` of the library"):
            after(text, place, "bow")
