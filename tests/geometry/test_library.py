"""The shipped primitives, lowered from their text, pass the self-test; leaks in declarations are findings in words."""

import os
import re
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.geometry import mesh
from artipg_dsl.geometry.box import bounds
from artipg_dsl.geometry.patches import find_existing
from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.language import FACES
from artipg_dsl.session import Session, check_text
from artipg_dsl.source import Source

from .selftest import check_primitive
from .shipped import SHIPPED

EVERY = os.environ.get("ARTIPG_EVERY") == "1"


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_primitive_agrees_with_itself(name):
    found = check_primitive(SHIPPED[name]) if EVERY else check_primitive(SHIPPED[name], 5, 1024)
    assert not found, "\n".join(map(str, found))


def test_the_library_has_primitives():
    assert {"Cuboid", "Cylinder", "TorusSector", "RoundedSleeve", "TaperedCuboid", "Superellipsoid"} <= set(SHIPPED)


def test_the_page_lists_every_shipped_primitive():
    page = (Path(__file__).parents[2] / "docs" / "primitives.md").read_text()
    missing = [name for name in SHIPPED if f"| `{name}` |" not in page]
    assert missing == []


def test_the_page_names_the_surfaces_that_are_no_faces():
    page = (Path(__file__).parents[2] / "docs" / "primitives.md").read_text()
    tables, rest = page.split("## Surfaces")
    told = {}
    for row in rest.split("## Beside")[0].splitlines():
        if row.startswith("| `"):
            primitives, surfaces = (re.findall(r"`(\w+)`", cell) for cell in row.split("|")[1:3])
            told.update(dict.fromkeys(primitives, surfaces))
    listed = re.findall(r"^\| (?:\d+|-) \| `(\w+)` \|", tables, re.MULTILINE)
    others = {name: [*dict.fromkeys(p.name for p in SHIPPED[name].patches if p.name not in FACES)] for name in listed}
    assert told == {name: surfaces for name, surfaces in others.items() if surfaces}


def test_a_prism_has_the_sides_that_each_instance_asks_for():
    prism, sides = SHIPPED["Prism"], np.array([3.0, 12.0, 4.0, 7.0])
    params = {
        "": np.zeros(4),
        "sides": sides,
        "radius": np.full(4, 0.1),
        "top_radius": np.full(4, 0.1),
        "height": np.full(4, 0.2),
    }
    assert set(draw_trial(prism)["sides"]) == set(range(3, 13))
    assert find_existing(prism, params).sum(axis=1).tolist() == (3 * sides).tolist()
    for group in mesh.build(prism, params):
        assert len(group.faces) == 4 * sides[group.rows[0]]
    volume, centre, _ = mesh.volume_inertia(prism, params)
    assert np.allclose(volume, sides / 2 * 0.01 * np.sin(2 * np.pi / sides) * 0.2, rtol=1e-12)
    assert np.abs(centre).max() < 1e-15
    low, high = bounds(prism, params)
    assert np.allclose(low[:, 0], [-0.1, -0.1 * np.cos(np.pi / 12), -0.1 * np.cos(np.pi / 4), -0.1])


def test_counts_of_surfaces_are_settled_with_the_text():
    text = """apg 1
use solids { Prism }
category Bar {
  count sides in 3 .. 5 = 4
  root part body : Prism(sides = sides, radius = 2cm, height = 30cm)
}
"""
    batch = Session.of_text(text).sampler.batch(np.arange(12), 1)
    (table,) = batch.sites()
    assert set(table.params["sides"]) == {3.0, 4.0, 5.0}
    again = from_text(to_text(batch.program))
    assert again.primitives["Prism"].whole == ("sides",) and to_text(again) == to_text(batch.program)


