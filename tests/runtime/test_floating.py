"""Parts that nothing holds, solids without thickness, ranges that are none: small programs whose answer is plain."""

from dataclasses import replace

import numpy as np
import pytest

from artipg_dsl.api import load
from artipg_dsl.errors import UserError
from artipg_dsl.graph import expr as E
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.run.counts import explain_exhausted
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.sampling.statistics import Exhausted, Statistics
from artipg_dsl.session import Session
from artipg_dsl.validity.faults import find_faults
from artipg_dsl.validity.mass import Weighing, find_crossed, find_weightless
from artipg_dsl.validity.neighbours import find_neighbours

HEAD = "apg 1\nuse primitives { Cuboid, Cylinder, RoundedCuboid }\ncategory Case {\n"
BODY = "root part body : Cuboid(size = [20cm, 20cm, 20cm])\n"


def program(body: str) -> Sampler:
    return Session.of_text(HEAD + body + "\n}\n").sampler


def found(body: str) -> list[str]:
    return [fault.words for fault in find_faults(program(body).batch(np.arange(1), 0)).others]


SHELF = (
    BODY
    + """
  part shelf : Cuboid(size = [20cm, 20cm, 1cm])
  connect shelf to body
  align shelf.bottom = body.top + {gap}
"""
)


@pytest.mark.parametrize(
    ("gap", "floats"), [("0mm", False), ("0.09mm", False), ("0.12mm", True), ("-1cm", False), ("5cm", True)]
)
def test_a_part_above_what_it_is_connected_to(gap: str, floats: bool) -> None:
    assert found(SHELF.format(gap=gap)) == ["`shelf` touches nothing else of its link, that of `body`"] * floats


def test_a_chain_of_contacts_holds_and_an_island_of_two_does_not() -> None:
    text = (
        BODY
        + """
  repeat step[k] in 0 ..< 4 {{
    part block : Cuboid(size = [5cm, 5cm, 5cm])
    connect block to body
    align block.bottom = body.top + {start} + k * 5cm
  }}
"""
    )
    assert found(text.format(start="0mm")) == []
    assert found(text.format(start="1mm")) == ["`step.block` touches nothing else of its link, that of `body`"]


@pytest.mark.parametrize(("sink", "floats"), [("0mm", False), ("-1mm", False), ("2mm", True)])
def test_a_ball_that_touches_in_a_point(sink: str, floats: bool) -> None:
    text = (
        BODY
        + f"""
  part knob : RoundedCuboid(size = [6cm, 6cm, 6cm], radius = 28mm)
  connect knob to body
  align knob.bottom = body.top + {sink}
"""
    )
    assert bool(found(text)) == floats


def test_allow_floating_is_silent_and_survives_compilation() -> None:
    text = SHELF.format(gap="1cm") + 'allow floating shelf because "it hangs on threads"\n'
    sampler = program(text)
    assert not find_faults(sampler.batch(np.arange(1), 0)).others
    again = from_text(to_text(sampler.program))
    assert [(a.kind, a.reason) for a in again.allowed] == [("floating", "it hangs on threads")]


def test_a_first_part_that_may_float_holds_none_of_the_others() -> None:
    """The parts of a link that do hang together are no worse for standing below it in the text."""
    text = (
        BODY
        + """
  part worm : Cuboid(size = [1cm, 1cm, 1cm])
  part grip : Cuboid(size = [9cm, 9cm, 1cm])
  part stem : Cuboid(size = [1cm, 1cm, {stem}])
  joint drive : prismatic body -> grip along z range 0cm .. 1cm
  connect worm to grip
  connect stem to grip
  align grip.bottom = body.top + 5mm
  align worm.bottom = grip.top + 4cm
  align stem.bottom = grip.top + {gap}
  allow floating worm because "its shank is not modelled"
"""
    )
    assert not found(text.format(stem="1cm", gap="0cm"))
    assert "stem" in str(found(text.format(stem="1cm", gap="2cm")))


@pytest.mark.parametrize("axis", range(3))
def test_neighbours_are_all_pairs_of_a_link_whose_boxes_overlap(axis: int) -> None:
    random = np.random.default_rng(axis)
    link = random.integers(0, 4, 120)
    low = random.uniform(-1, 1, (120, 3)) * np.where(np.arange(3) == axis, 1.0, 0.05)
    high, margin = low + random.uniform(0, 0.2, (120, 3)), random.uniform(0, 0.05, 120)
    low[:6], high[:6] = low[6:12], low[6:12]  # without extent, and at the same place
    expected = [
        (i, j)
        for i in np.argsort(link, kind="stable").tolist()
        for j in range(i + 1, 120)
        if link[i] == link[j]
        and (low[i] < high[j] + max(margin[i], margin[j])).all()
        and (low[j] < high[i] + max(margin[i], margin[j])).all()
    ]
    first, second = find_neighbours(link, low, high, margin)
    assert list(zip(first.tolist(), second.tolist(), strict=True)) == expected and len(expected) > 50
    assert all(len(found) == 0 for found in find_neighbours(link[:0], low[:0], high[:0], margin[:0]))


