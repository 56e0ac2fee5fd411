"""Trials as annotations say they come out: without a simulator, the same aims as with one, and what is wrong with a folder found."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl.annotate.states import own_joints
from artipg_dsl.layouts.where2act.foretold import Foretold
from artipg_dsl.layouts.where2act.hand import Trial
from artipg_dsl.robot.robots import Robots
from artipg_dsl.session import Session

from .conftest import Lay, faults, unlike

pytest.importorskip("h5py", reason="h5py is not installed: pip install 'artipg_dsl[hdf5]'")


def results(folder: Path) -> dict[str, dict[str, Any]]:
    return {path.parent.name: json.loads(path.read_text()) for path in sorted(folder.glob("*/*/result.json"))}


@pytest.fixture(scope="module")
def trials(lay: Lay) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "sapien", None)  # as where it is not installed
        return lay("where2act-foretold", "Microwave", n=2, shares=(1, 0, 1))


@pytest.mark.some
def test_the_folder_is_read_back(trials: Path) -> None:
    found = results(trials)
    assert len(found) == 24 and not faults(trials)
    gone = [abs(one["final_target_part_qpos"] - one["start_target_part_qpos"]) for one in found.values()]
    assert 4 <= sum(way > 0.01 for way in gone) < 24


@pytest.mark.slow
def test_it_is_what_physics_makes_of_the_same_trials(trials: Path, lay: Lay) -> None:
    pytest.importorskip("sapien", reason="SAPIEN is not installed: pip install 'artipg_dsl[sim]'")
    told, came = results(trials), results(lay("where2act", "Microwave", n=2, shares=(1, 0, 1)))
    assert told.keys() == came.keys()
    alike = 0
    for name, one in told.items():
        other = came[name]
        for same in ("pixel_locs", "gripper_direction_world", "joint_names"):
            assert one[same] == other[same]
        moved = [
            r["result"] == "VALID" and abs(r["final_target_part_qpos"] - r["start_target_part_qpos"]) > 0.01
            for r in (one, other)
        ]
        alike += moved[0] == moved[1]
    assert alike >= 22


def test_what_is_wrong_is_found(trials: Path) -> None:
    name, told = next(item for item in results(trials).items() if item[1]["result"] == "VALID")
    path = next(trials.glob(f"*/{name}/result.json"))
    before = path.read_bytes()
    told["final_joint_angles"][told["target_object_part_joint_id"]] += 0.1
    told["fault"] = "met a wall"
    path.write_text(json.dumps(told))
    try:
        found = " ".join(unlike(trials))
    finally:
        path.write_bytes(before)
    assert "joint values at the end" in found and "the fault is 'met a wall', not ''" in found


LID = """apg 1
use primitives { Cuboid }
category Chest {
  root part body : Cuboid(size = [30cm, 40cm, 20cm])
  part lid : Cuboid(size = [30cm, 40cm, 2cm])
  let hinge = line(at = [body.back, body.center.y, body.top], along = -y)
  joint open : revolute body.top -> lid.bottom gap 1mm about hinge range 0deg .. 110deg friction FRICTION
}
"""


def chest(friction: str) -> Foretold:
    batch = Session.of_text(LID.replace("FRICTION", friction)).sampler.batch(np.arange(1), 0)
    return Foretold(batch, Robots(batch).robot(0), 0.27, own_joints(batch))


def test_things_come_to_stand_by_themselves() -> None:
    loose, tight = chest("0.1Nm"), chest("50Nm")
    ajar = {"open": np.radians(60.0)}
    shut, far = loose.settle(ajar), loose.settle({"open": np.radians(105.0)})
    assert shut is not None and far is not None
    assert shut["open"] == 0.0, "a lid falls shut"
    assert far["open"] == pytest.approx(np.radians(110.0)), "or open, beyond its top"
    assert tight.settle(ajar) == ajar, "or is held by what rubs"


def test_a_lid_is_lifted_by_its_edge_and_not_by_its_hinge() -> None:
    hand = chest("0.1Nm")
    up = np.array([0.0, 0.0, 1.0])
    for x, lifted in ((0.14, True), (-0.1499, False)):
        out = hand.run(Trial("pulling", 1, np.array([x, 0.0, 0.221]), up, -up, up), {"open": 0.0})
        assert [out.values["open"] > 0.01, bool(out.end[2] > out.start[2] + 0.01)] == [lifted, lifted]
    pressed = hand.run(Trial("pushing", 1, np.array([0.14, 0.0, 0.221]), up, -up, -up), {"open": 0.0})
    assert pressed.fault == "" and pressed.values["open"] == 0.0
