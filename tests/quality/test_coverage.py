"""Pair coverage, and what is drawn to no effect."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

from artipg_dsl.quality import asking
from artipg_dsl.quality.coverage import find_together, list_factors, measure_coverage
from artipg_dsl.quality.dead import (
    draw_further,
    find_dead_alternatives,
    find_dead_grasps,
    find_dead_labels,
    find_dead_parameters,
    find_idle_labels,
)
from artipg_dsl.quality.fingerprint import fingerprint_objects
from artipg_dsl.sampling import known

from .programs import CHEST, sampled


def test_all_pairs_of_a_chest_are_seen() -> None:
    sampler, batch = sampled(CHEST)
    found = measure_coverage(sampler, batch)
    assert (found.seen, found.possible, found.missed, found.excluded) == (6, 6, (), ())
    assert found.share == 1.0


def test_what_few_objects_do_not_show_is_missed() -> None:
    sampler, _ = sampled(CHEST)
    found = measure_coverage(sampler, sampler.batch(np.array([3]), 0))
    assert (found.seen, found.possible) == (1, 6) and len(found.missed) == 5 and not found.excluded
    assert found.share == 1 / 6


def test_what_is_given_is_no_choice() -> None:
    sampler, _ = sampled(CHEST)
    given = {k: 1.0 for k, draw in enumerate(sampler.program.draws) if draw.column.name == "lid"}
    batch = sampler.batch(np.arange(40), 0, given=given)
    found = measure_coverage(sampler, batch)
    assert (found.possible, found.excluded) == (0, ()) and found.share == 1.0
    assert not find_dead_alternatives(sampler, batch, lambda: draw_further(sampler, batch))


GUARDED = """
category Guarded {
  count n in 1 .. 3
  root part body : Cuboid(size = [n * 10cm, 10cm, 10cm])
  part top : Cuboid(size = [5cm, 5cm, 5cm]) | Cylinder(radius = 2cm, height = 5cm) when n == 1 | none
  connect top.bottom on body.top
  when top is Cuboid {
    count m in 1 .. 2
    repeat knob[i] in 0 ..< m {
      part bead : Cylinder(radius = 3mm, height = 1cm)
      align bead.bottom = top.top
      align bead.center.x = top.center.x + i * 1cm
      connect bead to top
    }
  }
  require n < 3 or not top  else "so long ones carry nothing"
}
"""


def test_pairs_that_guards_or_requirements_exclude_are_told_from_missed_ones() -> None:
    sampler, batch = sampled(GUARDED, 200)
    found = measure_coverage(sampler, batch)
    excluded = {(p.first, p.one, p.second, p.two) for p in found.excluded}
    assert excluded == {
        ("n", "2", "top", "Cylinder"),
        ("n", "3", "top", "Cylinder"),
        ("n", "3", "top", "Cuboid"),
        ("n", "3", "m", "1"),
        ("n", "3", "m", "2"),
        ("top", "Cylinder", "m", "1"),
        ("top", "Cylinder", "m", "2"),
        ("top", "none", "m", "1"),
        ("top", "none", "m", "2"),
    }
    assert not found.missed and found.seen == found.possible == 6 + 4 + 2


ELEMENTS = """
category Elements {
  root part body : Cuboid(size = [10cm, 50cm, 10cm])
  repeat cell[i] in 0 ..< 2 spread body.box along y margin 10cm {
    part a : Cuboid(size = [2cm, 2cm, 2cm]) | none
    part b : Cuboid(size = [2cm, 2cm, 2cm]) when not a | none when a
    connect a.bottom on body.top at y = cell.center.y
    connect b.bottom on body.top at y = cell.center.y
  }
}
"""


def test_questions_are_put_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Evaluations do not grow with the pairs, the alternatives or the parameters that are tried."""
    made = Counter[str]()
    for module in (asking, known):

        def counted(*given: Any, evaluate: Any = module.make_batch, name: str = module.__name__, **named: Any) -> Any:
            made[name] += 1
            return evaluate(*given, **named)

        monkeypatch.setattr(module, "make_batch", counted)
    sampler, batch = sampled(GUARDED, 3)
    found = measure_coverage(sampler, batch)
    assert len(found.missed) > 2 and len(found.excluded) > 2 and made == {asking.__name__: 2}
    find_dead_alternatives(sampler, batch, lambda: draw_further(sampler, batch))
    assert made == {asking.__name__: 2 + 2}  # all options, and objects that may have the rare ones
    find_dead_parameters(batch, lambda: draw_further(sampler, batch))
    assert made[known.__name__] <= 2 * (1 + 3)  # before, and after each of three steps, of these objects and of others


