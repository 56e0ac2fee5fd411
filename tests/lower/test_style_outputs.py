"""What one alternative alone draws is not asked for where another is there: outputs of styles and of roles."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid }}
role G {{ inherit deep : length  out reach : length }}
template A : G {{
  let reach = deep
  part rod : Cuboid(size = [1cm, 1cm, 1cm])
}}
template B : G {{
  param k : {param}
  let reach = deep + {formula}
  part rod : Cuboid(size = [1cm, 1cm, 1cm])
}}
category T {{
  param b : length in 1cm .. 2cm
  style g : G = A | B
  root part h : {part}
  part c : Cuboid(size = [1cm, 1cm, 1cm])
  connect c to h
  align c.center = [h.reach - b, 0, 0]
}}
"""
RATIO, ANGLE = "ratio in 1 .. 2 = 1.5", "angle in 72deg .. 84deg = 78deg"


@pytest.mark.parametrize("part", ["g(deep = 4cm)", "G(deep = 4cm) = A | B"], ids=["style", "role"])
@pytest.mark.parametrize(
    ("param", "formula", "of"),
    [
        (RATIO, "3cm / k", lambda k: 0.03 / k),
        (ANGLE, "(9cm - 0.9 * deep) / sin(k)", lambda k: 0.054 / np.sin(k)),
        (ANGLE, "1cm / tan(k) + 1cm / cos(90deg - k)", lambda k: 0.01 / np.tan(k) + 0.01 / np.sin(k)),
        (RATIO, "1cm * log(k)", lambda k: 0.01 * np.log(k)),
        (RATIO, "1cm * k ^ (0 - 2)", lambda k: 0.01 / k**2),
    ],
    ids=["quotient", "sine", "tangent", "logarithm", "power"],
)
def test_a_formula_of_one_alternative_is_not_evaluated_for_the_other(part: str, param: str, formula: str, of) -> None:  # noqa: ANN001
    text = TEXT.format(part=part, param=param, formula=formula)
    with np.errstate(all="ignore"):
        batch = Session.of_text(text).sampler.batch(np.arange(12), seed=1)
    parts = batch.parts()
    assert np.isfinite(parts.translation).all()
    placed = parts.translation[np.array([name == "c" for name in parts.name]), 0]
    kinds = set()
    for number in range(12):
        drawn = batch.drawn(number)
        kind = drawn.get("h", drawn["g"])
        kinds.add(kind)
        reach = 0.04 + (of(next(v for name, v in drawn.items() if name.endswith(".k"))) if kind == "B" else 0.0)
        assert placed[number] == pytest.approx(reach - drawn["b"])
    assert kinds == {"A", "B"}
