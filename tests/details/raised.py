"""Racks whose real surface lies off the structure by as much everywhere: what tests of details share."""

from __future__ import annotations

import numpy as np

from artipg_dsl import random
from artipg_dsl.geometry import points as geometry
from artipg_dsl.runtime.batch import Batch

RAISED = 0.004  # metres: the real surface lies off the structure by so much, everywhere
PROGRAM = """apg 1
use primitives { Cuboid, Cylinder }
category Rack {
  param width : length in 40cm .. 80cm = 60cm vary 20%
  count pegs in 1 .. 4 = 2
  root part board : Cuboid(size = [4cm, width, 20cm])
  part hook : Hook = Bar | Rod
  connect hook.bottom on board.top
  repeat peg[i] in 0 ..< pegs split board along y {
    part pin : Cuboid(size = [6cm, 3cm, 3cm])
    connect pin.back on board.front
    align pin.center.z = board.center.z
  }
}
role Hook {
  inherit size : length[3] in [2cm, 2cm, 8cm] .. [3cm, 3cm, 12cm]
  slot grip
}
template Bar : Hook { part grip : Cuboid(size = size) }
template Rod : Hook { part grip : Cylinder(radius = size.x / 2, height = size.z) along z }
"""


def surface(batch: Batch, n: int, key: int) -> geometry.PointSet:
    address = batch.numbers.astype(np.uint64)
    return geometry.sample(batch.sites(), len(batch), n, random.key(key, "test"), address, outside=True)
