"""The tables of the language: all that stands in them is known to checker and lowering, and nothing else is."""

from __future__ import annotations

import math

import pytest

from artipg_dsl.language import FORMS, FUNCTIONS, MEMBERS, METHODS, NUMBERS, TYPES, Form
from artipg_dsl.lower import program
from artipg_dsl.lower.elaborate.drives import FORCES
from artipg_dsl.lower.solids.curves import OUTLINES
from artipg_dsl.lower.solids.paths import KINDS
from artipg_dsl.semantics.functions import RULES
from artipg_dsl.semantics.meanings import BuiltIn
from artipg_dsl.semantics.types import DIMENSIONS, PLACES, named
from artipg_dsl.session import Session
from artipg_dsl.syntax import ast

PATH = "path"  # the meaning of pieces of paths, which stand in chains


def test_every_function_has_a_rule_of_types_and_every_rule_a_function() -> None:
    assert {form.rule for form in FORMS} == set(RULES)


def test_every_function_has_a_meaning_and_every_meaning_a_function() -> None:
    assert {form.meaning for form in FORMS} == {*program.FUNCTIONS, *OUTLINES, PATH}
    assert {form.meaning for form in FORMS if form.kind == "curve"} == {*OUTLINES, PATH}
    assert {form.name for form in FORMS if form.kind == "force"} == set(FORCES)
    assert {form.name for form in FORMS if form.meaning == PATH} == set(KINDS) - {"formula"}


def test_types_are_those_of_the_checker() -> None:
    assert set(TYPES) == {*DIMENSIONS, *PLACES, "choice", "vec"}
    words = {"number", "root", "part", "elements", "joint"}
    used = {p.type for form in FORMS for p in form.parameters} | {form.gives for form in FORMS}
    for name in used - words | {m.type for members in MEMBERS.values() for m in members.values()} | set(MEMBERS):
        assert named(name)


CATEGORY = """apg 1
use primitives { Cuboid, Cylinder }
category Rack {
  let found = CALL
  root part body : Cuboid(size = [40cm, 60cm, 2cm])
  repeat row[i] in 0 ..< 2 spread body along y margin 5cm {
    part leg : Cylinder(radius = 1cm, height = 3cm)
    connect leg.top on body.bottom
    align leg.center.x = body.center.x
    align leg.center.y = row.center.y
  }
}
"""

CALLS = {
    "sin": "sin(a = 30deg)",
    "cos": "cos(30deg)",
    "tan": "tan(30deg)",
    "asin": "asin(0.5)",
    "acos": "acos(0.5)",
    "atan": "atan(0.5)",
    "atan2": "atan2(b = 1cm, a = 2cm)",
    "sqrt": "sqrt(4)",
    "hypot": "hypot(3cm, 4cm)",
    "abs": "abs(-2cm)",
    "sign": "sign(-2cm)",
    "min(path)": "min(row.leg.size.z)",
    "max(path)": "max(row.leg.size.z)",
    "sum(path)": "sum(row.leg.size.z)",
    "min(a, b, ...)": "min(2cm, 3cm, 4cm)",
    "max(a, b, ...)": "max(2cm, 3cm)",
    "number(path)": "number(row)",
    "floor": "floor(2.5)",
    "ceil": "ceil(2.5)",
    "round": "round(2.5)",
    "exp": "exp(1)",
    "log": "log(2)",
    "mod": "mod(7cm, 2cm)",
    "lowest": "lowest(row[0].leg, direction = -z)",
    "frame": "frame(at = [0, 0, 0], out = x, up = z)",
    "line(at, along)": "line([0, 0, 0], z)",
    "line(at, to)": "line(at = [0, 0, 0], to = [1cm, 0, 0])",
    "box": "box(1cm, -1cm, left = 1cm, right = -1cm, top = 1cm, bottom = -1cm)",
}


@pytest.mark.parametrize("form", [f for f in FORMS if f.kind in ("number", "reduction", "place")], ids=str)
def test_a_call_of_each_form_is_typed_and_lowered(form: Form) -> None:
    call = CALLS[form.call] if form.call in CALLS else CALLS[form.name]
    session = Session.of_text(CATEGORY.replace("CALL", call))
    assert session.lowering is not None, session.report.diagnostics
    assert session.typed is not None
    let = next(s for s in session.typed.category.body if isinstance(s, ast.LetDecl))  # type: ignore[union-attr]
    kind = session.typed.type_of(let.value)
    assert form.gives in ("number", "root") or str(kind) == str(named(form.gives))
    meaning = session.typed.meanings[id(let.value.function)]  # type: ignore[attr-defined]
    assert meaning == BuiltIn(form)


def test_arguments_are_bound_in_order_and_by_name() -> None:
    (frame,) = FUNCTIONS["frame"]
    assert [p.name for p in frame.bind(["up", None, "at"]) if p] == ["up", "out", "at"]
    assert frame.takes([None, None, None]) and frame.takes(["up", "out", "at"])
    assert not frame.takes([None, None]) and not frame.takes([None, None, None, None])
    assert not frame.takes([None, "at", "up"]) and not frame.takes([None, None, "upp"])
    polygon, at = FUNCTIONS["polygon"][0], METHODS["at"]
    assert polygon.takes([None] * 7) and not polygon.takes([None] * 2)
    assert at.takes([None, "z"]) and not at.takes(["z"])


def test_pi() -> None:
    assert NUMBERS == {"pi": math.pi}
