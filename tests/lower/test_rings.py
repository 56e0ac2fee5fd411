"""Links that hang on one another and joints that follow one another are refused, with the parts and the places; what only
looks like a ring (other branches, the element before) is not."""

from __future__ import annotations

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.runtime.rooted import Ring
from artipg_dsl.validity.tree import Tree

from .test_solve import HEAD, Session, category, sampled

A, B = (f"  part {n} : Cuboid(size = [1cm, 1cm, 1cm])\n" for n in "ab")
TURN = "range 0deg .. 90deg"
MODE = "  param mode : choice one | two = one\n"
CHAIN = """  repeat seg[i] in 0 ..< {count} {{
    part lt : Cuboid(size = [1cm, 1cm, 1cm])
    align lt.center.x = i * 3cm
    when i == 0 {{ joint slide : prismatic {first} -> lt along z range 0 .. 1cm }}
    else {{ joint slide : prismatic previous.lt -> lt along z range 0 .. 1cm }}
  }}
"""
FIRST = """template Mast {
  part grip : Cuboid(size = [1cm, 1cm, 1cm])
  part sleeve : Cuboid(size = [1cm, 1cm, 1cm])
  connect grip to lt
  part lt : Cuboid(size = [1cm, 1cm, 1cm])
  joint slide : prismatic sleeve -> lt along z range 0 .. 1cm
}
"""
DIALS = "".join(
    f"  part d{k} : Cuboid(size = [1cm, 1cm, 1cm])\n"
    f"  joint j{k} : continuous body.top -> d{k}.bottom at x = {3 * k}cm, y = 0 gap 1mm mimic {{}}\n"
    for k in range(3)
)


def found(text: str) -> list[tuple[str, str, list[int]]]:
    session = Session.of_text(HEAD + text)
    _ = session.lowering
    return [
        (d.code, d.message, [d.span.line, *(span.line for span, _ in d.notes)])
        for d in session.report.diagnostics
        if d.span is not None
    ]


@pytest.mark.parametrize(
    ("text", "message", "lines"),
    [
        (
            category(A + f"  joint j : revolute a -> a about a.left.back {TURN}"),
            "`a` is attached to itself: the links form a ring",
            [7],
        ),
        (category(A + "  joint j : fixed a -> a"), "`a` is attached to itself: the links form a ring", [7]),
        (
            category(
                A
                + B
                + f"  joint j : revolute a -> b about a.left.back {TURN}\n  joint k : revolute b -> a about a.left.back {TURN}"
            ),
            "`a` is attached to itself, by way of `b`: the links form a ring",
            [9, 8],
        ),
        (
            category(A + B + f"  connect a to b\n  joint k : revolute a -> b about a.left.back {TURN}"),
            "`b` is attached to itself: the links form a ring",
            [9, 8],
        ),
        (
            FIRST + category("  part m : Mast\n  connect m to body\n  align m.grip.bottom = body.top"),
            "`m.lt` is attached to itself: the links form a ring",
            [8, 5, 6],
        ),
        (
            category(CHAIN.format(count=3, first="seg[last].lt")),
            "`seg.lt` is attached to itself: the links form a ring",
            [9, 10],
        ),
        (
            category("  count n in 1 .. 3\n" + CHAIN.format(count="n", first="seg[last].lt")),
            "`seg.lt` is attached to itself: the links form a ring",
            [10],
        ),
        (category(DIALS.format("j0", "j0", "j0")), "the joint `j0` follows itself", [7]),
        (
            category(DIALS.format("j1", "j2", "-j0")),
            "the joint `j0` follows itself, by way of `j1` and `j2`",
            [7, 9, 11],
        ),
    ],
    ids=[
        "a joint on itself",
        "a fixed joint on itself",
        "two joints",
        "connect and joint",
        "an unattached first part",
        "the last element",
        "the last of a count",
        "a mimic of itself",
        "three mimics",
    ],
)
def test_a_ring_is_refused(text: str, message: str, lines: list[int]) -> None:
    assert found(text) == [("circular-definition", message, lines)]


SWAPPED = (
    MODE
    + A
    + B
    + f"  when mode == one {{\n    connect a to body\n    joint j : revolute a -> b about a.left.back {TURN}\n  }} else {{\n"
    + f"    connect b to body\n    joint j : revolute b -> a about a.left.back {TURN}\n  }}\n"
)


