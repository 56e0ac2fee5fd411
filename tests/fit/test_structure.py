"""The structure that a person sees of real objects, `benchmarks/structure.json`, is told in words of the categories."""

import importlib.util
import json
import os
import sys
from pathlib import Path

import pytest

from artipg_dsl.session import Session

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
TRUTH = json.loads((BENCHMARKS / "structure.json").read_text())
COUNTED = TRUTH.pop("counted")
TRUTH.pop("about")


@pytest.fixture(scope="module")
def structure():
    sys.path.insert(0, str(BENCHMARKS))  # it imports the benchmark beside it
    try:
        spec = importlib.util.spec_from_file_location("structure", BENCHMARKS / "structure.py")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(BENCHMARKS))
    return module


@pytest.mark.parametrize("category", TRUTH if os.environ.get("ARTIPG_EVERY") else sorted(TRUTH)[::3])
def test_facts_are_draws_and_their_options(category):
    draws: dict[str, set] = {}
    for draw in Session.of(category).sampler.program.draws:
        draws.setdefault(draw.column.name, set()).update(draw.options or ())
    names = {(name, option) for facts in TRUTH[category].values() for name, right in facts.items() for option in right}
    for sums in COUNTED.get(category, {}).values():
        names |= {
            (name, option) for name, worth in sums.items() for option in (worth if isinstance(worth, dict) else [1])
        }
    counted = COUNTED.get(category, {})
    assert [name for name, _ in names if name not in draws and name not in counted] == []
    wrong = [(name, option) for name, option in names if isinstance(option, str) and option not in draws.get(name, ())]
    assert [one for one in wrong if one[1] != "none"] == []  # a part that is not there


def test_what_a_fit_has_wrong(structure):
    counted = {"doors": {"cell.unit": {"Door": 1, "Pair": 2}}, "knobs": {"each": 2}}
    values = {"rows": [1, 3], "cell.unit": ["Pair", "Drawer", "Door"], "each": 2, "kind": "round"}
    right = {"rows": [1, 3], "doors": [3], "knobs": [4], "kind": ["oval", "round"], "lid": ["none"]}
    assert structure.wrong(values, right, counted) == {}
    missed = {"rows": [1], "doors": [2], "knobs": [2], "kind": [], "lid": ["Flap"]}
    assert structure.wrong(values, missed, counted) == {
        "rows": [1, 3],
        "doors": [3],
        "knobs": [4],
        "kind": ["round"],
        "lid": ["none"],
    }
