"""A compiled program is only data: nothing in it runs, and what is wrong with it is reported with its line."""

import ast
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.api import Samples
from artipg_dsl.errors import UserError
from artipg_dsl.geometry import pieces
from artipg_dsl.graph.expr import call, const, raw, var
from artipg_dsl.graph.formula import compile_formula, source
from artipg_dsl.graph.program import Allowed
from artipg_dsl.graph.reading import TextError, from_text
from artipg_dsl.graph.verify import UNITS
from artipg_dsl.graph.writing import to_text
from artipg_dsl.run.compiled import make_sampler, to_compiled
from artipg_dsl.run.job import open_job, prepare
from artipg_dsl.run.request import Request
from artipg_dsl.runtime.plan import make_plan
from artipg_dsl.sampling.module import to_module
from artipg_dsl.session import Session
from artipg_dsl.units import SI_UNITS

DATA = Path(__file__).parents[1] / "data"
HOSTILE = "z=__import__('os').system('touch ran')"
KNOB = """apg 1
use primitives { Cuboid, Cylinder }
use vocabularies { semantic, affordance }
## A box with a knob.
category Box {
  param width : length in 10cm .. 20cm = 12cm
  count knobs in 1 .. 3 = 2
  root part body : Cuboid(size = [width, width, 5cm])
  repeat row[i] in 0 ..< knobs spread body along y {
    part knob : Cylinder(radius = 5mm, height = 2cm)
    joint turn : revolute body.top -> knob.bottom range 0deg .. 90deg
  }
  require width * knobs <= 60cm else "too many knobs"
  label semantic.body on body
  label affordance.turn on row.knob where p.z > 0
  keypoint edge on body at [width / 3, 0, 0]
}
"""


@pytest.fixture(scope="module")
def text() -> str:
    session = Session.of_text(KNOB)
    assert session.lowering is not None, session.report.diagnostics
    return to_text(session.lowering.program)


def refused(text: str) -> str:
    with pytest.raises(TextError) as wrong:
        from_text(text)
    return str(wrong.value)


# ---------------------------------------------------------------- nothing runs


def test_a_program_that_names_python_is_refused_and_runs_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found = (DATA / "names_are_pasted_into_code.apgc").read_text(encoding="utf-8")
    assert "not a name" in refused(found)
    with pytest.raises(UserError, match="line 87 of the compiled program"):
        open_job(Request(str(DATA / "names_are_pasted_into_code.apgc")))
    assert not list(tmp_path.iterdir())


def test_generated_formulas_hold_no_text_of_the_program():
    names = ("p.x", HOSTILE, "x); import os\n#", "\x00\ud800")
    exprs = [call("add", var(name), const(1.0)) for name in names]
    assert not re.search(r"import|system|p_x", source(exprs, names))
    assert compile_formula(exprs, names)(1.0, 2.0, 3.0, 4.0) == (2.0, 3.0, 4.0, 5.0)


def test_generated_plans_and_modules_hold_texts_as_literals_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    program = Session.of_text(KNOB).sampler.program
    hostile = '\'"""\n\r\x0c\u2028\x00\\' + HOSTILE
    program.name, program.doc = hostile, hostile
    for scope in program.scopes:
        scope.name = hostile
    for draw in program.draws:
        draw.address, draw.column.name = hostile, hostile
    program.sites = [replace(site, path=hostile) for site in program.sites]
    program.joints = [replace(joint, path=hostile) for joint in program.joints]
    plan = make_plan(program, [])
    for made in (plan.source, to_module(program, "test")):
        tree = ast.parse(made)  # so nothing ends a line or a literal that should not
        called = {
            node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        }
        assert not called & {"__import__", "eval", "exec", "system"}
    plan.function  # noqa: B018 - compiles
    assert not list(tmp_path.iterdir())


def test_the_only_code_that_runs_is_generated_in_three_places():
    """The third is made of the names of our own classes' fields: nothing of a program reaches it."""
    package = Path(__file__).parents[2] / "artipg_dsl"
    words = ("exec", "eval", "__import__")
    texts = {path: path.read_text(encoding="utf-8") for path in package.rglob("*.py")}
    found = {
        path.relative_to(package).as_posix()
        for path, text in texts.items()
        if re.search(rf"\b({'|'.join(words)})\b", text)  # to parse all takes long
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in words
    }
    assert found == {"graph/formula.py", "runtime/evaluation.py", "records.py"}


