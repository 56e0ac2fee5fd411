"""Formulas of primitives that are read when they are asked for."""

import copy
import re
from threading import Thread

import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.graph.primitive import LATER, Primitive
from artipg_dsl.graph.reading import TextError, from_text
from artipg_dsl.graph.unread import from_kept
from artipg_dsl.graph.writing import to_text
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid, Cylinder }
category A {
  param wide : length in 1cm .. 2cm
  root part body : Cuboid(size = [9cm, 9cm, wide])
  part knob : Cylinder(radius = wide / 4, height = wide)
  connect knob.bottom on body.top
}
"""


@pytest.fixture(scope="module")
def text():
    return to_text(Session.of_text(TEXT).sampler.program)


def unread(primitive):
    return {name for name in LATER if not _has(primitive, name)}


def _has(primitive, name):
    try:
        Primitive.__dict__[name].__get__(primitive)
    except AttributeError:
        return False
    return True


def test_a_program_is_the_same(text):
    assert to_text(from_kept(text, "00")) == text == to_text(from_text(text))


def test_formulas_are_read_for_the_primitive_that_is_asked(text):
    cuboid, cylinder = from_kept(text, "00").primitives.values()
    assert cuboid.parameters == ("size.x", "size.y", "size.z") and cylinder.surfaces
    assert unread(cuboid) == unread(cylinder) == set(LATER)
    assert cylinder.inside is not None
    assert unread(cuboid) == set(LATER) and unread(cylinder) == set(LATER) - {"inside"}


def test_what_is_left_out_has_its_default(text):
    assert all(primitive.pieces == () for primitive in from_kept(text, "00").primitives.values())


def test_a_copy_has_its_formulas(text):
    primitive = from_kept(text, "00").primitives["Cuboid"]
    assert copy.copy(primitive).inside is primitive.inside


def test_an_attribute_that_no_primitive_has_is_missed(text):
    with pytest.raises(AttributeError, match="outside"):
        _ = from_kept(text, "00").primitives["Cuboid"].outside


def test_threads_that_ask_at_once_read_the_same(text):
    program, found = from_kept(text, "00"), []
    asked = [
        Thread(target=lambda p=p: found.append(p.inside is p.inside)) for p in program.primitives.values() for _ in "ab"
    ]
    for one in asked:
        one.start()
    for one in asked:
        one.join()
    assert found == [True] * 4 and to_text(program) == text


@pytest.mark.parametrize(
    ("pattern", "to", "said"),
    [
        (r"(= neg) (%\d+)\n(?=(?:%.*\n)*primitives)", r"\1 \2 \2\n", "neg takes 1 arguments, not 2"),
        (r'(primitives \(Primitive name "Cylinder".* inside) %\d+', r"\1 %99999", "%99999 is not known"),
        (r'(primitives \(Primitive name "Cylinder".* inside) %\d+', r"\1 3", "an expression"),
        (r'(primitives \(Primitive name "Cylinder".* requires) \[%\d+', r"\1 [%0", "true or false"),
    ],
)
def test_damage_is_an_error_once_it_is_met(text, pattern, to, said):
    wrong, count = re.subn(pattern, to, text, count=1)
    assert count and wrong != text
    program = from_kept(wrong, "00")
    with pytest.raises(UserError, match=said) as raised:
        to_text(program)
    assert "apgc cache clear" in raised.value.hint


@pytest.mark.parametrize(
    ("pattern", "to", "said"),
    [
        (r'(primitives \(Primitive name) "Cylinder"', r'\1 "Cuboid"', "different names"),
        (r'(primitives \(Primitive name "Cylinder" parameters) ', r"\1 7 parameters ", "twice"),
        (r'(primitives \(Primitive name "Cylinder" parameters) \[[^]]*\]', r"\1 7", "parameters"),
        (r"(primitives .*)\n", r"\1 7\n", "more after the end of the line"),
    ],
)
def test_what_is_read_at_once_is_verified_at_once(text, pattern, to, said):
    wrong, count = re.subn(pattern, to, text, count=1)
    assert count
    with pytest.raises(TextError, match=said):
        from_kept(wrong, "00")
