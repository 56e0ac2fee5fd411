"""Faces of a part that is turned about an axis of the frame in which they are named: along that axis they are that frame's."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.session import Session

WHEEL = """apg 1
use primitives {{ Cuboid, Cylinder }}
category Wheel {{
  root part hub : {}
  repeat stud[k] ring 6 about line(at = hub.center, along = {}) {{
    part bolt : Cylinder(radius = 4mm, height = 6mm) along x
    align bolt.back = hub.front
    align bolt.center.y = 1cm
    align bolt.center.z = 3cm
    connect bolt to hub
  }}
}}
"""


@pytest.mark.parametrize("axis", ["x", "-x"])
@pytest.mark.parametrize(
    "hub",
    [
        "Cuboid(size = [4cm, 10cm, 10cm])",
        "Cylinder(radius = 5cm, height = 4cm) along x",
        "Cylinder(radius = 5cm, height = 4cm) along -x",
        "Cuboid(size = [4cm, 10cm, 10cm]) turned 1/2turn about z",
        "Cuboid(size = [10cm, 4cm, 10cm]) turned 1/4turn about z",
    ],
)
def test_what_stands_in_a_ring_lies_on_the_front(hub: str, axis: str) -> None:
    batch = Session.of_text(WHEEL.format(hub, axis)).sampler.batch(np.arange(1), 1)
    (bolts,) = (site.translation for site in batch.sites() if site.path == "stud.bolt")
    assert np.allclose(bolts[:, 0], 0.023)
    assert np.allclose(np.hypot(bolts[:, 1], bolts[:, 2] - 0.05), np.hypot(0.01, 0.03))
    assert len(np.unique(np.round(bolts, 6), axis=0)) == 6


SLANTED = """apg 1
use primitives { Cuboid, Cylinder }
template Bar {
  param reach : length
  part rod : Cylinder(radius = 1cm, height = reach)
  port ends : line = line(at = rod.bottom.center, to = rod.top.center)
}
category Strut {
  root part body : Cuboid(size = [20cm, 20cm, 20cm])
  part bar : Bar
  connect bar between %s facing %s
  part tip : Cuboid(size = [1cm, 1cm, 1cm])
  connect tip to bar
  align tip.center = bar.rod.top.center
}
"""


@pytest.mark.parametrize("facing", ["y", "-y", "x", "-x"])
def test_the_top_of_a_slanted_bar_is_its_upper_end(facing: str) -> None:
    to = "[20cm, 0, 35cm]" if facing.endswith("y") else "[0, 20cm, 35cm]"
    program = SLANTED % (f"body.top.center and {to}", facing)
    batch = Session.of_text(program).sampler.batch(np.arange(1), 1)
    base, bar, tip = (
        next(site.translation[0] for site in batch.sites() if site.path == path) for path in ("body", "bar.rod", "tip")
    )
    assert np.allclose(tip - base, [0.2, 0, 0.35] if facing.endswith("y") else [0, 0.2, 0.35])
    assert np.allclose(2 * (bar - base) - (tip - base), [0, 0, 0.1])
