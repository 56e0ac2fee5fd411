"""Which link carries what: ports of alternatives, chains of links in a repeat, elements named from outside, guards."""

from __future__ import annotations

import numpy as np

from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.session import Session
from artipg_dsl.source import Source

TEXT = """apg 1
use primitives { Cuboid }
role Sash { inherit size : length[3]  port hold : frame  slot leaf  joint motion }
template Sided : Sash {
  param hand : choice left_hung | right_hung
  part leaf : Cuboid(size = size)
  when hand == left_hung { joint motion : revolute base -> leaf about leaf.front.left range 0deg .. 90deg }
  else { joint motion : revolute base -> leaf about leaf.front.right range 0deg .. 90deg }
  port hold = frame(at = leaf.front.center, out = x, up = z)
}
template Tilting : Sash {
  part leaf : Cuboid(size = size)
  joint motion : revolute base -> leaf about leaf.front.bottom range 0deg .. 15deg
  port hold = frame(at = leaf.front.center, out = x, up = z)
}
template Grip {
  part knob : Cuboid(size = [3cm, 3cm, 3cm])
  port mount = frame(at = knob.back.center, out = -x, up = z)
}
category Window {
  root part body : Cuboid(size = [5cm, 1m, 1m])
  part sash : Sash(size = [4cm, 60cm, 60cm]) = Sided | Tilting
  connect sash.back on body.front gap 5mm
  align sash.center.y = body.center.y
  align sash.center.z = body.center.z
  part handle : Grip
  connect handle.mount to sash.hold
}
"""


def test_rides_on_the_leaf_of_every_alternative() -> None:
    session = Session(Source("window.apg", TEXT), None)
    sampler = session.sampler
    batch = sampler.batch(np.arange(40), seed=3)
    sites = batch.sites()
    knob = next(site for site in sites if site.path.endswith("knob"))
    joints = batch.joints()
    assert len(np.unique(joints.definition)) == 3  # both hands and the tilting one were drawn
    assert (np.sort(joints.owner) == np.arange(40)).all()
    np.testing.assert_array_equal(knob.link[np.argsort(knob.owner)], joints.child[np.argsort(joints.owner)])


HEAD = """apg 1
use primitives { Cuboid }
"""
BEND = "joint bend : revolute previous.bar -> bar about line(at = previous.bar.top.center, along = y) range -30deg .. 30deg"


def chain(base: str, rest: str, more: str = "") -> str:
    """Segments one on the other: the first turns on ``base``, the others are attached as ``rest`` says."""
    return f"""
  repeat seg[i] in 0 ..< segments {{
    part bar : Cuboid(size = [2cm, 2cm, 10cm])
    when i == 0 {{
      align bar.bottom = {base}.top + 1mm
      joint first : revolute {base} -> bar about line(at = {base}.top.center, along = y) range -30deg .. 30deg
    }} else {{
      align bar.bottom = previous.bar.top + 1mm
      {rest}
    }}
    {more}
  }}
"""


def arm(rest: str, more: str = "", after: str = "") -> str:
    return f"""{HEAD}category Arm {{
  count segments in 3 .. 5 = 4
  root part foot : Cuboid(size = [10cm, 10cm, 4cm])
{chain("foot", rest, more)}
  part tip : Cuboid(size = [4cm, 4cm, 2cm])
  connect tip.bottom on seg[last].bar.top at center
  part clip : Cuboid(size = [1cm, 1cm, 1cm])
  connect clip.back on seg[1].bar.front at center
  keypoint end on seg[last].bar.top
  {after}
}}
"""


