"""The operators make primitives that pass the self-test, and say in words what they cannot make."""

import numpy as np
import pytest

from artipg_dsl.diagnostics import Report
from artipg_dsl.geometry.box import bounds
from artipg_dsl.geometry.mesh import build, moments
from artipg_dsl.geometry.patches import rows_of
from artipg_dsl.geometry.selftest import check_primitive
from artipg_dsl.geometry.surface import evaluate
from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.graph.expr import Scope, show, var
from artipg_dsl.graph.program import Program
from artipg_dsl.lower.expressions.context import Abort
from artipg_dsl.lower.expressions.env import Env
from artipg_dsl.lower.program import new_context
from artipg_dsl.lower.solids.curves import Curve
from artipg_dsl.lower.solids.primitives import lower_primitive
from artipg_dsl.semantics.check import check
from artipg_dsl.semantics.modules import Workspace
from artipg_dsl.session import Session
from artipg_dsl.source import Source
from artipg_dsl.syntax import ast

PATHS = """
template Paths {
  param rise : length in 10cm .. 20cm = 15cm
  param bend : length in 5cm .. 7cm = 6cm
  curve neck = from([0, 0, 0], z) line(rise - bend) arc(radius = bend, angle = 180deg, towards = x) line(5cm)
  curve other = from([0, 0, 0], z) line(rise) arc(radius = bend, angle = 180deg, towards = x) line(5cm)
  curve bow = from([0, 0, 0], x) arc(radius = bend, angle = 40deg, towards = z)
}
"""


def load(text):
    report = Report()
    workspace = Workspace(report)
    module = workspace.load_source(Source("test.apg", "apg 1\n" + text + PATHS))
    assert module is not None, report
    return new_context(report, Program("test"), check(workspace, module, Report())), module


def lowered(text, path=None):
    """The first primitive of a text; ``path`` names the curve of ``Paths`` that its parameter ``path`` gets."""
    context, module = load(text)
    primitive = next(s for s in module.own() if s.kind == "primitive")
    return lower_primitive(context, primitive, {} if path is None else {"path": curve(context, module, path)})


def curve(context, module, name):
    symbol = module.find("Paths")
    env = Env(context, module, symbol, Scope("paths"), "")
    env.names.update(rise=var("rise"), bend=var("bend"))
    return Curve(next(s for s in symbol.body if isinstance(s, ast.LetDecl) and s.name == name), env)


