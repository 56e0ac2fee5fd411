"""``pushes``, ``pulls`` and their way back: decided by normal, side and hinge, in mirrors, repeats, guards and roles."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import Points, sample_points
from artipg_dsl.annotate.states import own_joints, rest_values, twist
from artipg_dsl.diagnostics import CompileError
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

TEXT = """
apg 1
use primitives { Cuboid, Cylinder }
vocabulary affordance { push pull open }
role Front { inherit size : length[3] in [1cm, 1cm, 1cm] .. [1m, 1m, 1m]   slot leaf   joint motion }
template Drawer : Front {
  part leaf : Cuboid(size = size)
  joint motion : prismatic base -> leaf along x range 0 .. 20cm
  field shut : bool on leaf = pushes_back(motion)
}
template Door : Front {
  param hand : choice on_left | on_right
  part leaf : Cuboid(size = size)
  when hand == on_left {
    joint motion : revolute base -> leaf about leaf.left.back range 0deg .. 90deg
  } else {
    joint motion : revolute base -> leaf about leaf.right.back range -90deg .. 0deg
  }
  field shut : bool on leaf = pushes_back(motion)
}
template Lid : Front {
  part leaf : Cuboid(size = size) turned 20deg about y
  joint motion : screw base -> leaf about line(at = leaf.center, along = z) range 0turn .. 1turn pitch 10mm
  field shut : bool on leaf = pushes_back(motion)
}
category Rack {
  param lean : angle in 5deg .. 30deg
  root part body : Cuboid(size = [20cm, 1m, 60cm])
  repeat side[i] mirror across y {
    part front : Front(size = [2cm, 30cm, 20cm]) = Drawer | Door | Lid | none weight 0.3
    connect front.back on body.front gap 2mm
    when front {
      align front.left = body.left - 4cm
      part key : Cuboid(size = [1cm, 3cm, 3cm]) turned lean about z
      align key.center = front.center + [3cm, 8cm, 2cm]
      connect key to front
    }
    label affordance.push on front where pushes(front.motion)
    label affordance.pull on side.front where pulls(front.motion)
    label affordance.open on key where pulls(front.motion)
  }
  part wheel : Cylinder(radius = 10cm, height = 5cm)
  joint spin : continuous body.top -> wheel.bottom gap 2mm
  part crank : Cuboid(size = [14cm, 2cm, 1cm])
  connect crank.bottom on wheel.top
  align crank.back = wheel.center.x
  label affordance.push on wheel, crank where pushes(spin) and pushes_back(spin)
}
"""


@pytest.fixture(scope="module")
def batch() -> Batch:
    return Session.of_text(TEXT).sampler.batch(np.arange(40), seed=1)


@pytest.fixture(scope="module")
def points(batch: Batch) -> Points:
    return sample_points(batch, 800)


def cosines(batch: Batch, points: Points) -> tuple[np.ndarray, np.ndarray]:
    """Of normal and motion at each point (B, n) as its own joint grows, and the joint, -1 for none."""
    start = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    link = start[:, None] + points.link
    velocity = twist(batch, np.zeros(len(batch.joints().owner))).at(link, points.position)
    speed = np.sqrt((velocity**2).sum(axis=-1))
    dot = (velocity * points.normal).sum(axis=-1)
    return np.where(speed > 1e-9, dot / np.maximum(speed, 1e-9), 0.0), own_joints(batch)[link]


def upward(batch: Batch) -> np.ndarray:
    """1 for joints that can only grow from rest, -1 for those that can only fall, 0 for the others."""
    joints, rest = batch.joints(), rest_values(batch)
    up = np.isnan(joints.high) | (joints.high > rest + 1e-6)
    down = np.isnan(joints.low) | (joints.low < rest - 1e-6)
    return up.astype(int) - down


def on(batch: Batch, points: Points, word: str) -> np.ndarray:
    """Whether points lie on parts whose path has a word."""
    table = batch.parts()
    start = np.searchsorted(table.owner, np.arange(len(batch)))
    paths = np.array([batch.program.parts[k].path for k in table.definition])
    return np.char.find(paths[start[:, None] + points.instance], word) >= 0


@pytest.mark.parametrize(("word", "force", "way"), [("push", -1, 1), ("pull", 1, 1), ("shut", -1, -1), ("open", 1, 1)])
def test_what_is_labelled_moves_along_its_normal(batch: Batch, points: Points, word: str, force: int, way: int) -> None:
    cosine, joint = cosines(batch, points)
    sign = force * way * upward(batch)[joint]
    labelled = points.labels[f"field.{word}" if word == "shut" else f"affordance.{word}"]
    assert labelled.sum() > 20
    assert (joint[labelled] >= 0).all()
    free = upward(batch)[joint] == 0
    assert (np.where(free, np.abs(cosine), sign * cosine)[labelled] >= 0.6 - 1e-6).all()


def test_what_moves_along_its_normal_is_labelled(batch: Batch, points: Points) -> None:
    cosine, joint = cosines(batch, points)
    straight = np.array([kind == "prismatic" for kind in batch.joints().kind])[joint] & (joint >= 0)
    leaf = straight & ~on(batch, points, "key")
    assert leaf.sum() > 500
    assert np.array_equal(points.labels["affordance.pull"][leaf], cosine[leaf] > 0.6)
    assert np.array_equal(points.labels["field.shut"][leaf], cosine[leaf] > 0.6)
    assert np.array_equal(points.labels["affordance.push"][leaf], cosine[leaf] < -0.6)


def test_a_point_near_the_axis_has_no_lever(batch: Batch, points: Points) -> None:
    cosine, joint = cosines(batch, points)
    round_about = np.array([kind == "continuous" for kind in batch.joints().kind])[joint] & (joint >= 0)
    pushed = points.labels["affordance.push"] & round_about
    assert pushed.any() and not (pushed & on(batch, points, "wheel")).any()  # a round one turns by friction alone
    center = points.position[pushed][:, :2]
    assert np.sqrt((center**2).sum(axis=-1)).min() > 0.05  # half of a reach of 14 cm about the wheel's middle


REFUSED = {
    "label affordance.push on foot where pushes(open)": "the joint `open` does not move what this is on",
    "label affordance.push on lid where pushes(lid)": "`pushes` takes a joint",
    "label affordance.push on lid where pushes(opening)": "there is no `opening` here",
    "label affordance.push on lid where pushes(stiff)": "is fixed",
    "label affordance.push on lid where pushes(open, open)": "takes one argument",
    "require pulls(open)": "only allowed in formulas of labels",
}


@pytest.mark.parametrize("statement", REFUSED)
def test_what_cannot_be_asked_is_refused(statement: str) -> None:
    text = f"""
apg 1
use primitives {{ Cuboid }}
vocabulary affordance {{ push }}
category Box {{
  root part body : Cuboid(size = [20cm, 20cm, 20cm])
  part foot : Cuboid(size = [20cm, 20cm, 2cm])
  joint stiff : fixed body.bottom -> foot.top
  part lid : Cuboid(size = [20cm, 20cm, 1cm])
  joint open : revolute body.top -> lid.bottom gap 1mm about lid.back.bottom range 0deg .. 90deg
  {statement}
}}
"""
    with pytest.raises(CompileError) as caught:
        _ = Session.of_text(text).sampler
    messages = [d.message for d in caught.value.report.diagnostics if d.severity == "error"]
    assert len(messages) == 1 and REFUSED[statement] in messages[0], messages
