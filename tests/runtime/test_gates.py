"""Joints that wait for others: what states become, and what the check proves of them."""

from pathlib import Path

import numpy as np
import pytest

from artipg_dsl import api as apg
from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.diagnostics import CompileError
from artipg_dsl.errors import UserError

TEXT = """
apg 1
use bodies { OpenBox }
use primitives { Cuboid }
vocabulary affordance { pull : along }
category Oven {
  root part body : OpenBox(size = [40cm, 50cm, 30cm], wall = 12mm)
  part door : Cuboid(size = [2cm, 50cm, 30cm])
  align door.back = body.front + 1mm
  joint open : revolute body -> door about door.left.back range 0deg .. 110deg
  part rack : Cuboid(size = [30cm, 46cm, 1cm])
  align rack.bottom = body.inner.bottom + 8cm
  joint slide : prismatic body -> rack along x range 0 .. 25cm when open > LEAST
  part pan : Cuboid(size = [10cm, 10cm, 2cm])
  joint push : prismatic rack -> pan along y range 0 .. 10cm when slide > 20cm and open > 100deg
  align pan.bottom = rack.top + 1mm
  label affordance.pull on rack.front
}
"""


@pytest.fixture(scope="module")
def oven(tmp_path_factory: pytest.TempPathFactory) -> apg.Samples:
    file = tmp_path_factory.mktemp("gates") / "oven.apg"
    file.write_text(TEXT.replace("LEAST", "95deg"), encoding="utf-8")
    return apg.sample(str(file), 2)


def test_states_keep_shut_joints_at_rest(oven: apg.Samples) -> None:
    names = oven.batch.joints().name[:3]
    values = joint_values(oven.batch, read_states("open,random:200"))[:, :3]
    door, slide, push = (values[:, names.index(name)] for name in ("open", "slide", "push"))
    assert slide[0] > 0.19 and push[0] > 0.0  # `open` opens what it waits for
    assert (slide[door < np.radians(95)] == 0.0).all() and (slide[1:] > 0.0).any()
    assert (push[(slide < 0.2) | (door < np.radians(100))] == 0.0).all()


def test_a_named_state_opens_what_it_waits_for(oven: apg.Samples) -> None:
    values = joint_values(oven.batch, read_states("slide=20cm,slide=20cm+open=10deg,open=20%,slide=80%"))[:, :2]
    assert np.allclose(
        values, [[np.radians(110), 0.2], [np.radians(10), 0.0], [np.radians(22), 0.0], [np.radians(110), 0.2]]
    )


def test_annotations_tell_when(oven: apg.Samples) -> None:
    opened = joint_values(oven.batch, read_states("open"))
    told = annotate(oven.batch, opened)[0]
    waits = {joint["name"]: joint["enabled_when"] for joint in told["joints"]}
    assert waits["open"] is None and waits["slide"] == [{"joint": "open", "from": round(np.radians(95), 9), "to": None}]
    assert [gate["joint"] for gate in waits["push"]] == ["slide", "open"]
    (acts,), (then,) = told["interactions"], told["states"][0]["interactions"]
    assert not acts["enabled"] and acts["travel"] == [0.0, 0.0]
    assert then["enabled"] and then["travel"][1] == pytest.approx(0.05)


