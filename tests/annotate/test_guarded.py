"""A label, a material, a grasp and a keypoint under `when` hold where its condition does, and nowhere else."""

from __future__ import annotations

import numpy as np

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.session import Session
from artipg_dsl.source import Source

TEXT = """apg 1
use primitives   { Cuboid, Cylinder }
use materials    { oak, steel }
use vocabularies { affordance }
category Block {
  root part body : Cuboid(size = [20cm, 20cm, 4cm])
  param kind : choice turned | pressed
  part knob : Cylinder(radius = 2cm, height = 3cm)
  connect knob.bottom on body.top at center
  when kind == turned {
    label affordance.turn on knob
    material steel on knob
    keypoint rim on knob at [2cm, 0, 0]
    grasp hold_knob on knob { at [0, 0, 0]  approach -z  close y  opening 4cm }
  } else {
    label affordance.press on knob
    material oak on knob
  }
}
"""


def test_only_where_the_condition_holds() -> None:
    batch = Session(Source("block.apg", TEXT), None).sampler.batch(np.arange(30), seed=5)
    told = annotate(batch)
    turned = np.array([batch.drawn(k)["kind"] == "turned" for k in range(30)])
    assert 0 < turned.sum() < 30
    points = sample_points(batch, 64)
    knob = points.primitive == next(k for k, site in enumerate(batch.program.sites) if site.path == "knob")
    assert knob.any(axis=1).all()
    assert (points.labels["affordance.turn"] == (knob & turned[:, None])).all()
    assert (points.labels["affordance.press"] == (knob & ~turned[:, None])).all()
    materials = [m.name for m in batch.program.materials.values()]
    assert (
        points.material[knob] == np.where(turned, materials.index("steel"), materials.index("oak"))[np.nonzero(knob)[0]]
    ).all()
    for one, held in zip(told, turned, strict=True):
        assert [k["name"] for k in one["keypoints"]] == (["rim"] if held else [])
        assert bool(one["grasps"]) == held
