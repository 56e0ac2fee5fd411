"""Colours, outline and fixes."""

from artipg_dsl.lsp.colours import KINDS, colours
from artipg_dsl.lsp.fixes import fixes
from artipg_dsl.lsp.outline import outline
from artipg_dsl.source import Source

from .texts import STAND


def coloured(text):
    found = list(colours(Source("a.apg", text)))
    assert {colour.kind for colour in found} <= set(KINDS)
    assert all(a.span.end <= b.span.start for a, b in zip(found, found[1:], strict=False))
    return [(colour.span.text, colour.kind) for colour in found]


def test_each_word_has_its_colour():
    found = coloured("apg 1\ntemplate A : B {\n  param width : length = min(2cm, 1/2 * a.size.x)  # no\n}\n")
    assert found == [
        ("apg", "keyword"), ("1", "number"), ("template", "keyword"), ("A", "class"), ("B", "class"), ("param", "keyword"),
        ("width", "variable"), ("length", "type"), ("min", "function"), ("2cm", "number"), ("1", "number"), ("2", "number"),
        ("a", "variable"), ("size", "property"), ("x", "property"), ("# no", "comment"),
    ]  # fmt: skip


def test_a_word_of_the_grammar_may_be_a_name():
    text = "apg 1\nuse primitives { Cuboid }\ntemplate A {\n  let range = 2cm\n  part b : Cuboid(size = [range, range, range])\n}\n"
    assert ("range", "variable") in coloured(text) and ("range", "keyword") not in coloured(text)


def test_a_statement_that_cannot_be_read_keeps_its_colours():
    found = coloured(STAND.replace("align back.back = shelf.back", "align back.back = = 3cm"))
    assert ("3cm", "number") in found and ("joint", "keyword") in found
    assert len(found) == len(coloured(STAND)) - 1


def test_the_outline_has_what_bodies_declare(texts):
    (stand,) = outline(texts.analysis(STAND))
    assert (stand.name, stand.kind) == ("Stand", "category")
    inner = {item.name: item for item in stand.inner}
    kinds = {"height": "param", "shelf": "part", "leg": "repeat", "tilt": "joint"}
    assert {name: inner[name].kind for name in kinds} == kinds
    assert [item.name for item in inner["leg"].inner] == ["aside", "post"]
    assert inner["tilt"].name_span.text == "tilt" and inner["tilt"].span.text.startswith("joint tilt : revolute")


def test_a_word_that_is_misspelt_can_be_replaced(texts):
    analysis = texts.analysis(STAND.replace("= shelf.top", "= shelv.top"))
    (found,) = analysis.report.diagnostics
    (fix,) = fixes(found)
    assert (fix.span.text, fix.text) == ("shelv", "shelf")


def test_other_findings_propose_nothing(texts):
    analysis = texts.analysis(STAND.replace("height : length in 30cm", "height : length in 30"))
    assert analysis.report.failed and not any(fixes(found) for found in analysis.report.diagnostics)
