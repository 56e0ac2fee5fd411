"""Annotations foretell what a hand moves, and grasps hold, in SAPIEN: trials of Where2Act and a gripper that closes.

One object of one category; ``ARTIPG_EVERY=1`` takes ten of all that Where2Act has. ``benchmarks/trials.py`` takes more.
"""

from __future__ import annotations

import os
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
import pytest

from artipg_dsl.robot.robots import Robots
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

from .matrix import ROOT

if TYPE_CHECKING:
    from .attempts import Attempt

pytest.importorskip("sapien", reason="SAPIEN is not installed: pip install 'artipg_dsl[sim]'")

EVERY = os.environ.get("ARTIPG_EVERY")
TRIED = [
    *("box", "door", "kettle", "microwave", "refrigerator", "switch", "trash_can", "window", "bucket", "kitchen_pot"),
    *("safe", "table", "washing_machine", "faucet"),
]
CATEGORIES = ["storage_furniture", *(TRIED if EVERY else ())]


def batch(category: str, number: int) -> Batch:
    path = str(ROOT / "categories" / f"{category}.apg")
    return Session.of(path).sampler.batch(np.arange(number, number + 1), 1)


@cache
def attempts(category: str) -> list[Attempt]:
    from .attempts import try_object

    objects = range(10) if EVERY else (1,)
    return [one for i in objects for one in try_object(batch(category, i), 100 if EVERY else 80, 1)]


@pytest.mark.parametrize("category", CATEGORIES)
def test_what_is_foretold_comes(category: str) -> None:
    found = [one for one in attempts(category) if not one.word]
    other = [one for one in found if one.foretold != one.came]
    assert len(found) >= 80
    assert sum(one.came for one in found) >= 0.1 * len(found)
    assert len(other) <= (0.05 if EVERY else 0.08) * len(found), other


@pytest.mark.parametrize("category", CATEGORIES)
def test_labelled_points_move_more_than_others(category: str) -> None:
    told, others = (
        [one.came for one in attempts(category) if one.word and one.labelled is value] for value in (True, False)
    )
    assert told
    assert len(told) - sum(told) <= max(1, 0.05 * len(told))
    assert sum(others) < sum(told)


@pytest.mark.slow
def test_an_axis_that_is_turned_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """What annotations say of other axes than those of the files does not come."""
    from artipg_dsl.layouts.where2act import forecast

    from .attempts import try_object

    right = forecast.find_jacobian

    def turned(*given: object) -> object:
        found = right(*given)  # type: ignore[arg-type]
        return type(found)(found.driver, np.roll(found.turn, 1, axis=-1), np.roll(found.shift, 1, axis=-1))

    monkeypatch.setattr(forecast, "find_jacobian", turned)
    found = try_object(batch("storage_furniture", 1), 60, 0)
    assert sum(one.foretold != one.came for one in found) > 0.15 * len(found)


@pytest.mark.slow
def test_a_chain_may_be_shorter_than_others_where_the_last_joint_has_no_end() -> None:
    """Of a cart, wheels hang on forks that turn, or on its frame."""
    from .attempts import try_object

    found = try_object(batch("cart", 0), 30, 0)
    assert sum(one.foretold == one.came for one in found) >= 0.9 * len(found)


SOME_GRIPS = [("storage_furniture", 1), ("kettle", 7), ("usb", 7)]  # handles; a round knob; a cap that is pulled off
MORE_GRIPS = [("usb", 5), ("usb", 0), ("knife", 3)]  # a cap that swivels; a plug that slides in; half of a hilt


@pytest.mark.some
@pytest.mark.parametrize(("category", "number"), SOME_GRIPS + (MORE_GRIPS if EVERY else []))
def test_a_gripper_that_closes_holds(category: str, number: int) -> None:
    from .closing import grips

    found = grips(batch(category, number))
    assert len(found) >= 5
    loose = [one for one in found if one.fault]
    assert len(loose) <= 0.1 * len(found), loose


LIFTED = """apg 1
use primitives { Cuboid }
category Lifted {
  root part body : Cuboid(size = [20cm, 20cm, 10cm])
  part lid : Cuboid(size = [20cm, 20cm, 1cm])
  joint lift : prismatic body.top -> lid.bottom gap 1mm range 0cm .. 12cm
}
"""


