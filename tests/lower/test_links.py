"""What is fixed to a port of one of several alternatives rides on that alternative's own link."""

from __future__ import annotations

import numpy as np

from artipg_dsl.session import Session
from artipg_dsl.source import Source

TEXT = """apg 1
use primitives { Cuboid }
role Sash { inherit size : length[3]  port hold : frame  slot leaf  joint motion }
template Sided : Sash {
  param hand : choice left_hung | right_hung
  part leaf : Cuboid(size = size)
  when hand == left_hung { joint motion : revolute base -> leaf about leaf.front.left range 0deg .. 90deg }
  else { joint motion : revolute base -> leaf about leaf.front.right range 0deg .. 90deg }
  port hold = frame(at = leaf.front.center, out = x, up = z)
}
template Tilting : Sash {
  part leaf : Cuboid(size = size)
  joint motion : revolute base -> leaf about leaf.front.bottom range 0deg .. 15deg
  port hold = frame(at = leaf.front.center, out = x, up = z)
}
template Grip {
  part knob : Cuboid(size = [3cm, 3cm, 3cm])
  port mount = frame(at = knob.back.center, out = -x, up = z)
}
category Window {
  root part body : Cuboid(size = [5cm, 1m, 1m])
  part sash : Sash(size = [4cm, 60cm, 60cm]) = Sided | Tilting
  connect sash.back on body.front gap 5mm
  align sash.center.y = body.center.y
  align sash.center.z = body.center.z
  part handle : Grip
  connect handle.mount to sash.hold
}
"""


def test_rides_on_the_leaf_of_every_alternative() -> None:
    session = Session(Source("window.apg", TEXT), None)
    sampler = session.sampler
    batch = sampler.batch(np.arange(40), seed=3)
    sites = batch.sites()
    knob = next(site for site in sites if site.path.endswith("knob"))
    joints = batch.joints()
    assert len(np.unique(joints.definition)) == 3  # both hands and the tilting one were drawn
    assert (np.sort(joints.owner) == np.arange(40)).all()
    np.testing.assert_array_equal(knob.link[np.argsort(knob.owner)], joints.child[np.argsort(joints.owner)])