# ---------------------------------------------------------------- what is wrong is told with its line

EDITS = {
    r'\$1 = real @0 "width"': [
        (f'$1 = real @0 "{HOSTILE}"', "not a name"),
        ('$1 = real @0 ""', "not a name"),
        ('$1 = other @0 "width"', "no kind of column"),
        ('$7 = real @0 "width"', r"expected \$1"),
        ('$1 = real @7 "width"', "@7 is not known"),
        ('$1 = real @0 "width', "not text"),
        ('$1 = real @0 "width" 3', "more after the end"),
        ('$1 real @0 "width"', "expected ="),
        ('$1 = real @0 "\\ud800"', "not text"),
    ],
    r"%1 = const 0\.1": [
        ("%1 = const", "too early"),
        ("%1 = const inf 3", "arguments of const"),
        ('%1 = const "1"', "constant"),
        ("%1 = add", "add takes 2"),
        ("%1 = system", "no operator"),
        ("%1 = __class__", "no operator"),
        ("%1 = add %1 %1", "%1 is not known"),
        ("%1 = " + "[" * 100, "constant|nested|operator"),
        ("%1 = const " + "[" * 100, "nested"),
        ("%1 = const %-1", "not a value"),
        ('%1 = var "p.x"', "variable"),
        ('%1 = root "0] or 1" %0', "not known|root"),
        ("%1 = solve 1 0 %1", "not known|solve"),
        ("%1 = solve 99999 0", "solve"),
        ("%1 = reduce os @0 %1", "not known|reduction"),
    ],
    r'kind "real"': [
        ('kind "unreal"', "no kind of draw"),
        ("kind 3", "kind: 3 where text"),
        ("kynd 3", "no field 'kynd'"),
    ],
    r'address "width"': [('address ""', "no address"), ("address none", "address: nothing where text")],
    r'unit "m"': [('unit "furlong"', "not a unit"), ('unit "m" unit "m"', "twice")],
    r'kind "revolute"': [('kind "telepathic"', "no kind of joint")],
    r"child 1": [
        ("child 9", "no link 9"),
        ("child -1", "no link -1"),
        ("child 1.5", "child: 1.5 where a whole number"),
    ],
    r'primitive "Cylinder"': [('primitive "Kernel"', "no primitive Kernel")],
    r'path "row.knob" name': [('path "../../etc/passwd" name', "not a name"), ('path "a\\nb" name', "not a name")],
    r'semantic \[\["body"': [('semantic [["soul"', "no word")],
    r'vocabulary "semantic" \["unlabelled"': [('vocabulary "semantic" [', "is not unlabelled")],
    r'program "Box"': [
        ('program "Box <b>"', "not a valid name"),
        ("program 3", "program is text"),
        ('category "Box"', "no item"),
    ],
    r"part 0\)": [("part 77)", "no part 77"), ("part 0", "ends before")],
    r"link \[0\] part 0\)": [("link [0] part 1)", "does not exist in all its rows")],
    r"test \[\[0\.001": [("test [[nan", "finite"), ("test [[9.0", "ends before")],
    r"condition %\d+": [("condition %1", "condition is true or false, not a number")],
    r'vocabulary "affordance" name "turn"': [
        ('vocabulary "affordance" name "<script>"', "not a name"),
        ('guard %1 vocabulary "affordance" name "turn"', "guard is true or false, not a number"),
    ],
    r"parent -1": [("parent 0", "must come after"), ("parent 99", "must come after")],
    r"\(Pose ": [("(System ", "no record")],
}


@pytest.mark.parametrize(("pattern", "edit", "words"), [(p, e, w) for p, edits in EDITS.items() for e, w in edits])
def test_an_edit_is_reported_with_its_line_and_what_is_wrong(text, pattern, edit, words):
    edited, count = re.subn(pattern, lambda _: edit, text, count=1)
    assert count == 1, f"{pattern} stands nowhere in the program"
    message = refused(edited)
    assert re.search(words, message), message
    assert re.search(r"line \d+ of the compiled program|incomplete or damaged", message), message


