"""Which grasps a hand can make: a post whose surroundings are known."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.grasps import sample_grasps
from artipg_dsl.annotate.gripper import REASONS, STANDARD, Gripper, find_wide, judge, read_gripper
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.errors import UsageError
from artipg_dsl.session import Session

POST = """
apg 1
use primitives {{ Cuboid, Cylinder }}
category Post {{
  param near : length in {near}mm .. {near}mm
  root part floor : Cuboid(size = [60cm, 60cm, 2cm])
  part post : Cylinder(radius = 15mm, height = 30cm)
  part wall : Cuboid(size = [60cm, 2cm, 30cm])
  connect post.bottom on floor.top
  align post.center.x = floor.center.x
  align post.center.y = floor.center.y
  joint slide : prismatic floor -> wall along y range 0cm .. 20cm
  align wall.bottom = floor.top + 1mm
  align wall.right = post.left + near
  align wall.center.x = floor.center.x
  grasp side on post for t in -0.45 .. 0.45 {{ at [0, 0, t * size.z]  approach -x  close y  opening {opening} }}
}}
"""


def batch(near: float = 80.0, opening: str = "3cm", turn: str = ""):
    return Session.of_text(POST.format(near=near, opening=opening)).sampler.batch(np.arange(2), 1)


def verdicts(of, gripper: Gripper = STANDARD, states: np.ndarray | None = None) -> list[str]:
    found = sample_grasps(of)
    return [REASONS[k] for k in judge(of, found, gripper, states)[: len(found.t) // 2]]


def test_a_free_post_is_grasped_but_for_its_foot() -> None:
    # 13.5 cm below the middle, 1.5 cm above the floor: the palm, 6 cm across, would lie in it
    assert verdicts(batch()) == ["blocked"] + ["reachable"] * 4
    assert verdicts(batch(), Gripper(palm_width=0.02)) == ["reachable"] * 5


def test_an_opening_has_to_fit() -> None:
    assert verdicts(batch(opening="9cm")) == ["wide"] * 5
    assert verdicts(batch(opening="2.8cm")) == ["blocked"] * 5  # the post is 3 cm
    assert verdicts(batch(opening="9cm"), Gripper(stroke=0.1, palm_width=0.02)) == ["reachable"] * 5


def test_a_grasp_may_state_the_hand_it_is_meant_for() -> None:
    stated = batch(opening="9cm  stroke 10cm  palm_width 2cm")
    assert verdicts(stated) == ["reachable"] * 5
    assert verdicts(stated, Gripper(stroke=0.11)) == ["blocked"] + ["reachable"] * 4  # a hand of one's own counts alone
    assert verdicts(stated, Gripper(palm_width=0.02)) == ["wide"] * 5
    by_size = batch(opening="size.y + 1mm  stroke size.y + t * 1cm")
    assert verdicts(by_size) == ["wide"] * 3 + ["reachable"] * 2
    told = annotate(stated)[0]["grasps"][0]
    assert (
        told["gripper"] == {"stroke": 0.1, "palm_width": 0.02} and annotate(batch())[0]["grasps"][0]["gripper"] is None
    )


@pytest.mark.parametrize("near, found", [(9.0, "blocked"), (11.0, "reachable")])
def test_a_finger_is_as_thick_as_it_is(near: float, found: str) -> None:
    assert verdicts(batch(near=near), Gripper(palm=0.04, palm_width=0.02)) == [found] * 5


def test_a_wall_that_has_moved_away_no_longer_hinders() -> None:
    tight = batch(near=5.0)
    assert verdicts(tight) == ["blocked"] * 5
    apart = joint_values(tight, read_states("slide=15cm"))[0]
    assert verdicts(tight, states=apart)[1:] == ["reachable"] * 4


def test_something_has_to_be_held() -> None:
    text = POST.format(near=80, opening="3cm").replace("at [0, 0, t * size.z]", "at [9cm, 0, t * size.z]")
    assert verdicts(Session.of_text(text).sampler.batch(np.arange(2), 1))[1:] == ["empty"] * 4


def test_the_annotation_counts_what_was_dropped() -> None:
    plain = annotate(batch())[1]
    assert [g["reachable"] for g in plain["grasps"]] == [True] * 4
    assert plain["dropped"] == [{"name": "side", "wide": 0, "blocked": 1, "empty": 0}]
    every = annotate(batch(), gripper=None)[1]
    assert len(every["grasps"]) == 5 and every["dropped"] == [] and every["grasps"][0]["reachable"] is None
    tight = batch(near=5.0)
    told = annotate(tight, joint_values(tight, read_states("rest,slide=15cm")))[1]
    assert [g["reachable"] for g in told["grasps"]] == [False] * 4
    assert [[g["reachable"] for g in s["grasps"]] for s in told["states"]] == [[False] * 4, [True] * 4]
    assert told["dropped"][0]["blocked"] == 1


@pytest.mark.parametrize(
    ("opening", "told"),
    [("(3cm + near)", [(0, 0.11, 0.08)]), ("(7cm + (t + 0.45) * 9cm)", []), ("11cm stroke 12cm", [])],
)
def test_a_family_of_which_every_grasp_is_too_wide_is_found(opening: str, told: list[tuple[int, float, float]]) -> None:
    assert [pytest.approx(found) for found in told] == find_wide(sample_grasps(batch(opening=opening)))


def test_an_object_is_judged_the_same_in_any_batch() -> None:
    sampler = Session.of("Chair").sampler
    several, alone = sampler.batch(np.arange(6), 3), sampler.batch(np.array([4]), 3)
    found = sample_grasps(several)
    assert (
        judge(several, found, STANDARD)[found.owner == 4].tolist()
        == judge(alone, sample_grasps(alone), STANDARD).tolist()
    )


def test_measures_are_read_from_text() -> None:
    assert read_gripper("standard") == STANDARD and read_gripper("any") is None
    assert read_gripper("stroke=10cm, width = 15mm") == Gripper(stroke=0.1, width=0.015)
    for text in ("", "stroke=10", "grip=1cm", "stroke=0mm", "stroke=10cm;width=1cm"):
        with pytest.raises(UsageError):
            read_gripper(text)


def test_the_page_lists_the_measures() -> None:
    page = (Path(__file__).parents[2] / "docs" / "labels.md").read_text(encoding="utf-8")
    rows = [
        r.split("|")[1:3]
        for r in page.split("<!-- gripper -->")[1].split("<!-- end -->")[0].splitlines()
        if r.startswith("| `")
    ]
    listed = {name.strip(" `"): float(default.replace("mm", "")) / 1000 for name, default in rows}
    assert listed == asdict(STANDARD)


def test_no_grasp_and_no_keypoint_on_what_is_none() -> None:
    text = POST.format(near=80, opening="3cm").replace(
        "category Post {",
        """role Knob { inherit radius : length = 1cm }
