"""Paths that authors write: what works, and whose curve is named where one does not."""

import math

import numpy as np
import pytest

from artipg_dsl.graph import expr as E
from artipg_dsl.lower.solids.paths import stretches, turned
from artipg_dsl.lower.solids.probe import Probe
from artipg_dsl.lower.values.handed import Step
from artipg_dsl.session import Session, check_text
from artipg_dsl.source import Source

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


SPRING = """apg 1
primitive Spring {
  param r     : length > 0  test 3cm .. 5cm
  param share : angle > 0   test ANGLE .. ANGLE
  curve run (u in 0turn .. 1turn) = [r * cos(u * share / 1turn), r * sin(u * share / 1turn), r * u / 1turn]
  solid = sweep(circle(0.5mm)) along run up z
}
"""


@pytest.mark.parametrize("turns", [65, 256, 512])
def test_turns_are_counted_whatever_the_steps_show(turns):
    """A path of 256 turns has the same direction at each of 256 steps."""
    found = check_text(Source("test.apg", SPRING.replace("ANGLE", f"{turns}turn"))).diagnostics
    assert [d.code for d in found] == ["bad-curve"]
    assert f"the path makes {turns} turns" in found[0].message


def winding(turns, power):
    """A circle that is run through with a speed that grows as a power of v."""
    angle = E.mul(E.const(math.tau * turns), E.power(E.var("v"), E.const(power)))
    (path,) = stretches([Step("formula", (E.call("cos", angle), E.call("sin", angle), E.ZERO))])
    return path


@pytest.mark.parametrize(("turns", "power"), [(0.75, 1.0), (20.0, 1.0), (60.0, 8.0), (1024.0, 1.0), (5000.0, 2.0)])
def test_turns_of_a_path_are_exact(turns, power):
    probe = Probe.of({"": np.zeros(1)})
    assert turned(probe, winding(turns, power)) / math.tau == pytest.approx(turns, rel=1e-2)
