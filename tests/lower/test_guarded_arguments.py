"""What an argument gives is taken wherever the template declares it: under a ``when``, as a count, as one of several alternatives."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.diagnostics.model import CompileError
from artipg_dsl.session import Session

PROGRAM = """apg 1
use primitives {{ Cuboid, Cylinder }}
role Plate {{ inherit deep : length }}
template Fitting : Plate {{
  param form : choice upright | round = upright
  when form == upright {{
    param high : length in 5cm .. 6cm
    count bolts in 1 .. 2
    param edge : choice sharp | blunt
    part plate : Cuboid(size = [deep, bolts * 4cm, high if edge == blunt else 1cm])
  }} else {{
    part rose : Cylinder(radius = 4cm, height = deep) along x
  }}
}}
category Door {{
  param high : length in 5cm .. 6cm
  param form : choice upright | round
  {style}
  root part plate : {part}
}}
"""
GIVEN = "form = upright, high = 2 * high, bolts = 5, edge = blunt"
WAYS = {
    "alone": ("", f"Fitting(deep = 1cm, {GIVEN})"),
    "role": ("", f"Plate(deep = 1cm) = Fitting({GIVEN})"),
    "alternatives": ("", f"Fitting(deep = 1cm, {GIVEN}) | Cuboid(size = [1cm, 2cm, 3cm]) when high < 0cm"),
    "style": (f"style all : Plate = Fitting({GIVEN})", "all(deep = 1cm)"),
    "user of a style": ("style all : Plate = Fitting", f"all(deep = 1cm, {GIVEN})"),
}


@pytest.mark.parametrize("way", WAYS)
def test_an_argument_is_taken(way: str) -> None:
    style, part = WAYS[way]
    batch = Session.of_text(PROGRAM.format(style=style, part=part)).sampler.batch(np.arange(20), 0)
    parts = batch.parts()
    size = (parts.high - parts.low)[[path == "plate" for path in parts.path]]
    high = np.array([batch.drawn(i)["high"] for i in range(20)])
    assert size == pytest.approx(np.stack([np.full(20, 0.01), np.full(20, 0.2), 2 * high], axis=1))
    assert set(batch.drawn(0)) <= {"high", "form", "plate", "all"}


def test_every_alternative_of_a_style_takes_what_its_user_gives() -> None:
    bars = (
        "template {0} : Plate {{{{\n  param long : length in 5cm .. 6cm\n  count n in 1 .. 2\n"
        "  part bar : Cuboid(size = [deep, n * 1cm, long])\n}}}}\n"
    )
    program = PROGRAM.replace("category", bars.format("Bar") + bars.format("Rod") + "category", 1)
    text = program.format(style="style all : Plate = Bar | Rod", part="all(deep = 1cm, long = 20cm, n = 7)")
    parts = Session.of_text(text).sampler.batch(np.arange(20), 0).parts()
    at = np.flatnonzero([path == "plate" for path in parts.path])
    assert {parts.template[k] for k in at} == {"Bar", "Rod"}
    assert (parts.high - parts.low)[at] == pytest.approx(np.tile([0.01, 0.07, 0.2], (20, 1)))


@pytest.mark.parametrize("given", ["high = 9cm", "form = form, high = 9cm", "form = round, bolts = 5"])
def test_an_argument_that_may_be_lost_is_refused(given: str) -> None:
    with pytest.raises(CompileError, match=r"`(high|bolts)` only exists under a guard.*`when form == upright`"):
        Session.of_text(PROGRAM.format(style="", part=f"Fitting(deep = 1cm, {given})")).sampler.batch(np.arange(1), 0)


def test_a_guard_around_the_part_ensures_it_too() -> None:
    text = PROGRAM.format(style="", part="Cuboid(size = [1cm, 1cm, 1cm])")
    more = """  when form == upright {
    part other : Fitting(deep = 1cm, form = form, high = 9cm)
    connect other to plate
    align other.back = plate.front
  }
}
"""
    text = text.rstrip().removesuffix("}") + more
    parts = Session.of_text(text).sampler.batch(np.arange(20), 0).parts()
    high = (parts.high - parts.low)[[path == "other.plate" for path in parts.path]][:, 2]
    assert 0 < len(high) < 20 and set(np.round(high, 9)) <= {0.01, 0.09}
