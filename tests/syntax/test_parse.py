"""Text to tree: the design's examples, spans, and the structure of what is built."""

import gc
from pathlib import Path

import pytest

from artipg_dsl.diagnostics import Report
from artipg_dsl.resources import categories_dir, library_dir
from artipg_dsl.source import Source
from artipg_dsl.syntax import ast
from artipg_dsl.syntax.load import load
from artipg_dsl.syntax.parse import MOST_ERRORS, parse

from .helpers import body_of, nodes, prefix, tree_of, value_of

HERE = Path(__file__).parent
FILES = sorted([*(HERE / "design").glob("*.apg"), *library_dir().glob("*.apg"), *categories_dir().glob("*.apg")])


@pytest.mark.parametrize("path", FILES, ids=lambda p: f"{p.parent.name}/{p.stem}")
def test_files_parse_with_valid_spans(path: Path):
    text = path.read_text(encoding="utf-8")
    tree = tree_of(text, str(path))
    for node, holder in nodes(tree):
        assert 0 <= node.span.start < node.span.end <= len(text)
        assert text[node.span.start : node.span.end].strip() == text[node.span.start : node.span.end] or holder is None
        if holder is not None:
            assert holder.span.start <= node.span.start and node.span.end <= holder.span.end
        if hasattr(node, "name_span") and node.name is not None:
            assert text[node.name_span.start : node.name_span.end] == node.name


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("1 + 2 * 3", "(+ 1 (* 2 3))"),
        ("a - b - c", "(- (- a b) c)"),
        ("-a ^ 2 ^ -b", "(- (^ a (^ 2 (- b))))"),
        ("a / b * c", "(* (/ a b) c)"),
        ("not a is B or c and d == 1", "(or (not (is a B)) (and c (== d 1)))"),
        ("a if b else c if d else e", "(if b a (if d c e))"),
        ("v * 1/2turn", "(* v 0.5turn)"),
        ("v - 1/2", "(- v (/ 1 2))"),
        ("2cm/steps + 3m/s", "(+ (/ 2cm steps) 3m/s)"),
        ("0.4N*m + 2N*mass + 7.5e2kg/m3", "(+ (+ 0.4N*m (* 2N mass)) 750kg/m3)"),
        ("8% * a.b[last].c(1, d = _)", "(* 8% a.b[last].c(1 d=_))"),
        ("[a,\n  -b, # half\n  [c]]", "[a (- b) [c]]"),
        ("(a +\n b)", "(+ a b)"),
        ("a +\n b", "(+ a b)"),
        ("max(a, b,)", "max(a b)"),
        ('"a \\"b\\""', "'a \"b\"'"),
        ("wall.at(u, z = h).out", "wall.at(u z=h).out"),
    ],
)
def test_expressions(text: str, meant: str):
    assert value_of(text) == meant


def test_spans_keep_their_parentheses():
    (let,) = body_of("let x = (a + b) * c")
    text = let.span.source.text
    assert text[let.value.span.start : let.value.span.end] == "(a + b) * c"


def test_param():
    (param,) = body_of("param a, b : length[3] in 1cm .. 2cm = 1.5cm ~ normal(c, sigma = 2) vary 8% was old")
    assert (param.keyword, param.names, param.type.name, param.type.size) == ("param", ("a", "b"), "length", 3)
    assert prefix(param.domain) == "1cm..2cm" and prefix(param.default) == "1.5cm" and prefix(param.vary) == "8%"
    assert param.distribution.name == "normal" and [a.name for a in param.distribution.arguments] == [None, "sigma"]
    assert (param.was, param.derived, param.positive, param.test) == ("old", False, False, None)


def test_bound_test_values_and_derived():
    first, second = body_of("param r : length > 0 test 1mm .. 1m", "param h : length derived")
    assert first.positive and prefix(first.test) == "1mm..1m"
    assert second.derived and not second.positive


def test_types():
    body = body_of("param a : choice x | y", "param b : style Handle", "param c : count", "param d : curve")
    assert [(p.type.name, p.type.values, p.type.style) for p in body] == [
        ("choice", ("x", "y"), False),
        ("Handle", (), True),
        ("count", (), False),
        ("curve", (), False),
    ]


