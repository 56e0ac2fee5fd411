"""Whose axes formulas, grasps and keypoints on a target have: a part's own, or, for a slot, those of the template that binds it."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.grasps import sample_grasps, sample_keypoints
from artipg_dsl.session import Session

TOOL = """
apg 1
use primitives {{ Cuboid, Cylinder }}
use vocabularies {{ affordance }}
role Held {{ slot grip }}
template Tool : Held {{
  part head : Cuboid(size = [3cm, 3cm, 3cm])
  part rod : Cylinder(radius = 1cm, height = 20cm) along x
  align rod.back = head.front - 1mm
  slot grip = {grip}
  {slot}
}}
category Work {{
  root part tool : Held = Tool
  when tool is Tool {{
    label affordance.grasp on {target} where n.z > 0.9
    grasp hold on {target} {{ at [0, 0, size.z / 4]  approach -x  close y  opening size.y + 1mm }}
    keypoint end on {target} at [0, 0, size.z / 2]
  }}
}}
"""


def made(target: str, grip: str = "head", slot: str = "") -> tuple[np.ndarray, ...]:
    """Mean normal of what has the label, point and closing direction of the grasp, the keypoint; in the object's frame, from the
    rod's middle."""
    batch = Session.of_text(TOOL.format(target=target, grip=grip, slot=slot)).sampler.batch(np.arange(1), 1)
    points, grasps, keys = sample_points(batch, 4000), sample_grasps(batch), sample_keypoints(batch)
    normal = points.normal[points.labels["affordance.grasp"] > 0].mean(axis=0)
    middle = np.array([0.114, 0, 0.015])  # the head is 3 cm long, and stands on z = 0
    return normal, grasps.point[0] - middle, grasps.rotation[0][:, 1], keys.point[0] - middle


@pytest.mark.parametrize("slot", ["", "slot metal = head", "slot metal = rod"])
def test_a_part_has_its_own_axes_whatever_slots_are_bound(slot: str) -> None:
    normal, point, close, end = made("tool.rod", slot=slot)  # its z is the object's x
    assert np.allclose(normal, [1, 0, 0], atol=0.05)
    assert np.allclose(point, [0.05, 0, 0], atol=1e-6)
    assert np.allclose(close, [0, 0, 1], atol=1e-9)
    assert np.allclose(end, [0.1, 0, 0], atol=1e-6)


def test_a_slot_has_the_axes_of_the_template_that_binds_it() -> None:
    normal, point, close, end = made("tool.grip", grip="rod")
    assert np.allclose(normal, [0, 0, 1], atol=0.1)  # above
    assert np.allclose(point, [0, 0, 0.005], atol=1e-6)
    assert np.allclose(close, [0, 1, 0], atol=1e-9)
    assert np.allclose(end, [0, 0, 0.01], atol=1e-6)
