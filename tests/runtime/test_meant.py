"""Of which parts a statement in a repeat speaks: those of the same elements, each with the distance of its element."""

import numpy as np
import pytest

from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session
from artipg_dsl.validity.faults import Faults, find_faults

HEAD = "apg 1\nuse primitives { Cuboid }\ncategory Case {\n  root part body : Cuboid(size = [1m, 1m, 2cm])\n"
# `one` of an element is 4 cm from `two` of the element before it, and far from its own
PAIRS = """
  repeat cell[k] in 0 ..< 2 split body along y {
    part one : Cuboid(size = [10cm, 2cm, 10cm])
    align one.bottom = body.top + 1mm
    align one.center.x = 0
    align one.center.y = cell.right + 3cm
    joint slide : prismatic body -> one along x range 0 .. 10cm
    part two : Cuboid(size = [10cm, 2cm, 10cm])
    align two.bottom = body.top + 1mm
    align two.center.x = 0
    align two.center.y = cell.left - 3cm
    joint run : prismatic body -> two along x range 0 .. 10cm
    clear one from two by DISTANCE
  }
"""
# 1 cm above the body, each element
ABOVE = """
  repeat cell[k] in 0 ..< 2 split body along y {
    part one : Cuboid(size = [10cm, 2cm, 10cm])
    align one.bottom = body.top + 1cm
    align one.center.x = 0
    align one.center.y = cell.center.y
    joint slide : prismatic body -> one along x range 0 .. 10cm
    let distance = DISTANCE
    clear one from body by distance
  }
"""
# `one` stands in the wall of its own cell, or in that of the other
ROOMS = """
  repeat cell[k] in 0 ..< 2 split body along y {
    part wall : Cuboid(size = [60cm, 2cm, 20cm])
    align wall.bottom = body.top + 1mm
    align wall.center.x = 0
    align wall.center.y = cell.right
    joint shift : prismatic body -> wall along x range 0 .. 1cm
    repeat room[j] in 0 ..< 2 split cell along x {
      part one : Cuboid(size = [10cm, 2cm, 10cm])
      align one.bottom = body.top + 1cm
      align one.center.x = room.center.x
      align one.center.y = PLACE
      joint slide : prismatic body -> one along x range 0 .. 10cm
      STATEMENT
    }
  }
"""


def faults(text: str, **parts: str) -> Faults:
    for name, part in parts.items():
        text = text.replace(name, part)
    sampler: Sampler = Session.of_text(HEAD + text + "}\n").sampler
    return find_faults(sampler.batch(np.arange(1), 0))


@pytest.mark.parametrize(("distance", "wrong"), [("10cm", 0), ("10cm all", 0), ("60cm", 3), ("60cm all", 4)])
def test_clear_compares_parts_of_the_same_element(distance: str, wrong: int) -> None:
    """Two of one element are 42 cm apart. With `all` the several joints together are told, too."""
    assert len(faults(PAIRS, DISTANCE=distance).others) == wrong


@pytest.mark.parametrize("other", ["one from body", "body from one"])
@pytest.mark.parametrize("every", ["", " all"])
@pytest.mark.parametrize(("distance", "wrong"), [("9mm", 0), ("1mm + 10mm * k", 2), ("11mm - 10mm * k", 2)])
def test_each_element_keeps_its_own_distance(other: str, every: str, distance: str, wrong: int) -> None:
    """Whichever of the elements has the larger one, at rest and while it slides."""
    text = ABOVE.replace("one from body by distance", f"{other} by distance{every}")
    assert len(faults(text, DISTANCE=distance).others) == wrong


def test_an_element_that_may_come_near_is_not_asked_for_the_distance_of_another() -> None:
    text = ABOVE.replace("body.top + 1cm", "body.top + 1cm + 9mm * (1 - k)")
    assert faults(text, DISTANCE="9mm + 9mm * (1 - k)").others == ()


@pytest.mark.parametrize("place", ["cell.right", "cell.left - 1cm"])
def test_a_repeat_in_a_repeat_means_the_elements_of_both(place: str) -> None:
    """What is allowed or asked for in a room is so with the wall of its cell, not with that of another."""
    own = place == "cell.right"
    assert len(faults(ROOMS, PLACE=place, STATEMENT="").collisions)
    for word in ("allow overlap one, wall", "free one, wall"):
        assert bool(len(faults(ROOMS, PLACE=place, STATEMENT=f'{word} because "so"').collisions)) != own
    near = [fault.words for fault in faults(ROOMS, PLACE=place, STATEMENT="clear one from wall by 5cm").others]
    assert bool(near) == own


@pytest.mark.parametrize("waits", ["", "when open > 80deg"])
@pytest.mark.parametrize("allowed", ["", 'allow overlap rack, body because "it runs in a groove"'])
def test_parts_of_links_that_may_overlap_keep_their_distance(waits: str, allowed: str) -> None:
    """Also while a joint moves that waits for another."""
    text = f"""
      part post : Cuboid(size = [2cm, 2cm, 30cm])
      align post.bottom = body.top
      align post.center.x = 48cm
      align post.center.y = 0
      connect post to body
      part door : Cuboid(size = [2cm, 20cm, 20cm])
      align door.bottom = body.top + 1mm
      align door.back = body.front + 1mm
      align door.center.y = -20cm
      joint open : revolute body -> door about door.right.back range 0deg .. 100deg
      part rack : Cuboid(size = [10cm, 10cm, 2cm])
      align rack.bottom = body.top + 1mm
      align rack.center.x = 20cm
      align rack.center.y = 8cm
      joint slide : prismatic body -> rack along x range 0 .. 30cm {waits}
      clear rack from post by 5cm
      {allowed}
    """
    (fault,) = faults(text).others
    assert fault.words.endswith("does not hold while slide moves")


# a peg of each of two units side by side, 1 mm apart; whatever the repeat in the unit is called
UNITS = """apg 1
use primitives { Cuboid }
template Unit {
  part bar : Cuboid(size = [2cm, 4cm, 1cm])
  repeat INNER[j] in 0 ..< 2 {
    part peg : Cuboid(size = [1cm, 1cm, 1cm])
    joint up : prismatic bar -> peg along z range 0 .. 1mm
    align peg.bottom = bar.top + 1mm
    align peg.center.y = -15mm + j * 3cm
  }
}
category Case {
  root part body : Cuboid(size = [1m, 1m, 2cm])
  repeat row[i] in 0 ..< 2 {
    part unit : Unit
    joint pull : prismatic body -> unit along x range 0 .. 1cm
    align unit.bottom = body.top + 1mm
    align unit.center.y = i * 41mm
  }
  clear row[0].unit.FIRST from row[1].unit.SECOND by 2mm
}
"""


@pytest.mark.parametrize("inner", ["hole", "row"])
@pytest.mark.parametrize(
    ("first", "second", "faulty"),
    [
        ("[1].peg", "[0].peg", True),
        ("[0].peg", "[last].peg", False),
        (".peg", ".peg", True),
        ("[0].peg", ".peg", False),
    ],
)
def test_a_number_is_of_the_repeat_that_it_stands_behind(inner: str, first: str, second: str, faulty: bool) -> None:
    text = UNITS.replace("INNER", inner).replace("FIRST", inner + first).replace("SECOND", inner + second)
    batch = Session.of_text(text).sampler.batch(np.arange(1), seed=1)
    assert any("clear" in fault.words for fault in find_faults(batch).others) is faulty