def test_a_finger_that_leaves_before_it_presses_enough_moves_nothing() -> None:
    """It rises off a slope: what it takes along it takes from the first, and what is heavier stays where it is."""
    from artipg_dsl.layouts.where2act.forecast import Scene, take_along

    made = Session.of_text(LIFTED).sampler.batch(np.arange(1), 0)
    normal, lead = np.array([[-0.08, -0.35, 0.93]]), 0.014 * np.array([[0.37, 0.73, 0.57]])

    def rises(weight: float, deep: float) -> float:
        scene = Scene(made, np.zeros(1), np.zeros(1), np.array([weight]), np.zeros(1), 4000.0)
        place = np.ones(1, dtype=np.int64), np.array([[-0.02, -0.1, 0.1]])
        return float(take_along(scene, *place, normal, -deep * normal, lead, 4.0).gone.sum())

    assert rises(0.1, 6e-4) > 5e-3 and rises(2.0, 2e-3) > 4e-3
    assert rises(2.0, 6e-4) == 0.0


def test_a_gripper_beside_a_grasp_holds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    from . import closing

    right = closing.hand_of
    monkeypatch.setattr(closing, "hand_of", lambda grasp: replace(right(grasp), point=right(grasp).point - [0.5, 0, 0]))
    assert {one.fault for one in closing.grips(batch("storage_furniture", 1))} == {"closes on nothing"}


LOCKED = """apg 1
use primitives { Cuboid }
category Locker {
  root part body : Cuboid(size = [30cm, 40cm, 50cm])
  part door : Cuboid(size = [2cm, 40cm, 50cm])
  align door.back = body.front + 1mm
  part knob : Cuboid(size = [2cm, 4cm, 4cm])
  align knob.back = door.front + 1mm
  joint open : revolute body -> door about door.left.back range 0deg .. 100deg when turn >= 60deg
  joint turn : revolute door -> knob about line(at = knob.center, along = x) range 0deg .. 90deg
}
"""


def test_what_waits_is_latched_until_it_may_go() -> None:
    """A door that swings once its knob is turned, and does not close by the latch while it stands open."""
    from artipg_dsl.layouts.where2act.hand import Standing

    standing = Standing(Robots(Session.of_text(LOCKED).sampler.batch(np.arange(1), 0)).robot(0))
    door, knob = (standing.order.index(name) for name in ("open", "turn"))

    def swung(turned: float, opened: float) -> float:
        standing.place({"open": opened, "turn": turned})
        speed = np.zeros(2)
        speed[door] = 2.0
        standing.body.set_qvel(speed)
        standing.step()
        standing.body.set_qvel(speed)
        for _ in range(20):
            standing.step()
        assert abs(standing.now()[knob] - turned) < 0.05
        return float(standing.now()[door] - opened)

    assert abs(swung(0.0, 0.0)) < 1e-3 and swung(1.2, 0.0) > 5e-3
    assert abs(swung(0.0, 0.0)) < 1e-3 and swung(0.0, 0.5) > 5e-3


TOWED = """apg 1
use primitives { Cuboid }
category Towed {
  let lead = 1mm / 1rad
  root part body : Cuboid(size = [20cm, 20cm, 10cm])
  part knob : Cuboid(size = [2cm, 4cm, 4cm])
  align knob.back = body.front + 1mm
  joint turn : revolute body -> knob about line(at = knob.center, along = x) range 0deg .. 90deg friction 0.01Nm
  part rod : Cuboid(size = [1cm, 1cm, 4cm])
  align rod.bottom = body.top + 1mm
  joint rise : prismatic body -> rod along z range 0mm .. 2mm mimic turn * lead
}
"""


def test_a_follower_goes_along_and_does_not_hold_its_leader() -> None:
    """SAPIEN's own tie inverts the ratio: it held both where they were."""
    from artipg_dsl.layouts.where2act.hand import Standing

    standing = Standing(Robots(Session.of_text(TOWED).sampler.batch(np.arange(1), 0)).robot(0))
    turn, rise = (standing.order.index(name) for name in ("turn", "rise"))
    standing.place({"turn": 0.0, "rise": 0.0})
    for _ in range(100):
        standing.links[1].add_force_torque([0, 0, 0], [0.05, 0, 0])
        standing.step()
    now = standing.now()
    assert now[turn] > 0.3 and abs(now[rise] - 1e-3 * now[turn]) < 2e-4


