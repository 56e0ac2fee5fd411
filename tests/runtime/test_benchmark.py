"""The benchmark of what users wait for counts what there is; the loop in plain floats computes what columns do."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl.session import Session

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


def benchmark(name: str) -> Any:
    spec = importlib.util.spec_from_file_location(name, BENCHMARKS / f"{name}.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_what_costs_is_found_by_its_name() -> None:
    whole = benchmark("whole")
    sampler = Session.of("Foldingrack").sampler
    with whole.counting() as counts:
        whole.labelled(sampler.batch(np.arange(2), 3, checked=True))
    assert counts.keys() == whole.COUNTED.keys()
    assert counts["pieces"] and counts["loops"] and counts["pairs"]
    assert counts["plans"] <= 1  # of the batch that tries again


@pytest.mark.some
@pytest.mark.parametrize("category", ["Microwave", "Table"])
def test_a_loop_in_plain_floats_gives_the_tables(category: str) -> None:
    plain = benchmark("plain")
    batch = Session.of(category).sampler.batch(np.arange(6), 5)
    loop = plain.Loop(batch)
    drawn = loop.drawn(batch)
    assert loop.verify(batch, drawn) <= plain.CLOSE
    for values in drawn[3]:
        values[:] = [value + 1e-3 if value % 1.0 else value for value in values]
    with pytest.raises(AssertionError, match="off"):
        loop.verify(batch, drawn)