def held(text: str, objects: int = 1) -> list[tuple[dict[str, str], dict[str, str]]]:
    """Of each object: the link that carries each part, and the parent of each link that has one."""
    batch = Session(Source("links.apg", text), None).sampler.batch(np.arange(objects), seed=1)
    links, joints, parts = batch.links(), batch.joints(), batch.parts()
    found = []
    for k in range(objects):
        names = [links.name[row] for row in np.flatnonzero(links.owner == k)]
        carried = {parts.name[row]: names[parts.link[row]] for row in np.flatnonzero(parts.owner == k)}
        above = {names[joints.child[row]]: names[joints.parent[row]] for row in np.flatnonzero(joints.owner == k)}
        found.append((carried, above))
    return found


def test_a_chain_bends_at_every_joint_and_what_is_on_its_end_moves_with_its_end() -> None:
    counts = set()
    for parts, above in held(arm(BEND), 6):
        last = len(above) - 1
        counts.add(last)
        assert above == {f"seg_{k}.bar": f"seg_{k - 1}.bar" if k else "foot" for k in range(last + 1)}
        assert parts["tip"] == f"seg_{last}.bar"
        assert parts["clip"] == "seg_1.bar"
    assert len(counts) > 1


def test_elements_that_are_rigid_on_the_one_before_ride_on_the_first() -> None:
    for parts, above in held(arm("connect bar to previous.bar"), 3):
        assert above == {"seg_0.bar": "foot"}
        assert {link for path, link in parts.items() if path != "foot"} == {"seg_0.bar"}


def test_elements_that_are_rigid_on_the_one_before_ride_on_the_last_that_moves() -> None:
    for parts, above in held(arm(f"when i == 2 {{ {BEND} }} else {{ connect bar to previous.bar }}"), 6):
        assert above == {"seg_0.bar": "foot", "seg_2.bar": "seg_0.bar"}
        bars = [link for path, link in parts.items() if path.endswith("bar")]
        assert bars == ["seg_0.bar"] * 2 + ["seg_2.bar"] * (len(bars) - 2)
        assert parts["clip"] == "seg_0.bar"
        assert parts["tip"] == "seg_2.bar"


def test_tiers_that_stand_on_another_part_of_the_one_before() -> None:
    text = f"""{HEAD}category Rack {{
  root part foot : Cuboid(size = [10cm, 10cm, 4cm])
  repeat tier[i] in 0 ..< 3 {{
    part post : Cuboid(size = [2cm, 2cm, 10cm])
    when i == 0 {{
      align post.bottom = foot.top + 5mm
      joint turn : continuous foot -> post about line(at = foot.top.center, along = z)
    }} else {{ connect post.bottom on previous.plate.top at center }}
    part plate : Cuboid(size = [8cm, 8cm, 1cm])
    connect plate.bottom on post.top at center
  }}
}}
"""
    [(parts, above)] = held(text)
    assert above == {"tier_0.post": "foot"}
    assert {link for path, link in parts.items() if path != "foot"} == {"tier_0.post"}


def test_templates_that_are_rigid_on_a_port_of_the_one_before() -> None:
    text = f"""{HEAD}template Unit {{
  part rod : Cuboid(size = [2cm, 2cm, 10cm])
  part knob : Cuboid(size = [3cm, 3cm, 1cm])
  align knob.bottom = rod.top
  port foot = frame(at = rod.bottom.center, out = -z, up = x)
  port head = frame(at = knob.top.center, out = z, up = x)
}}
category Mast {{
  root part deck : Cuboid(size = [10cm, 10cm, 4cm])
  part boss : Cuboid(size = [4cm, 4cm, 1cm])
  joint turn : continuous deck.top -> boss.bottom at center gap 1mm about line(at = deck.top.center, along = z)
  repeat tier[i] in 0 ..< 4 {{
    part unit : Unit
    when i == 0 {{ connect unit.foot to boss.top }} else {{ connect unit.foot to previous.unit.head }}
  }}
}}
"""
    [(parts, above)] = held(text)
    assert above == {"boss": "deck"}
    assert {link for path, link in parts.items() if path != "deck"} == {"boss"}


