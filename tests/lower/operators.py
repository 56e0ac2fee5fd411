"""Primitives that operators make of curves, as texts, and how they are lowered: what tests of operators share."""

from artipg_dsl.diagnostics import Report
from artipg_dsl.graph.expr import Scope, var
from artipg_dsl.graph.program import Program
from artipg_dsl.lower.expressions.env import Env
from artipg_dsl.lower.program import new_context
from artipg_dsl.lower.solids.curves import Curve
from artipg_dsl.lower.solids.primitives import lower_primitive
from artipg_dsl.semantics.check import check
from artipg_dsl.semantics.modules import Workspace
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
SLAB = f"""
primitive Slab {{{SIZES}
  curve oval (u in 0turn .. 1turn) = [2 * r * cos(u), r * sin(u)]
  curve brim (u in 0turn .. 1turn) = [(2 * r - a / 4) * cos(u), (r - a / 4) * sin(u)]
  solid = loft(brim, oval, oval, brim) along z at [0, a / 4, a, 5 * a / 4]
}}
"""
COLUMN = f"""
primitive Column {{{SIZES}
  solid = loft(circle(a), circle(b), rectangle(a, b), rectangle(2 * a, b), rectangle(a, 2 * b)) along z at [0, l / 3, l, 1.2 * l, 2 * l]
}}
"""
VASE = f"""
primitive Vase {{{SIZES}
  let across(u, k, n) = k * r * cos(u) / (abs(cos(u)) ^ n + abs(sin(u)) ^ n) ^ (1 / n)
  let along(u, k, n, s) = k * a * sin(u) / (abs(cos(u)) ^ n + abs(sin(u)) ^ n) ^ (1 / n) + s * b
  curve foot  (u in 0turn .. 1turn) = [across(u, 1.2, 3), along(u, 1.2, 3, -1)]
  curve waist (u in 0turn .. 1turn) = [across(u, 0.8, 2.5), along(u, 0.8, 2.5, 0)]
  curve belly (u in 0turn .. 1turn) = [across(u, 1, 2.5), along(u, 1, 2.5, 1)]
  curve mouth (u in 0turn .. 1turn) = [across(u, 0.9, 2), along(u, 0.9, 2, 0.5)]
  solid = loft(foot, waist, belly, belly, mouth) along z at [0, l / 2, l, 1.2 * l, 2 * l] smooth
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