JOINTED = (
    BODY
    + """
  part lid : Cuboid(size = [20cm, 20cm, 1cm])
  align lid.bottom = body.top + {gap}
  align lid.back = body.back
  joint {joint}
"""
)


@pytest.mark.parametrize(
    ("joint", "gap", "floats"),
    [
        ("open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg", "5mm", False),
        ("open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg", "6cm", True),
        ("turn : revolute body -> lid about line(at = body.center, along = z) range 0deg .. 90deg", "6cm", True),
        ("pull : prismatic body -> lid along z range 0cm .. 5cm", "1cm", False),
        ("pull : prismatic body -> lid along z range 0cm .. 5cm", "6cm", True),
        ("pull : prismatic body -> lid along z range -5cm .. 0cm", "6cm", False),
    ],
)
def test_links_must_come_near_what_holds_them(joint: str, gap: str, floats: bool) -> None:
    words = ["nothing holds `lid`: the link that carries it is not within 2 cm"] * floats
    assert found(JOINTED.format(joint=joint, gap=gap)) == words


def test_a_wheel_far_from_its_body_is_held_by_an_axle_that_reaches_both() -> None:
    text = (
        BODY
        + """
  part wheel : Cylinder(radius = 5cm, height = 6cm) along y
  align wheel.right = body.left + {gap}
  joint roll : continuous body -> wheel about line(at = wheel.center, along = y)
"""
    )
    assert found(text.format(gap="15mm")) == []
    assert found(text.format(gap="50mm")) == ["nothing holds `wheel`: the link that carries it is not within 2 cm"]


@pytest.mark.parametrize(("aside", "held"), [("2cm", True), ("6cm", False)])
def test_what_a_loop_ties_to_something_that_is_held(aside: str, held: bool) -> None:
    """A block that slides far above what carries it, at the end of a rod, which a crank on a post moves."""
    text = """
  root part bed : Cuboid(size = [40cm, 8cm, 1cm])
  part post : Cuboid(size = [1cm, 1cm, 12cm])
  connect post.bottom on bed.top
  part crank : Cuboid(size = [3cm, 5mm, 5mm])
  align crank.center = [1.5cm, 1cm, 12cm]
  joint turn : revolute bed -> crank about line(at = [0, 1cm, 12cm], along = y) range -90deg .. 0deg
  part rod : Cuboid(size = [10cm, 5mm, 5mm])
  align rod.center = [8cm, 2cm, 12cm]
  joint knee : revolute crank -> rod about line(at = [3cm, 2cm, 12cm], along = y) range -180deg .. 180deg
  part block : Cuboid(size = [1cm, 5mm, 1cm])
  align block.center = [13cm, {aside} + 1cm, 12cm]
  joint slide : prismatic bed -> block along x range -5cm .. 5cm
  close rod.front.center on block.center - [0, {aside} - 1cm, 0]
"""
    words = (
        []
        if held
        else ["nothing holds `block`: neither the link that carries it nor what `close` ties it to is within 2 cm"]
    )
    assert found(text.format(aside=aside)) == words


def test_a_range_upside_down_is_drawn_again_and_counted_at_its_line() -> None:
    text = "param far : length in 1cm .. 9cm\n" + JOINTED.format(
        joint="pull : prismatic body -> lid along z range 5cm .. far", gap="1mm"
    )
    sampler, statistics = program(text), Statistics()
    batch = sampler.batch(np.arange(40), 0, statistics=statistics)
    assert (batch.values()["far"] >= 0.05).all() and 0 < statistics.first_valid < 40
    (broken,) = statistics.broken
    where = sampler.program.requirements[broken].where
    assert where is not None and where.line == 10


def test_floating_objects_are_drawn_again() -> None:
    sampler = program("param up : length in -5mm .. 5mm\n" + SHELF.format(gap="up"))
    statistics = Statistics()
    batch = sampler.batch(np.arange(30), 0, checked=True, statistics=statistics)
    assert (batch.values()["up"] <= 1.1e-4).all() and 0 < statistics.first_valid < 30
    assert list(statistics.unsound) == ["`shelf` touches nothing else of its link, that of `body`"]


