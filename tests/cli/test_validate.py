"""``apgc validate`` tells a watcher how far it is."""

import numpy as np

from artipg_dsl.cli.validate import examine
from artipg_dsl.run.job import open_job


def test_progress_is_told_before_every_step():
    told = []
    found = examine(open_job("Globe", 0, {}), np.arange(2), 2, progress=lambda done, steps: told.append((done, steps)))
    assert told == [(k, 4) for k in range(5)]
    assert found["objects"] == 2 and found["delivered"]["invalid"] == 0
