"""Labels and grasps by physics: a hand moves what labels say, in MuJoCo; two fingers hold what grasps say, on exported meshes.

A few categories and two objects of each; ``ARTIPG_EVERY=1`` takes all of them. ``benchmarks/affordances.py`` and
``benchmarks/holding.py`` take more.
"""

from __future__ import annotations

import os
from functools import cache

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

from .matrix import ROOT, SHIPPED

EVERY = os.environ.get("ARTIPG_EVERY")
PUSHED = ["door", "faucet", "foldingrack", "storage_furniture", "usb"]
GRIPPED = ["faucet", "foldingrack", "globe", "kettle", "usb", "washing_machine"]


@cache
def batch(category: str, moving: bool = False) -> Batch:
    """The first two objects; of those that have a joint, where that is asked for: most mugs and chairs have none."""
    sampler = Session.of(str(ROOT / "categories" / f"{category}.apg")).sampler
    numbers = np.arange(2)
    if moving:
        joints = sampler.batch(np.arange(12), 1).joints()
        numbers = np.unique(joints.owner[np.array(joints.kind) != "fixed"])[:2]
    return sampler.batch(numbers, 1)


@pytest.mark.parametrize("category", SHIPPED if EVERY else PUSHED)
def test_what_is_labelled_moves(category: str) -> None:
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install 'artipg_dsl[sim]'")
    from .hands import trials

    found = [
        trial for trial in trials(batch(category, moving=True), points=150, each=1, others=False) if trial.labelled
    ]
    still = [trial for trial in found if not trial.moved]
    assert found
    assert len(still) <= 0.05 * len(found), still


@pytest.mark.parametrize("category", SHIPPED if EVERY else GRIPPED)
def test_what_a_hand_grips_has_grasps_that_hold(category: str) -> None:
    for package in ("fcl", "embreex"):
        pytest.importorskip(package, reason=f"{package} is not installed: pip install 'artipg_dsl[collide,rays]'")
    from .fingers import verdicts

    made = batch(category)
    held, links = verdicts(made, annotate(made))
    loose = [verdict for verdict in held if verdict.fault]
    lacking = [name for name, grasped in links if not grasped]
    assert len(loose) <= 0.05 * len(held), loose
    assert len(lacking) <= 0.1 * len(links), lacking
