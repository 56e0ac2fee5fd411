"""Friction, damping, effort and velocity where a text gives none: what gravity and a hand ask for."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from artipg_dsl.export.dynamics import FADE, GRAVITY, HAND, HOLD, PIN, SLIDING, VELOCITY, Dynamics, dynamics


def one(kind: str, axis: list[float], **given: float) -> Dynamics:
    """A rod of 2 kg, 0.6 m long along x, held at its end by one joint."""
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
    table = SimpleNamespace(
        owner=np.zeros(1, int), number=np.zeros(1, int), kind=[kind], origin=np.zeros((1, 3)), axis=np.array([axis]),
        **({name: nan for name in ("damping", "friction", "effort", "velocity")} | fields),
    )  # fmt: skip
    inertia = np.array([np.eye(3), np.diag([1e-6, 0.06, 0.06])])
    pose = np.tile(np.eye(3), (2, 1, 1)), np.zeros((2, 3))
    center = np.array([[0.0, 0, 0], [0.3, 0, 0]])
    return dynamics(table, table.rest, np.zeros(1, int), np.array([5.0, 2.0]), center, inertia, pose)


def test_a_hinge_that_gravity_pulls_off_its_rest_holds_itself() -> None:
    found = one("revolute", [0.0, -1.0, 0.0])
    assert found.friction[0] == pytest.approx(HOLD * 2.0 * GRAVITY * 0.3)
    about = 0.06 + 2.0 * 0.3**2
    assert found.damping[0] == pytest.approx(about / FADE["revolute"])
    assert found.velocity[0] == VELOCITY["revolute"]
    taken = found.friction[0] + 2.0 * GRAVITY * 0.3
    assert found.effort[0] == pytest.approx(max(HAND * np.sqrt(3 * about / 2.0), 2 * taken))


def test_a_limit_that_gravity_presses_against_holds_without_friction() -> None:
    held = one("revolute", [0.0, -1.0, 0.0], rest=0.0)  # opens upwards: its weight closes it
    assert held.friction[0] == pytest.approx(PIN * 2.0 * GRAVITY)
    fallen = one("revolute", [0.0, 1.0, 0.0], rest=0.0)  # opens downwards
    assert fallen.friction[0] == pytest.approx(HOLD * 2.0 * GRAVITY * 0.3)


def test_what_gravity_does_not_move_only_rubs() -> None:
    assert one("revolute", [0.0, 0.0, 1.0]).friction[0] == pytest.approx(PIN * 2.0 * GRAVITY)
    assert one("prismatic", [1.0, 0.0, 0.0]).friction[0] == pytest.approx(SLIDING * 2.0 * GRAVITY)
    assert one("prismatic", [0.0, 0.0, 1.0]).friction[0] == pytest.approx(HOLD * 2.0 * GRAVITY)


def test_a_leaf_is_moved_by_a_hand_at_its_edge() -> None:
    assert one("revolute", [0.0, 0.0, 1.0]).effort[0] == pytest.approx(HAND * 0.6, rel=0.01)
    assert one("prismatic", [1.0, 0.0, 0.0]).effort[0] == HAND


def test_what_the_text_gives_stays_and_effort_overcomes_it() -> None:
    found = one("prismatic", [1.0, 0.0, 0.0], friction=200.0, damping=3.0, velocity=0.2)
    assert (found.friction[0], found.damping[0], found.velocity[0]) == (200.0, 3.0, 0.2)
    assert found.effort[0] == pytest.approx(400.0)
    assert one("revolute", [0.0, -1.0, 0.0], effort=7.0).effort[0] == 7.0
