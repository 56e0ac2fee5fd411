"""What new authors tried and could not write: it is done."""

import pytest

from artipg_dsl.graph.expr import col
from artipg_dsl.session import Session

HORN = """
primitive Horn {
  param path : curve
  param a : length > 0  test 5mm .. 1cm
  solid = loft(circle(a), circle(a / 2)) along path up y
}
template Spout {
  param l : length in 5cm .. 8cm = 6cm
  curve way = from([0, 0, 0], x) line(l) arc(radius = 4cm, angle = 90deg, towards = z)
  part horn : Horn(path = way, a = 8mm)
  port tip : frame = horn.end
}
category A {
  root part spout : Spout
  part cap : Cylinder(radius = 1cm, height = 1cm)
  connect cap.bottom to spout.tip
}
"""
LOFT = """
primitive L {
  param w : length > 0  test 1cm .. 4cm
  solid = loft(circle(w), circle(1.2 * w), circle(1.1 * w), circle(w)) along z at [0, w, 2 * w, 4 * w]
}
category A { root part l : L(w = 2cm) }
"""
BOW = """
use bars { Tube }
category A {
  param reach : length in 10cm .. 12cm = 11cm
  param begin : length in 1cm .. 3cm = 2cm
  curve bow (t in 0turn .. 0.5turn) = [reach * sin(t), 0mm, begin - reach * cos(t)]
  root part wire : Tube(path = bow, radius = 1cm)
}
"""


def batch(text):
    session = Session.of_text("apg 1\nuse primitives { Cylinder }\n" + text)
    assert session.lowering is not None, [d.message for d in session.report.diagnostics]
    return session.sampler.batch(range(3), 0)


def test_the_ends_of_a_loft_along_a_path_are_frames():
    parts = batch(HORN).parts()
    caps = [k for k, path in enumerate(parts.path) if path == "cap"]
    horn = [k for k, path in enumerate(parts.path) if path == "spout.horn"]
    low, high = parts.low + parts.translation, parts.high + parts.translation
    assert low[caps, 2] == pytest.approx(high[horn, 2], abs=1e-12)


def test_levels_of_a_loft_are_as_many_as_its_sections():
    parts = batch(LOFT).parts()
    assert parts.high[:, 2] - parts.low[:, 2] == pytest.approx(0.08)


def test_a_formula_of_a_template_is_a_path():
    made = batch(BOW)
    reach = made.program.draws[0].column
    wide = (made.parts().high - made.parts().low)[:, 0]
    assert wide == pytest.approx(made.read([col(reach)], reach.scope)[0] + 0.01, abs=1e-12)
