"""What a batch reads is planned with the program: no further plan is made for a batch."""

import numpy as np
import pytest

from artipg_dsl.runtime import batch as module
from artipg_dsl.session import Session


@pytest.mark.parametrize("category", ["StorageFurniture", "Foldingrack"])  # links in repeats; closed loops
def test_sampling_and_poses_make_no_further_plan(category, monkeypatch):
    made = []
    monkeypatch.setattr(module, "make_plan", lambda *given: made.append(given))
    batch = Session.of(category).sampler.batch(np.arange(4), seed=3, checked=True)
    batch.pose()
    batch.parts()
    batch.sites()
    assert not made
