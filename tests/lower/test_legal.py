"""Every number of an object has a legal range: constants outside are errors with a place, draws outside are drawn again."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.sampling.statistics import Exhausted, Statistics
from artipg_dsl.session import Session

USES = {
    "OpenBox": "bodies { OpenBox }",
    "BarHandle": "handles { Handle, BarHandle, BowHandle }",
    "affordance": "vocabularies { affordance }",
    "Cuboid": "primitives { Cuboid }",
}
BLOCK = "part b : Cuboid(size = [1cm, 1cm, 1cm])\n"
CUBE = BLOCK + "connect b.bottom on body.top\n"
SLIDE = BLOCK + "joint j : prismatic body -> b along x range 0cm .. 5cm "
TURN = BLOCK + "joint j : revolute body -> b about {} range 0deg .. 90deg"
HANDLE = "part h : Handle = BarHandle weight {} | BowHandle weight {}\nconnect h.mount to body.front at center"
KEY = " {{\npart c : Cuboid(size = [1cm, 1cm, 1cm])\nconnect c.bottom on body.top\n}}"
ROW = """count n in {}
repeat e[i] in 0 ..< n {{
  param k : length in 1cm .. 2cm
  part b : Cuboid(size = [1cm, 1cm, k])\n  connect b.bottom on body.top\n}}
