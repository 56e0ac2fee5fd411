"""A requirement on a member of an optional part holds trivially without the part, except where it asks itself whether it is there; an
`align` goes with the parts on its left."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid }
category T {
  param depth : length in 1cm .. 10cm
  root part body : Cuboid(size = [30cm, 30cm, 20cm])
  part lid : Cuboid(size = [20cm, 20cm, 2cm]) | none
  connect lid.bottom on body.top
  STATED
}
"""


def made(stated: str) -> tuple[Batch, np.ndarray, np.ndarray]:
    """The objects, which of them have the lid, and their depths."""
    batch = Session.of_text(TEXT.replace("STATED", stated)).sampler.batch(np.arange(200), seed=1)
    there = [any(part["name"] == "lid" for part in told["parts"]) for told in annotate(batch)]
    return batch, np.array(there), batch.values()["depth"]


@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("(lid.size.z if lid else 5cm) <= depth", lambda lid, d: np.where(lid, d >= 0.02, d >= 0.05)),
        ("depth <= 3cm if not lid else lid.size.z < depth", lambda lid, d: np.where(lid, d >= 0.02, d <= 0.03)),
        ("(lid and lid.size.z > 3cm) or depth < 5cm", lambda lid, d: d <= 0.05),
        ("(lid is Cuboid and lid.size.z > 1cm) or depth < 5cm", lambda lid, d: lid | (d <= 0.05)),
        ("depth < 5cm or not (not lid or lid.size.z > 3cm)", lambda lid, d: lid | (d <= 0.05)),
        ("not lid or lid.size.z < depth", lambda lid, d: ~lid | (d >= 0.02)),
        ("lid.size.z < depth", lambda lid, d: ~lid | (d >= 0.02)),
        ("lid.size.z < depth or depth > 9cm", lambda lid, d: ~lid | (d >= 0.02)),
    ],
)
def test_what_asks_for_the_part_holds_without_it_too(
    condition: str, holds: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> None:
    _, lid, depth = made(f"require {condition}")
    assert holds(lid, depth).all() and lid.any() and not lid.all()


def test_a_preference_asks_for_the_part_as_well() -> None:
    _, lid, depth = made("prefer (lid.size.z if lid else 5cm) <= depth weight 6")
    assert (depth[~lid] < 0.05).mean() < 0.05 and (~lid).sum() > 10


def test_an_equation_goes_with_the_part_on_its_left() -> None:
    text = TEXT.replace("lid.bottom on body.top", "lid to body")
    sides = "lid.bottom + 1cm - depth", "body.top + 1cm"
    batch = Session.of_text(text.replace("STATED", "align {} = {}".format(*sides))).sampler.batch(np.arange(20), seed=1)
    parts, depth = batch.parts(), batch.values()["depth"]
    lid = np.flatnonzero(np.array(parts.name) == "lid")
    assert 0 < len(lid) < 20
    assert np.allclose(parts.translation[lid, 2] - 0.01, 0.2 + depth[parts.owner[lid]])
    refused = Session.of_text(text.replace("STATED", "align {1} = {0}".format(*sides)))
    assert refused.lowering is None
    assert [(d.code, d.span.text) for d in refused.report.diagnostics if d.span] == [("optional-outside-when", "lid")]
