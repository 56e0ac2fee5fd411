"""Types of expressions, and the code of what does not fit together."""

import pytest

from artipg_dsl.syntax import ast

from .helpers import HEAD, check_text, codes

BODY = """
let twice(a) = 2 * a
template Frame {
  param size : length[3]
  param wall : length in 1cm .. 2cm
  param lean : angle in 1deg .. 9deg
  param side : choice near | far
  param plate : length[2] in [1cm, 1cm] .. [2cm, 2cm]
  count n in 1 .. 4
  let area(a, b) = a * b
  part post : Cuboid(size = [wall, wall, _])
  part pin : Cylinder(radius = wall, height = 3cm)
  part grip : Handle = BarHandle | BowHandle
  repeat row[i] in 0 ..< n split box along z gap wall { part board : Cuboid }
  port hook[k] : frame = frame(at = front.center, out = x, up = z)
  let probe = EXPR
}
"""

GOOD = {
    "5cm + 3mm": "a length",
    "2 + 3": "a count",
    "1/2": "a ratio",
    "30%": "a ratio",
    "wall * wall": "an area",
    "wall / 2cm": "a ratio",
    "sqrt(wall * 3cm)": "a length",
    "sqrt(wall)": "length^1/2",
    "(wall / 1cm) ^ 3": "a ratio",
    "wall ^ 2 / wall": "a length",
    "700kg/m3 * wall ^ 3": "a mass",
    "0": "a count",
    "0 + wall": "a length",
    "sin(lean) * wall": "a length",
    "atan2(wall, 3cm) + 1turn": "an angle",
    "wall * lean / 1rad": "a length",
    "floor(wall / 1mm) + n": "a count",
    "n / 2": "a ratio",
    "min(wall, post.top - bottom)": "a length",
    "max(0, wall)": "a length",
    "mod(lean, 90deg)": "an angle",
    "twice(wall)": "a length",
    "area(wall, 2)": "a length",
    "wall if n > 2 else 0": "a length",
    "n > 2 and not side == near": "true or false",
    "front": "a plane",
    "front - wall": "a plane",
    "post.front - front": "a length",
    "(post.left + post.right) / 2": "a length",
    "post.left.back": "an edge",
    "post.left.back.top": "a point",
    "post.front.center": "a point",
    "center.z": "a length",
    "post.size": "length[3]",
    "post.size.z": "a length",
    "plate.y": "a length",
    "[front, center.y, 0]": "length[3]",
    "center + [0, 0, wall]": "a point",
    "post.center - center": "length[3]",
    "2 * [1cm, 2cm]": "length[2]",
    "pin.axis": "a line",
    "pin.axis.origin": "a point",
    "pin.side.at(0.25turn, z = wall)": "a frame",
    "grip.mount": "a frame",
    "grip.mount.origin.y": "a length",
    "grip.grip.front": "a plane",
    "row[0].size.z": "a length",
    "row[last].board.top": "a plane",
    "sum(row.size.z)": "a length",
    "max(row.board.size.x)": "a length",
    "number(row)": "a count",
    "hook[1].out": "a direction (x, -y, ...)",
    "line(at = center, along = -z)": "a line",
    "line(at = center, to = post.center)": "a line",
    "box(left = left - wall)": "a box",
    "lowest(post, -z)": "a length",
    "from([0, 0, 0], z) line(wall) arc(radius = wall, angle = 90deg, towards = x)": "a curve",
}


@pytest.mark.parametrize("text", GOOD)
def test_type_of(tmp_path, text):
    body = BODY.replace("EXPR", text).replace("let probe = from", "curve probe = from")
    report, typed = check_text(tmp_path, HEAD + body)
    assert codes(report) == []
    probe = next(s for s in typed.main.find("Frame").body if isinstance(s, ast.LetDecl) and s.name == "probe")
    assert str(typed.type_of(probe.value)) == GOOD[text]