def test_what_to_do_where_a_part_always_floats_is_told() -> None:
    with pytest.raises(Exhausted) as caught:
        (sampler := program(SHELF.format(gap="1cm"))).batch(np.arange(1), 0, checked=True)
    error = explain_exhausted(sampler.program, caught.value, {}, {}, lambda _: 0.0)
    assert str(error.hint).startswith("bring the part to what carries it")


def test_the_same_whatever_else_is_in_the_batch() -> None:
    sampler = program("param up : length in -5mm .. 5mm\n" + SHELF.format(gap="up"))
    (whole,) = find_faults(sampler.batch(np.arange(30), 2)).others
    assert [n for n in range(30) if find_faults(sampler.batch(np.array([n]), 2)).others] == whole.objects.tolist()


HOLLOW = """apg 1
use primitives { Cuboid }
template Shell {
  param there : choice yes | no = yes
  when there == yes { part core : Cuboid(size = [20cm, 20cm, 20cm]) }
}
category Case {
  param there : choice yes | no = yes
  root part body : Shell(there = %s)
}
"""


def test_an_object_without_any_surface_is_drawn_again() -> None:
    batch = Session.of_text(HOLLOW % "there").sampler.batch(np.arange(12), 0, checked=True)
    assert {batch.drawn(k)["there"] for k in range(12)} == {"yes"}
    never = Session.of_text(HOLLOW % "no").sampler
    statistics = Statistics()
    with pytest.raises(Exhausted):
        never.batch(np.arange(2), 0, checked=True, statistics=statistics)
    assert list(statistics.unsound) == ["no part of `Case` has a surface"]


def test_an_object_without_any_surface_that_is_not_checked_is_an_error() -> None:
    for there in ("there", "no"):
        with pytest.raises(UserError, match="surface"):
            load(HOLLOW % there, 8, checked=False).points(16)


def test_an_edited_range_that_does_not_hold_the_rest_value() -> None:
    sampler = program(
        BODY
        + "part b : Cuboid(size = [1cm, 1cm, 1cm])\njoint j : prismatic body.top -> b.bottom at center range 0 .. 5cm"
    )
    (joint,) = sampler.program.joints
    sampler.program.joints[0] = replace(joint, low=E.const(0.02), high=E.const(0.01))
    (fault,) = find_faults(Sampler(sampler.program).batch(np.arange(1), 0)).others
    assert fault.words.endswith("the range of `j` does not contain its rest value")


FIXED = (
    BODY
    + """
  param q : ratio in 0 .. 1
  part b : Cuboid(size = [1cm, 1cm, 1cm])
  joint j : fixed body -> b
  align b.center.x = 0
  align b.center.y = 0
  align b.center.z = {}
"""
)


def test_a_link_that_others_fill_weighs_nothing_and_is_drawn_again() -> None:
    words = "the link `b` has no mass of its own: denser parts fill all of it"
    assert found(FIXED.format("0")) == [words]
    assert found(FIXED.format("10cm")) == []
    assert found(FIXED.replace("fixed body -> b", "prismatic body -> b along x range 0 .. 1mm").format("0")) == []
    counted = Statistics()
    sampler = program(FIXED.format("9cm + q * 2cm"))
    made = sampler.batch(np.arange(12), 0, checked=True, statistics=counted)
    assert counted.unsound[words] > 0
    assert all(not found.others for found in [find_faults(made)])
    alone = [sampler.batch(np.array([k]), 0, checked=True).state.attempt[0] for k in range(12)]
    assert alone == made.state.attempt.tolist()


def test_what_bounds_tell_to_keep_a_mass_is_not_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    safes = Session.of("Safe").sampler.batch(np.arange(12), 0)
    monkeypatch.setattr(Weighing, "masses", lambda *_: pytest.fail("overlaps were measured"))
    assert not safes.joints().that().all() and find_weightless(safes) == []


WASHER = """apg 1
primitive Washer {
  param side, bore : length > 0  test 1cm .. 2cm
  solid = extrude(rectangle(side, side), rectangle(bore / 4, bore / 2)) along z from 0 to 1mm
}
category Ring {
  root part ring : Washer(side = 1.6cm, bore = BORE)
}
"""


@pytest.mark.parametrize(
    ("bore", "wrong"), [("2cm", []), ("3cm", []), ("4cm", ["the surfaces of `ring` cross one another"])]
)
def test_a_hole_that_is_larger_than_what_it_is_in(bore: str, wrong: list[str]) -> None:
    """Beyond the range that a primitive is tested for, each of its solids is asked whether a body can have its moments."""
    batch = Session.of_text(WASHER.replace("BORE", bore)).sampler.batch(np.arange(1), 0)
    assert [fault.words for fault in find_crossed(batch)] == wrong
    assert [fault.words for fault in find_faults(batch).others] == wrong
