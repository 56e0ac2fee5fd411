"""Small programs whose figures are known by counting."""

from __future__ import annotations

import numpy as np

from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session

HEAD = """apg 1
use primitives   { Cuboid, Cylinder }
use vocabularies { semantic }
"""

CHEST = """
category Chest {
  param width : length in 30cm .. 60cm
  count drawers in 0 .. 2 = 1
  root part body : Cuboid(size = [30cm, width, 30cm])
  repeat bay[i] in 0 ..< drawers {
    part drawer : Cuboid(size = [20cm, 20cm, 8cm])
    align drawer.back = body.front + 1mm
    align drawer.bottom = body.bottom + i * 10cm
    joint pull : prismatic body -> drawer along x range 0 .. 10cm
    label semantic.drawer on drawer
  }
  part lid : Cuboid(size = [20cm, 20cm, 2cm]) | none
  when lid {
    align lid.bottom = body.top + 1mm
    align lid.back = body.back
    label semantic.lid on lid
  }
  joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
  label semantic.body on body
}
"""


def sampled(text: str, n: int = 60, seed: int = 0) -> tuple[Sampler, Batch]:
    sampler = Session.of_text(HEAD + text).sampler
    return sampler, sampler.batch(np.arange(n), seed)
