"""Equations without a closed form: their roots, which of several, what fails, and the module that needs NumPy alone."""

from __future__ import annotations

import sys
from types import ModuleType

import numpy as np
import pytest

from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.runtime.newton import solve_roots
from artipg_dsl.sampling.module import to_module
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.sampling.statistics import Exhausted, Statistics

from .test_solve import HEAD, Session, category, codes, compiled, sampled, value

# the foot of a slanted strut of fixed length that touches a drum: its angle and its length are coupled
TANGENT = category("""
  param tilt : angle in 1deg .. 89deg derived
  param reach : length in 1cm .. 80cm derived
  align reach * cos(tilt) = w - 5cm * sin(tilt)
  align reach * sin(tilt) = 6cm + 5cm * cos(tilt)
  part strut : Cuboid(size = [reach, 1cm, 1cm])
  connect strut.back on body.front
""")
# two circles meet in two points: the defaults choose
CIRCLES = """
  param a : length in -50cm .. 50cm = {a} derived
  param b : length in -50cm .. 50cm = {b} derived
  align a * a + b * b = w * w
  align (a - 10cm) * (a - 10cm) + (b + a / 3) * (b + a / 3) = w * w
  part p : Cuboid(size = [60cm + a, 60cm + b, 1cm])
  connect p.back on body.front
"""


def test_a_tangent_is_found_for_every_object() -> None:
    batch = sampled(TANGENT, 200)
    w, tilt, reach = (value(batch, name) for name in ("w", "tilt", "reach"))
    np.testing.assert_allclose(reach * np.cos(tilt), w - 0.05 * np.sin(tilt), rtol=1e-12)
    np.testing.assert_allclose(reach * np.sin(tilt), 0.06 + 0.05 * np.cos(tilt), rtol=1e-12)
    # a tangent from (0, 0) to the circle around (w, 6 cm): Pythagoras knows its length
    np.testing.assert_allclose(reach, np.sqrt(w**2 + 0.06**2 - 0.05**2), rtol=1e-12)
    assert (batch.state.attempt == 0).all()


def test_the_default_chooses_the_root() -> None:
    found = [sampled(category(CIRCLES.format(a=a, b=b))) for a, b in (("20cm", "20cm"), ("20cm", "-20cm"))]
    values = [(value(batch, "a"), value(batch, "b")) for batch in found]
    for a, b in values:
        np.testing.assert_allclose(a**2 + b**2, value(found[0], "w") ** 2, rtol=1e-12)
    assert (values[0][1] > 0).all() and (values[1][1] < 0).all()


@pytest.mark.parametrize(("near", "sign"), [("b = 20cm", 1), ("b = -20cm, a = 0cm + w / 2", -1)])
def test_near_chooses_the_root(near: str, sign: int) -> None:
    text = CIRCLES.format(a="20cm", b="0cm").replace("(b + a / 3) = w * w", f"(b + a / 3) = w * w near {near}")
    batch = sampled(category(text))
    assert (np.sign(value(batch, "b")) == sign).all()
    np.testing.assert_allclose(value(batch, "a") ** 2 + value(batch, "b") ** 2, value(batch, "w") ** 2, rtol=1e-12)


def test_near_chooses_the_root_of_a_square() -> None:
    text = """
  param a : length in -50cm .. 50cm derived
  align a * a = w * w / 4 near a = {near}
  part p : Cuboid(size = [60cm + a, 1cm, 1cm])
  connect p.back on body.front
"""
    for near, factor in (("10cm", 0.5), ("-10cm", -0.5)):
        batch = sampled(category(text.format(near=near)))
        np.testing.assert_allclose(value(batch, "a"), factor * value(batch, "w"), rtol=1e-12)


def test_near_places_a_part_on_the_side_meant() -> None:
    text = """
  part p : Cuboid(size = [1cm, 1cm, 1cm])
  connect p to body
  align p.center.y * p.center.y = w * w / 9 near p.left = {near}
"""
    for near, sign in (("10cm", 1), ("-10cm", -1)):
        batch = sampled(category(text.format(near=near)))
        np.testing.assert_allclose(value(batch, "p.at.y"), sign * value(batch, "w") / 3, rtol=1e-12)


