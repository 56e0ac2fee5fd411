"""The benchmark of what users wait for counts what there is."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np

from artipg_dsl.session import Session

WHOLE = Path(__file__).parents[2] / "benchmarks" / "whole.py"


def test_what_costs_is_found_by_its_name() -> None:
    spec = importlib.util.spec_from_file_location("whole", WHOLE)
    assert spec is not None and spec.loader is not None
    whole = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(whole)
    sampler = Session.of("Foldingrack").sampler
    with whole.counting() as counts:
        whole.labelled(sampler.batch(np.arange(2), 3, checked=True))
    assert counts.keys() == whole.COUNTED.keys()
    assert counts["pieces"] and counts["loops"] and counts["pairs"]
    assert counts["plans"] <= 1  # of the batch that tries again