def test_another_part_of_a_repeat_lies_on_the_element_before() -> None:
    cap = """part cap : Cuboid(size = [3cm, 3cm, 1mm])
    when i > 0 { connect cap.bottom on previous.bar.top at center } else { connect cap.bottom on foot.top at center }"""
    [(parts, above)] = held(arm(BEND, cap))
    assert len(above) >= 3
    for k in range(len(above)):
        assert parts[f"seg[{k}].cap"] == above[f"seg_{k}.bar"]


def test_chains_in_templates_in_a_repeat() -> None:
    text = f"""{HEAD}template Arm {{
  count segments in 3 .. 3 = 3
  part sole : Cuboid(size = [6cm, 6cm, 1cm])
{chain("sole", BEND)}
  port end = frame(at = seg[last].bar.top.center, out = z, up = x)
  port mount = frame(at = sole.bottom.center, out = -z, up = x)
}}
template Grip {{
  part knob : Cuboid(size = [3cm, 3cm, 3cm])
  port mount = frame(at = knob.bottom.center, out = -z, up = x)
}}
category Robot {{
  root part foot : Cuboid(size = [10cm, 40cm, 4cm])
  repeat half[k] in 0 ..< 2 spread foot along y margin 10cm {{
    part arm : Arm
    connect arm.mount to frame(at = half.top.center, out = z, up = x)
    part grip : Grip
    connect grip.mount to arm.end
  }}
  part flag : Grip
  connect flag.mount to half[last].arm.end
  part badge : Grip
  connect badge.mount to half[0].grip.knob.front
}}
"""
    [(parts, above)] = held(text)
    for k in range(2):
        assert above[f"half_{k}.arm.seg_0.bar"] == "foot"
        assert above[f"half_{k}.arm.seg_2.bar"] == f"half_{k}.arm.seg_1.bar"
        assert parts[f"half[{k}].grip"] == f"half_{k}.arm.seg_2.bar"
    assert parts["flag"] == "half_1.arm.seg_2.bar"
    assert parts["badge"] == "half_0.arm.seg_2.bar"


def test_branches_that_fix_a_part_to_different_links() -> None:
    text = f"""{HEAD}category Desk {{
  param side : choice left | right | middle
  root part foot : Cuboid(size = [10cm, 40cm, 4cm])
  repeat flap[k] in 0 ..< 2 spread foot along y margin 5cm {{
    part leaf : Cuboid(size = [9cm, 9cm, 1cm])
    align leaf.bottom = foot.top + 1mm
    align leaf.center.y = flap.center.y
    joint lift : prismatic foot -> leaf along z range 0 .. 5cm
  }}
  part lamp : Cuboid(size = [1cm, 1cm, 1cm])
  when side == left {{ connect lamp.bottom on flap[1].leaf.top at center }}
  when side == right {{ connect lamp.bottom on flap[0].leaf.top at center }}
  when side == middle {{ connect lamp.bottom on foot.top at center }}
}}
"""
    assert {parts["lamp"] for parts, _ in held(text, 20)} == {"flap_0.leaf", "flap_1.leaf", "foot"}


def test_what_no_guard_attaches_stays_with_the_template() -> None:
    text = f"""{HEAD}template Box {{
  count rows in 0 .. 1 = 0
  part case : Cuboid(size = [9cm, 9cm, 9cm])
  part lid : Cuboid(size = [9cm, 9cm, 1cm])
  align lid.bottom = case.top + 1mm
  when rows == 1 {{ joint lift : prismatic case -> lid along z range 0 .. 5cm }}
  port mount = frame(at = case.bottom.center, out = -z, up = x)
}}
category Desk {{
  root part foot : Cuboid(size = [10cm, 40cm, 4cm])
  part chest : Box
  connect chest.mount to foot.top
}}
"""
    assert {parts["chest.lid"] for parts, _ in held(text, 12)} == {"foot", "chest.lid"}


