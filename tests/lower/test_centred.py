"""``at center`` means the middle of what a part is put on or in, in a template as in a category."""

import numpy as np

from artipg_dsl.session import Session, check_text
from artipg_dsl.source import Source

TRAY = """apg 1
use primitives { Cuboid }
template Tray {
  param size : length[3]
  part floor : Cuboid(size = [_, 20cm, 2cm])
  align floor.left = left
  align floor.bottom = bottom
  align floor.front = front
  align floor.back = back
  part cup : Cuboid(size = [3cm, 4cm, 5cm])
  connect cup in floor FIT
}
category Desk {
  root part tray : Tray(size = [30cm, 60cm, 10cm])
}
"""


def test_the_middle_of_a_box_is_its_own() -> None:
    batch = Session.of_text(TRAY.replace("FIT", "fit bottom at center")).sampler.batch(np.arange(1), 1)
    parts = batch.parts()
    (floor, cup) = (next(i for i, p in enumerate(parts.path) if p.endswith(name)) for name in ("floor", "cup"))
    middle = parts.translation + (parts.low + parts.high) / 2
    np.testing.assert_allclose(middle[cup][:2], middle[floor][:2], atol=1e-12)
    np.testing.assert_allclose(middle[cup][2] - middle[floor][2], (0.05 - 0.02) / 2, atol=1e-12)


def test_a_box_that_is_filled_leaves_nothing_to_centre() -> None:
    source = Source("desk.apg", TRAY.replace("[3cm, 4cm, 5cm]", "_").replace("FIT", "at center"))
    found = [d.message for d in check_text(source).diagnostics if d.severity == "error"]
    assert "`at center` has no effect here: `in` without `fit` fits all six faces" in found


def test_a_coordinate_in_a_box_is_that_of_the_part() -> None:
    batch = Session.of_text(TRAY.replace("FIT", "fit bottom at x = 3cm, y = -20cm")).sampler.batch(np.arange(1), 1)
    parts = batch.parts()
    cup = next(i for i, path in enumerate(parts.path) if path.endswith("cup"))
    np.testing.assert_allclose(parts.translation[cup][:2], [0.03, -0.2], atol=1e-12)