def test_choices_of_one_element_meet_in_the_element() -> None:
    sampler, batch = sampled(ELEMENTS)
    first, second = list_factors(batch)
    assert find_together(batch, first, second).tolist() == [[False, True], [True, False]]
    found = measure_coverage(sampler, batch)
    assert (found.seen, len(found.missed), len(found.excluded)) == (2, 0, 2)


def test_of_long_counts_thirds_are_told_apart() -> None:
    _, batch = sampled("category Box { count n in 2 .. 30  root part body : Cuboid(size = [n * 1cm, 1cm, 1cm]) }", 5)
    (factor,) = list_factors(batch)
    assert [level.name for level in factor.levels] == ["2..10", "11..20", "21..30"]


DEAD = """
category Dead {
  param width  : length in 10cm .. 20cm
  param unused : length in 10cm .. 20cm
  param stuck  : length in 10cm .. 20cm
  param colour : ratio in 0 .. 1
  param bound  : length in 5cm .. 30cm
  require width <= bound  else "too wide"
  require stuck <= 10cm   else "there is one value"
  count idle in 1 .. 4
  root part body : Cuboid(size = [width, 10cm, 10cm])
  part knob : Cuboid(size = [stuck, 1cm, 1cm]) | none
  connect knob.bottom on body.top
  param reach : angle in 10deg .. 90deg
  part lid : Cuboid(size = [1cm, 1cm, 1cm])
  align lid.bottom = body.top + 10cm
  joint open : revolute body -> lid about lid.back.bottom range 0deg .. reach
  label semantic.body on body where p.x < colour * size.x
}
"""


def test_parameters_without_effect_are_found() -> None:
    sampler, batch = sampled(DEAD)
    assert {dead.name: dead.why for dead in find_dead_parameters(batch, lambda: draw_further(sampler, batch))} == {
        "unused": "changes nothing",
        "idle": "changes nothing",
        "stuck": "has no room to vary",
        "bound": "changes nothing",
    }
    assert all(
        dead.where.startswith("<text>:") for dead in find_dead_parameters(batch, lambda: draw_further(sampler, batch))
    )


def test_a_parameter_of_what_is_never_there_is_never_drawn() -> None:
    text = """
category Never {
  root part body : Cuboid(size = [10cm, 10cm, 10cm])
  part top : Cuboid(size = [_, 5cm, 5cm]) weight 0 | none
  connect top.bottom on body.top
  when top {
    param w : length in 2cm .. 5cm
    align top.front = top.back + w
  }
}"""
    sampler, batch = sampled(text)
    assert [(d.name, d.why) for d in find_dead_parameters(batch, lambda: draw_further(sampler, batch))] == [
        ("w", "is never drawn")
    ]
    assert [
        (d.name, d.option, d.why) for d in find_dead_alternatives(sampler, batch, lambda: draw_further(sampler, batch))
    ] == [("top", "Cuboid", "is never taken")]


def test_what_few_objects_have_is_looked_for_in_others() -> None:
    text = """
template Stud { param w : length in 2cm .. 5cm  part knob : Cuboid(size = [w, w, w])  port foot = knob.bottom }
template Peg  { part knob : Cuboid(size = [1cm, 1cm, 1cm])  port foot = knob.bottom }
category Rare {
  root part body : Cuboid(size = [10cm, 10cm, 10cm])
  part top : Stud | Peg weight 100
  connect top.foot on body.top
}"""
    sampler, batch = sampled(text, 8)
    assert not batch.state.values[next(k for k, d in enumerate(batch.program.draws) if d.column.name == "top.w")].size
    assert not find_dead_parameters(batch, lambda: draw_further(sampler, batch))
    assert not find_dead_alternatives(sampler, batch, lambda: draw_further(sampler, batch))


def test_alternatives_that_cannot_be_told_apart() -> None:
    text = """
role Top { inherit size : length[3] in [1cm, 1cm, 1cm] .. [3cm, 3cm, 3cm]  slot cap }
template Plain : Top { part cap : Cuboid(size = size) }
template Other : Top { part lump : Cuboid(size = size)  slot cap = lump }
template Long  : Top { part cap : Cuboid(size = [size.x, size.y, size.z + 1cm]) }
category Box {
  root part body : Cuboid(size = [10cm, 10cm, 10cm])
  part top : Top = Plain | Other | Long
  connect top.cap.bottom on body.top
}"""
    sampler, batch = sampled(text)
    found = find_dead_alternatives(sampler, batch, lambda: draw_further(sampler, batch))
    assert [(d.name, d.option, d.why) for d in found] == [("top", "Other", "cannot be told from Plain")]


