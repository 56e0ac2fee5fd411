"""Members are what the checker found them to be: declared by the author, or part of the language."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.session import Session

CATEGORY = """apg 1
use primitives { Cuboid }
template Unit {
  param up : length = 3cm
  param size : length[3] = [2cm, 4cm, 6cm]
  part block : Cuboid(size = size)
}
category Shelf {
  root part body : Cuboid(size = [40cm, 60cm, 2cm])
  let middle(a) = a.center
  part unit : Unit along x
  connect unit.bottom on body.top at center
  repeat row[i] in 0 ..< 2 spread body along y { param gap : length = 5cm }
  repeat post[i] in 0 ..< 2 split body along y {
    part stud : Cuboid(size = [1cm, 1cm, 4cm])
    connect stud.bottom on body.top at x = post.center.x, y = post.center.y
  }
  part found : Cuboid(size = [EXPR, 1cm, 1cm])
  connect found.top on body.bottom at center
}
"""

MEMBERS = {
    "unit.up": 0.03,
    "unit.size.z": 0.06,  # what it declares, in its own frame
    "unit.front.center.x - unit.back.center.x": 0.06,
    "row[0].gap": 0.05,
    "middle(post[1].stud).y - middle(post[0].stud).y": 0.3,
    "middle(body.front).x": 0.2,
    "lowest(post[1].stud, y)": 0.155,
}


@pytest.mark.parametrize("text", MEMBERS)
def test_member(text: str) -> None:
    session = Session.of_text(CATEGORY.replace("EXPR", text))
    assert session.report.diagnostics == ()
    batch = session.sampler.batch(np.arange(1), seed=1)
    found = next(site for site in batch.sites() if site.path == "found")
    assert found.params["size.x"] == pytest.approx(MEMBERS[text])


CURVES = {
    "named": "curve edge = circle(r)\n  solid = extrude(edge) along z from 0 to r",
    "let": "let edge = rectangle(r, height = 2 * r)\n  solid = extrude(edge) along z from 0 to r",
    "moved": "curve edge (v in 0 .. 1) = [r, v * r]\n  curve inner = offset(edge, -1mm)\n  solid = lathe(edge, inner) about z",
}


@pytest.mark.parametrize("text", CURVES.values(), ids=CURVES)
def test_curves_with_names(text: str) -> None:
    head = "apg 1\nprimitive Bar {\n  param r : length > 0  test 1cm .. 5cm\n  " + text + "\n}\n"
    session = Session.of_text(head + "category Pole {\n  root part pole : Bar(r = 2cm)\n}\n")
    assert session.lowering is not None, session.report.diagnostics


def test_what_a_part_of_two_branches_is() -> None:
    text = """apg 1
use primitives { Cuboid, Cylinder }
category Stand {
  root part body : Cuboid(size = [40cm, 60cm, 2cm])
  count k in 1 .. 4
  when k > 2 { part leg : Cuboid(size = [1cm, 1cm, 4cm])  connect leg.top on body.bottom at center }
  else { part leg : Cylinder(radius = 1cm, height = 4cm)  connect leg.top on body.bottom at center }
  part found : Cuboid(size = [2cm if leg is Cylinder else 1cm, 1cm, 1cm])
  connect found.bottom on body.top at center
}
"""
    batch = Session.of_text(text).sampler.batch(np.arange(16), seed=1)
    found = next(site for site in batch.sites() if site.path == "found")
    round_legs = next(site for site in batch.sites() if site.primitive.name == "Cylinder").owner
    assert 0 < len(round_legs) < 16
    assert set(np.flatnonzero(found.params["size.x"] > 0.015)) == set(round_legs)


def test_a_port_of_a_primitive_is_a_value_in_it() -> None:
    text = """apg 1
