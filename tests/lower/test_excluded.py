"""`check` warns of a value of a count or a choice that a requirement leaves no object."""

from __future__ import annotations

import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
category Stool {{
  param width, depth : length in 30cm .. 40cm
  count legs in 2 .. 4
  param kind : choice low | high
  root part seat : Cuboid(size = [depth, width, 5cm if kind == low else 9cm])
  {rule}
  repeat leg[k] in 0 ..< legs spread seat along y margin 5cm {{
    part post : Cuboid(size = [3cm, 3cm, 30cm])
    connect post.top on seat.bottom
    align post.center.y = leg.center.y
  }}
}}
"""


def found(rule: str) -> list[str]:
    session = Session.of_text(TEXT.format(rule=rule))
    told = [d for d in session.examine().diagnostics if d.code in ("excluded-value", "impossible")]
    assert all(d.span is not None and d.span.line == 8 for d in told)
    return [d.message for d in told]


@pytest.mark.parametrize(
    ("rule", "told"),
    [
        ("", []),
        ("require width + depth >= 65cm", []),
        ("when legs == 2 { require width >= 35cm }", []),  # narrows the width of those with two legs
        ("when legs == 2 { require width + depth <= 70cm }", []),
        ("when legs == 2 { require width + depth <= 601mm }", ["`legs` is never 2: all "]),
        ("when kind == high { require width * depth >= 1595cm * 1cm }", ["`kind` is never `high`: "]),
        (
            "when legs == 3 and kind == low { require width + depth <= 601mm }",
            [],
        ),  # each value remains without the other
    ],
)
def test_a_value_without_objects_is_told(rule: str, told: list[str]) -> None:
    messages = found(rule)
    assert len(messages) == len(told)
    assert all(message.startswith(start) for message, start in zip(messages, told, strict=True))


def test_a_value_that_breaks_a_requirement_is_told_with_it() -> None:
    (message,) = found("when legs == 2 { require sin(9rad * width / 1m * 99) + sin(7rad * depth / 1m * 99) >= 1.999 }")
    assert message.startswith("`legs` is ") and "objects tried with it break this requirement" in message


def test_a_drawn_number_never_equals_another_under_a_condition() -> None:
    (message,) = found("when legs == 2 { require width == depth }")
    assert message == (
        "`depth` is drawn from a range, so `width == depth` never holds exactly; so what stands under this `when` is never drawn"
    )


def test_what_divides_by_zero_is_named_with_the_value_that_it_excludes() -> None:
    text = TEXT.format(rule="").replace("[depth, width,", "[depth, width / (legs - 3),")
    told = [d.message for d in Session.of_text(text).examine().diagnostics if d.code == "excluded-value"]
    assert len(told) == 2
    assert told[0].startswith("`legs` is never 2: ")  # negative
    assert told[1].startswith("`legs` is never 3: ")
    assert "`width / (legs - 3)` has no value, or a very large one: it divides by zero" in told[1]


@pytest.mark.parametrize("formula", ["(width / 1cm - 35) ^ (1/2)", "(width / 1cm - 35) ^ (-0.5)"])
def test_a_power_without_a_value_is_named(formula: str) -> None:
    text = TEXT.format(rule="").replace("[depth, width,", f"[depth, width + 1mm * min(1, {formula}),")
    told = [d.message for d in Session.of_text(text).examine().diagnostics if d.code == "undefined-value"]
    assert len(told) == 1 and told[0].startswith(f"`{formula}` has no value in ")