def test_labels_that_hold_nowhere_are_found() -> None:
    text = """
vocabulary act { pull, grasp, turn, push, support }
category Drawer {
  root part body : Cuboid(size = [30cm, 40cm, 2cm])
  part slab : Cuboid(size = [30cm, 40cm, 10cm])
  part knob : Cylinder(radius = 1cm, height = 3cm) along x
  connect knob.bottom to frame(at = slab.front.center, out = x, up = z) sink 1mm
  joint slide : prismatic body.top -> slab.bottom gap 1mm along x range 0cm .. 10cm
  label semantic.drawer on slab, knob
  label semantic.handle on knob
  label act.pull on knob where n.z < 0.5
  label act.grasp on knob where n.z > 0.9
  label act.turn on knob where p.z > size.z
  label act.push on slab where n.z < -0.5 and p.z > 0
  label act.support on slab.front, slab.top where n.z > 0.5
}"""
    _, batch = sampled(text)
    found = [(dead.name, dead.why) for dead in find_dead_labels(batch)]
    assert found == [("act.push", "holds nowhere"), ("act.turn", "holds nowhere")]


@pytest.mark.parametrize(("where", "found"), [("n.x > 0.5", ["act.press"]), ("n.z > 0.5", [])])
def test_what_is_pressed_where_it_would_not_move_is_found(where: str, found: list[str]) -> None:
    """The x of a part that stands along x lies across: the label is on the side of the key."""
    text = f"""
vocabulary act {{ press : along, grasp }}
category Bell {{
  root part body : Cuboid(size = [2cm, 10cm, 10cm])
  part key : Cylinder(radius = 5mm, height = 6mm) along x
  align key.back = body.front + 2mm
  joint go : prismatic body -> key along -x range 0mm .. 1mm
  label semantic.body on body
  label semantic.button on key
  label act.press on key where {where}
  label act.grasp on key where n.x > 0.5
}}"""
    _, batch = sampled(text)
    idle = find_idle_labels(batch)
    assert [dead.name for dead in idle] == found
    assert all("`go` moves along the surface" in dead.why for dead in idle)


def test_a_label_below_deeper_ones_holds_nowhere() -> None:
    text = """
vocabulary act { pull, grasp }
template Handle {
  param size : length[3]
  part bar : Cuboid(size = size)
  label act.grasp on bar
}
category Door {
  root part leaf : Cuboid(size = [2cm, 40cm, 60cm])
  part handle : Handle(size = [3cm, 2cm, 12cm])
  connect handle.back to leaf.front
  label act.pull on handle
}"""
    _, batch = sampled(text)
    assert [dead.name for dead in find_dead_labels(batch)] == ["act.pull"]
    _, batch = sampled(
        text.replace("act.pull on handle", "act.pull on handle.bar").replace("label act.grasp on bar", "")
    )
    assert not find_dead_labels(batch)


def test_a_fingerprint_belongs_to_the_object() -> None:
    sampler, batch = sampled(CHEST)
    together_, alone = fingerprint_objects(batch), fingerprint_objects(sampler.batch(np.array([11, 5]), 0))
    assert alone.tolist() == [together_[11], together_[5]]
    assert len(np.unique(together_)) == 60


GRASPED = """use bodies { OpenBox }
category Grasped {
  param wide : length in 2cm .. 4cm
  root part body : OpenBox(size = [20cm, 20cm, 20cm], wall = 1cm)
  part door : Cuboid(size = [1cm, 20cm, 20cm])
  align door.back = body.front + 1mm
  joint open : revolute body -> door about door.left.back range 0deg .. 110deg
  part peg : Cuboid(size = [3cm, wide, 3cm])
  connect peg.bottom on body.top
  part core : Cuboid(size = [3cm, wide, 3cm])
  connect core.back on body.inner.back
  grasp hold on peg { at [0, 0, 0]  approach -z  close y  opening size.y + 1mm }
  grasp take on core { at [0, 0, 0]  approach -x  close y  opening size.y + 1mm }
  grasp beside on peg { at [0, 0, 9cm]  approach -z  close y  opening size.y + 1mm }
  grasp below on peg { at [0, 0, 0]  approach z  close y  opening size.y + 1mm }
  grasp far on body { at [0, 0, size.z / 2]  approach -z  close y  opening size.y }
}
"""


def test_grasps_that_no_hand_makes_are_told_with_what_is_in_the_way() -> None:
    _, batch = sampled(GRASPED)
    assert [(dead.name, dead.why.partition(": ")[2]) for dead in find_dead_grasps(batch)] == [
        ("below", "something is in the way of fingers or palm (48 objects)"),
        ("beside", "nothing is between the fingers (48 objects)"),
        ("far", "it opens wider than the gripper (48 objects)"),
    ]
