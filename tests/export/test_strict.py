"""Shipped objects in every configuration, by the code of ``benchmarks/strict.py``, which reads exported files alone."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
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


@pytest.mark.some
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


# ------------------------------------------------------------------ apgc validate --meshes

APART = ARM.replace("margin 15cm", "margin 5cm")
POST = """apg 1
use primitives { Cylinder, Cuboid }
category Peg {
  root part body : Cuboid(size = [10cm, 10cm, 10cm])
  part peg : Cylinder(radius = 2cm, height = 10cm)
  align peg.bottom = body.top + 1mm
  joint spin : continuous body -> peg about peg.axis
  part post : Cylinder(radius = 2cm, height = 10cm)
  connect post.bottom on body.top
  align post.center.y = peg.center.y
  align post.center.x = peg.center.x + 3.97cm
}
"""


def test_meshes_are_looked_at_in_the_same_states(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "arms.apg").write_text(ARM)
    (tmp_path / "apart.apg").write_text(APART)
    assert main(["validate", str(tmp_path / "apart.apg"), "-n", "2", "--meshes"]) == 0
    assert capsys.readouterr().out.count("in every state        100.0%") == 2
    assert main(["validate", str(tmp_path / "arms.apg"), "-n", "2", "--states", "random:64", "--meshes"]) == 1
    told = capsys.readouterr().out
    assert "in every state        0.0%   (the pieces that collide)" in told
    assert "at rest 100.0%, and while each joint moves 100.0%, and in 64 random configurations 0.0%" in told
    assert "arm_0.bar and arm_1.bar share" in told and "`arm[0].bar` and `arm[1].bar` about (" in told
    assert "arm_0.swing at " in told and "arm_1.swing at " in told


def test_a_mesh_can_meet_where_no_piece_does() -> None:
    """Two cylinders 0.3 mm into one another: their true surfaces are met by meshes at other angles than by pieces."""
    from artipg_dsl.export.strict import check_meshes
    from artipg_dsl.session import Session

    found = check_meshes(Session.of_text(POST).sampler.batch(np.arange(1), 0), 4)
    assert (found.objects, found.rest, found.sweeps, found.all) == (1, 0, 0, 0)
    touch = found.touches[0]
    assert (touch.links, touch.parts, touch.state) == (("body", "peg"), ("post", "peg"), "at rest")
    assert touch.depth == pytest.approx(3e-4, rel=0.05) and touch.values == {}
    assert touch.at[0] == pytest.approx(0.01985, abs=1e-4)


def test_both_ways_of_looking_agree(strict: ModuleType, tmp_path: Path) -> None:
    from artipg_dsl.export.strict import check_meshes as look
    from artipg_dsl.session import Session

    (tmp_path / "peg.apg").write_text(POST)
    folder = tmp_path / "out"
    assert (
        main(["sample", str(tmp_path / "peg.apg"), "-n", "1", "--unchecked", "--format", "urdf", "-o", str(folder)])
        == 0
    )
    hits, _ = strict.examine(strict.read(folder / "objects" / "000000", {}))
    ours = look(Session.of_text(POST).sampler.batch(np.arange(1), 0), 1).touches
    depth = {hit.when: hit.depth for hit in hits}
    assert depth["at rest"] == pytest.approx(ours[0].depth, rel=1e-6)


def test_without_its_package_a_message_names_the_extra(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("artipg_dsl.extras.find_spec", lambda name: None)
    assert main(["validate", "Window", "-n", "1", "--meshes"]) == 1
    assert "artipg_dsl[collide]" in capsys.readouterr().err