def test_a_rack_that_meets_the_door_it_waits_for_is_no_object(tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.mktemp("gates") / "oven.apg"
    file.write_text(
        TEXT.replace("LEAST", "60deg"), encoding="utf-8"
    )  # the open door is clear of it, the door half open is not
    with pytest.raises(UserError, match="rack collide while slide moves"):
        apg.sample(str(file), 1)


SAFE = """
apg 1
use bodies { OpenBox }
use primitives { Cuboid, Cylinder }
category Safe {
  root part body : OpenBox(size = [30cm, 40cm, 40cm], wall = 1cm)
  part door : Cuboid(size = [1cm, 40cm, 40cm])
  align door.back = body.front + 1mm
  part handle : Cylinder(radius = 2cm, height = 4cm) along x
  joint turn : revolute door.front -> handle.back gap 1mm range 0deg .. 90deg
  joint open : revolute body -> door about door.left.back range 0deg .. 100deg when turn >= LEAST
  part post : Cuboid(size = [1cm, 2cm, 38cm])                   # what the bolt goes behind
  align post.front = body.front
  align post.right = body.inner.right
  connect post to body
  part arm : Cuboid(size = [6cm, 1cm, 1cm])
  align arm.front = door.back
  align arm.right = body.inner.right + 4cm
  connect arm to door
  part bolt : Cuboid(size = [2cm, 6cm, 1cm])
  align bolt.back = arm.back
  align bolt.right = body.inner.right + 5mm
  align bolt.bottom = arm.top + 1mm
  joint slide : prismatic arm -> bolt along y range 0 .. 6cm mimic turn * (6cm / 90deg)
}
"""


def test_a_door_waits_for_the_bolt_that_its_gate_draws(tmp_path_factory: pytest.TempPathFactory) -> None:
    file = tmp_path_factory.mktemp("gates") / "safe.apg"
    file.write_text(SAFE.replace("LEAST", "85deg"), encoding="utf-8")
    assert len(apg.sample(str(file), 1)) == 1
    file.write_text(SAFE.replace("LEAST", "10deg"), encoding="utf-8")  # hardly drawn
    with pytest.raises(UserError, match="bolt collide while open moves"):
        apg.sample(str(file), 1)


def test_objects_of_which_none_moves_have_no_states_to_settle(tmp_path: Path) -> None:
    """A category whose joints wait may draw objects without joints, and a batch may hold only these."""
    file = tmp_path / "chest.apg"
    moving = TEXT.replace("LEAST", "95deg").split("  part door")
    file.write_text(
        f"{moving[0]}  param shut : choice yes | no = no\n  when shut == no {{\n  part door{moving[1].rstrip()}\n}}\n",
        encoding="utf-8",
    )
    still = apg.sample(str(file), 2, set={"shut": "yes"})
    assert joint_values(still.batch, read_states("open,random:3")).shape == (4, 0)
    assert [one["joints"] for one in annotate(still.batch, still.batch.rest()[None])] == [[], []]


def test_turns_beyond_the_first_are_like_it(tmp_path: Path) -> None:
    file = tmp_path / "stick.apg"
    file.write_text(
        """apg 1
use primitives { Cylinder, HollowFrustum }
use glues { Ridges }
category Stick {
  root part barrel : HollowFrustum(radius = 12mm, bore = 9mm, height = 5cm)
  part cap : Cylinder(radius = 12mm, height = 2cm)
  align cap.bottom = barrel.top + 0.3mm
  joint off : prismatic barrel -> cap along z range 0mm .. 3cm
  part foot : Cylinder(radius = 11.4mm, height = 8mm)
  align foot.top = barrel.bottom - 0.4mm
  part grooves : Ridges(radius = 11.4mm, high = 5mm, ridges = 24)
  connect grooves to foot
  align grooves.center = foot.center
  joint turn : revolute barrel -> foot about foot.axis range 0turn .. 7turn when off > 2cm
}
"""
    )
    assert apg.sample(str(file), 1).batch.joints().high[1] == pytest.approx(14 * np.pi)
    file.write_text(file.read_text().replace("barrel.bottom - 0.4mm", "barrel.bottom + 1mm"))
    with pytest.raises(UserError, match="barrel and foot collide"):
        apg.sample(str(file), 1)


FIRST = """
apg 1
use primitives { Cuboid }
category Ladder {
  root part body : Cuboid(size = [4cm, 40cm, 4cm])
  repeat step[i] in 0 ..< 3 {
    part bar : Cuboid(size = [4cm, 40cm, 1cm])
    when i == 0 {
      align bar.top = body.bottom - 1cm
      joint fall : prismatic body -> bar along -z range 0cm .. 5cm
    } else {
      align bar.top = previous.bar.bottom - 1cm
      joint fall : prismatic previous.bar -> bar along -z range 0cm .. 5cm mimic previous.fall
    }
  }
  part rail : Cuboid(size = [4cm, 1cm, 4cm])
  align rail.right = body.left + 1mm
  joint swing : prismatic body -> rail along y range 0cm .. 5cm when step[0].fall > 4cm
}
"""


def test_a_joint_waits_for_the_element_that_leads_the_others(tmp_path: Path) -> None:
    """Both branches name their joint alike: that of the first element moves by itself, and is the one that is named."""
    file = tmp_path / "ladder.apg"
    file.write_text(FIRST, encoding="utf-8")
    made = apg.sample(str(file), 1, checked=False)
    values = joint_values(made.batch, read_states("swing=5cm,swing=5cm+step_0.fall=1cm"))
    assert values.tolist() == pytest.approx(np.array([[0.05] * 4, [0.0, 0.01, 0.01, 0.01]]))
    file.write_text(FIRST.replace("step[0]", "step[1]"), encoding="utf-8")
    with pytest.raises(CompileError, match="follows another joint"):
        apg.sample(str(file), 1, checked=False)