primitive Post {
  param h : length > 0  test 1cm .. 2cm
  curve edge (v in 0 .. 1) = [tip.origin.z / 4, h * v]
  solid = lathe(edge) about z
  port tip : frame = frame(at = [0, 0, h], out = z, up = x)
}
category Stand { root part post : Post(h = 2cm) }
"""
    program = Session.of_text(text).sampler.program
    (site,) = program.sites
    assert [program.parts[site.part].high[k].constant for k in range(3)] == [0.005, 0.005, 0.02]


CLASH = """apg 1
use primitives   { Cuboid }
use vocabularies { semantic }
role Cover { inherit size : length[3] }
template Thick : Cover {
  param pad : length in 1cm .. 2cm
  part body : Cuboid(size = size)
}
template Padded : Cover {
  part body : Cuboid(size = size - [0, 0, 1cm])
  part pad : Cuboid(size = [size.x, size.y, 1cm])
  align body.bottom = bottom
  align pad.top = top
}
template Offset : Cover {
  param pad : length[3] = [1cm, 2cm, 3cm]
  part body : Cuboid(size = size)
}
category Chest {
  root part base : Cuboid(size = [20cm, 20cm, 10cm])
  part cover : Cover(size = [5cm, 5cm, 5cm]) = Thick | Padded | Offset
  connect cover.bottom on base.top
  part found : Cuboid(size = [4cm, 1cm, 1cm])
  connect found to base
  align found.top = base.bottom
  align found.center.x = base.center.x
  when cover is Thick { align found.left = base.left + cover.pad }
  when cover is Padded {
    label semantic.lid on cover.pad
    align found.left = base.left + cover.pad.size.z
  }
  when cover is Offset { align found.left = base.left + cover.pad.y }
}
"""


def test_one_name_for_different_things_of_alternatives() -> None:
    session = Session.of_text(CLASH)
    batch = session.sampler.batch(np.arange(48), seed=1)
    found = next(site for site in batch.sites() if site.path == "found")
    label = next(label for label in session.sampler.program.labels if label.name == "lid")
    assert {batch.sites()[target.site].path for target in label.targets} == {"cover.pad"}
    drawn = [batch.drawn(k) for k in range(48)]
    pads = [{"Thick": one.get("cover.pad"), "Padded": 0.01, "Offset": 0.02}[one["cover"]] for one in drawn]
    assert {one["cover"] for one in drawn} == {"Thick", "Padded", "Offset"}
    np.testing.assert_allclose(found.translation[:, 1], 0.095 + np.array(pads))


HANDED = """apg 1
use primitives { Cuboid }
role Back { inherit size : length[3] }
template Oval : Back { param lean : length in 1cm .. 2cm  part leaf : Cuboid(size = size) }
template Round : Back { let lean = [1cm, 2cm, 3cm]  part leaf : Cuboid(size = size) }
template Knob { let lean = 3mm  part ball : Cuboid(size = [1cm, 1cm, 1cm]) }
category Chair {
  let twice(b) = 2 * b.lean
  root part seat : Cuboid(size = [40cm, 40cm, 4cm])
  part back : Back(size = [4cm, 40cm, 40cm]) = Oval | Round
  connect back.bottom on seat.top
  part knob : Knob
  connect knob.top on seat.bottom at center
  part first : Cuboid(size = [twice(knob), 1cm, 1cm])
  connect first.right on seat.left
  when back is Oval {
    part second : Cuboid(size = [twice(back), 1cm, 1cm])
    connect second.left on seat.right
  }
}
"""


def test_a_function_of_a_part_whose_other_alternatives_have_something_else() -> None:
    batch = Session.of_text(HANDED).sampler.batch(np.arange(16), seed=1)
    sizes = {site.path: site for site in batch.sites()}
    assert (sizes["first"].params["size.x"] == 0.006).all()
    second = sizes["second"]
    leans = [batch.drawn(k).get("back.lean") for k in second.owner.tolist()]
    assert 0 < len(second.owner) < 16
    np.testing.assert_allclose(second.params["size.x"], 2 * np.array(leans))
