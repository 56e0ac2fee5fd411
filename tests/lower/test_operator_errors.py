"""What operators cannot make is said in words."""

import pytest

from artipg_dsl.lower.expressions.context import Abort
from artipg_dsl.lower.solids.primitives import lower_primitive

from .operators import BEND, FLASK, PLATE, load


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        (
            "sweep(rectangle(a, b)) along way up y",
            "loft(circle(a), circle(b)) along z",
            "wrong-arguments",
            "the levels",
        ),
        (
            "sweep(rectangle(a, b))",
            "loft(rectangle(a, b), polygon([0, 0], [a, 0], [0, b]))",
            "broken-chain",
            "this one 3",
        ),
        ("sweep(rectangle(a, b))", "sweep(rectangle(a, b), circle(a))", "broken-chain", "do not match"),
        (
            "sweep(rectangle(a, b)) along way up y",
            "loft(circle(a), circle(b)) along z from 0 to l smooth",
            "wrong-arguments",
            "`smooth` needs at least three sections",
        ),
        (
            "sweep(rectangle(a, b)) along way up y",
            "loft(circle(a), circle(b)) along way up y smooth",
            "wrong-arguments",
            "no effect along a path",
        ),
    ],
)
def test_what_sections_cannot_be_is_said_in_words(old, new, code, words):
    assert old in BEND
    context, module = load(BEND.replace(old, new))
    with pytest.raises(Abort):
        lower_primitive(context, module.find("Bend"))
    (found,) = context.report.diagnostics
    assert found.code == code and words in found.message


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        ("- a / 4, r * sin(u)", "- a, r * sin(u)", "bad-curve", "cannot be filled"),
        ("- a / 4, r * sin(u)", "+ a / 4, r * sin(u)", "bad-curve", "cannot be filled"),
        ("[arch, sill]", "arch", "broken-chain", "this outline is not closed"),
    ],
    ids=["outside", "overlapping", "open"],
)
def test_holes_lie_within_the_outline_and_apart(old, new, code, words):
    context, module = load(PLATE.replace(old, new))
    with pytest.raises(Abort):
        lower_primitive(context, module.find("Plate"))
    (found,) = context.report.diagnostics
    assert found.code == code and words in found.message


@pytest.mark.parametrize(
    ("old", "new", "code", "words"),
    [
        ("/ 2 * v, height * v]", "/ 2 * v, height * v + 1mm]", "broken-chain", "does not begin where `base` ends"),
        ("[base, side], [floor, lining]", "[base, side], [lining]", "broken-chain", "2 curves, the inner one 1"),
        ("about z", "about -z", "bad-axis", "takes x, y or z after `about`"),
        ("[radius * v, 0mm]", "[radius * (2 * v - 1), 0mm]", "bad-curve", "a radius below 0"),
        ("[radius * v, 0mm]", "[radius * sqrt(v - 0.5) * sqrt(2), 0mm]", "bad-curve", "no value"),
        ("lathe([base, side], [floor, lining]) about", "sweep(circle(wall)) along side up", "bad-curve", "in a plane"),
    ],
)
def test_what_cannot_be_made_is_said_in_words(old, new, code, words):
    assert old in FLASK
    context, module = load(FLASK.replace(old, new))
    with pytest.raises(Abort):
        lower_primitive(context, module.find("Flask"))
    (found,) = context.report.diagnostics
    assert found.code == code and words in found.message
