"""One template that stands several times among the alternatives of a part or a style: each is told and drawn for itself."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.session import Session

PROGRAM = """apg 1
use primitives {{ Cuboid }}
vocabulary semantic {{ body handle }}
role Grip {{ inherit wide : length }}
template Bar : Grip {{
  param deep : length
  param long : length in 5cm .. 6cm
  count bars in 1 .. 3
  param shape : choice plain | full
  part bar : Cuboid(size = [deep, wide, (bars if shape == plain else 4) * long])
  symmetry bar : turn 2 about z
}}
category Box {{
  {style}
  root part body : Cuboid(size = [30cm, 30cm, 60cm])
  part grip : {grip}
  connect grip to body
  align grip.back = body.front
  label semantic.handle on grip
  symmetry grip : turn 4 about z
}}
"""
GIVEN = "Bar(deep = 1cm) | Bar(deep = 2cm) | Bar(deep = 3cm, bars = 2)"
WAYS = {
    "role": {"style": "", "grip": f"Grip(wide = 1cm) = {GIVEN}"},
    "style": {"style": f"style pull : Grip = {GIVEN}", "grip": "pull(wide = 1cm)"},
}


@pytest.mark.parametrize("way", WAYS)
def test_a_template_stands_several_times(way: str) -> None:
    made = annotate(Session.of_text(PROGRAM.format(**WAYS[way])).sampler.batch(np.arange(30), 0))
    seen = set()
    for told in made:
        drawn = {name.rpartition(".")[2]: value for name, value in told["drawn"].items()}
        number = ("Bar", "Bar#2", "Bar#3").index(drawn.get("grip", drawn.get("pull"))) + 1
        bars = 4 if drawn["shape"] == "full" else 2 if number == 3 else drawn["bars"]
        grip = next(part for part in told["parts"] if part["path"] == "grip")
        assert grip["size"] == pytest.approx([number / 100, 0.01, bars * drawn["long"]])
        assert (grip["semantic"], grip["symmetry"]) == ("handle", "4 about z")
        seen.add(number)
    assert seen == {1, 2, 3}
