"""What a statement means does not hang on how early in the text a name is read; requirements with `or` narrow draws."""

from __future__ import annotations

import numpy as np

from artipg_dsl.sampling.statistics import Statistics
from artipg_dsl.session import Session
from artipg_dsl.source import Source

EARLY = """apg 1
use primitives { Cuboid }
template Post {
  param high : length in 5cm .. 9cm
  part rod : Cuboid(size = [2cm, 2cm, high])
  let room = high - 1cm
  port foot = frame(at = rod.bottom.center, out = -z, up = x)
}
category Stand {
  root part base : Cuboid(size = [20cm, 20cm, 4cm])
  param tall : choice yes | no
  part post : Post
  let room = post.room
  let above = post.rod.top - base.top
  param lift : length in 0mm .. 20mm
  require lift <= room - 1cm
  require above >= 5cm
  when tall == yes { connect post.foot to base.top at center }
  else { connect post.foot to base.top at y = 5cm }
}
"""

EITHER = """apg 1
use primitives { Cuboid }
category Box {
  param kind : choice low | high
  param width : length in 10cm .. 90cm
  param height : length in 10cm .. 90cm
  require height <= 0.3 * width or kind == high
  root part body : Cuboid(size = [20cm, width, height])
  part lid : Cuboid(size = [20cm, 20cm, 2cm]) | none
  connect lid.bottom on body.top
  param edge : length in 1mm .. 20mm
  require lid or edge >= 12mm
}
"""


def test_a_part_read_before_the_when_that_mounts_it() -> None:
    sampler = Session(Source("stand.apg", EARLY), None).sampler
    statistics = Statistics()
    batch = sampler.batch(np.arange(40), seed=0, statistics=statistics)
    assert statistics.first_valid == 40
    post = next(site for site in batch.sites() if site.path == "post.rod")
    base = next(site for site in batch.sites() if site.path == "base")
    offset = post.translation - base.translation[np.searchsorted(base.owner, post.owner)]
    assert (offset[:, 2] > 0.04).all()
    assert set(np.round(np.abs(offset[:, 1]), 6)) == {0.0, 0.05}


def test_an_inequality_beside_an_or_narrows_the_draw() -> None:
    sampler = Session(Source("box.apg", EITHER), None).sampler
    statistics = Statistics()
    batch = sampler.batch(np.arange(300), seed=0, statistics=statistics)
    broken = {sampler.program.requirements[k].message: n for k, n in statistics.broken.items()}
    assert not any("edge" in message for message in broken), broken
    body = next(site for site in batch.sites() if site.path == "body")
    low = body.params["size.z"] <= 0.3 * body.params["size.y"] + 1e-9
    assert 0 < low.sum() < 300
