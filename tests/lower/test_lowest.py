"""`lowest`: how far the box of a part reaches in a direction, whatever its length and however the part is turned."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest

from artipg_dsl.session import Session

TEXT = """apg 1
use primitives { Cuboid }
category T {
  param steep : angle in -170deg .. 170deg
  root part body : Cuboid(size = [30cm, 30cm, 20cm])
  part bar : Cuboid(size = [10cm, 4cm, 2cm]) TURNED
  connect bar to body
  align bar.center = [3cm, 5cm, 30cm]
  part post : Cuboid(size = [1cm, 1cm, 1m])
  connect post to body
  align post.center = [lowest(bar, DIRECTION), 2m, 0]
}
"""


@pytest.mark.parametrize("turned", ["", "along y", "turned 30deg about y"])
@pytest.mark.parametrize(
    ("direction", "way"),
    [
        ("-z", lambda a: [0, 0, -1]),
        ("[1, 1, 0]", lambda a: [1, 1, 0]),
        ("[-2, 0, 1]", lambda a: [-2, 0, 1]),
        ("[cos(steep), 0, sin(steep)]", lambda a: [np.cos(a), 0, np.sin(a)]),
    ],
)
def test_the_farthest_corner_counts(turned: str, direction: str, way: Callable[[float], list[float]]) -> None:
    text = TEXT.replace("TURNED", turned).replace("DIRECTION", direction)
    batch = Session.of_text(text).sampler.batch(np.arange(30), seed=1)
    parts, steep = batch.parts(), batch.values()["steep"]
    corners = np.array(list(itertools.product((-0.5, 0.5), repeat=3)))
    for number in range(30):
        row = {parts.name[k]: k for k in np.flatnonzero(parts.owner == number)}
        bar, post, body = row["bar"], row["post"], row["body"]
        size = parts.high[bar] - parts.low[bar]
        places = (corners * size) @ parts.rotation[bar].T + parts.translation[bar] - parts.translation[body]
        wanted = (places @ way(steep[number])).max() / np.linalg.norm(way(steep[number]))
        assert parts.translation[post, 0] == pytest.approx(wanted)