"""
GRASP = CUBE + "grasp g on b for t in 0 .. 1 {{ at [0, 0, {}] approach {} close {} opening {} quality {} }}"


def session(body: str, before: str = "") -> tuple[Session, int]:
    """The program of a box with ``body``, and the line on which that begins."""
    text = f"category Box {{\n  root part body : Cuboid(size = [30cm, 50cm, 25cm])\n{body}\n}}\n{before}"
    head = "apg 1\n" + "".join(f"use {module}\n" for word, module in USES.items() if word in text)
    return Session.of_text(head + text, "case.apg"), head.count("\n") + 3


CONSTANT = {
    "a length divided by 0": ("let k = body.size.x / (3 - 3)", 0, "`body.size.x / (3 - 3)` divides by zero"),
    "a root": ("let k = (0 - 2) ^ 0.5", 0, "-2 has no power 0.5: a negative number only has whole powers"),
    "a power": ("let k = 10 ^ 400", 0, "`10 ^ 400` is too large for a number"),
    "a logarithm": ("let k = log(1 - 1)", 0, "0 has no logarithm: only numbers above 0 have one"),
    "an angle": (CUBE + "align b.center.y = 1cm * sin(asin(2))", 2, "`asin` takes numbers from -1 to 1, but this is 2"),
    "a remainder": ("let k = mod(5, 0)", 0, "`mod(5, 0)` divides by zero"),
    "a function": ("let f(q) = 1 / q\nlet k = f(0)", 0, "`1 / q` divides by zero"),
    "a negative size": (
        "part b : Cuboid(size = [-1cm, 1cm, 1cm])\nconnect b to body",
        0,
        "b: size.x must be positive, for every draw",
    ),
    "a size beyond": (
        "part b : Cuboid(size = [1cm, 1cm, 9000km])\nconnect b to body",
        0,
        "the size of `b` along z is 9000km, but sizes",
    ),
    "a place beyond": (
        CUBE + "align b.center.y = 2000km",
        0,
        "the place of `b` is at least 2000km, but places must lie within 1 km of the origin",
    ),
    "a wall": (
        "part b : OpenBox(size = [9cm, 9cm, 9cm], wall = -2mm)\nconnect b to body",
        None,
        "must be positive, for every draw",
    ),
    "an element": (ROW.format("2 .. 3") + "let w = e[3].k", 6, "`e[3]`: the repeat has no such element"),
    "a rank below": (ROW.format("2 .. 3") + "let w = e[-1].k", 6, "elements are counted from 0"),
    "rest": (SLIDE + "rest 9cm", 1, "the rest value of the joint lies outside its range 0"),
    "damping": (
        SLIDE + "damping -5Ns/m",
        1,
        "the damping of the joint `j` is -5, but it must be finite and not negative",
    ),
    "damping beyond all measure": (
        SLIDE + "damping 1e300Ns/m",
        1,
        "the damping of the joint `j` is 1e+300, but it is at most 1e9",
    ),
    "positions": (SLIDE + "positions 1000000", 1, "but a joint has at most 100,000 positions"),
    "a median": (
        "param q : length in -1cm .. 2cm ~ lognormal(-1cm, 0.5)",
        0,
        "an argument of the distribution of `q` is -1cm, but a median must be finite and above 0",
    ),
    "friction": (SLIDE + "friction -1N", 1, "the friction of the joint `j` is -1"),
    "effort": (SLIDE + "effort 0N", 1, "the effort of the joint `j` is 0, but it must be finite and above 0"),
    "effort below a spring": (
        SLIDE + "stiffness 100N/m effort 4N",
        1,
        "the effort of the joint `j` less what its spring takes at the end of its range is -1, but a joint must take its spring to the end",
    ),
    "velocity": (SLIDE + "velocity 0m/s", 1, "the velocity of the joint `j` is 0"),
    "pitch": (
        BLOCK + "joint j : screw body.bottom -> b.top gap 1mm range 0turn .. 3turn pitch 0mm",
        1,
        "the pitch of the joint `j` is 0",
    ),
    "an axis": (TURN.format("line(at = body.top.center, along = [0, 0, 0])"), 1, "a direction must not be [0, 0, 0]"),
    "a line": (
        TURN.format("line(at = body.top.center, to = body.top.center)"),
        1,
        "the length of the axis of the joint `j` is 0",
    ),
    "an axis of a part": (
        "part b : Cuboid(size = [1cm, 1cm, 1cm]) turned 9deg about [0, 0, 0]\nconnect b to body",
        0,
        "a direction must not be [0, 0, 0]",
    ),
    "an axis askew": (
        "part b : Cuboid(size = [1cm, 1cm, 1cm]) along [1, 1, 0]\nconnect b to body",
        0,
        "a part can only lie along x, y or z",
    ),
    "no weight": (
        HANDLE.format(0, 0),
        0,
        "the largest weight of `h` is 0, but at least one alternative needs a weight above 0",
    ),
    "a weight": (HANDLE.format("log(-1)", 1), 0, "-1 has no logarithm"),
    "a weight divided by 0": (HANDLE.format("1 / (1 - 1)", 1), 0, "`1 / (1 - 1)` divides by zero"),
    "a deviation": (
        "param r : length in 1cm .. 2cm ~ lognormal(0cm, 0.1)",
        0,
        "an argument of the distribution of `r` is 0",
    ),
    "a value": ("param r : length in 1cm .. 2cm ~ values(0cm / 0)", 0, "`0cm / 0` divides by zero"),
    "a step": ("param r : length in 1cm .. 2cm vary -5%", 0, "the step of `r` is -0.05"),
    "many elements": (
        "repeat k[i] in 0 ..< 10000000 pitch 1mm along y" + KEY.format(),
        0,
        "the number of elements of `k` is 1e+07",
    ),
    "a fine fill": ("repeat k[i] fill body along y every 0.0001mm" + KEY.format(), 0, "`every` of `k` is 0.0001mm"),
    "a fill of many": (
        "repeat k[i] fill body along y every 0.01mm" + KEY.format(),
        0,
        "the number of elements of `k` is 50001, but a repeat",
    ),
    "a fill every 0": ("repeat k[i] fill body along y every 0cm" + KEY.format(), 0, "`every` of `k` is 0"),
    "a label": (CUBE + "label affordance.push on body = 7", 2, "the label `push` is 7, but it must lie in 0 .. 1"),
    "a label divided by 0": (
        "label affordance.push on body = 1cm / (p.x - p.x)",
        0,
        "`1cm / (p.x - p.x)` divides by zero",
    ),
    "a field": ("field f : ratio on body = log(-1)", 0, "-1 has no logarithm"),
    "a field of vectors": ("field f : vec on body = n / (1 - 1)", 0, "`n / (1 - 1)` divides by zero"),
    "a place of a grasp": (
        GRASP.format("t * size.z / (1 - 1)", "-z", "y", "size.y", 1),
        2,
        "`t * size.z / (1 - 1)` divides by zero",
    ),
    "an approach": (
        GRASP.format(0, "[0, 0, t]", "y", "size.y", 1),
        2,
        "the length of `approach` of the grasp `g` is 0",
    ),
    "a closing direction": (
        GRASP.format(0, "-z", "z", "size.y", 1),
        2,
        "the part of `close` across the `approach` of the grasp `g` is 0",
    ),
    "an opening": (
        GRASP.format(0, "-z", "y", "-1cm", 1),
        2,
        "the opening of the grasp `g` is -1cm, but an opening must be above 0",
    ),
    "a quality": (
        GRASP.format(0, "-z", "y", "size.y", 7),
        2,
        "the quality of the grasp `g` is 7, but it must lie in 0 .. 1",
    ),
    "a distance": (CUBE + "clear b from body by -1cm", 2, "is -1cm, but a distance must not be negative"),
}


@pytest.mark.parametrize(("body", "line", "message"), CONSTANT.values(), ids=CONSTANT.keys())
def test_what_is_never_legal_is_an_error_with_its_place(body: str, line: int | None, message: str) -> None:
    made, first = session(body)
    assert made.lowering is None
    found = next(one for one in made.report.diagnostics if one.severity == "error")
    assert message in found.message and found.code in ("undefined-value", "illegal-value", "impossible", "bad-axis")
    assert found.span is not None
    assert line is None or found.span.line == first + line


@pytest.mark.parametrize(
    ("properties", "message"),
    [
        ("density 0kg/m3", "`density` is 0"),
        ("density -5kg/m3", "`density` is -5"),
        ("density 500kg/m3  friction 1e300", "`friction_static` is 1e+300, but it is at most 1000"),
        ("density 5kg/m3 / 0", "divides by zero"),
        ("density 9kg/m3 .. 5kg/m3", "the range is empty"),
        ("density 5kg/m3 friction -0.5", "`friction_static` is -0.5"),
        ("density 5kg/m3 restitution 3", "`restitution` is 3"),
        ("density 5kg/m3 colour [6, -4, 0.2]", "`colour` is 6"),
        ("density 5kg/m3 roughness 6", "`roughness` is 6"),
        ("density 5kg/m3 metalness -1", "`metalness` is -1"),
        ("density 5kg/m3 transparency 7", "`transparency` is 7"),
    ],
)
def test_properties_of_materials_are_legal(properties: str, message: str) -> None:
    made, first = session("  material bad on body", f"material bad {{\n  {properties}\n}}\n")
    assert made.lowering is None
    (found,) = made.report.diagnostics
    assert message in found.message and found.span is not None and found.span.line == first + 3


RATIO = "param q : ratio in -1 .. 1\n"
DRAWN = {
    "a place": (CUBE + "align b.center.y = sqrt(q) * 1cm", 3),
    "rest": (SLIDE + "rest q * 9cm", 2),
    "an end of a range": (BLOCK + "joint j : prismatic body -> b along x range 0cm .. sqrt(q) * 5cm", 2),
    "damping": (SLIDE + "damping q * 5Ns/m", 2),
    "a weight": (HANDLE.format("sqrt(q)", 1), 1),
    "a label": ("label affordance.push on body = q", 1),
    "a field": ("field f : ratio on body = sqrt(q)", 1),
    "what a field reads": ("field f : ratio on body = p.x / 1m + sqrt(q)", 1),
    "the range of a draw": ("param r : length in 0cm .. sqrt(q) * 1cm", 1),
    "a deviation": ("param r : length in 0cm .. 1cm ~ normal(1cm, q * 1cm)", 1),
    "a grasp": (GRASP.format("t * 1cm", "-z", "y", "1cm * sqrt(q + t - 0.5)", 1), 3),
    "a distance": (CUBE + "clear b from body by q * 1mm", 3),
    "a preference": (CUBE + "prefer q < 0.5 weight q", 3),
    "a keypoint": (CUBE + "keypoint tip on b at [0, 0, sqrt(q) * 1cm]", 3),
    "an element": (ROW.format("2 .. 4") + "let w = e[3].k", 7),
    "elements": ("count n in 1 .. 50\nrepeat k[i] in 0 ..< n * n * n * n pitch 1mm along y" + KEY.format(), 2),
    "elements of elements": (
        "count n in 1 .. 50\nrepeat r[j] in 0 ..< n * n pitch 1mm along x {\nrepeat k[i] in 0 ..< n * n pitch 1mm along y"
        + KEY.format()
        + "\n}",
        3,
    ),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("body", "line"), DRAWN.values(), ids=DRAWN.keys())
def test_what_is_not_always_legal_is_drawn_again(body: str, line: int) -> None:
    made, first = session(RATIO + body)
    sampler = made.sampler
    counted = Statistics()
    batch = sampler.batch(np.arange(24), seed=3, statistics=counted)
    assert 0 < counted.first_valid < 24
    program = sampler.program
    reasons = [program.requirements[k].where for k in counted.broken] + [program.draws[k].where for k in counted.missed]
    assert first + line in {place.line for place in reasons if place is not None}
    tables = [*batch.sites(), batch.parts(), batch.links(), batch.joints()]
    for table in tables:
        for name in ("rotation", "translation", "low", "high", "rest", "axis", "origin"):
            assert np.isfinite(getattr(table, name, 0.0)).all()


def test_what_is_never_reached_need_not_have_a_value() -> None:
    for body in ("let n = 0\nlet k = 1cm / n if n > 0 else 2cm", "let n = 0\nlet k = 2cm if n == 0 else 1cm / n"):
        made, _ = session(body + "\npart b : Cuboid(size = [k, 1cm, 1cm])\nconnect b.bottom on body.top")
        assert made.lowering is not None, made.report.diagnostics


def test_an_element_that_is_asked_for_first_need_not_be_there() -> None:
    for asked in ("e[3].k if n > 3 else 1cm", "1cm if n <= 3 else e[3].k", "e[last].k", "e[n - 2].k"):
        made, _ = session(ROW.format("2 .. 4") + f"let w = {asked}")
        counted = Statistics()
        batch = made.sampler.batch(np.arange(16), seed=3, statistics=counted)
        assert counted.first_valid == 16
        assert {batch.drawn(k)["n"] for k in range(16)} == {2, 3, 4}


def test_a_direction_of_any_length_turns_as_its_unit_does() -> None:
    turned = "part b : Cuboid(size = [1cm, 2cm, 3cm]) turned 20deg about [2, 2, 0]\nconnect b to body"
    parts = session(turned)[0].sampler.batch(np.arange(1), seed=0).parts()
    rotation = parts.rotation[parts.path.index("b")]
    assert np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)


def test_objects_of_too_many_elements_are_told_and_cost_no_memory() -> None:
    body = "count n in 40 .. 50\nrepeat k[i] in 0 ..< n ^ 4 pitch 1mm along y" + KEY.format()
    made, _ = session(body)
    if made.lowering is None:
        (found,) = made.report.diagnostics
        assert "a repeat must have 0 to 5,000 elements" in found.message
        return
    with pytest.raises(Exhausted):
        made.sampler.batch(np.arange(4), seed=0)


def test_shipped_categories_ask_little_beyond_what_is_certain() -> None:
    """Nearly all numbers of a category are shown to be legal beforehand: what is left is asked of each object."""
    lowering = Session.of("Globe").lowering
    assert lowering is not None
    asked = [r for r in lowering.program.requirements if ": " in r.message and "1 km" in r.message]
    assert len(asked) < 10


UNDEFINED = {
    "an arc": ("asin(0.8 + 0.4 * q) / 1rad", "it takes numbers from -1 to 1"),
    "a root": ("sqrt(q - 0.5)", "negative numbers have no square root"),
}


@pytest.mark.parametrize(("formula", "why"), UNDEFINED.values(), ids=UNDEFINED)
def test_an_operation_without_a_value_is_told_instead_of_what_follows_from_it(formula: str, why: str) -> None:
    """Once, by its own place, however many numbers are made of it."""
    said = formula.removesuffix(" / 1rad")
    made, first = session(
        f"param q : ratio in 0 .. 1\nlet k = {formula}\n{CUBE}align b.center.y = k * 1cm\nlabel affordance.push on b = k / 9"
    )
    asked = [r for r in made.sampler.program.requirements if "has no value" in r.message]
    assert [(r.message, r.where and (r.where.line, r.where.column)) for r in asked] == [
        (f"`{said}` has no value: {why}", (first + 1, 9))
    ]
    made.advise()
    (found,) = [d for d in made.report.diagnostics if d.code == "undefined-value"]
    assert found.severity == "warning" and found.span is not None and found.span.text == said
    assert found.message.startswith(f"`{said}` has no value in ") and found.message.endswith(
        f" attempts at an object: {why}"
    )


def test_a_formula_that_is_avoided_where_it_has_no_value_is_no_warning() -> None:
    made, _ = session(
        f"param q : ratio in 0 .. 1\nlet k = sqrt(q - 0.5) if q >= 0.5 else 0\n{CUBE}align b.center.y = k * 1cm"
    )
    made.advise()
    assert not [d for d in made.report.diagnostics if d.code == "undefined-value"]


def test_of_two_operations_that_may_have_no_value_none_is_blamed() -> None:
    """The first of these has one wherever it counts."""
    both = "(sqrt(q - 0.5) if q >= 0.5 else 0) + asin(0.8 + 0.4 * q) / 1rad"
    made, _ = session(f"param q : ratio in 0 .. 1\nlet k = {both}\n{CUBE}align b.center.y = k * 1cm")
    assert not [r for r in made.sampler.program.requirements if "has no value" in r.message]