BAD = {
    "5cm + 3": "missing-unit",
    "3 > wall": "missing-unit",
    "min(2, wall)": "missing-unit",
    "[1cm, 2, 3cm]": "missing-unit",
    "5cm + 3deg": "wrong-dimension",
    "wall * lean + wall": "wrong-dimension",
    "wall ^ n": "wrong-dimension",
    "sin(wall)": "wrong-dimension",
    "cos(0.5)": "wrong-dimension",
    "asin(lean)": "wrong-dimension",
    "floor(wall)": "wrong-dimension",
    "hypot(wall, lean)": "wrong-dimension",
    "wall if n > 2 else lean": "wrong-dimension",
    "twice(wall, 1)": "wrong-arguments",
    "sum(wall)": "wrong-arguments",
    "line(at = center)": "wrong-arguments",
    "frame(at = center, out = x)": "missing-argument",
    "box(frnt = front)": "unknown-argument",
    "wal": "unknown-name",
    "post.sise": "unknown-member",
    "post.front.top.back.x.y": "unknown-member",
    "plate.z": "unknown-member",
    "sine(lean)": "unknown-function",
    "side == nearr": "unknown-choice",
    "5parsec": "unknown-unit",
    "row.size": "many-elements",
    "row.board.top - top": "many-elements",
    "grip.neck": "optional-outside-when",
    "twice": "wrong-type",
    "not wall": "wrong-type",
    "post + 1cm": "wrong-type",
    "[post, 1cm, 2cm]": "wrong-type",
    "post[0]": "wrong-type",
    "previous": "unknown-name",
    "_": "misplaced-hole",
    "grip is Cuboid": "unrelated-type",
    "grip is Barhandle": "unknown-template",
    "wall is BarHandle": "wrong-type",
}


@pytest.mark.parametrize("text", BAD)
def test_code_of(tmp_path, text):
    report, _ = check_text(tmp_path, HEAD + BODY.replace("EXPR", text))
    assert codes(report) == [BAD[text]]  # one finding: what follows from it is not reported again


def test_an_error_is_reported_once_however_often_its_value_is_used(tmp_path):
    text = HEAD + "template T {\n  let a = hight + 1cm\n  let b = a * 2\n  let c = sin(b) + a.x\n  require c < b\n}\n"
    report, _ = check_text(tmp_path, text)
    assert [(d.code, d.span.line) for d in report.diagnostics] == [("unknown-name", 5)]


def test_templates_and_functions_do_not_contain_themselves(tmp_path):
    text = HEAD + (
        "let f(a) = g(a) + 1\nlet g(a) = f(a)\nlet h = f(2)\n"
        "template A { part b : B | none }\ntemplate B { part c : Cuboid | C }\ntemplate C { part a : A }\n"
    )
    report, _ = check_text(tmp_path, text)
    assert [(d.code, d.message) for d in report.diagnostics] == [
        ("circular-definition", "this function is defined in terms of itself"),
        ("circular-definition", "templates contain each other: A > B > C > A"),
    ]


def test_an_output_of_a_role_has_the_type_that_the_role_says(tmp_path):
    text = HEAD + (
        "role Pot { out mouth : length }\n"
        "template A : Pot { let mouth = 3cm }\ntemplate B : Pot { let mouth = 3deg }\n"
        "template C : Pot { param mouth : length in 1cm .. 2cm }\ntemplate D : Pot { let mouth = 3 }\n"
        "template E : Pot { out mouth : length = 3cm }\ntemplate F : Pot { out mouth : angle = 3deg }\n"
        "template G : Pot { out mouth : length }\ntemplate H : Pot { let mouth = 1cm  out deep : length = 2cm }\n"
    )
    report, _ = check_text(tmp_path, text)
    assert [(d.code, d.span.line) for d in report.diagnostics] == [
        ("wrong-dimension", 6),
        ("missing-unit", 8),
        ("wrong-type", 10),
        ("missing-value", 11),
        ("unknown-member", 12),
    ]
