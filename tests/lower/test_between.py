"""A bar between two places: its length, and where ``sink`` and ``gap`` move its ends."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid }
template Bar {
  param reach : length
  part rod : Cuboid(size = [1cm, 1cm, reach])
  port ends : line = line(at = rod.bottom.center, to = rod.top.center)
}
category Block {
  root part body : Cuboid(size = [20cm, 20cm, 20cm])
  part bar : Bar
  connect bar between PLACES facing -x CLAUSE
}
"""
SIDE = "frame(at = [-10cm, 0, -5cm], out = -x, up = z) and frame(at = [-10cm, 0, 5cm], out = -x, up = z)"
ACROSS = "frame(at = [0, -4cm, 0], out = y, up = z) and frame(at = [0, 4cm, 0], out = -y, up = z)"
ASKEW = "frame(at = [-10cm, 0, -5cm], out = -x, up = z) and frame(at = [-10cm, 0, 5cm], out = z, up = x)"
POINTS = "body.back.center + [0, 0, -5cm] and body.back.center + [0, 0, 5cm]"
FACES = "body.left.center and body.right.center"
WRITTEN = "[-10cm, 0, -5cm] and [-10cm, 0, body.center.z + 5cm]"
MIXED = "frame(at = [-10cm, 0, -5cm], out = -x, up = z) and body.back.center + [0, 0, 5cm]"


def ends(places: str, clause: str) -> np.ndarray:
    """Both ends of the bar in the frame of the body, in millimetres."""
    text = TEXT.replace("PLACES", places).replace("CLAUSE", clause)
    parts = Session.of_text(text, "block.apg").sampler.batch(np.arange(1), seed=0).parts()
    body, rod = parts.path.index("body"), parts.path.index("bar.rod")
    along = parts.rotation[rod] @ np.array([0, 0, 1.0]) * parts.high[rod, 2]
    middle = parts.translation[rod] - parts.translation[body]
    return 1000 * np.stack([middle - along, middle + along])


@pytest.mark.parametrize(
    ("places", "clause", "expected"),
    [
        (SIDE, "", [[-100, 0, -50], [-100, 0, 50]]),
        (SIDE, "sink 5mm", [[-95, 0, -50], [-95, 0, 50]]),
        (SIDE, "gap 5mm", [[-105, 0, -50], [-105, 0, 50]]),
        (ACROSS, "sink 5mm", [[0, -45, 0], [0, 45, 0]]),
        (ASKEW, "sink 5mm", [[-95, 0, -50], [-100, 0, 45]]),
        (POINTS, "sink 5mm", [[-100, 0, -55], [-100, 0, 55]]),
        (WRITTEN, "sink 5mm", [[-100, 0, -55], [-100, 0, 55]]),
        (MIXED, "sink 5mm", [[-95, 0, -50], [-100, 0, 55]]),
        (FACES, "sink 5mm", [[0, 95, 0], [0, -95, 0]]),
        (FACES, "gap 5mm", [[0, 105, 0], [0, -105, 0]]),
    ],
    ids=[
        "neither",
        "a side",
        "a gap",
        "walls that face one another",
        "frames askew",
        "points",
        "points written out",
        "one of each",
        "faces sunk",
        "faces",
    ],
)
def test_each_end_moves_into_what_it_lies_on(places: str, clause: str, expected: list[list[float]]) -> None:
    assert np.allclose(ends(places, clause), expected, atol=1e-9)
