"""Joints that catch in positions: where they rest, and which values states give them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl import api as apg
from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.cli.main import main
from artipg_dsl.diagnostics import CompileError
from artipg_dsl.robot.robots import Robots

TEXT = """
apg 1
use primitives { Cuboid, Cylinder }
category Board {
  count stops in 3 .. 5
  root part body : Cuboid(size = [4cm, 60cm, 30cm])
  part rocker : Cuboid(size = [1cm, 2cm, 4cm])
  align rocker.back = body.front + 5mm
  align rocker.center.y = -20cm
  joint tilt : revolute body -> rocker about line(at = rocker.center, along = y) range -8deg .. 8deg positions 2
  part slider : Cuboid(size = [1cm, 1cm, 1cm])
  align slider.back = body.front + 1mm
  joint slide : prismatic body -> slider along z range 0 .. 6cm rest 25mm positions stops
  part dial : Cylinder(radius = 2cm, height = 1cm) along x
  align dial.back = body.front + 1mm
  align dial.center.y = 20cm
  joint turn : continuous body -> dial about line(at = dial.center, along = x) positions 8
  part pointer : Cuboid(size = [1cm, 1cm, 1cm])
  align pointer.front = body.back - 1mm
  joint follow : prismatic body -> pointer along z range -1m .. 1m mimic slide / 2
}
"""
NAMES = ("tilt", "slide", "turn", "follow")


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> apg.Samples:
    file = tmp_path_factory.mktemp("detents") / "board.apg"
    file.write_text(TEXT, encoding="utf-8")
    return apg.sample(str(file), 12)


def values(board: apg.Samples, states: str) -> tuple[np.ndarray, ...]:
    """(K, 12) of each joint."""
    table, names = joint_values(board.batch, read_states(states)), np.array(board.batch.joints().name)
    return tuple(table[:, names == name] for name in NAMES)


def test_they_rest_in_the_nearest_position(board: apg.Samples) -> None:
    tilt, slide, turn, follow = values(board, "rest")
    assert np.allclose(tilt, np.radians(-8.0)) and (turn == 0.0).all()  # of two that are as near, the lower
    step = 0.06 / (np.array([len(np.unique(np.round(column, 9))) for column in values(board, "random:200")[1].T]) - 1)
    assert np.allclose(slide[0] / step, np.rint(slide[0] / step)) and (np.abs(slide - 0.025) <= step / 2 + 1e-12).all()
    assert np.allclose(follow, slide / 2)


def test_random_states_are_positions_each_as_often(board: apg.Samples) -> None:
    tilt, slide, turn, follow = values(board, "random:400")
    assert set(np.round(np.degrees(tilt.ravel()), 6)) == {-8.0, 8.0}
    assert abs((tilt > 0.0).mean() - 0.5) < 0.02
    assert {len(set(np.round(column, 9))) for column in slide.T} <= {3, 4, 5}
    eighths = np.round(turn / (np.pi / 4), 6)
    assert (eighths == np.rint(eighths)).all() and len(np.unique(eighths)) == 8
    assert np.allclose(follow, slide / 2)


def test_open_is_a_position_and_a_named_value_is_kept(board: apg.Samples) -> None:
    tilt, slide, _, _ = values(board, "open")
    assert np.allclose(tilt, np.radians(8.0))
    assert np.allclose(slide, 0.06)
    assert np.allclose(values(board, "slide=13mm")[1], 0.013)


def test_files_say_in_how_many(board: apg.Samples) -> None:
    told = {joint["name"]: joint["positions"] for joint in annotate(board.batch, None)[0]["joints"]}
    joints = {joint.name: joint.positions for joint in Robots(board.batch).robot(0).joints}
    assert told["tilt"] == joints["tilt"] == 2 and told["turn"] == joints["turn"] == 8 and 3 <= told["slide"] <= 5
    assert told["follow"] is None and joints["follow"] == 0


def test_a_joint_with_positions_has_ends_of_its_own(tmp_path: Path) -> None:
    file = tmp_path / "board.apg"
    file.write_text(TEXT.replace("0 .. 6cm", "0 .. clearance"), encoding="utf-8")
    with pytest.raises(CompileError, match="clearance"):
        apg.sample(str(file), 1)


def test_files_that_have_room_for_it_say_so(board: apg.Samples, tmp_path: Path) -> None:
    (tmp_path / "board.apg").write_text(TEXT, encoding="utf-8")
    main(
        [
            "sample",
            str(tmp_path / "board.apg"),
            "-n",
            "1",
            "-o",
            str(tmp_path / "out"),
            "--format",
            "mjcf,usd,glb,partnet-mobility",
        ]
    )
    said = {path.suffix: path.read_bytes() for path in (tmp_path / "out").rglob("object*.*")}
    assert b'<numeric name="positions_turn" data="8"/>' in said[".xml"] and b"artipg:positions = 8" in said[".usda"]
    assert b'"positions":8' in said[".glb"].replace(b" ", b"")
    (mobility,) = (tmp_path / "out").rglob("mobility_v2.json")
    assert sorted(n["jointData"].get("positions", 0) for n in json.loads(mobility.read_text()))[-1] == 8