DOME = """
primitive Dome {
  param radius : length > 0  test 2cm .. 8cm
  param rise   : length > 0  test 3mm .. 4cm
  curve dome (v in 0turn .. 0.25turn) = [radius * cos(v), rise * sin(v)]
  solid = lathe(dome) about z
}
"""
FLASK = """
primitive Flask {
  param radius : length > 0  test 3cm .. 5cm
  param height : length > 0  test 15cm .. 30cm
  param wall   : length > 0  test 1mm .. 3mm
  curve base   (v in 0 .. 1) = [radius * v, 0mm]
  curve side   (v in 0 .. 1) = [radius - radius / 2 * v, height * v]
  curve floor  (v in 0 .. 1) = [(radius - wall) * v, wall]
  curve lining (v in 0 .. 1) = [radius - radius / 2 * v - wall, wall + (height - wall) * v]
  solid = lathe([base, side], [floor, lining]) about z
}
"""
BLADE = """
primitive Blade {
  param long  : length > 0  test 4cm .. 15cm
  param broad : length > 0  test 8mm .. 25mm
  param thick : length > 0  test 1mm .. 3mm
  curve spine (v in 0 .. 1) = [long * v, -broad / 2]
  curve edge (v in 0 .. 1) = [long * v, broad * (1/2 - 1/2 * v * v)]
  solid = extrude(edge, spine) along z from 0 to thick
}
"""
ROD = """
primitive Rod {
  param radius : length > 0  test 1cm .. 2cm
  param thick  : length > 0  test 1cm .. 2cm
  solid = extrude(circle(radius)) along z from -thick to thick
}
"""
BAR = """
primitive Bar {
  param a, b, c : length > 0  test 1cm .. 2cm
  solid = extrude(rectangle(a, b)) along x from 0 to c
}
"""
ARCH = """
primitive Arch {
  param span  : length > 0  test 8cm .. 12cm
  param thick : length > 0  test 7mm .. 12mm
  curve spine (t in 0turn .. 0.5turn) = [span / 3 * sin(t), 0mm, -span / 2 * cos(t)]
  solid = sweep(circle(thick / 2)) along spine up y
}
"""
TUBE = """
primitive Tube {
  param path   : curve
  param radius : length > 0  test 5mm .. 2cm
  solid = sweep(circle(radius)) along path up y
}
"""
PIPE = """
primitive Pipe {
  param path   : curve
  param radius : length > 0  test 1cm .. 2cm
  param thick  : length > 0  test 2mm .. 4mm
  solid = sweep(circle(radius), circle(radius - thick)) along path up y
}
"""
CHANNEL = """
primitive Channel {
  param a : length > 0  test 10cm .. 20cm
  param t : length > 0  test 5mm .. 3cm
  solid = extrude(polygon([0, 0], [a, 0], [a, a], [a - t, a], [a - t, t], [t, t], [t, a], [0, a])) along y from 0 to a
}
"""
PLATE = """
primitive Plate {
  param a, b : length > 0  test 8cm .. 20cm
  param r, t : length > 0  test 3mm .. 9mm
  curve bore (u in 0turn .. 1turn) = [r * cos(u) - a / 4, r * sin(u)]
  curve arch (v in -1 .. 1) = [a / 4 + r * sin(v * 1/4turn), r * cos(v * 1/4turn)]
  curve sill (v in -1 .. 1) = [a / 4 - r * v, 0mm]
  solid = extrude(rectangle(a, b), bore, [arch, sill]) along z from 0 to t
}
"""
DISC = """
primitive Disc {
  param radius : length > 0  test 5cm .. 20cm
  curve edge (u in 0turn .. 1turn) = [radius * cos(u), radius * sin(u)]
  curve bore (u in 0turn .. 1turn) = [radius / 5 * cos(u) - radius / 2, radius / 5 * sin(u)]
  solid = extrude(edge, bore, polygon([0, 0], [radius / 2, 0], [radius / 4, radius / 4])) along x from 0 to 1cm
}
"""
SIZES = """
  param a, b : length > 0  test 4mm .. 12mm
  param l : length > 0  test 5cm .. 10cm
  param r : length > 0  test 2cm .. 4cm
"""
PLINTH = f"""
primitive Plinth {{{SIZES}
  solid = loft(rectangle(2 * a, 2 * b), rectangle(b, a), rectangle(3 * a, a)) along x at [0, l / 3, l]
}}
"""
BEND = f"""
primitive Bend {{{SIZES}
  curve way = from([0, 0, 0], x) line(l) arc(radius = r, angle = 90deg, towards = z) line(l)
  solid = sweep(rectangle(a, b)) along way up y
}}
"""
DUCT = f"""
primitive Duct {{{SIZES}
  curve way = from([0, 0, 0], x) line(l) arc(radius = r, angle = 70deg, towards = z)
  solid = sweep(rectangle(2 * a, 2 * b), rectangle(a, b)) along way up y
}}
"""
HORN = f"""
primitive Horn {{{SIZES}
  curve way = from([0, 0, 0], x) line(l) arc(radius = r, angle = 90deg, towards = z)
  solid = loft(circle(a), circle(a / 2)) along way up y
}}
"""
HOOK = f"""
primitive Hook {{{SIZES}
  curve way = from([0, 0, 0], -z) line(l) arc(radius = r, angle = 270deg, towards = x)
  solid = sweep(circle(a)) along way up y
}}
"""
BALUSTER = f"""
primitive Baluster {{{SIZES}
  solid = loft(circle(a), circle(2 * b), circle(b / 2), circle(b)) along z at [0, l / 3, l, 3 * l] smooth
}}
"""
SHOULDER = f"""
primitive Shoulder {{{SIZES}
  curve oval (u in 0turn .. 1turn) = [2 * r * cos(u), r * sin(u)]
  solid = loft(oval, oval, circle(a), circle(a)) along z at [0, l, 2 * l, 2 * l + a] smooth
}}
"""
HANDLE = f"""
primitive Handle {{{SIZES}
  let tip = r + 2 * a
  solid = loft(rectangle(a, b), rectangle(3 * a, 2 * b), polygon([a, 0], [tip, -r], [tip, r], [r, r])) along x at [-l, 0, l / 2] smooth
}}
"""