def test_values_that_need_one_another_are_reported(text, tmp_path):
    """A definition that reads itself passes line by line; planning finds the circle."""
    number = text.count("\n$")
    lines = text.rstrip("\n").split("\n")
    count = sum(line.startswith("%") for line in lines)
    lines += [f'${number} = real @0 "loop"', f"%{count} = col ${number}", f"define ${number} %{count}"]
    lines += [f'requirements (Requirement scope @0 condition %{count + 1} guard %{count + 1} message "" where none)']
    lines.insert(-1, f"%{count + 1} = le %{count} %{count}")
    program = from_text("\n".join(lines))
    path = tmp_path / "loop.apgc"
    path.write_text(to_compiled(program), encoding="utf-8")
    with pytest.raises(UserError, match="in a circle"):
        open_job(Request(str(path)))


def test_tables_beyond_all_bounds_are_refused(text, tmp_path):
    for old in (r"3\.0", r"0\.6", r"1\.0"):  # 3 knobs at most, 60 cm in all, and 1 at least
        text = re.sub(rf"(%\d+) = const {old}\b", r"\1 = const 1000000000.0", text, count=1)
    program = from_text(text)
    path = tmp_path / "many.apgc"
    path.write_text(to_compiled(program), encoding="utf-8")
    with pytest.raises(UserError, match="elements of one repeat"):
        open_job(Request(str(path))).batch(np.arange(3))


def test_a_division_by_zero_is_a_value_not_an_error():
    with np.errstate(divide="ignore"):
        (found,) = compile_formula([raw("div", (const(1.0), const(0.0)))], ())()
    assert np.isinf(found)


def test_units_inside_are_those_of_the_language():
    assert UNITS == {"", *SI_UNITS.values()}


# ---------------------------------------------------------------- objects that cannot be


def sampled(text: str, old: str, new: str) -> str:
    """What is told of the objects of a program after an edit."""
    edited, count = re.subn(old, new, text, count=1)
    assert count == 1
    program = from_text(edited)
    with pytest.raises(UserError) as wrong:
        prepare(make_sampler(program, "edited.apgc"), Request("edited.apgc")).batch(np.arange(2))
    return wrong.value.message


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            r"(%\d+) = const 0\.005\b",
            r"\1 = const -0.005",
            "primitive row.knob: its parameters break a requirement|no valid",
        ),
        (r"(%\d+) = const 0\.005\b", r"\1 = const nan", "not finite|no valid"),
        (r"(joints .*?)parent \[0\]", r"\1parent [1]", "hangs on itself|ring"),
        (r"(joints .*?)rest (%\d+)", r"\1rest %infinite", "not finite"),
        (r"(sites .*?)rotation \[\[(%\d+) (%\d+)", r"\1rotation [[\3 \3", "its rotation matrix is not a rotation"),
        (
            r"(keypoints .*?point) \[(%\d+) %\d+ %\d+\]",
            r"\1 [%infinite %infinite %infinite]",
            "keypoint edge: it has a number that is not finite",
        ),
        (r"(joints .*?axis) \[(%\d+) %\d+ %\d+\]", r"\1 [\2 \2 \2]", "its axis is not a unit vector"),
    ],
)
def test_objects_that_cannot_be_are_refused(text: str, old: str, new: str, words: str) -> None:
    if "%infinite" in new:
        number = sum(line.startswith("%") for line in text.split("\n"))
        at = text.index("\njoints ")
        before = sum(line.startswith("%") for line in text[:at].split("\n"))
        text = (
            text[:at]
            + f"\n%{before} = const inf"
            + re.sub(r"%(\d+)\b", lambda m: f"%{int(m[1]) + (int(m[1]) >= before)}", text[at:])
        )
        assert number >= before
        new = new.replace("%infinite", f"%{before}")
    assert re.search(words, sampled(text, old, new)), sampled(text, old, new)


def test_surfaces_that_do_not_close_are_a_users_error(text: str) -> None:
    edited = re.sub(
        r'(primitives \(Primitive name "Cylinder".*?u_range) \[(%\d+) (%\d+)\]', r"\1 [\2 \2]", text, count=1
    )
    job = prepare(make_sampler(from_text(edited), "edited.apgc"), Request("edited.apgc"))
    with pytest.raises(UserError, match="Cylinder: surface"):
        Samples(job).meshes()


def test_a_solid_without_faces_is_a_users_error(text: str) -> None:
    box = re.search(r'Primitive name "Cuboid".*', text)[0]
    flat = re.sub(r"u_range \[(%\d+) %\d+\] v_range \[%\d+ %\d+\]", r"u_range [\1 \1] v_range [\1 \1]", box)
    job = prepare(make_sampler(from_text(text.replace(box, flat)), "edited.apgc"), Request("edited.apgc"))
    assert flat != box
    with pytest.raises(UserError, match="Cuboid: "):
        Samples(job).meshes()


