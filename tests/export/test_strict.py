"""Shipped objects in every configuration, by the code of ``benchmarks/strict.py``, which reads exported files alone."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from artipg_dsl.cli.main import main

FILE = Path(__file__).parents[2] / "benchmarks" / "strict.py"
ARM = """apg 1
use primitives { Cuboid }
category Arms {
  root part body : Cuboid(size = [60cm, 60cm, 2cm])
  repeat arm[k] in 0 ..< 2 spread body along y margin 15cm {
    part bar : Cuboid(size = [25cm, 2cm, 4cm])
    align bar.bottom = body.top + 1mm
    align bar.center.y = arm.center.y
    align bar.back = 0
    joint swing : revolute body -> bar about line(at = [0, arm.center.y, 0], along = z) range -80deg .. 80deg
  }
}
"""


@pytest.fixture(scope="module")
def strict() -> ModuleType:
    spec = importlib.util.spec_from_file_location("strict", FILE)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["strict"] = module
    spec.loader.exec_module(module)
    return module


def sampled(folder: Path, *arguments: str) -> Path:
    assert main(["sample", *arguments, "--format", "urdf,mjcf", "-o", str(folder)]) == 0
    return folder


def test_what_meets_only_together_is_found(strict: ModuleType, tmp_path: Path) -> None:
    """Two arms 25 cm long, 30 cm apart: neither reaches the other at rest, both together do."""
    (tmp_path / "arms.apg").write_text(ARM)
    folder = sampled(tmp_path / "out", str(tmp_path / "arms.apg"), "-n", "1")
    found = strict.measure(folder, tell=False)
    assert (found["objects"], found["rest"], found["sweep"], found["all"]) == (1, 1, 1, 0)
    hits, states = strict.examine(strict.read(folder / "objects" / "000000", {}))
    assert states == 1 + 2 * 2 * ((strict.STEPS + 1) // 2 - 1) + strict.STATES
    assert {hit.solids for hit in hits} == {("arm_0.bar", "arm_1.bar")} and hits[0].depth > 1e-3


def test_touching_is_no_fault_and_lying_within_is(strict: ModuleType) -> None:
    from manifold3d import Manifold

    box = Manifold.cube((1, 1, 1))
    assert strict.shared(box, box.translate((1, 0, 0)))[0] <= strict.DEPTH
    assert strict.shared(box, box.translate((1 - 1e-5, 0, 0)))[0] == pytest.approx(1e-5, rel=1e-3)
    assert strict.shared(box, Manifold.cube((0.1, 0.1, 0.1)).translate((0.4, 0.4, 0.4)))[0] == pytest.approx(0.1)


@pytest.mark.parametrize(
    "arguments",
    [
        ["Kettle", "--seed", "1", "--set", "place=bail", "--set", "handle=ArcGrip", "--only", "1,12,16"],
        ["Faucet", "--only", "3,10"],  # heads that tilt both ways at once
    ],
)
def test_shipped_objects_are_valid_in_every_configuration(
    strict: ModuleType, tmp_path: Path, arguments: list[str]
) -> None:
    found = strict.measure(sampled(tmp_path / "out", *arguments))
    assert found["all"] == found["objects"] > 0