SIDEWAYS = BEND.replace("Bend", "Sideways").replace("up y", "up x")
UPRIGHT = BEND.replace("Bend", "Upright").replace("up y", "")
SPACE = f"""
primitive Space {{{SIZES}
  curve way = from([0, 0, 0], x) line(l) arc(radius = r, angle = 90deg, towards = y) line(a) arc(radius = r, angle = 60deg, towards = TILT)
  curve oval (t in 0turn .. 1turn) = [a * cos(t), b * sin(t)]
  solid = sweep(oval) along way up z
}}
""".replace("TILT", "[0.3, 0.2, 1]")
RIBBON = """
primitive Ribbon {
  param r : length > 0  test 2cm .. 4cm
  param w : length > 0  test 1mm .. 2mm
  curve way (t in 0 .. 1.5) = [r * cos(t * 1turn), r * sin(t * 1turn), 8 * w * t]
  solid = sweep(rectangle(2 * w, 3 * w)) along way up z
}
"""
SPRING = (
    RIBBON.replace("Ribbon", "Spring").replace("rectangle(2 * w, 3 * w)", "circle(w)").replace("0 .. 1.5)", "0 .. 2.5)")
)
STRAP = """
primitive Strap {
  param r : length > 0  test 5cm .. 9cm
  param w : length > 0  test 5mm .. 1cm
  curve way (t in 0turn .. 0.4turn) = [r * cos(t), 0mm, 2 * r * sin(t)]
  solid = sweep(rectangle(w, 2 * w)) along way up y
}
"""
SADDLE = """
primitive Saddle {
  param r : length > 0  test 4cm .. 5cm
  param w : length > 0  test 2mm .. 3mm
  curve way (t in 0turn .. 0.5turn) = [r * cos(t), r * sin(t), r * sin(t) * sin(t)]
  solid = sweep(rectangle(2 * w, 3 * w)) along way up x
}
"""
TUSK = """
primitive Tusk {
  param r : length > 0  test 5cm .. 9cm
  param w : length > 0  test 5mm .. 1cm
  curve way (t in 0turn .. 0.3turn) = [r * cos(t), 0mm, 2 * r * sin(t)]
  curve oval (u in 0turn .. 1turn) = [w * cos(u), 2 * w * sin(u)]
  solid = loft(oval, circle(w / 3)) along way up y
}
"""
RAM = """
primitive Ram {
  param r : length > 0  test 2cm .. 4cm
  param w : length > 0  test 2mm .. 3mm
  curve way (t in 0 .. 1.3) = [r * cos(t * 1turn), r * sin(t * 1turn), 8 * w * t * t]
  solid = loft(circle(2 * w), circle(w)) along way up z
}
"""
LEVER = """
primitive Lever {
  param r : length > 0  test 4cm .. 5cm
  param w : length > 0  test 2mm .. 3mm
  curve way (t in 0turn .. 0.5turn) = [r * cos(t), r * sin(t), r * sin(t) * sin(t)]
  solid = loft(rectangle(2 * w, 3 * w), rectangle(4 * w, w)) along way up x
}
"""
SPIRAL = """
primitive Spiral {
  param r : length > 0  test 2cm .. 4cm
  param w : length > 0  test 0.5mm .. 1mm
  curve way (t in 0 .. 2.2) = [r * (1 - t / 40) * cos(t * 1turn), r * (1 - t / 40) * sin(t * 1turn), 6 * w * t]
  solid = sweep(circle(w)) along way up z
}
"""
WINDING = [SPIRAL, TUSK, RAM, LEVER, SIDEWAYS, UPRIGHT, SPACE, RIBBON, SPRING, STRAP, SADDLE]


@pytest.mark.parametrize("text", WINDING, ids=lambda text: text.split()[1].lower())
def test_any_path_takes_any_section(text):
    """In every plane and in space, along `up` and without, over several turns, along formulas."""
    assert check_primitive(lowered(text).primitive, samples=1) == []


@pytest.mark.parametrize(
    "text",
    [CHANNEL, PLINTH, BEND, DUCT, HORN, HOOK, BALUSTER, SHOULDER, HANDLE],
    ids=lambda text: text.split()[1].lower(),
)
def test_sections_and_outlines_pass_the_self_test(text):
    findings = check_primitive(lowered(text).primitive, samples=2)
    assert findings == []


@pytest.mark.parametrize(
    ("text", "curves"), [(BALUSTER, 1), (SHOULDER, 1), (HANDLE, 4)], ids=["circles", "ovals", "corners"]
)
def test_a_smooth_loft_has_no_kink_and_reaches_no_further_than_its_sections(text, curves):
    """The normals on both sides of a section agree, which they do not without the word; the box is that of the sections."""
    kinks, boxes = [], []
    for way in (text, text.replace(" smooth", "")):
        primitive = lowered(way).primitive
        params = draw_trial(primitive, 6)
        walls = [k for k, patch in enumerate(primitive.patches) if patch.name not in ("start", "end")]
        row, u = np.repeat(np.arange(rows_of(params)), 9), np.tile(np.linspace(0.0, 1.0, 9), rows_of(params))
        turns = [0.0]
        for low, high in zip(walls, walls[curves:], strict=False):
            below, above = (
                evaluate(primitive, k, params, row, u, np.full_like(u, v))[1] for k, v in ((low, 1.0), (high, 0.0))
            )
            turns.append(np.sqrt(((above - below) ** 2).sum(axis=-1)).max())
        kinks.append(max(turns))
        boxes.append(np.stack(bounds(primitive, params)))
    assert kinks[0] < 1e-6 and kinks[1] > 0.1
    assert boxes[0] == pytest.approx(boxes[1], abs=1e-12)


