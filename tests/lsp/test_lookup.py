"""The name at a place: what it stands for, and where it is declared."""

import pytest

from artipg_dsl.lsp.lookup import find

from .texts import SHELVES, STAND

CASES = [  # text with a mark, the beginning of what is shown, words of what is said of it, where it is declared
    ("height : length in 30cm", "he|ight : length in 30cm", "param height : length in 30cm .. 60cm = 40cm", "From floor", "height : length"),
    ("cm, height])\n  repeat", "cm, hei|ght])\n  repeat", "param height", "From floor", "height : length"),
    ("shelf : Board(", "shelf : Boa|rd(", "template Board\n  param depth : length", "A board that lies", "Board {"),
    ("Board(depth", "Board(de|pth", "param depth : length in 20cm .. 30cm", "", "depth : length"),
    ("Board }", "Boa|rd }", "template Board", "A board that lies", "Board {"),
    ("use shelves ", "use shel|ves ", "use shelves", "declares Board", "apg 1"),
    ("param height : length", "param height : len|gth", "length", "a number of that dimension", None),
    ("tilt : revolute", "tilt : revo|lute", "joint : revolute", "needs `range`", None),
    ("joint tilt", "joint ti|lt", "joint tilt : revolute shelf -> back", "", "tilt : revolute"),
    ("on shelf.bottom", "on shelf.bott|om", "shelf.bottom : a plane", "its face towards -z", None),
    ("connect post.top", "connect po|st.top", "part post : Cuboid", "", "post : Cuboid"),
    ("(i - 1/2)", "(i| - 1/2)", "repeat leg[i] in 0 ..< 2", "", "i]"),
    ("y + aside", "y + asi|de", "let aside = (i - 1/2) * 50cm", "a length", "aside = "),
    ("semantic.shelf on", "semantic.she|lf on", "semantic.shelf", "What a part is", None),
    ("label semantic.shelf", "label sema|ntic.shelf", "vocabulary semantic", "What a part is", None),
    ("material oak", "material o|ak", "material oak", "", None),
    ("look == plain", "look == pl|ain", "plain : one of plain, carved", "", None),
]  # fmt: skip


@pytest.mark.parametrize("old, new, code, about, declared", CASES)
def test_what_a_name_stands_for(texts, old, new, code, about, declared):
    analysis, offset = texts.at(old, new)
    found = find(analysis, offset)
    assert found is not None and found.code.startswith(code) and about in found.about
    assert found.span.start <= offset <= found.span.end
    if declared is not None:
        (span,) = found.declared
        assert span.source.text[span.start :].startswith(declared)
        assert analysis.path_of(span.source) == (texts.shelves if span.source.text == SHELVES else texts.stand)


def test_the_members_of_a_part_are_those_of_its_template(texts):
    analysis, offset = texts.at("y + aside", "y + shelf.ed|ge")
    found = find(analysis, offset)
    assert found.code == "let edge = depth / 10" and found.about == "a length"
    assert analysis.path_of(found.declared[0].source) == texts.shelves


def test_a_word_that_stands_for_nothing_is_not_explained(texts):
    for old, new in (("repeat leg", "rep|eat leg"), ("From floor", "From fl|oor"), ("y + aside", "y + nothing|s")):
        assert find(*texts.at(old, new)) is None


def test_names_are_known_beside_a_statement_that_cannot_be_read(texts):
    analysis = texts.analysis(STAND.replace("align back.back = shelf.back", "align back.back = = shelf.back"))
    assert analysis.report.failed
    found = find(analysis, STAND.index("height])"))
    assert found is not None and found.code.startswith("param height")


def test_what_is_not_saved_counts(texts):
    from artipg_dsl.source import Source

    other = Source(str(texts.shelves), SHELVES.replace("Board", "Plank"))
    analysis = texts.analysis(STAND, {texts.shelves: other})
    (found,) = (d for d in analysis.report.diagnostics if d.severity == "error")
    assert found.code == "unknown-import" and texts.shelves in analysis.reads
    assert not texts.analysis(STAND).report.failed