template Ball : Knob { part body : Cylinder(radius = radius, height = 3cm) }
category Post {
  part knob : Knob = Ball | none
  connect knob.bottom on post.top
  when knob {
    align knob.center.x = post.center.x
    align knob.center.y = post.center.y
  }
  grasp top on knob { at [0, 0, 0]  approach -z  close y  opening size.y }
  keypoint middle on knob
""",
    )
    found = annotate(Session.of_text(text).sampler.batch(np.arange(12), 1), gripper=None)
    with_knob = [any(p["path"] == "knob" for p in a["parts"]) for a in found]
    assert 0 < sum(with_knob) < 12
    for there, told in zip(with_knob, found, strict=True):
        assert ("top" in {g["name"] for g in told["grasps"]}) is there
        assert [k["name"] for k in told["keypoints"]] == (["middle"] if there else [])


def test_a_hose_is_held_above_the_taps_wherever_it_has_swung() -> None:
    made = apg.sample("Faucet", n=4, seed=5, set={"spout": "HoseSpout"}).batch
    found = sample_grasps(made)
    hose = np.array(found.name) == "bend_hose"
    assert hose.sum() == 40  # at its root and at its mouth
    for values in joint_values(made, read_states("rest,swivel=80%")):
        assert not judge(made, found, STANDARD, values)[hose].any()


@pytest.mark.parametrize(
    ("category", "families"),
    [
        ("Cart", {"hold_bow", "hold_pole"}),
        ("Clock", {"wind_up"}),
        ("Fan", {"turn_knob", "turn_dial"}),  # the dial of a low fan lies below its guard: one reaches it aslant
        ("Lamp", {"hold_rim"}),  # of shades whose walls lean by up to 30 degrees
        ("Toilet", {"press_lever"}),
    ],
)
def test_what_a_hand_holds_of_shipped_objects_it_reaches_at_rest(category: str, families: set[str]) -> None:
    made = Session.of(category).sampler.batch(np.arange(24), 5)
    grasps = sample_grasps(made)
    verdict = judge(made, grasps, STANDARD, made.settle(made.joints().rest))
    chosen = np.isin(grasps.name, list(families))
    held = set(zip(grasps.owner[chosen], grasps.link[chosen], strict=True))
    reached = chosen & (verdict == 0)
    assert families <= set(grasps.name)
    assert held == set(zip(grasps.owner[reached], grasps.link[reached], strict=True))
