"""What the check does, counted: pairs of convex bodies that are told apart, hulls, plans. Times would say it of one machine alone.

NumPy is asked, whose steps all go through ``collide.separate``; compiled code looks at the same pairs.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.native import backend
from artipg_dsl.session import Session

WHOLE = Path(__file__).parents[2] / "benchmarks" / "whole.py"
# of four objects, a tenth above what they were; where a change makes them fewer, they may be lowered
MOST = {"Microwave": {"pairs": 740, "hulls": 8, "pieces": 10}, "Scissors": {"pairs": 890, "hulls": 0, "pieces": 10}}


@pytest.fixture(autouse=True)
def numpy_alone(monkeypatch) -> Iterator[None]:
    monkeypatch.setenv(backend.VARIABLE, "numpy")
    backend.choose("numpy")
    yield
    monkeypatch.undo()
    backend._state = backend._State()


@pytest.mark.parametrize("category", MOST)
def test_no_more_is_looked_at_than_before(category: str) -> None:
    spec = importlib.util.spec_from_file_location("whole", WHOLE)
    assert spec is not None and spec.loader is not None
    whole = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(whole)
    sampler = Session.of(category).sampler
    sampler.batch(np.arange(4), 1, checked=True).joints()  # what is found once for a program
    found = []
    for count in (4, 8):
        with whole.counting() as counts:
            sampler.batch(np.arange(count), 3, checked=True).joints()
        found.append(counts)
    few, many = found
    assert few["plans"] == many["plans"] == 0
    for name, most in MOST[category].items():
        assert few[name] <= most, name
    assert many["pieces"] <= few["pieces"] + 2, "pieces are made for all objects together"
    assert few["pairs"] < many["pairs"] <= 2.4 * few["pairs"], "the work goes with the number of objects"