def test_the_part_that_holds_another_is_the_element_that_was_named() -> None:
    parts = Session(Source("arm.apg", arm(BEND)), None).sampler.batch(np.arange(1), seed=1).parts()
    bars = [name for name in parts.name if name.endswith(".bar")]
    assert parts.name[parts.holder[parts.name.index("tip")]] == bars[-1]
    assert parts.name[parts.holder[parts.name.index("clip")]] == bars[1]


def test_references_to_elements_survive_the_text_form() -> None:
    rigid = Session(Source("arm.apg", arm(f"when i == 2 {{ {BEND} }} else {{ connect bar to previous.bar }}")), None)
    text = to_text(rigid.lowering.program)
    assert "(Onward " in text and "(Elsewhere " in text
    assert to_text(from_text(text)) == text


def test_an_element_by_the_rank_of_another_repeat_is_a_mistake_with_words() -> None:
    pins = """repeat key[k] in 0 ..< 2 {
    part pin : Cuboid(size = [1cm, 1cm, 1cm])
    connect pin.back on seg[k].bar.front at center
  }"""
    session = Session(Source("arm.apg", arm(BEND, after=pins)), None)
    assert session.lowering is None
    assert {d.code for d in session.report.diagnostics} == {"unrelated-rows"}


def carriers(body: str) -> dict[str, dict[str, str]]:
    """What carries the arm of a template with this body, and the template itself, by its shape."""
    text = f"""apg 1
use primitives {{ Cuboid, Cylinder }}
template Turner {{
  param shape : choice round | square | bare
  {body}
}}
category Tool {{
  root part foot : Cuboid(size = [20cm, 20cm, 4cm])
  part turner : Turner
  connect turner to foot
}}
"""
    batch = Session.of_text(text, "tool.apg").sampler.batch(np.arange(60), seed=0)
    parts, links = batch.parts(), batch.links()
    names = dict(zip(zip(links.owner, links.number, strict=True), links.name, strict=True))
    found: dict[str, dict[str, str]] = {"turner": {}, "turner.arm": {}}
    for path, owner, link in zip(parts.path, parts.owner, parts.link, strict=True):
        if path in found:
            shape = str(batch.drawn(int(owner))["turner.shape"])
            assert found[path].setdefault(shape, names[owner, link]) == names[owner, link]
    return found


ROUND = "part nut : Cylinder(radius = 1cm, height = 2cm)  joint turn : revolute base -> nut about nut.left.back range 0deg .. 90deg"
SQUARE = "part pin : Cuboid(size = [2cm, 2cm, 2cm])  joint turn : revolute base -> pin about pin.left.back range 0deg .. 90deg"
ARM = "part arm : Cuboid(size = [10cm, 1cm, 1cm])  align arm.center = [0m, 0m, 3cm]"


def test_the_first_part_may_be_another_in_each_branch() -> None:
    """What is not attached goes with the first part that exists, as the text has them; without one, with the base."""
    branches = f"when shape == round {{ {ROUND} }} else {{ {SQUARE} }}"
    expected = {"round": "turner.nut", "square": "turner.pin", "bare": "turner.pin"}
    assert carriers(f"{branches}\n{ARM}") == {"turner": expected, "turner.arm": expected}

    some = f"when shape == round {{ {ROUND} }} when shape == square {{ {SQUARE} }}"
    expected["bare"] = "foot"
    assert carriers(f"{some}\n{ARM}") == {"turner": expected, "turner.arm": expected}

    base = dict.fromkeys(expected, "foot")  # before the others in the text, the arm is the first part itself
    assert carriers(f"{ARM}\n{some}") == {"turner": base, "turner.arm": base}


def test_a_part_of_a_branch_that_hangs_on_another_is_not_the_first() -> None:
    hung = "when shape == round { part nut : Cylinder(radius = 1cm, height = 2cm)  connect nut.bottom on arm.top at center }"
    base = {"round": "foot", "square": "foot", "bare": "foot"}
    assert carriers(f"{hung}\n{ARM}") == {"turner": base, "turner.arm": base}