def test_part_with_role_and_alternatives():
    (part,) = body_of(
        "root part lid : Lid(radius = r - t) turned 20deg about y =",
        "    Lift weight 3   when a is B",
        "  # another",
        "  | Hinged(tab = 1cm) along -x",
        "  | none weight 0.2 was cover",
    )
    assert (part.root, part.role, part.was, len(part.alternatives)) == (True, "Lid", "cover", 3)
    first, second, third = part.alternatives
    assert (first.name, prefix(first.weight), prefix(first.guard)) == ("Lift", "3", "(is a B)")
    assert second.arguments[0].name == "tab" and second.placements[0].kind == "along"
    assert prefix(second.placements[0].direction) == "(- x)"
    assert (third.name, prefix(third.weight)) == (None, "0.2")
    assert (part.placements[0].kind, prefix(part.placements[0].angle)) == ("turned", "20deg")


def test_part_of_one_template():
    (part,) = body_of("part pad : Pad(size = [1cm, _, 2cm])")
    assert (part.root, part.role, part.arguments) == (False, None, ())
    assert part.alternatives[0].name == "Pad" and prefix(part.alternatives[0].arguments[0].value) == "[1cm _ 2cm]"


def test_a_guard_belongs_to_its_line():
    body = body_of("part a : B", "when c { part d : E }")
    assert [type(s) for s in body] == [ast.PartDecl, ast.WhenStmt] and body[0].alternatives[0].guard is None


def test_statements_on_one_line():
    body = body_of("when a.gap { part d : Cuboid   connect d in a.gap } repeat b mirror across y { part c : D }")
    assert [type(s) for s in body] == [ast.WhenStmt, ast.RepeatStmt]
    assert [type(s) for s in body[0].body] == [ast.PartDecl, ast.ConnectStmt]


def test_else_when():
    (when,) = body_of("when a { part b : B } else when c { part d : D }", "else", "{", "part e : E }")
    (nested,) = when.otherwise
    assert isinstance(nested, ast.WhenStmt) and nested.otherwise[0].name == "e"


@pytest.mark.parametrize(
    ("text", "clauses"),
    [
        ("connect a.b to c.d at y = e, z = 1cm", ["to c.d", "at y=e z=1cm"]),
        ("connect a on b.front fit right, top at center", ["on b.front", "fit right top", "at center"]),
        ("connect a between b and c.d facing +x sink 3mm", ["between b c.d", "facing (+ x)", "sink 3mm"]),
        (
            "joint j : revolute a -> b about c.left range -r .. r rest 0deg mimic 2 * k",
            ["about c.left", "range (- r)..r", "rest 0deg", "mimic (* 2 k)"],
        ),
        (
            "joint j : screw a -> b along z range 0 .. clearance pitch 2mm",
            ["along z", "range 0..clearance", "pitch 2mm"],
        ),
        (
            "joint j : revolute a -> b about z range 0 .. clearance all rest 0",
            ["about z", "range 0..(all clearance)", "rest 0"],
        ),
        (
            "repeat a in 0 ..< n split b along z weight w gap g each 1cm .. 2cm { }",
            ["split b", "along z", "weight w", "gap g", "each 1cm..2cm"],
        ),
        ("grasp a on b for t in 0 .. 1 {", ["at [0 0 t]", "approach (- x)", "close y", "opening size.y"]),
    ],
)
def test_clauses(text: str, clauses: list[str]):
    rest = ("at [0, 0, t]  approach -x", "close y  opening size.y }") if text.startswith("grasp") else ()
    (statement,) = body_of(text, *rest)
    assert [prefix(c) for c in ast.clauses(statement)] == clauses


@pytest.mark.parametrize(
    ("text", "form", "count", "index"),
    [
        ("repeat a[i] in 0 ..< n + 1 spread b along x { }", "spread", "(+ n 1)", "i"),
        ("repeat a[k] ring 2 about line(at = p, along = x) { }", "ring", "2", "k"),
        ("repeat a mirror across y { }", "mirror", None, None),
        ("repeat a[k] fill b along y every 2cm { }", "fill", None, "k"),
        ("repeat a in 0 ..< 4 { }", "", "4", None),
    ],
)
def test_repeats(text: str, form: str, count: str | None, index: str | None):
    (repeat,) = body_of(text)
    assert (repeat.form, repeat.index) == (form, index)
    assert (prefix(repeat.count) if repeat.count else None) == count


def test_labels():
    plain, where, value = body_of("label a.b on c, d", "label a.close on c where p.y < 0", "label a.b on c = 1 - p.x")
    assert [prefix(t) for t in plain.targets] == ["c", "d"] and (plain.where, plain.value) == (None, None)
    assert (where.label, prefix(where.where)) == ("close", "(< p.y 0)")
    assert len(value.targets) == 1 and prefix(value.value) == "(- 1 p.x)"