PLATE = """apg 1
primitive Plate {
  param side : length > 0  test 1cm .. 1m
  param rise : length > 0  test 1cm .. 1m
  surface front  (u in 0 .. 1, v in 0 .. 1) = [side / 2, (u - 1/2) * side, (v - 1/2) * rise]
  surface back   (u in 0 .. 1, v in 0 .. 1) = [-side / 2, (1/2 - u) * side, (v - 1/2) * rise]
  surface left   (u in 0 .. 1, v in 0 .. 1) = [(1/2 - u) * side, side / 2, (v - 1/2) * rise]
  surface right  (u in 0 .. 1, v in 0 .. 1) = [(u - 1/2) * side, -side / 2, (v - 1/2) * rise]
  surface bottom (u in 0 .. 1, v in 0 .. 1) = [(u - 1/2) * side, (1/2 - v) * side, -rise / 2]
  surface top    (u in 0 .. 1, v in 0 .. 1) = [(u - 1/2) * side, (v - 1/2) * side, rise / 2]
  inside (p) = max(abs(p.x) - side / 2, abs(p.y) - side / 2, abs(p.z) - rise / 2)
  box = [side, side, rise]
}
"""
CATEGORY = "category Thing {\n  root part body : Plate(side = 10cm, rise = 2cm)\n}\n"


def findings(text):
    report = check_text(Source("plate.apg", text))
    return list(report.diagnostics)


def test_a_closed_primitive_has_no_findings():
    assert findings(PLATE) == []
    assert findings(PLATE + CATEGORY) == []


@pytest.mark.parametrize("tail", ["", CATEGORY])
def test_a_leak_is_told_at_the_primitive_with_surface_and_edge(tail):
    (finding,) = findings(PLATE.replace("(v - 1/2) * side, rise / 2]", "(v - 1/2) * side * 0.9, rise / 2]") + tail)
    assert (finding.code, finding.span.line) == ("leaky-primitive", 2)
    assert finding.message.startswith("the surface `front` of the primitive `Plate`")
    assert "its edge v end meets no other edge: the surface leaks there" in finding.message
    assert "the nearest is u end of top" in finding.message
    assert [span.line for span, _ in finding.notes] == [5] and finding.hint


def test_an_inside_function_that_disagrees_is_told_before_anything_is_sampled():
    session = Session.of_text(PLATE.replace("abs(p.z) - rise / 2)", "abs(p.z) - rise)") + CATEGORY, "plate.apg")
    assert session.lowering is None
    (finding,) = session.report.diagnostics
    assert finding.code == "leaky-primitive" and "surface `bottom`" in finding.message
    assert "the inside function disagrees with it: both sides are inside" in finding.message


def test_a_missing_surface_leaks():
    lines = [line for line in PLATE.splitlines() if not line.startswith("  surface top")]
    (finding,) = findings("\n".join(lines) + "\n" + CATEGORY)
    assert finding.code == "leaky-primitive" and "leaks" in finding.message


ROD = """apg 1
primitive Rod {
  param radius : length > 0  test 1cm .. 10cm
  param height : length > 0  test 1cm .. 1m
  param span : angle > 0 = 360deg  test 30deg .. 360deg
  let half = span / 2
  surface side   (u in -half .. half, v in 0 .. 1) = [radius * cos(u), radius * sin(u), (v - 1/2) * height]
  surface top    (u in 0 .. 1, v in -half .. half) = [u * radius * cos(v), u * radius * sin(v), height / 2]
  surface bottom (u in -half .. half, v in 0 .. 1) = [v * radius * cos(u), v * radius * sin(u), -height / 2]
  surface start  (u in 0 .. 1, v in 0 .. 1) = [u * radius * cos(half), -u * radius * sin(half), (v - 1/2) * height] when span < 1turn
  surface end    (u in 0 .. 1, v in 0 .. 1) = [(1 - u) * radius * cos(half), (1 - u) * radius * sin(half), (v - 1/2) * height] when span < 1turn
  let cut(q) = -radius if span >= 1turn else abs(q.y) * cos(half) - q.x * sin(half)
  inside (p) = max(hypot(p.x, p.y) - radius, abs(p.z) - height / 2, cut(p))
  let wide = radius * sin(half) if span < 180deg else radius
  box = [min(0mm, radius * cos(half)), -wide, -height / 2] .. [radius, wide, height / 2]
}
"""
WRONG = {
    "a cut face that is always there": (
        "(1 - u) * radius * sin(half), (v - 1/2) * height] when span < 1turn",
        "(1 - u) * radius * sin(half), (v - 1/2) * height]",
        ("`side`", "u start of side, u end of side, u start of end", "about ["),
    ),
    "a bottom that spans less": (
        "bottom (u in -half ..",
        "bottom (u in -half / 2 ..",
        ("`side`", "v end of bottom", "about ["),
    ),
    "a top too high": (
        "sin(v), height / 2]",
        "sin(v), height / 2 + 1mm]",
        ("`side`", "edge v end", "u end of top", "% of its size away"),
    ),
    "another radius": (
        "hypot(p.x, p.y) - radius,",
        "hypot(p.x, p.y) - 0.9 * radius,",
        ("`side`", "neither side is inside", "about ["),
    ),
    "an inside function that is negative outside": (
        "inside (p) = max(",
        "inside (p) = -max(",
        ("far outside", "inside"),
    ),
}


