"""What is pressed or pushed moves: its surface lies across the motion of the joint that the label is of.

``where n.x > 0.5`` on a part that stands ``along x`` is about the part's own x, which lies across: so labels of keys were on their sides.
"""

from __future__ import annotations

import os

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.annotate.states import joint_twist
from artipg_dsl.resources import categories_dir
from artipg_dsl.session import Session

MENDED = ["camera", "clock", "coffee_machine", "lamp", "shaver", "toaster"]
WHOLE = {"cart"}  # a cart is pushed by its handle, which folds besides
EVERY = sorted({path.stem for path in categories_dir().glob("*.apg")} - WHOLE)


@pytest.mark.parametrize("category", EVERY if os.environ.get("ARTIPG_EVERY") else MENDED)
def test_what_is_pressed_lies_across_its_way(category: str) -> None:
    batch = Session.of(str(categories_dir() / f"{category}.apg")).sampler.batch(np.arange(8), 1)
    joints, rest = batch.joints(), batch.rest()
    cloud = sample_points(batch, Sampling(48, per="link"), rest * 0.0, motion=True)
    assert cloud.acting is not None
    twist, number, owner = joint_twist(batch, rest * 0.0), np.asarray(joints.number), np.asarray(joints.owner)
    across: dict[tuple[str, int], list[bool]] = {}
    for word in ("press", "push"):
        label = cloud.labels.get(f"affordance.{word}")
        if label is None:
            continue
        acting = cloud.acting[f"affordance.{word}"]
        for row, point in np.argwhere((label > 0) & (acting >= 0)):
            (joint,) = np.flatnonzero((number == acting[row, point]) & (owner == cloud.object[row]))
            way = twist.at(joint, cloud.position[row, point].astype(float))
            cosine = abs(way @ cloud.normal[row, point]) / max(float(np.sqrt(way @ way)), 1e-12)
            across.setdefault((word, int(joints.definition[joint])), []).append(cosine > 0.45)
    names = batch.program.joints
    wrong = {(word, names[k].path): f"{np.mean(ok):.0%}" for (word, k), ok in across.items() if np.mean(ok) < 0.8}
    assert across or category not in MENDED
    assert not wrong