def test_requirements():
    body = body_of('require a < b else "no" repair c', "require stable", "require stable open", "require a")
    assert [(r.stable, r.message) for r in body] == [(None, "no"), ("rest", None), ("open", None), (None, None)]
    assert prefix(body[0].repair) == "c"


def test_primitive():
    tree = tree_of(
        "primitive P {\n curve a = from([0, 0, 0], z) line(b) arc(radius = r)\n curve c = circle(r)\n"
        " surface s[i in 0 ..< 4] (u in 0 .. 1, v in 0turn .. 1turn) = [u, v, i] when r > 0\n"
        " box = a .. b\n piece w (i in 0 ..< 8) = hull(s(0, 1), t)\n solid = extrude(e) along z from 0 to t\n}\n"
    )
    chain, circle, surface, box, piece, solid = tree.declarations[0].body
    assert prefix(chain.value) == "chain from([0 0 0] z) line(b) arc(radius=r)" and chain.keyword == "curve"
    assert isinstance(circle.value, ast.CallExpr)
    assert (surface.index, prefix(surface.index_count), surface.u, surface.v) == ("i", "4", "u", "v")
    assert prefix(surface.v_range) == "0turn..1turn" and prefix(surface.guard) == "(> r 0)"
    assert (prefix(box.low), prefix(box.high), box.value) == ("a", "b", None)
    assert (piece.index, prefix(piece.count), [prefix(p) for p in piece.points]) == ("i", "8", ["s(0 1)", "t"])
    assert solid.operator == "extrude" and [prefix(c) for c in ast.clauses(solid)] == ["along z", "from 0", "to t"]


def test_top_level():
    tree = tree_of(
        "apg 1\nuse a { B,\n  C }\nlet f(x) = x\nmaterial m { density 7kg/m3  friction 1 }\n"
        "vocabulary v { part, door\n on }\nrole R : S { }\n"
    )
    assert [(u.module, u.names) for u in tree.uses] == [("a", ("B", "C"))]
    function, material, vocabulary, role = tree.declarations
    assert function.parameters == ("x",) and role.parent == "S"
    assert [prefix(p) for p in ast.clauses(material)] == ["density 7kg/m3..7kg/m3", "friction 1..1"]
    assert vocabulary.words == ("part", "door", "on")


def test_docs():
    tree = tree_of(
        "# no doc\n## A stool.\n## For sitting.\ncategory Stool {\n"
        "  param a : length   ## how high\n  param b : length\n  ## the seat\n  part c : D  ## round\n  # no doc\n"
        "  part e : F | G  ## first\n    | H\n  let x = max(1,\n    2)   ## last\n}\n"
    )
    stool = tree.declarations[0]
    assert stool.doc == "A stool.\nFor sitting."
    assert [s.doc for s in stool.body] == ["how high", "", "the seat\nround", "first", "last"]


def test_several_errors_in_one_run():
    report = Report()
    assert parse(Source("t", "category C {\n part a B\n param x = 1\n part c : D\n let e 5\n}\n"), report) is None
    assert [d.span.line for d in report.diagnostics] == [2, 3, 5]


def test_errors_have_an_end():
    report = Report()
    assert parse(Source("t", "category C {\n" + " part a B\n" * 50 + "}\n"), report) is None
    assert len(report.diagnostics) == MOST_ERRORS


def test_garbage_collection_is_as_before():
    for enabled in (True, False):
        gc.enable() if enabled else gc.disable()
        try:
            parse(Source("t", "category {"), Report())
            assert gc.isenabled() == enabled
        finally:
            gc.enable()


def test_load(tmp_path):
    good = tmp_path / "good.apg"
    good.write_bytes(b"\xef\xbb\xbfapg 1\r\nlet a = 1\r\n")
    report = Report()
    source = load(good, report)
    assert source is not None and source.text == "apg 1\nlet a = 1\n" and not report.failed


def test_load_reports(tmp_path):
    bad = tmp_path / "bad.apg"
    bad.write_bytes(b"apg 1\nlet gr\xf6sse = 1\n")
    report = Report()
    assert [load(p, report) for p in (bad, tmp_path / "none.apg", tmp_path)] == [None] * 3
    assert sorted(d.code for d in report.diagnostics) == ["missing-file", "missing-file", "not-utf8"]
    (place,) = [d.span for d in report.diagnostics if d.span]
    assert (place.line, place.column) == (2, 7)
