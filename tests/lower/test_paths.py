"""Paths that authors write: what works, and whose curve is named where one does not."""

from artipg_dsl.session import Session

STRAP = """
primitive Strap {
  param path : curve
  param w : length > 0  test 5mm .. 1cm
  solid = sweep(rectangle(w, 2 * w)) along path up y
}
"""
AUTHOR = """
use bars { Tube }
category A {
  param rise : length in 1cm .. 5cm = 2cm
  param r : length in 5cm .. 9cm = 6cm
  CURVE
  root part rod : PART
}
"""


def session(curve, part="Tube(path = way, radius = 1cm)"):
    return Session.of_text("apg 1\n" + STRAP + AUTHOR.replace("CURVE", curve).replace("PART", part))


def test_the_authors_curve_and_its_parameters_are_named():
    one = session("curve way = from([0, 0, rise], x) arc(radius = 8cm, angle = 450deg, towards = z)")
    assert one.lowering is None
    (found,) = [d for d in one.report.diagnostics if d.severity == "error"]
    assert found.span.source.name == "<text>" and "curve way" in found.span.source.text.split("\n")[found.span.line - 1]
    assert "rise = 0.0" in found.message and "path." not in found.message
    assert any("rod" in text for _, text in found.trace)
    assert any(span.source.name.endswith("bars.apg") for span, _ in found.notes)


def test_only_what_domains_allow_is_tested():
    """At rise = -5cm the root has no value, but no domain allows that."""
    one = session("curve way (t in 0 .. 1) = [r * t, 0mm, sqrt(rise - 9mm) * sqrt(1cm) * t]")
    assert one.lowering is not None, [d.message for d in one.report.diagnostics]
