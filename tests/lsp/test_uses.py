"""Where a name is used."""

from artipg_dsl.lsp.analysis import Analysis
from artipg_dsl.lsp.uses import uses
from artipg_dsl.source import Source

from .texts import SHELVES, STAND


def lines(text, found):
    return [text.split("\n")[span.line - 1].strip() for span in found]


def test_a_name_is_found_where_it_means_the_same(texts):
    text = STAND.replace("let aside", "let height2 = 2 * height\n    let aside").replace("Board(depth", "Board( depth")
    found = uses(texts.analysis(text), text.index("height])"))
    assert lines(text, found) == [
        "param height : length in 30cm .. 60cm = 40cm",
        "part back : Cuboid(size = [2cm, 60cm, height])",
        "let height2 = 2 * height",
        "part post : Cuboid(size = [3cm, 3cm, height])",
    ]


def test_one_word_that_means_different_things_is_told_apart(texts):
    depth = "param depth : length in 1cm .. 2cm"
    text = STAND.replace("param height", f"{depth}\n  param height").replace("[2cm, 60cm", "[depth, 60cm")
    analysis = texts.analysis(text)
    own, taken = (uses(analysis, text.index(place)) for place in ("depth :", "depth ="))
    assert lines(text, own) == [depth, "part back : Cuboid(size = [depth, 60cm, height])"]
    assert lines(text, taken) == ["root part shelf : Board(depth = 28cm)"]


def test_uses_in_other_files_are_found_from_either(texts):
    stand, shelves = texts.analysis(STAND), Analysis(Source(str(texts.shelves), SHELVES), {})
    there = uses(shelves, SHELVES.index("depth :"), [stand])
    here = uses(stand, STAND.index("depth ="), [shelves])
    places = [(span.source.name, span.line) for span in there]
    assert places == [(str(texts.shelves), 6), (str(texts.shelves), 8), (str(texts.shelves), 9), (str(texts.stand), 11)]
    assert {(span.source.name, span.line) for span in here} == set(places)


def test_what_is_the_language_s_own_is_declared_nowhere(texts):
    assert not uses(texts.analysis(STAND), STAND.index("revolute"))
    assert not uses(texts.analysis(STAND), STAND.index("label semantic"))


def test_a_module_is_used_where_it_is_named(texts):
    text = STAND.replace("## From floor to board.", "## Lies on shelves.")
    found = uses(texts.analysis(text), text.index("shelves "))
    assert lines(text, found) == ["use shelves      { Board }"] and found[0].text == "shelves"


def test_what_branches_declare_is_one_thing(texts):
    text = STAND.replace(
        "  when look == plain {",
        "  when look == plain { let far = 1cm } else { let far = 2cm }\n  require far < height\n  when look == plain {",
    )
    places = [text.index(place) for place in ("far = 1", "far = 2", "far <")]
    for place in places:
        assert [span.start for span in uses(texts.analysis(text), place)] == places