@pytest.mark.parametrize(
    "body",
    [
        SWAPPED,
        CHAIN.format(count=3, first="body"),
        CHAIN.format(count=3, first="body") + A + f"  joint j : revolute seg[last].lt -> a about a.left.back {TURN}",
        CHAIN.format(count=3, first="body").replace(
            "range 0 .. 1cm }\n  }", "range 0 .. 1cm mimic previous.slide }\n  }"
        ),
    ],
    ids=["either way", "a chain", "on the last", "mimics of the element before"],
)
def test_what_is_no_ring_is_taken(body: str) -> None:
    batch = sampled(category(body), 8)
    tree = Tree(batch)
    assert tree.chain[:, -1].max() == -1 and (np.bincount(batch.joints().owner) >= 1).all()


def test_followers_in_a_chain_follow_its_head() -> None:
    """`mimic -2 * previous.slide` takes part in each step: 1, -2, 4, ..., whichever branch states the joint."""
    body = CHAIN.format(count=4, first="body").replace(
        "range 0 .. 1cm }\n  }", "range 0 .. 1cm mimic -2 * previous.slide }\n  }"
    )
    joints = sampled(category(body), 2).joints()
    assert joints.mimic.tolist() == [-1, 0, 0, 0] * 2
    assert joints.multiplier.tolist() == [1.0, -2.0, 4.0, -8.0] * 2


def test_a_ring_that_only_rows_show_ends_in_an_error() -> None:
    """A ring longer than what is followed in symbols: no object is made, and nothing loops."""
    batch = sampled(category(CHAIN.format(count=40, first="seg[last].lt")), 2)
    with pytest.raises(Ring, match=r"the links of object 0 form a ring: .*`seg_0\.slide`"):
        batch.joints()


@pytest.mark.parametrize("branch", ["", "else "])
def test_a_mimic_of_a_joint_of_both_branches_follows_the_one_that_is_there(branch: str) -> None:
    body = f"""  repeat seg[i] in 0 ..< 3 {{
    part lt : Cuboid(size = [1cm, 1cm, 1cm])
    part rt : Cuboid(size = [1cm, 1cm, 1cm])
    when i == 0 {{ joint slide : prismatic body -> lt along z range 0 .. 1cm }}
    else {{ joint slide : prismatic previous.lt -> lt along z range 0 .. 1cm }}
    when i == 0 {{ {"" if branch else "joint follow : prismatic body -> rt along z range 0 .. 1cm mimic slide"} }}
    else {{ {"joint follow : prismatic body -> rt along z range 0 .. 1cm mimic slide" if branch else ""} }}
    when i == 0 {{ {"connect rt to body" if branch else ""} }} else {{ {"" if branch else "connect rt to body"} }}
  }}
"""
    joints = sampled(category(body), 1).joints()
    rows = {name: row for row, name in enumerate(joints.name)}
    followers = [f"seg_{k}.follow" for k in ([1, 2] if branch else [0])]
    assert [joints.name[joints.mimic[rows[name]]] for name in followers] == [
        name.replace("follow", "slide") for name in followers
    ]


def test_joints_that_lead_by_turns_are_read_back() -> None:
    """Either of two joints follows the other, by branch: no ring, in the compiled form neither."""
    dial = "  part d{0} : Cuboid(size = [1cm, 1cm, 1cm])\n"
    joint = "    joint j{0} : continuous body.top -> d{0}.bottom at x = {0} * 3cm, y = 0 gap 1mm{1}\n"
    body = MODE + dial.format(0) + dial.format(1) + "  when mode == one {\n"
    body += joint.format(0, "") + joint.format(1, " mimic j0") + "  } else {\n"
    body += joint.format(1, "") + joint.format(0, " mimic j1") + "  }\n"
    text = to_text(sampled(category(body), 2).program)
    assert to_text(from_text(text)) == text


def test_the_first_of_a_ring_rests_as_it_says() -> None:
    """The others follow it, whatever they would rest at by themselves."""
    text = """apg 1
use primitives { Cuboid, Cylinder }
category Stand {
  root part hub : Cylinder(radius = 3cm, height = 6cm)
  repeat leg[k] ring 3 about line(at = hub.center, along = z) {
    part bar : Cuboid(size = [1cm, 1cm, 20cm])
    align bar.back = 32mm
    align bar.top = 3cm
    joint fold : revolute hub -> bar about line(at = bar.top.center, along = y) range -70deg .. 0deg rest -55deg mimic previous.fold
  }
}
"""
    joints = apg.load(text, n=1).object(0).annotation["joints"]
    assert [round(np.degrees(joint["rest"]), 6) for joint in joints] == [-55.0] * 3
