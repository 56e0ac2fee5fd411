"""`apgc check` compares boxes with surfaces where values lie outside of the test ranges."""

from textwrap import dedent

from artipg_dsl.diagnostics import CODES
from artipg_dsl.session import Session

TEXT = dedent(CODES["untested-values"].example)


def told(text):
    return [d for d in Session.of_text(text).examine().diagnostics if d.code == "untested-values"]


def test_a_wrong_box_names_the_part_the_value_and_the_range():
    (found,) = told(TEXT)
    assert "`bow` reaches 9.91 mm out of its box: here `begin` of `Bow` is -0.5236" in found.message
    assert "0 .. 0.3491" in found.message and found.severity == "warning"


def test_a_range_that_holds_the_value_makes_the_box_right():
    assert told(TEXT.replace("test 0deg .. 20deg", "test -40deg .. 20deg")) == []


def test_a_value_beyond_its_range_where_the_box_is_right_is_not_told():
    assert told(TEXT.replace("begin = -30deg", "begin = 10deg").replace("radius = 7cm", "radius = 3cm")) == []
