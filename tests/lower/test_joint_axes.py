"""Where the axis of a joint lies that turns about the face or the port of its parent."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid, Cylinder }}
template Dial {{
  part disc : Cylinder(radius = 2cm, height = 1cm) along x
  port seat = disc.back
}}
category Panel {{
  root part body : Cuboid(size = [10cm, 40cm, 10cm])
  part dial : Dial
  joint turn : {kind} {joint} gap 1mm
}}
"""


@pytest.mark.parametrize("kind", ["continuous", "ball"])
@pytest.mark.parametrize("child", ["dial.back", "dial.seat"], ids=["a face", "a port"])
@pytest.mark.parametrize(
    ("at", "place"),
    [("", (0, 0)), ("at center", (0, 0)), ("at y = 15cm, z = 1cm", (15, 1)), ("at [5cm, -10cm, 2cm]", (-10, 2))],
    ids=["nothing", "the middle", "coordinates", "a point"],
)
def test_at_moves_the_axis_with_the_part(kind: str, child: str, at: str, place: tuple[float, float]) -> None:
    text = TEXT.format(kind=kind, joint=f"body.front -> {child} {at}")
    batch = Session.of_text(text, "panel.apg").sampler.batch(np.arange(1), seed=0)
    joints, parts = batch.joints(), batch.parts()
    body, disc = (parts.translation[parts.path.index(path)] for path in ("body", "dial.disc"))
    assert np.allclose((joints.origin[0] - body)[1:], np.array(place) / 100, atol=1e-12)
    assert np.allclose(joints.axis[0], [1, 0, 0], atol=1e-12)
    assert np.allclose((disc - body)[1:], np.array(place) / 100, atol=1e-12)
