"""Friction, damping, effort and velocity where a text gives none: what gravity and a hand ask for."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.robot.dynamics import (
    FADE,
    FINGER,
    GRAVITY,
    HAND,
    HOLD,
    PIN,
    QUICK,
    SLIDING,
    SWIFT,
    VELOCITY,
    Dynamics,
    _of_all,
    complete_dynamics,
)
from artipg_dsl.runtime.tables import JointTable
from artipg_dsl.validity.mass import Mass


def one(
    kind: str, axis: list[float], mass: float = 2.0, lifted: float = 0.0, thrust: float = 0.0, **given: float
) -> Dynamics:
    """A rod of 2 kg, 0.6 m long along x, held at its end by one joint; at rest it stands ``lifted`` (radians) out of the level."""
    nan = np.full(1, np.nan)
    plain = {
        "low": 0.0,
        "high": 1.0,
        "rest": 0.5,
        "mimic": -1,
        "multiplier": 1.0,
        "pitch": np.nan,
        "parent": 0,
        "child": 1,
    }
    fields = {name: np.array([value]) for name, value in (plain | given).items()}
    table = JointTable(
        owner=np.zeros(1, int),
        number=np.zeros(1, int),
        name=["joint"],
        definition=np.zeros(1, int),
        offset=np.zeros(1),
        kind=[kind],
        origin=np.zeros((1, 3)),
        axis=np.array([axis]),
        **({name: nan for name in ("damping", "friction", "stiffness", "effort", "velocity", "positions")} | fields),
    )
    inertia = np.array([np.eye(3), mass * np.diag([5e-7, 0.03, 0.03])])
    turn = np.array([[np.cos(lifted), 0, -np.sin(lifted)], [0, 1, 0], [np.sin(lifted), 0, np.cos(lifted)]])
    pose = np.stack([np.eye(3), turn]), np.zeros((2, 3))
    links = Mass(np.array([5.0, mass]), np.array([[0.0, 0, 0], [0.3, 0, 0]]), inertia)
    together = np.zeros(1, int), np.ones(1)
    return complete_dynamics(table, table.rest, np.zeros(1, int), links, pose, together, np.array([thrust]))


def test_a_hinge_that_gravity_pulls_off_its_rest_holds_itself() -> None:
    found = one("revolute", [0.0, -1.0, 0.0], high=2.0)
    assert found.friction[0] == pytest.approx(HOLD * 2.0 * GRAVITY * 0.3)
    about = 0.06 + 2.0 * 0.3**2
    assert found.damping[0] == pytest.approx(about / FADE["revolute"])
    assert found.velocity[0] == VELOCITY["revolute"]
    taken = found.friction[0] + 2.0 * GRAVITY * 0.3
    assert found.effort[0] == pytest.approx(taken + HAND * 0.6, rel=0.01)


def test_the_load_is_the_most_over_the_range() -> None:
    """A rod that leans back by sixty to eighty degrees need not be held as one that comes down to the level."""
    steep = one("revolute", [0.0, -1.0, 0.0], lifted=np.radians(70), low=-0.1745, high=0.1745, rest=0.0)
    assert steep.friction[0] == pytest.approx(HOLD * 2.0 * GRAVITY * 0.3 * np.cos(np.radians(60)), rel=1e-3)
    far = one("revolute", [0.0, -1.0, 0.0], lifted=np.radians(70), low=-2.0, high=2.0, rest=0.0)
    assert far.friction[0] == pytest.approx(HOLD * 2.0 * GRAVITY * 0.3)


def test_a_limit_that_gravity_presses_against_holds_without_friction() -> None:
    held = one("revolute", [0.0, -1.0, 0.0], rest=0.0)  # opens upwards: its weight closes it
    assert held.friction[0] == pytest.approx(PIN * 2.0 * GRAVITY)
    fallen = one("revolute", [0.0, 1.0, 0.0], rest=0.0)  # opens downwards
    assert fallen.friction[0] == pytest.approx(HOLD * 2.0 * GRAVITY * 0.3)


def test_a_floor_that_spreads_a_hinge_is_held_against_unless_a_limit_does() -> None:
    weight = 2.0 * GRAVITY * 0.3
    spread = one(
        "revolute", [0.0, -1.0, 0.0], rest=0.0, thrust=3.0 * weight
    )  # its weight alone presses it on its limit
    assert spread.friction[0] == pytest.approx(HOLD * 2.0 * weight)
    assert spread.effort[0] > spread.friction[0]
    limited = one("revolute", [0.0, -1.0, 0.0], low=-1.0, high=0.0, rest=0.0, thrust=3.0 * weight)
    assert limited.friction[0] == pytest.approx(HOLD * weight)  # lifted off the floor it hangs


def test_what_gravity_does_not_move_only_rubs() -> None:
    assert one("revolute", [0.0, 0.0, 1.0]).friction[0] == pytest.approx(PIN * 2.0 * GRAVITY)
    assert one("prismatic", [1.0, 0.0, 0.0]).friction[0] == pytest.approx(SLIDING * 2.0 * GRAVITY)
    assert one("prismatic", [0.0, 0.0, 1.0]).friction[0] == pytest.approx(HOLD * 2.0 * GRAVITY)


def test_a_leaf_is_moved_by_a_hand_at_its_edge() -> None:
    assert one("revolute", [0.0, 0.0, 1.0], high=2.0).effort[0] == pytest.approx(
        HAND * 0.6 + PIN * 2.0 * GRAVITY, rel=0.01
    )
    assert one("prismatic", [1.0, 0.0, 0.0]).effort[0] == pytest.approx(HAND + SLIDING * 2.0 * GRAVITY)


def test_a_key_is_not_moved_by_a_hand_s_whole_force() -> None:
    """Under 50 N a gram would be over its millimetre and back before a simulator looks at it again."""
    key = one("prismatic", [1.0, 0.0, 0.0], mass=0.001, low=0.0, high=0.001, rest=0.0)
    assert 0.5 * (key.effort[0] - key.friction[0]) / (0.001 + key.armature[0]) * QUICK**2 == pytest.approx(0.001)
    assert key.effort[0] < 2e-3
    wide = one("prismatic", [1.0, 0.0, 0.0], mass=0.001, low=0.0, high=0.1, rest=0.0)
    assert 0.5 * (wide.effort[0] - wide.friction[0]) / (0.001 + FINGER) * QUICK**2 == pytest.approx(0.1)
    assert wide.armature[0] == pytest.approx(FINGER)


def test_what_overcomes_much_friction_is_slowed_by_an_armature() -> None:
    stiff = one("prismatic", [1.0, 0.0, 0.0], mass=0.001, low=0.0, high=0.01, rest=0.0, friction=1.0)
    net = stiff.effort[0] - stiff.friction[0]
    assert 0.5 * net / (0.001 + stiff.armature[0]) * QUICK**2 == pytest.approx(0.01)


def test_a_stated_effort_makes_a_button_no_heavier_than_a_simulator_needs() -> None:
    button = one("prismatic", [1.0, 0.0, 0.0], mass=0.001, low=0.0, high=0.005, rest=0.0, effort=20.0)
    net = button.effort[0] - button.friction[0]
    assert button.effort[0] == 20.0 and 0.5 * net / (0.001 + button.armature[0]) * SWIFT**2 == pytest.approx(0.005)
    assert button.armature[0] < 6.0


def test_what_moves_together_is_felt_by_each() -> None:
    """Of a leader and a follower twice as fast, each is given what moves both."""
    value, leader, ratio = np.array([1.0, 3.0, 5.0]), np.array([0, 0, 2]), np.array([1.0, -2.0, 1.0])
    assert _of_all(value, leader, ratio, 1) == pytest.approx([1 + 6, 3.5, 5])
    assert _of_all(value, leader, ratio, 2) == pytest.approx([1 + 12, 13 / 4, 5])


def test_what_the_text_gives_stays_and_effort_overcomes_it() -> None:
    found = one("prismatic", [1.0, 0.0, 0.0], friction=200.0, damping=3.0, velocity=0.2)
    assert (found.friction[0], found.damping[0], found.velocity[0]) == (200.0, 3.0, 0.2)
    assert found.effort[0] == pytest.approx(300.0)  # half as much again: more than a hand's push
    assert one("revolute", [0.0, -1.0, 0.0], effort=7.0).effort[0] == 7.0


def test_a_spring_asks_for_effort_and_lets_a_joint_return_without_swinging() -> None:
    plain, sprung = (one("revolute", [0.0, -1.0, 0.0], high=1.2, low=-0.3, stiffness=k) for k in (np.nan, 80.0))
    inertia = 0.06 + 2.0 * 0.3**2
    assert plain.friction[0] == sprung.friction[0]
    assert sprung.armature[0] == 0.0 and sprung.damping[0] == pytest.approx(2.0 * np.sqrt(80.0 * inertia))
    most = 80.0 * 0.8  # from 0.5 to -0.3
    assert sprung.effort[0] == pytest.approx(1.5 * (most + (1.0 + HOLD) * 2.0 * GRAVITY * 0.3))


def test_a_light_key_on_a_stiff_spring_does_not_return_at_once() -> None:
    """Also where its effort is stated, and far less than the spring takes."""
    for effort in (np.nan, 0.5):
        found = one(
            "prismatic", [1.0, 0.0, 0.0], mass=1e-3, low=0.0, high=1e-3, rest=0.0, stiffness=2000.0, effort=effort
        )
        moved = 1e-3 + found.armature[0]
        assert np.pi / 2 * np.sqrt(moved / 2000.0) >= SWIFT * (1 - 1e-9)
        assert found.damping[0] == pytest.approx(2.0 * np.sqrt(2000.0 * moved))
