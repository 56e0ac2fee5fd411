"""``sum``, ``min``, ``max`` and ``number`` over the elements of repeats, be they in one another or all alike."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl
from artipg_dsl.session import Session

CATEGORY = """apg 1
use primitives { Cuboid }
category Shelf {
  root part body : Cuboid(size = [40cm, 60cm, 2cm])
  param twice : bool = true
  repeat c[i] in 0 ..< 2 spread body along y {
    let same = 3cm
    let outer = body.size.x
    let rising = (i + 1) * 1cm
    repeat d[j] in 0 ..< 3 split c along x {
      let same = 1cm
      let rising = (i + j + 1) * 1cm
    }
  }
  part found : Cuboid(size = [EXPR, 1cm, 1cm])
  connect found.bottom on body.top at center
}
"""

REDUCED = {
    "sum(c.same)": 0.06,  # counted for each element, though it is the same in all of them
    "sum(c.outer)": 0.8,
    "sum(c.rising)": 0.03,
    "sum(2 * c.rising)": 0.06,
    "sum(c.rising if twice else 0)": 0.03,
    "max(c.same)": 0.03,
    "sum(c.d.same)": 0.06,
    "sum(c.d.rising)": 0.15,
    "min(c.d.rising)": 0.01,
    "max(1cm + c.d.rising)": 0.05,
    "number(c) * 1cm": 0.02,
    "number(c.d) * 1cm": 0.06,
}


@pytest.mark.parametrize("text", REDUCED)
def test_reduced(text: str) -> None:
    session = Session.of_text(CATEGORY.replace("EXPR", text))
    batch = session.sampler.batch(np.arange(1), seed=1)
    found = next(site for site in batch.sites() if site.path == "found")
    assert found.params["size.x"] == pytest.approx(REDUCED[text])


@pytest.mark.parametrize("member", ["param w : length in 1cm .. 2cm", "let w = 2cm"])
@pytest.mark.parametrize("form", ["min", "max"])
def test_an_object_that_needs_the_least_or_greatest_of_nothing_is_drawn_again(form: str, member: str) -> None:
    text = f"""
use primitives {{ Cuboid }}
category T {{
  count n in 0 .. 2
  root part body : Cuboid(size = [9cm, 9cm, 9cm])
  repeat r[i] in 0 ..< n split body along y {{ {member} }}
  part a : Cuboid(size = [1cm, 1cm, {form}(r.w)])
  connect a.bottom on body.top
}}"""
    some = artipg_dsl.load(text, n=20)
    assert set(some["n"].tolist()) == {1.0, 2.0}
    guarded = artipg_dsl.load(text.replace(f"{form}(r.w)", f"{form}(r.w) if n > 0 else 3cm"), n=20)
    parts = guarded.parts()
    heights = (parts.high - parts.low)[[p == "a" for p in parts.path], 2]
    assert heights[guarded["n"] == 0] == pytest.approx(0.03) and (heights[guarded["n"] > 0] <= 0.02).all()
    assert set(guarded["n"].tolist()) == {0.0, 1.0, 2.0}
