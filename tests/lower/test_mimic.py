"""A joint follows another by a factor and an offset, written in any order."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.errors import UserError
from artipg_dsl.session import Session

TEXT = """apg 1
use primitives {{ Cuboid, Cylinder }}
category Dials {{
  param lead : ratio in 2 .. 2
  root part body : Cuboid(size = [20cm, 20cm, 20cm])
  part dial : Cylinder(radius = 2cm, height = 1cm)
  joint turn : revolute body.top -> dial.bottom at center gap 1mm range 0deg .. 90deg
  part hand : Cylinder(radius = 1cm, height = 1cm)
  joint follow : {} body.left -> hand.bottom at center gap 1mm range {} mimic {}
}}
"""
TURN = np.deg2rad(1.0)


@pytest.mark.parametrize(
    ("formula", "multiplier", "offset"),
    [
        ("turn", 1.0, 0.0),
        ("lead * turn", 2.0, 0.0),
        ("-(turn * lead) / 3", -2.0 / 3.0, 0.0),
        ("2 * (lead * turn)", 4.0, 0.0),
        ("turn + 10deg", 1.0, 10.0 * TURN),
        ("20deg - lead * turn", -2.0, 20.0 * TURN),
        ("lead * (turn - 5deg) / 4", 0.5, -2.5 * TURN),
        ("min(lead, 1) * turn", 1.0, 0.0),
    ],
)
def test_angles(formula: str, multiplier: float, offset: float) -> None:
    joints = (
        Session.of_text(TEXT.format("revolute", "-180deg .. 1turn", formula)).sampler.batch(np.arange(2), 1).joints()
    )
    row = joints.name.index("follow")
    np.testing.assert_allclose(joints.multiplier[row], multiplier, rtol=1e-12)
    np.testing.assert_allclose(joints.offset[row], offset, atol=1e-12)


@pytest.mark.parametrize(
    "formula", ["turn * (2cm / 90deg)", "2cm / 90deg * turn", "turn * lead * 1cm / 90deg", "(turn / 90deg) * 2cm"]
)
def test_a_slide_follows_a_hinge(formula: str) -> None:
    batch = Session.of_text(TEXT.format("prismatic", "0 .. 5cm", f"{formula} + 1cm")).sampler.batch(np.arange(2), 1)
    joints = batch.joints()
    rows, leads = (np.flatnonzero(np.array(joints.name) == name) for name in ("follow", "turn"))
    states = np.zeros(len(joints.name))
    states[leads] = np.deg2rad(45.0)
    np.testing.assert_allclose(batch.settle(states)[rows], 0.02, atol=1e-12)


def test_it_rests_where_its_leader_puts_it() -> None:
    text = TEXT.replace("0deg .. 90deg", "0deg .. 90deg rest 30deg").format(
        "revolute", "0deg .. 1turn", "turn * 2 + 10deg"
    )
    joints = Session.of_text(text).sampler.batch(np.arange(2), 1).joints()
    np.testing.assert_allclose(joints.rest, np.deg2rad([30.0, 70.0] * 2), rtol=1e-12)


def test_a_slide_follows_a_crank() -> None:
    formula = "lead * 1cm * sin(turn)"
    batch = Session.of_text(TEXT.format("prismatic", "0 .. 5cm", formula)).sampler.batch(np.arange(3), 1)
    joints = batch.joints()
    rows, leads = (np.flatnonzero(np.array(joints.name) == name) for name in ("follow", "turn"))
    states = np.zeros((4, len(joints.name)))
    states[:, leads] = np.deg2rad([0.0, 20.0, 60.0, 90.0])[:, None]
    np.testing.assert_allclose(batch.settle(states)[:, rows], 0.02 * np.sin(states[:, leads]), atol=1e-15)
    np.testing.assert_allclose(joints.multiplier[rows], 0.02 / np.deg2rad(90.0))  # the straight line between the ends


TILT = np.deg2rad(60.0)


@pytest.mark.parametrize(
    ("formula", "rest"),
    [
        ("2cm * (sin(turn) + turn / 1rad)", 0.02 * (np.sin(TILT) + TILT)),
        ("max(0cm, 2cm * turn / 1rad - 1cm)", 0.02 * TILT - 0.01),
        (
            "turn * (1cm / 1rad) if turn < 50deg else 2cm / 1rad * turn - 50deg * (1cm / 1rad)",
            0.02 * TILT - np.deg2rad(50.0) * 0.01,
        ),
    ],
)
def test_it_rests_where_its_formula_puts_it(formula: str, rest: float) -> None:
    text = TEXT.replace("0deg .. 90deg", "0deg .. 90deg rest 60deg").format("prismatic", "0 .. 6cm", formula)
    joints = Session.of_text(text).sampler.batch(np.arange(1), 1).joints()
    np.testing.assert_allclose(joints.rest[joints.name.index("follow")], rest, rtol=1e-12)


@pytest.mark.parametrize("formula", ["2cm * sin(2 * turn)", "1cm / sin(turn)", "2cm * sqrt(sin(turn) - 0.5)"])
def test_a_formula_that_turns_back_or_is_undefined_is_refused(formula: str) -> None:
    session = Session.of_text(TEXT.format("prismatic", "0 .. 6cm", formula))
    words = "the joint `follow` does not rise or fall throughout the range of `turn`"
    with pytest.raises(UserError, match=words):
        session.sampler.batch(np.arange(2), 1).joints()
    (told,) = [d for d in session.examine().diagnostics if d.severity == "error"]
    assert told.code == "bad-mimic" and words in told.message and told.span is not None
    assert told.span.text == formula