def test_a_solid_that_is_inside_out_is_a_users_error(text: str) -> None:
    """Its mass would be right and its inertia negative."""
    inside = next(re.finditer(r'Primitive name "Cuboid".*? inside %(\d+)', text))[1]
    edited = re.sub(rf"%{inside} = max", f"%{inside} = div", text, count=1)
    job = prepare(make_sampler(from_text(edited), "edited.apgc"), Request("edited.apgc"))
    assert edited != text
    with pytest.raises(UserError, match="the surfaces of `body` are inside out"):
        job.batch(np.arange(2))


def test_pieces_beyond_all_bounds_are_a_users_error() -> None:
    sampler = Session.of("Bottle").sampler
    for primitive in sampler.program.primitives.values():
        if primitive.pieces:
            piece = replace(primitive.pieces[0], count=const(1e9))
            params = {
                name: np.array([low]) for name, (low, _) in zip(primitive.parameters, primitive.test, strict=True)
            }
            with pytest.raises(UserError, match="is there 1000000000 times"):
                pieces.build(replace(primitive, pieces=(piece,)), params)
            return
    raise AssertionError("no primitive of a bottle has pieces")


def test_an_exception_that_names_no_part_excuses_none(text: str) -> None:
    """``allow floating`` with an empty list of parts can stand in a compiled program: it says nothing of any part."""
    program = from_text(text)
    program.allowed.append(Allowed("floating", program.scopes[0], (), (), "nothing"))
    made = Samples(
        prepare(make_sampler(from_text(to_text(program)), "none.apgc"), Request("none.apgc", numbers=((0, 1),)))
    )
    assert len(made) == 2


def test_formulas_with_given_values_have_the_same_bits() -> None:
    """What is given is not computed, by calls, by generated code and in all outputs; a given value may be an output itself."""
    x, y = var("x"), var("y")
    row = x * x + const(0.1)
    exprs = (row * y + call("sin", row), row, y * call("where", call("lt", y, row), y, row))
    whole, split = compile_formula(exprs, ("x", "y")), compile_formula(exprs, ("y",), (row,))
    draws = np.random.default_rng(0)
    for a, b in ((draws.normal(size=7), draws.normal(size=7)), (2.0, draws.normal(size=3))):
        given = np.asarray(a) * a + 0.1
        for one, other, code in zip(whole(a, b), split(given, b), split.numpy(given, b), strict=True):
            assert np.array_equal(one, other) and np.array_equal(one, code)
    with pytest.raises(ValueError, match="reads x"):
        compile_formula((x + row,), ("y",), (row,))


CRANK = """apg 1
use primitives { Cuboid, Cylinder }
category Crank {
  root part body : Cuboid(size = [30cm, 30cm, 30cm])
  part wheel : Cylinder(radius = 4cm, height = 1cm)
  joint wind : revolute body.top -> wheel.bottom at center gap 1mm range 0deg .. 90deg
  part second : Cylinder(radius = 4cm, height = 1cm)
  joint turn : revolute body.front -> second.bottom at center gap 1mm range 0deg .. 90deg
  part bolt : Cuboid(size = [1cm, 1cm, 6cm])
  joint draw : prismatic body.left -> bolt.right at center gap 1mm along -z range 0cm .. 2cm mimic 2cm * sin(turn)
}
"""


@pytest.mark.parametrize(
    ("joint", "leader", "words"),
    [
        ("turn", 0, "a joint with a curve follows one that follows another"),
        ("wind", 2, "a joint follows one with a curve"),
    ],
)
def test_curves_lead_from_joints_that_move_by_themselves_to_none_others(joint: str, leader: int, words: str) -> None:
    """Chains of followers are put together by factors and offsets: a formula among them would count as one."""
    lowering = Session.of_text(CRANK).lowering
    assert lowering is not None
    text = to_text(lowering.program)
    (line,) = [line for line in text.splitlines() if line.startswith(f'joints (Joint path "{joint}"')]
    one, nought = (f"%{re.search(rf'^%([0-9]+) = const {value}$', text, re.MULTILINE)[1]}" for value in ("1.0", "0.0"))
    edited = text.replace(line, line.replace(" where", f" mimic [[{leader}] {one} {nought}] where"))
    assert from_text(text).joints
    assert words in refused(edited)
