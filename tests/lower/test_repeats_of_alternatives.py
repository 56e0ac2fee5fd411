"""Repeats of one name in several alternatives are different repeats: a guard says which one is meant."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid }
role Post { slot foot }
template Low : Post {
  part foot : Cuboid(size = [2cm, 2cm, 2cm])
  repeat ring[i] in 0 ..< 2 { param wide : length = 1cm * (i + 1) }
}
template High : Post {
  part foot : Cuboid(size = [2cm, 2cm, 9cm])
  repeat ring[i] in 0 ..< 3 { param wide : length = 5cm * (i + 1) }
}
category T {
  root part post : Post = Low | High
  STATED
}
"""


def of(stated: str) -> Session:
    return Session.of_text(TEXT.replace("STATED", stated))


@pytest.mark.parametrize("index", ["1", "last"])
def test_a_guard_says_which_repeat_is_meant(index: str) -> None:
    plate = f"part plate : Cuboid(size = [1cm, 1cm, post.ring[{index}].wide])\n connect plate.bottom on post.top"
    found = set()
    for told in annotate(of(f"when post is Low {{ {plate} }} else {{ {plate} }}").sampler.batch(np.arange(20), seed=1)):
        parts = {part["name"]: part for part in told["parts"]}
        found.add((parts["post"]["template"], round(parts["plate"]["size"][2], 6)))
    assert found == {("Low", 0.02), ("High", 0.1 if index == "1" else 0.15)}


def test_without_a_guard_it_is_refused() -> None:
    session = of("part plate : Cuboid(size = [1cm, 1cm, post.ring[0].wide])\n  connect plate.bottom on post.top")
    assert session.lowering is None
    (told,) = session.report.diagnostics
    assert told.code == "many-elements" and told.span is not None and told.span.words == "ring"
