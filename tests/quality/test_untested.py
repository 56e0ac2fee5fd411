"""`apgc check` compares boxes with surfaces where values lie outside of the test ranges."""

from textwrap import dedent

from artipg_dsl.diagnostics.codes import CODES
from artipg_dsl.geometry import pieces
from artipg_dsl.session import Session

TEXT = dedent(CODES["untested-values"].example)
SLAB = """
apg 1
use vocabularies { semantic }
use materials { steel }
primitive Slab {
  param wide : length > 0  test 10cm .. 20cm
  surface top    (u in 0 .. 1, v in 0 .. 1) = [wide * (u - 0.5), wide * (v - 0.5), 1cm]
  surface bottom (u in 0 .. 1, v in 0 .. 1) = [wide * (0.5 - u), wide * (v - 0.5), -1cm]
  surface front  (u in 0 .. 1, v in 0 .. 1) = [wide / 2, wide * (u - 0.5), 2cm * (v - 0.5)]
  surface back   (u in 0 .. 1, v in 0 .. 1) = [-wide / 2, wide * (0.5 - u), 2cm * (v - 0.5)]
  surface right  (u in 0 .. 1, v in 0 .. 1) = [wide * (0.5 - u), wide / 2, 2cm * (v - 0.5)]
  surface left   (u in 0 .. 1, v in 0 .. 1) = [wide * (u - 0.5), -wide / 2, 2cm * (v - 0.5)]
  inside (p) = max(abs(p.x) - wide / 2, abs(p.y) - wide / 2, abs(p.z) - 1cm)
  box = [wide, wide, 2cm]
  let far = max(wide / 2, 5cm)
  piece whole = hull([-far, -far, -1cm], [far, -far, -1cm], [-far, far, -1cm], [far, far, -1cm],
                     [-far, -far, 1cm], [far, -far, 1cm], [-far, far, 1cm], [far, far, 1cm])
}
category Tile {
  root part slab : Slab(wide = 6cm)
  label semantic.handle on slab
  material steel on slab
}
"""


def told(text):
    return [d for d in Session.of_text(text).examine().diagnostics if d.code == "untested-values"]


def test_a_wrong_box_names_the_part_the_value_and_the_range():
    (found,) = told(TEXT)
    assert "`bow` reaches 9.91 mm out of its box: here `begin` of `Bow` is -0.5236" in found.message
    assert "0 .. 0.3491" in found.message and found.severity == "warning"


def test_a_range_that_holds_the_value_makes_the_box_right():
    assert told(TEXT.replace("test 0deg .. 20deg", "test -40deg .. 20deg")) == []


def test_a_value_beyond_its_range_where_the_box_is_right_is_not_told():
    assert told(TEXT.replace("begin = -30deg", "begin = 10deg").replace("radius = 7cm", "radius = 3cm")) == []


def test_a_piece_that_is_wrong_at_the_value_is_told():
    (found,) = told(SLAB)
    assert found.message.startswith(
        "a convex piece of `slab` reaches 20 mm out of its box: here `wide` of `Slab` is 0.06"
    )
    assert told(SLAB.replace("wide = 6cm", "wide = 12cm")) == []


def test_of_several_places_that_of_the_worst_value_is_named(monkeypatch):
    """Places have rows in each of the objects; of a value within the range nothing is told. Pieces are computed once for all looks."""
    asked = []
    clouds = pieces.clouds
    monkeypatch.setattr(
        pieces, "clouds", lambda primitive, params: asked.append(primitive.name) or clouds(primitive, params)
    )
    text = SLAB.replace(
        "root part slab : Slab(wide = 6cm)",
        """root part slab : Slab(wide = 12cm)
  repeat pile[i] in 0 ..< 2 {
    part low : Slab(wide = 8cm)
    part high : Slab(wide = 6cm + i * 1mm)
    connect low.bottom on slab.top + i * 4cm
    connect high.bottom on low.top
  }""",
    )
    (found,) = told(text)
    assert "`pile.high` reaches 20 mm out of its box: here `wide` of `Slab` is 0.06" in found.message
    assert asked == ["Slab"]
