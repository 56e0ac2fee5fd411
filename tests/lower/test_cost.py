"""What lowering costs goes with the length of the text: counts, not times."""

from collections import Counter

import numpy as np
import pytest

from artipg_dsl.graph import expr as E
from artipg_dsl.graph import formula
from artipg_dsl.graph.inequality import Ends
from artipg_dsl.graph.linear import Linear
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.substitution import substitute, substitute_all
from artipg_dsl.graph.writing import to_text
from artipg_dsl.lower import program as lowering
from artipg_dsl.lower.solids.probe import Probe
from artipg_dsl.session import Session

SPRING = """apg 1
primitive Wire {
  param path : curve
  param radius : length > 0  test 0.5mm .. 1.5mm
  solid = sweep(circle(radius)) along path up z
}
template Coil {
  param r : length in 2cm .. 4cm = 3cm
  curve run = from([r, 0, 0], [0, 1, 0.1]) ARCS
  part wire : Wire(path = run, radius = 1mm)
}
category Spring {
  root part coil : Coil
}
"""
SIDES = ("[-1, 0, 0.1]", "[0, -1, 0.1]", "[1, 0, 0.1]", "[0, 1, 0.1]")


def lowered(arcs):
    path = " ".join(f"arc(radius = r, angle = 90deg, towards = {SIDES[k % 4]})" for k in range(arcs))
    session = Session.of_text(SPRING.replace("ARCS", path))
    assert session.lowering is not None, [d.message for d in session.report.diagnostics if d.severity == "error"]
    return session.lowering.program


@pytest.mark.slow
def test_a_path_of_eight_arcs_takes_few_formulas_and_a_text_that_grows_evenly():
    short = to_text(lowered(4))
    before = formula._compile.cache_info().misses
    program = lowered(8)
    assert formula._compile.cache_info().misses - before < 8 * 20
    text = to_text(program)
    assert len(text) < 3 * len(short)
    assert to_text(from_text(text)) == text


def test_a_formula_is_seen_along_a_path_at_once_as_at_each_place():
    x, t = E.var("x"), E.var("v")
    probe = Probe.of({"": np.zeros(5), "x": np.linspace(0.5, 2.0, 5)})
    places = [k / 8 for k in range(9)]
    for held in ([E.mul(x, E.call("sin", t)), E.add(x, t)], [E.mul(t, E.call("log", t)), x]):
        each = np.stack([probe(*(substitute(e, {t: E.const(p)}) for e in held)) for p in places])
        assert np.allclose(probe.along(held, places, t), each, rtol=1e-15, atol=0.0, equal_nan=True)


def test_substitution_in_several_expressions_is_that_in_each():
    x, y = E.var("x"), E.var("y")
    shared = E.call("sin", E.mul(x, y))
    held = [E.add(shared, x), E.mul(shared, shared), y]
    assert substitute_all(held, {x: E.const(2.0)}) == [substitute(e, {x: E.const(2.0)}) for e in held]


def test_requirements_are_read_once_for_each_column(monkeypatch):
    """Bounds come back to the same expressions for every draw and every bound that is derived: they have been read by then."""
    read: Counter[tuple[object, E.Expr]] = Counter()

    def counted(kind, name):
        plain = getattr(kind, name)

        def method(self, node):
            read[self, node] += 1
            return plain(self, node)

        monkeypatch.setattr(kind, name, method)

    counted(Linear, "_parts")
    counted(Ends, "_of")
    bounds = lowering.attach_bounds

    def attach(program, strict):
        read.clear()
        found = bounds(program, strict)
        assert max(read.values()) == 1 and sum(read.values()) < 3000, "a tenth above what it was: it may be lowered"
        return found

    monkeypatch.setattr(lowering, "attach_bounds", attach)
    assert Session.of("StorageFurniture").lowering is not None
