"""Closed loops: a four-bar linkage against its closed form, a folding rack over its whole motion."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.runtime.loops import APART
from artipg_dsl.session import Session
from artipg_dsl.source import Source
from artipg_dsl.validity.evidence import random_states
from artipg_dsl.validity.faults import find_faults

# a slider crank: crank of 3 cm about the origin, rod of 10 cm, a block that slides along x
CRANK = """apg 1
use primitives { Cuboid }
category Crank {
  root part frame_block : Cuboid(size = [2cm, 2cm, 2cm])
  part crank : Cuboid(size = [3cm, 5mm, 5mm])
  joint turn : revolute frame_block -> crank about line(at = [0, 2cm, 0], along = -y) range 0deg .. 300deg
  align crank.back = 0
  align crank.center.y = 2cm
  align crank.center.z = 0
  part rod : Cuboid(size = [10cm, 5mm, 5mm])
  joint knee : revolute crank -> rod about line(at = [3cm, 3cm, 0], along = -y) range -400deg .. 400deg
  align rod.back = 3cm
  align rod.center.y = 3cm
  align rod.center.z = 0
  part block : Cuboid(size = [1cm, 5mm, 1cm])
  joint slide : prismatic frame_block -> block along x range -20cm .. 20cm
  align block.center = [13cm, 4cm, 0]
  close line(at = rod.front.center, along = y) on line(at = block.center, along = y)
}
"""


def test_a_slider_crank_moves_as_its_formula_says() -> None:
    batch = Session(Source("crank.apg", CRANK), None).sampler.batch(np.arange(4), seed=0)
    joints = batch.joints()
    turn, slide = (np.flatnonzero([n == name for n in joints.name]) for name in ("turn", "slide"))
    for angle in np.linspace(0.0, 5.0, 11):
        states = batch.rest().copy()
        states[turn] = angle
        values = batch.settle(states)
        assert values[turn].tolist() == [angle] * 4  # the first declared drives
        x = 0.03 * np.cos(angle) + np.sqrt(0.10**2 - (0.03 * np.sin(angle)) ** 2)
        np.testing.assert_allclose(values[slide], x - 0.13, atol=1e-9)


def test_an_annotation_tells_what_drives_a_loop_and_where_it_closes() -> None:
    (told,) = annotate(Session(Source("crank.apg", CRANK), None).sampler.batch(np.arange(1), seed=0))
    drives = {joint["name"]: joint["driven_by"] for joint in told["joints"]}
    assert drives == {"turn": None, "knee": "turn", "slide": "turn"}
    (closure,) = told["closures"]
    assert closure["links"] == ["rod", "block"]
    assert closure["point"] == pytest.approx(
        [0.13, closure["point"][1], 0.01]
    )  # the block's middle, lifted to the floor


def test_positions_of_what_a_loop_determines_are_told_to_have_no_effect() -> None:
    text = CRANK.replace("range -20cm .. 20cm", "range -20cm .. 20cm positions 3")
    report = Session(Source("crank.apg", text), None).examine()
    (found,) = [d for d in report.diagnostics if d.code == "unknown-clause"]
    assert "`slide` have no effect" in found.message and "`turn`" in str(found.hint)


def test_a_rack_stays_together_as_it_folds() -> None:
    batch = Session.of("Foldingrack").sampler.batch(np.arange(12), seed=1)
    joints, loops = batch.joints(), batch.loops
    assert loops is not None and loops.follows.any()
    slide = np.flatnonzero([n == "slide" for n in joints.name])
    for share in (0.0, 0.4, 1.0):
        states = batch.rest().copy()
        states[slide] = joints.low[slide] + share * (joints.high[slide] - joints.low[slide])
        assert not len(loops.apart(*batch.pose(states)))
        gap, _ = loops.slopes(batch.settle(states))
        assert np.abs(gap).max() < APART
        values = batch.settle(states)
        assert (values >= joints.low - 1e-6).all() and (values <= joints.high + 1e-6).all()


def test_objects_without_a_loop_need_none_beside_them() -> None:
    some = CRANK.replace(
        "  part crank :", "  param kind : choice driven | bare\n  when kind == driven {\n  part crank :"
    )
    sampler = Session(Source("crank.apg", some[: some.rindex("}")] + "  }\n}\n"), None).sampler
    whole = sampler.batch(np.arange(8), seed=0)
    closed = np.bincount(whole.joints().owner, minlength=8) > 0
    assert closed.any() and not closed.all() and whole.loops is not None
    for number in range(8):
        one = sampler.batch(np.array([number]), seed=0)
        assert (one.loops is not None) == closed[number]
        moved = [b.settle(b.rest() + 0.2) for b in (whole, one)]
        assert moved[0][whole.joints().owner == number].tobytes() == moved[1].tobytes()


def test_the_same_in_any_batch() -> None:
    sampler = Session.of("Foldingrack").sampler
    whole, one = sampler.batch(np.arange(6), seed=1), sampler.batch(np.array([4]), seed=1)
    halfway = [b.settle(b.rest() + 0.5 * (np.nan_to_num(b.joints().high) - b.rest())) for b in (whole, one)]
    assert halfway[0][whole.joints().owner == 4].tobytes() == halfway[1].tobytes()
    for number in range(6):  # an object stops where it has arrived, whatever others still have to do
        anywhere = [b.settle(random_states(b, number)) for b in (whole, one)]
        assert anywhere[0][whole.joints().owner == 4].tobytes() == anywhere[1].tobytes()


@pytest.mark.parametrize(
    ("text", "told", "example"),
    [
        (
            CRANK.replace("block.center, along", "block.center + [0, 0, 30cm], along"),
            "this loop does not close at rest",
            "300.0 mm apart with all joints at 0, in object 0",
        ),
        (
            CRANK.replace("block.center, along", "block.center + [0, 0, 8cm], along"),
            "this loop does not close while turn moves",
            "`turn` at 225.0 deg, in object 0",  # the rod reaches the block up to 221.8 degrees
        ),
        (
            CRANK.replace("-20cm .. 20cm", "-1cm .. 1cm"),
            "the loop takes slide beyond its range while turn moves",
            "`slide` at -60.0 mm where `turn` is at 180.0 deg, in object 0",  # crank and rod in line
        ),
        (
            CRANK.replace("-20cm .. 20cm", "1cm .. 20cm"),
            "the loop takes slide beyond its range at rest",
            "`slide` at 0.0 mm, in object 0",
        ),
    ],
)
@pytest.mark.parametrize("free", ["", "free rod, block\n  free crank, block\n"])
def test_a_loop_that_does_not_close_or_goes_too_far_is_told(text: str, told: str, example: str, free: str) -> None:
    """Whether or not its links may meet."""
    text = text[: text.rindex("}")] + f"  {free}}}\n"
    batch = Session(Source("crank.apg", text), None).sampler.batch(np.arange(2), seed=0, checked=False)
    (found,) = [fault for fault in find_faults(batch).others if told in fault.words]
    assert "crank.apg:" in found.words and found.objects.tolist() == [0, 1]
    assert found.example == example


def test_a_rest_that_a_loop_leaves_no_room_for_is_told_once() -> None:
    """That its range does not contain its rest value follows from it."""
    text = CRANK.replace("-20cm .. 20cm", "1cm .. 20cm")
    batch = Session(Source("crank.apg", text), None).sampler.batch(np.arange(1), seed=0, checked=False)
    told = [fault.what for fault in find_faults(batch).others if "slide" in fault.what]
    assert told == ["the loop takes slide beyond its range at rest"]


def test_a_place_to_close_on_may_be_written_out() -> None:
    """It lies on the link of the parts that its coordinates name."""
    for place in ("block.center + [0, -1cm, 0]", "[block.center.x, 3cm, block.center.z]"):
        text = CRANK[: CRANK.index("  close")] + f"  close rod.front.center on {place}\n}}\n"
        batch = Session(Source("crank.apg", text), None).sampler.batch(np.arange(1), seed=0)
        states = np.where(np.array(batch.joints().name) == "turn", 1.0, batch.rest())
        slide = batch.settle(states)[batch.joints().name.index("slide")]
        np.testing.assert_allclose(
            slide, 0.03 * np.cos(1) + np.sqrt(0.10**2 - (0.03 * np.sin(1)) ** 2) - 0.13, atol=1e-9
        )


def test_what_a_loop_moves_rests_where_that_puts_it() -> None:
    text = CRANK.replace("rod.front.center, along", "rod.front.center + [0, 0, 1mm], along")
    batch = Session(Source("crank.apg", text), None).sampler.batch(np.arange(2), seed=0, checked=False)
    joints = batch.joints()
    assert (joints.rest[joints.name.index("knee")] != 0.0) and batch.loops is not None
    np.testing.assert_array_equal(batch.settle(batch.rest()), batch.rest())
    assert not len(batch.loops.apart(*batch.pose()))


TURNTABLE = """root part plate : Cuboid(size = [20cm, 20cm, 1cm])
  part frame_block : Cuboid(size = [2cm, 2cm, 2cm])
  align frame_block.bottom = plate.top + 1mm
  joint swivel : continuous plate -> frame_block about line(at = plate.center, along = z)"""
SECOND = (
    CRANK[CRANK.index("  part crank") : CRANK.rindex("}")]
    .replace("turn :", "turn_2 :")
    .replace("knee", "knee_2")
    .replace("slide", "slide_2")
    .replace("crank", "crank_2")
    .replace("rod", "rod_2")
    .replace("block :", "block_2 :")
    .replace("-> block ", "-> block_2 ")
    .replace("block.center", "block_2.center")
    .replace("frame_block_2", "frame_block")
)
CARRIAGE = """part carriage : Cuboid(size = [1cm, 5mm, 1cm])
  align carriage.center = [13cm, 6cm, 0]
  joint carry : prismatic frame_block -> carriage along x range 0cm .. 30cm
  part block : Cuboid"""


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            CRANK.replace("root part frame_block : Cuboid(size = [2cm, 2cm, 2cm])", TURNTABLE).replace("-20cm", "-1cm"),
            "the loop takes slide beyond its range while turn moves",
        ),
        (
            CRANK[: CRANK.rindex("}")] + SECOND.replace("-20cm", "-1cm") + "}\n",
            "the loop takes slide_2 beyond its range while turn_2 moves",
        ),
        (
            CRANK.replace("part block : Cuboid", CARRIAGE).replace(
                "slide : prismatic frame_block", "slide : prismatic carriage"
            ),
            "the loop takes slide beyond its range while carry moves",
        ),
    ],
    ids=["on a turntable", "the second of two loops", "the second joint that drives a loop"],
)
def test_every_joint_that_drives_a_loop_is_moved(text: str, told: str) -> None:
    batch = Session(Source("crank.apg", text), None).sampler.batch(np.arange(2), seed=0, checked=False)
    found = [fault for fault in find_faults(batch).others if told in fault.words]
    assert [fault.objects.tolist() for fault in found] == [[0, 1]]


def test_a_joint_below_a_loop_moves_it_as_a_whole() -> None:
    text = CRANK.replace("root part frame_block : Cuboid(size = [2cm, 2cm, 2cm])", TURNTABLE)
    batch, bare = (
        Session(Source("crank.apg", t), None).sampler.batch(np.arange(1), seed=0, checked=False) for t in (text, CRANK)
    )
    names = batch.joints().name
    for angle in (0.4, 2.9):
        states = batch.rest().copy()
        states[names.index("swivel")], states[names.index("turn")] = 1.2, angle
        alone = bare.rest().copy()
        alone[bare.joints().name.index("turn")] = angle
        values, expected = batch.settle(states), bare.settle(alone)
        for name in bare.joints().name:
            assert abs(values[names.index(name)] - expected[bare.joints().name.index(name)]) < 1e-9
        assert values[names.index("swivel")] == 1.2 and batch.loops is not None
        assert not len(batch.loops.apart(*batch.pose(states)))