def test_a_circle_between_rectangles_is_cut_into_arcs_that_close():
    primitive = lowered(PLINTH.replace("rectangle(b, a)", "circle(b)")).primitive
    assert primitive.surfaces == ("skin", "start", "end") and len(primitive.patches) == 16
    (group,) = build(primitive, draw_trial(primitive, 2))
    volume = moments(group.vertices, group.faces)[0]
    assert (volume > 0).all() and group.vertices.shape[1] > 24


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
    ("text", "path"),
    [(DOME, None), (FLASK, None), (BLADE, None), (ROD, None), (BAR, None), (ARCH, None), (TUBE, "neck"), (PIPE, "bow")],
    ids=["dome", "flask", "blade", "rod", "bar", "arch", "tube", "pipe"],
)
def test_the_self_test_finds_nothing(text, path):
    assert check_primitive(lowered(text, path).primitive, samples=2) == []


@pytest.mark.parametrize("text", [PLATE, DISC], ids=["plate", "disc"])
def test_an_outline_has_any_number_of_holes(text):
    assert check_primitive(lowered(text).primitive, samples=1) == []


def test_the_walls_of_holes_bear_the_names_of_their_curves_and_the_holes_are_empty():
    primitive = lowered(PLATE).primitive
    assert set(primitive.surfaces) == {"skin", "bore", "arch", "sill", "start", "end"}
    params = {"a": np.array([0.2]), "b": np.array([0.12]), "r": np.array([0.008]), "t": np.array([0.005])}
    (group,) = build(primitive, params)
    volume = moments(group.vertices, group.faces)[0]
    holes = np.pi * 0.008**2 * 1.5
    assert volume[0] == pytest.approx((0.2 * 0.12 - holes) * 0.005, rel=2e-3)


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


def test_surfaces_bear_the_names_of_the_curves():
    assert lowered(DOME).primitive.surfaces == ("start", "dome")
    assert lowered(FLASK).primitive.surfaces == ("base", "side", "rim", "lining", "floor")
    assert lowered(BLADE).primitive.surfaces == ("edge", "spine", "rim", "start", "end")
    assert lowered(TUBE, "neck").primitive.surfaces == ("skin", "start", "end")


def test_a_box_is_as_simple_as_it_can_be():
    primitive = lowered(DOME).primitive
    assert [show(c) for c in primitive.low] == ["-radius", "-radius", "0"]
    assert [show(c) for c in primitive.high] == ["radius", "radius", "rise"]


def test_a_path_becomes_parameters_of_the_primitive():
    found = lowered(TUBE, "neck")
    assert found.primitive.parameters == ("path.0", "path.1", "radius")
    start, end = found.ports["start"], found.ports["end"]
    assert [c.constant for c in start.out] == [0.0, 0.0, -1.0]
    assert [round(c.constant, 9) for c in end.out] == [0.0, 0.0, -1.0]


def test_paths_of_one_shape_share_a_primitive():
    context, module = load(TUBE)
    tube = module.find("Tube")
    first, second, third = (
        lower_primitive(context, tube, {"path": curve(context, module, name)}) for name in ("neck", "other", "bow")
    )
    assert first is second and third is not first
    assert list(context.program.primitives) == ["Tube", "Tube_2"]


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


def test_two_shapes_of_path_are_two_primitives():
    """A straight bar and a bent one in one object: each site has the formulas of its own."""
    text = """
    use bars { Tube }
    category Bent {
      root part one : Half
      part other : Whole
      connect other to one
    }
    template Half {
      curve way = from([0, 0, 0], x) line(10cm) arc(radius = 5cm, angle = 90deg, towards = z)
      part bar : Tube(path = way, radius = 1cm)
    }
    template Whole {
      param long : length in 20cm .. 30cm = 25cm
      param rise : length in 10cm .. 20cm = 15cm
      curve way = from([0, 0, 0], x) line(long) arc(radius = 5cm, angle = 90deg, towards = z) line(rise)
      part bar : Tube(path = way, radius = 1cm)
    }
    """
    batch = Session.of_text("apg 1\n" + text).sampler.batch(range(2), 0)
    half, whole = batch.sites()
    assert half.primitive.name != whole.primitive.name
    assert len(half.params) == len(half.primitive.parameters) < len(whole.params) == len(whole.primitive.parameters)