def test_a_leader_feels_what_its_follower_weighs() -> None:
    """A kilogram that rises by 2 cm a radian turns a knob back that 0.01 Nm hold, and not one that 0.5 Nm hold."""
    from artipg_dsl.layouts.where2act.hand import Standing

    def left(friction: str) -> float:
        text = TOWED.replace("1mm / 1rad", "20mm / 1rad").replace("0mm .. 2mm", "0mm .. 40mm")
        text = text.replace("[1cm, 1cm, 4cm]", "[10cm, 10cm, 10cm]").replace("0.01Nm", friction)
        standing = Standing(Robots(Session.of_text(text).sampler.batch(np.arange(1), 0)).robot(0))
        standing.place({"turn": 1.0, "rise": 0.02})
        for _ in range(200):
            standing.step()
        return standing.values()["turn"]

    assert left("0.01Nm") < 0.5 and abs(left("0.5Nm") - 1.0) < 1e-2


def test_an_object_moves_in_its_unit_as_in_metres() -> None:
    """A knob that its follower's weight turns back, and a lid that falls: hinge, slide, rotor, damping, friction and mimic."""
    from artipg_dsl.layouts.where2act.hand import Standing

    text = TOWED.replace("1mm / 1rad", "20mm / 1rad").replace("0mm .. 2mm", "0mm .. 40mm")
    text = text.replace("[1cm, 1cm, 4cm]", "[10cm, 10cm, 10cm]").replace("0.01Nm", "0.05Nm")
    text = (
        text.rstrip("}\n")
        + """
  part lid : Cuboid(size = [20cm, 20cm, 1cm])
  align lid.top = body.bottom - 3cm
  joint open : revolute body -> lid about lid.back.bottom range -80deg .. 80deg friction 0.02Nm damping 0.3Nms/rad
}
"""
    )
    robot = Robots(Session.of_text(text).sampler.batch(np.arange(1), 0)).robot(0)

    def path(unit: float) -> np.ndarray:
        standing = Standing(robot, unit)
        standing.place({"turn": 1.0, "rise": 0.02, "open": 0.0})
        found = []
        for _ in range(35):  # PhysX lets nothing fall faster than some 10 units a second
            standing.step()
            found.append(list(standing.values().values()))
        return np.array(found)

    metres, units = path(1.0), path(0.04)
    gone = np.abs(metres[-1] - metres[0])
    assert (gone > [0.05, 1e-3, 0.05]).all() and (np.abs(metres - units).max(axis=0) < 0.02 * gone).all(), gone


KEYED = """apg 1
use primitives { Cuboid, RoundedCuboid }
category Keyed {
  root part body : Cuboid(size = [5cm, 10cm, 1cm])
  part key : RoundedCuboid(size = [10mm, 9mm, 0.8mm], radius = 0.3mm)
  align key.bottom = body.top + 1mm
  joint press : prismatic body -> key along -z range 0mm .. 0.5mm
}
"""


def test_a_small_key_keeps_its_shape() -> None:
    """In metres PhysX made a wedge of five corners of it, 0.7 mm too high, on which fingers slipped and lids stuck."""
    from artipg_dsl.export.partnet.mobility import folder_frame
    from artipg_dsl.layouts.where2act.hand import Standing

    robot = Robots(Session.of_text(KEYED).sampler.batch(np.arange(1), 0)).robot(0)
    unit = folder_frame(robot).unit
    (shape,) = Standing(robot, unit).links[1].collision_shapes
    corners = np.asarray(shape.get_vertices()) * shape.get_scale() * unit
    want = robot.links[1].colliders[0].hull.vertices
    assert np.abs(corners.max(axis=0) - want.max(axis=0)).max() < 5e-5
    assert np.abs(corners.min(axis=0) - want.min(axis=0)).max() < 5e-5


KNOB = """apg 1
use primitives { Cuboid, Cylinder }
category Knob {
  root part body : Cuboid(size = [20cm, 20cm, 20cm])
  part knob : Cylinder(radius = 6mm, height = 16mm) along x
  align knob.back = body.front + 1mm
  joint turn : continuous body -> knob about knob.axis
}
"""


