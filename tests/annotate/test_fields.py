"""Declared fields: numbers, booleans and vectors, with conditions, over the point, the target and other parts."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import Points, sample_points
from artipg_dsl.annotate.points import field_kinds
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

TEXT = """
apg 1
use primitives { Cuboid }
use handles { Handle, BarHandle, BowHandle }
vocabulary affordance { grasp push pull }
role Walled {
  inherit size : length[3] in [1cm, 1cm, 1cm] .. [1m, 1m, 1m]
  slot sides
}
template Case : Walled {
  part block : Cuboid(size = size)
  align block.center = center
  slot sides = block.left, block.right
  field depth : length on block = 1m
}
category Box {
  param lean : angle in 10deg .. 30deg
  param reach : length in 1cm .. 9cm
  root part body : Case(size = [10cm, 20cm, 30cm])
  part door : Cuboid(size = [1cm, 20cm, 30cm]) turned lean about z
  joint swing : revolute body -> door about door.left.back range 0deg .. 90deg
  align door.center = body.center + [10cm, 0, 0]
  part knob : Handle = BarHandle | BowHandle | none
  connect knob.mount to body.back at center
  label affordance.push on body.sides
  label affordance.grasp on door where p.z > 0 = (0.5 if knob else 1) * min(abs(p.z) / (size.z + reach), 1)
  label affordance.pull on knob.grip
  field wear : ratio on body.sides where p.z > 0.2 * size.z = reach / 9cm
  field rusty : bool on door = n.x > 0.5 and p.z > 0
  field pulling : vec on door where n.x > 0.5 = -n
  field offset : length[3] on door = p
  field ahead : vec on body = x
  field depth : length on body = 2m
}
"""


@pytest.fixture(scope="module")
def batch() -> Batch:
    return Session.of_text(TEXT).sampler.batch(np.arange(12), seed=1)


@pytest.fixture(scope="module")
def points(batch: Batch) -> Points:
    return sample_points(batch, 500)


def value(points: Points, name: str) -> np.ndarray:
    return points.labels[f"field.{name}"].astype(np.float64)


def test_kinds(batch: Batch) -> None:
    assert field_kinds(batch.program.labels) == {
        "affordance.grasp": "grade",
        "affordance.pull": "mask",
        "affordance.push": "mask",
        "field.ahead": "vectors",
        "field.depth": "field",
        "field.offset": "vectors",
        "field.pulling": "vectors",
        "field.rusty": "mask",
        "field.wear": "field",
    }


def test_a_slot_binds_several_surfaces(points: Points) -> None:
    push = points.labels["affordance.push"]
    left = push & (points.normal[..., 1] > 0.99)
    right = push & (points.normal[..., 1] < -0.99)
    assert left.any() and right.any() and (left | right == push).all()


def test_a_degree_reads_parameters_and_whether_a_part_is_there(batch: Batch, points: Points) -> None:
    door = points.link == 1
    drawn = [batch.drawn(i) for i in range(len(batch))]
    factor = np.array([1.0 if d["knob"] == "none" else 0.5 for d in drawn])[:, None]
    assert set(factor.ravel()) == {0.5, 1.0}
    reach = np.array([d["reach"] for d in drawn])[:, None]
    above = points.npcs[..., 2] * np.sqrt(0.01**2 + 0.2**2 + 0.3**2)
    expected = np.where(door & (above > 0), factor * above / (0.3 + reach), 0.0)
    assert points.labels["affordance.grasp"] == pytest.approx(expected, abs=1e-6)


def test_a_condition_leaves_the_rest_unsaid(batch: Batch, points: Points) -> None:
    wear = value(points, "wear")
    said = ~np.isnan(wear)
    assert said.any() and (points.labels["affordance.push"][said]).all()
    reach = np.array([batch.drawn(i)["reach"] for i in range(len(batch))])[:, None] / 0.09
    assert wear[said] == pytest.approx(np.broadcast_to(reach, wear.shape)[said], abs=1e-6)


def test_the_innermost_says_what_a_field_is(points: Points) -> None:
    on_case = ~np.isnan(value(points, "depth"))
    assert on_case.any() and (value(points, "depth")[on_case] == 1.0).all()


def test_vectors_lie_in_the_frame_of_the_object_and_move_with_their_link(batch: Batch, points: Points) -> None:
    pulling, ahead = value(points, "pulling"), value(points, "ahead")
    said = ~np.isnan(pulling[..., 0])
    assert said.any() and (said <= (points.link == 1)).all()
    assert pulling[said] == pytest.approx(-points.normal[said], abs=1e-6)
    assert points.labels["field.rusty"].dtype == bool and points.labels["field.rusty"].any()
    forward = ahead[~np.isnan(ahead[..., 0])]
    assert len(forward) and (forward == [1.0, 0.0, 0.0]).all()
    states = joint_values(batch, read_states("rest,random:2"))
    shown = sample_points(batch, 500, states)
    moved = shown.labels["field.pulling"].astype(np.float64)
    assert moved.shape == (12, 3, 500, 3)
    for k in range(3):
        assert moved[:, k][said] == pytest.approx(-shown.normal[:, k][said], abs=1e-6)
    assert np.abs(moved[:, 1] - moved[:, 0])[said].max() > 0.1


def test_a_family_of_surfaces_is_named_as_one() -> None:
    text = """
apg 1
use tubs { TubShell }
vocabulary affordance { contain }
category Pail {
  root part pail : TubShell(size = [30cm, 40cm, 20cm], radius = 4cm, wall = 4mm)
  label affordance.contain on pail.lining_side, pail.lining_corner
}
"""
    cloud = sample_points(Session.of_text(text).sampler.batch(np.arange(2), seed=1), 400)
    x, y, z = np.abs(cloud.position - [0, 0, 0.1]).transpose(2, 0, 1)
    off = np.hypot(np.maximum(x - 0.11, 0), np.maximum(y - 0.16, 0))  # from where the corners are turned
    lining = (off < 0.038) & (z < 0.1 - 1e-6)
    assert 100 < lining[0].sum() < 250 and np.array_equal(cloud.labels["affordance.contain"], lining)
