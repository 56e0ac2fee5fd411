"""Exported objects in MuJoCo, PyBullet and SAPIEN: they load, rest, move through their range and stand.

A few categories and one object of each; ``ARTIPG_EVERY=1`` takes all of them. ``benchmarks/simulators.py`` takes more.
"""

from __future__ import annotations

import os
from functools import cache

import pytest

from .levels import LEVELS, climb
from .matrix import SHIPPED, SIMULATORS, Object, objects, simulator
from .subject import written

# lids that stand open, followers, loops, tiny slides, drawers, a screw, a screen held up
FEW = ["bottle", "display", "foldingrack", "laptop", "scissors", "storage_furniture"]


@cache
def first(category: str) -> Object:
    return objects(category, 1, 1)[0]


@pytest.mark.parametrize("package", SIMULATORS)
@pytest.mark.parametrize("category", SHIPPED if os.environ.get("ARTIPG_EVERY") else FEW)
def test_levels(category: str, package: str) -> None:
    adapter = simulator(package)
    if adapter is None:
        pytest.skip(f"{package} is not installed: pip install 'artipg_dsl[sim]'")
    one = first(category)
    for form in adapter.forms:
        with written(one.robot, form, ways=one.ways, bound=one.bound) as subject:
            found = climb(adapter, subject, 3, one.stands)
        assert set(found) == set(LEVELS if one.stands else LEVELS[:-1])
        assert not any(found.values()), (form, found)