def test_a_finger_turns_a_knob_that_is_smaller_than_its_way() -> None:
    """How far the finger has got beyond it is no force that the knob takes: only what rubs is."""
    from artipg_dsl.layouts.where2act.forecast import Scene, take_along

    made = Session.of_text(KNOB).sampler.batch(np.arange(1), 0)
    normal, lead = np.array([[0.0, 0, 1]]), 0.018 * np.array([[0.77, 0.63, -0.03]])
    point = np.array([[0.11, 0, 0.106]])  # 6 mm above the axis

    def goes(rubs: float) -> np.ndarray:
        scene = Scene(made, np.zeros(1), np.array([rubs]), np.zeros(1), np.zeros(1), 4000.0)
        return take_along(scene, np.ones(1, dtype=np.int64), point, normal, 8e-4 * -normal, lead, 4.0).way[0]

    assert goes(0.02) @ lead[0] > 0.5 * np.sqrt(goes(0.02) @ goes(0.02)) * 0.018 > 1e-5
    assert not goes(1.0).any()


BALANCED = """apg 1
use primitives { Cuboid }
category Balanced {
  root part body : Cuboid(size = [40cm, 50cm, 60cm])
  part flap : Cuboid(size = [2cm, 50cm, 60cm])
  align flap.back = body.front + 1mm
  joint open : revolute body -> flap about flap.bottom.back range 0deg .. 90deg stiffness 8Nm/rad damping 1Nms/rad
  part key : Cuboid(size = [1cm, 2cm, 2cm])
  align key.bottom = body.top + 1mm
  joint press : prismatic body -> key along -z range 0mm .. 4mm stiffness 1000N/m
  material board on body, flap, key
}
material board { density 700kg/m3 }
"""


@pytest.mark.parametrize("unit", [1.0, 0.4])
def test_a_spring_brings_a_key_back_and_bears_a_flap(unit: float) -> None:
    """The key comes up from any place; the flap, which weighs 12 Nm, stays in any with friction of a quarter of that."""
    from artipg_dsl.layouts.where2act.hand import Standing

    robot = Robots(Session.of_text(BALANCED).sampler.batch(np.arange(1), 0)).robot(0)
    (flap,) = (joint for joint in robot.joints if joint.name == "open")
    assert flap.friction < 4.0 and flap.unsprung is not None and flap.unsprung[0] > 14.0
    standing = Standing(robot, unit)
    for opened in (0.0, 0.4, 0.9, 1.5):
        standing.place({"open": opened, "press": 4e-3})
        for _ in range(500):
            standing.step()
        found = standing.values()
        assert abs(found["open"] - opened) < 5e-3 and abs(found["press"]) < 1e-4, found


def test_a_spring_is_foretold_to_stop_a_hand_as_soft_as_itself_half_way() -> None:
    from artipg_dsl.layouts.where2act.forecast import Scene, follow, weights

    made = Session.of_text(BALANCED).sampler.batch(np.arange(1), 0)
    names, springs = list(made.joints().name), np.nan_to_num(made.joints().stiffness)
    press, key = names.index("press"), int(made.joints().child[names.index("press")])
    scene = Scene(made, made.rest(), np.zeros(2), np.zeros(2), springs, 1000.0)
    path = follow(scene, np.array([key]), np.array([[0.0, 0.0, 0.62]]), np.array([[0.0, 0.0, -4e-3]]))
    assert path.gone[0] == pytest.approx([2e-3], abs=2e-5)
    state = made.rest().copy()
    state[press] = 3e-3
    robot = Robots(made).robot(0)
    assert (weights(made, robot, state) - weights(made, robot, made.rest()))[press] == pytest.approx(3.0, rel=1e-6)


def test_what_a_spring_draws_is_foretold_to_come_back() -> None:
    from artipg_dsl.layouts.where2act.foretold import Foretold

    made = Session.of_text(BALANCED).sampler.batch(np.arange(1), 0)
    foretold = Foretold(made, Robots(made).robot(0), 0.4, np.arange(3))
    found = foretold.settle({"open": 0.9, "press": 3e-3})
    assert found is not None and found["open"] == 0.9 and abs(found["press"]) < 2e-6