@pytest.mark.parametrize(
    ("near", "code"), [("a = 10deg", "wrong-dimension"), ("body = 1cm", "wrong-type"), ("aa = 1cm", "unknown-name")]
)
def test_wrong_starts(near: str, code: str) -> None:
    assert codes(category(f"  param a : length in 1cm .. 50cm derived\n  align a * a = w * w near {near}")) == [code]


def test_roots_do_not_depend_on_the_batch() -> None:
    sampler = compiled(TANGENT).sampler
    whole = value(sampler.batch(np.arange(64), seed=3), "reach")
    parts = [value(sampler.batch(np.arange(n, n + 16), seed=3), "reach") for n in range(0, 64, 16)]
    assert np.concatenate(parts).tobytes() == whole.tobytes()


def test_the_text_form_and_the_module_find_the_same_roots(monkeypatch) -> None:
    program = compiled(TANGENT).sampler.program
    text = to_text(program)
    again = from_text(text)
    assert to_text(again) == text
    reach = value(Sampler(program).batch(np.arange(9), seed=3), "reach")
    assert value(Sampler(again).batch(np.arange(9), seed=3), "reach").tobytes() == reach.tobytes()
    module = ModuleType("made")
    monkeypatch.setitem(sys.modules, "made", module)
    exec(to_module(program, "0"), vars(module))
    strut = next(s for s in module.sample(range(9), seed=3)["sites"].values() if s["path"] == "strut")
    assert strut["parameters"]["size.x"].tobytes() == reach.tobytes()


def test_no_root_is_a_failure_with_its_line() -> None:
    text = category("""
  param a : length in 1cm .. 50cm derived
  param k : length in 20cm .. 40cm
  align a + 5cm * sin(a / 10cm * 1rad) = k * (1 + a * a / (w * w))
  part p : Cuboid(size = [a, 1cm, 1cm])
  connect p.back on body.front
""")
    session = compiled(text)
    statistics = Statistics()
    try:
        batch = session.sampler.batch(np.arange(40), seed=1, statistics=statistics)
        a, w, k = (value(batch, name) for name in ("a", "w", "k"))
        np.testing.assert_allclose(a + 0.05 * np.sin(a / 0.1), k * (1 + a * a / (w * w)), rtol=1e-8)
    except Exhausted:
        pass
    failed = {session.sampler.program.requirements[n] for n in statistics.broken}
    asked = [r for r in failed if "were found that solve this" in r.message]
    assert asked and all(r.where is not None and r.where.line == 9 for r in asked)
    assert all("`a`" in r.message for r in asked)


def test_an_unknown_read_through_another_table_stays_an_error() -> None:
    text = category("""
  param a : length in 1cm .. 9cm derived
  repeat row[r] in 0 ..< 3 split body along z {
    let f = a * (1 + r) + a * a / 1m
    part plate : Cuboid
    connect plate in row
  }
  align sum(row.f) + a = w
""")
    assert "not-solvable" in codes(text)


def test_all_defaults() -> None:
    session = Session.of_text(HEAD + TANGENT)
    made = session.sampler.batch(np.arange(1), seed=0, defaults=True)
    assert np.isfinite(value(made, "reach")).all()


@pytest.mark.parametrize("rows", [1, 7, 300])
def test_newton_on_plain_arrays(rows: int) -> None:
    goal = np.linspace(0.5, 3.0, rows)

    def system(x, y, p):
        return x * x + y * y - p, x - y * y * y, 2 * x, 2 * y, 1.0, -3 * y * y

    x, y = solve_roots(system, (1.0, 1.0), (goal,))
    np.testing.assert_allclose(x * x + y * y, goal, rtol=1e-14)
    np.testing.assert_allclose(x, y**3, rtol=1e-13)


def test_newton_stands_still_where_the_slope_is_0() -> None:
    (x,) = solve_roots(lambda x, p: (x * x + p + 1.0, 2 * x), (0.0,), (np.zeros(2),))
    assert (x == 0.0).all()
