"""A path that bends more tightly than its section is wide is an error at the author's curve, with both figures."""

import pytest

from artipg_dsl.sampling.statistics import Exhausted
from artipg_dsl.session import Session, check_text
from artipg_dsl.source import Source

TEXT = """apg 1
use bars { Tube }
primitive Strip {
  param path : curve
  param wide : length > 0  test 6mm .. 2cm
  solid = sweep(rectangle(wide, 2mm)) along path up y
}
category A {
  param b : length in 2mm .. 8mm
  curve way = PATH
  root part wire : PART
}
"""
LINE = "from([0, 0, 0], z) line(5cm) arc(radius = RADIUS, angle = 90deg, towards = x) line(5cm)"
CURVE = "(t in 0turn .. 0.5turn) = [RADIUS * cos(t), 0mm, RADIUS * sin(t)]"
OVAL = "(t in 0turn .. 0.5turn) = [RADIUS * cos(t), 0mm, 5 * RADIUS * sin(t)]"


def report(path, part, radius):
    written = f"curve way {path}" if path.startswith("(") else f"curve way = {path}"
    text = TEXT.replace("curve way = PATH", written.replace("RADIUS", radius)).replace("PART", part)
    return [d for d in check_text(Source("test.apg", text)).diagnostics if d.severity == "error"]


@pytest.mark.parametrize(
    ("path", "part", "radius", "words"),
    [
        (LINE, "Tube(path = way, radius = 9mm)", "5mm", "curvature is 5mm there, and the section reaches 9mm"),
        (LINE, "Tube(path = way, radius = 9mm)", "b", "curvature is at most 8mm there, and the section reaches 9mm"),
        (CURVE, "Tube(path = way, radius = 9mm)", "8mm", "curvature is 8mm there, and the section reaches 9mm"),
        (
            CURVE,
            "Tube(path = way, radius = 1mm + b)",
            "2mm",
            "curvature is 2mm there, and the section reaches at least 3mm",
        ),
        (CURVE, "Strip(path = way, wide = 2cm)", "8mm", "curvature is 8mm there, and the section reaches 1cm"),
        (OVAL, "Tube(path = way, radius = 9mm)", "b", "curvature is at most 1."),
    ],
    ids=["arc", "arc-drawn", "formula", "section-drawn", "rectangle", "oval"],
)
def test_the_curve_is_blamed_with_its_radius_and_the_size_of_the_section(path, part, radius, words):
    (found,) = report(path, part, radius)
    assert found.span.line == 10 and found.message.startswith("`way` ") and "too tightly" in found.message
    assert words in found.message


@pytest.mark.parametrize("path", [LINE, CURVE], ids=["arc", "formula"])
@pytest.mark.parametrize(
    "part", ["Tube(path = way, radius = 1mm)", "Strip(path = way, wide = 2mm)"], ids=["tube", "strip"]
)
def test_what_is_thin_enough_bends_as_it_is_told(path, part):
    """Though the primitive's own test ranges are wider than the bend."""
    assert report(path, part, "2.5mm") == []


def test_what_only_the_draws_show_is_counted_at_the_curve():
    """The ranges of a formula's curvature are too wide for `check` to tell."""
    text = TEXT.replace("curve way = PATH", f"curve way {CURVE.replace('RADIUS', 'b')}").replace(
        "PART", "Tube(path = way, radius = 9mm)"
    )
    sampler = Session.of_text(text, "test.apg").sampler
    with pytest.raises(Exhausted) as error:
        sampler.batch(range(1), seed=0)
    failed = [sampler.program.requirements[number] for number in error.value.statistics.broken]
    assert [(r.where.line, r.message) for r in failed] == [
        (10, "wire: `way` bends more tightly than its section allows")
    ]