def test_a_sound_rod_has_no_findings():
    assert findings(ROD.replace("30deg .. 360deg", "30deg .. 170deg")) == []


def test_a_concave_primitive_without_pieces_is_told_of():
    (finding,) = findings(ROD)  # a sector of more than half a turn: its hull fills what is cut out
    assert (finding.code, finding.severity, finding.span.line) == ("missing-pieces", "warning", 2)
    assert "is concave, and has no pieces: its hull reaches" in finding.message and "span = " in finding.message


INSIDE = "max(abs(p.x) - side / 2, abs(p.y) - side / 2, abs(p.z) - rise / 2)"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (f"2 * {INSIDE}", "the slope of the inside function reaches 2, not 1"),
        (
            f"max({INSIDE}, (0.45 - max(abs(p.x) / side, abs(p.y) / side, abs(p.z) / rise)) * min(side, rise))",
            "% of the space, the inside function",
        ),
    ],
)
def test_an_inside_function_that_is_no_distance_is_told_of(text, told):
    (finding,) = findings(PLATE.replace(INSIDE, text) + CATEGORY)
    assert (finding.code, finding.severity, finding.span.line) == ("leaky-primitive", "warning", 11)
    assert "the inside function of the primitive `Plate` disagrees with its surfaces" in finding.message
    assert told in finding.message, finding.message


def test_a_piece_that_reaches_out_of_its_solid_is_told_of():
    corners = ", ".join(
        f"[{x}side / 2, {y}side / 2, {z}rise / 2]" for x in ("", "-") for y in ("", "-") for z in ("", "-")
    )
    sound = PLATE.replace("  box", f"  piece all = hull({corners})\n  box")
    assert findings(sound + CATEGORY) == []
    (finding,) = findings(sound.replace("hull([side / 2,", "hull([side,") + CATEGORY)
    assert (finding.code, finding.severity, finding.span.line) == ("missing-pieces", "warning", 12)
    assert "a piece of the primitive `Plate` reaches out of it: this piece reaches" in finding.message


SWITCHED = """apg 1
primitive Peg {
  param radius, height : length > 0  test 1mm .. 1m
  param short : bool
  let tall = height / 2 if short else height
  surface side   (u in 0turn .. 1turn, v in 0 .. 1) = [radius * cos(u), radius * sin(u), v * tall]
  surface top    (u in 0turn .. 1turn, v in 0 .. 1) = [v * radius * cos(u), v * radius * sin(u), TOP]
  surface bottom (u in 0turn .. 1turn, v in 0 .. 1) = [v * radius * cos(u), -v * radius * sin(u), 0cm]
  inside (p) = max(hypot(p.x, p.y) - radius, p.z - tall, -p.z)
  box = [-radius, -radius, 0] .. [radius, radius, tall]
}
category C { root part a : Peg(radius = 1cm, height = 4cm, short = SHORT) }
"""


@pytest.mark.parametrize("given", ["true", "false"])
@pytest.mark.parametrize(("top", "leaks"), [("tall", ""), ("height", "short = true"), ("height / 2", "short = false")])
def test_a_switch_is_tested_both_ways(top, leaks, given):
    found = findings(SWITCHED.replace("TOP", top).replace("SHORT", given))
    assert [d.code for d in found] == ["leaky-primitive"] * bool(leaks)
    assert all(leaks in d.message for d in found)


@pytest.mark.parametrize("name", WRONG)
def test_wrong_declarations_say_which_surface_leaks_and_where(name):
    old, new, told = WRONG[name]
    assert old in ROD
    (finding,) = findings(ROD.replace(old, new))
    assert finding.code == "leaky-primitive" and all(word in finding.message for word in told), finding.message
