"""The ledger: what determines each unknown, case by case, and the blocks that the graph shows."""

from __future__ import annotations

import random

import pytest

from artipg_dsl.cli.compile import emit_graph
from artipg_dsl.cli.ledger import entries
from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text

from .test_solve import category, compiled

TEXT = category("""
  param k : choice one | two | three = one
  param a : length in 1cm .. 80cm derived
  param b : length in 1cm .. 80cm derived
  align a + b = w
  align a - b = w / 5
  part p : Cuboid(size = [1cm, _, _])
  connect p.back on body.front
  align p.right = body.right
  align p.size.z * p.size.z + p.size.z * sqrt(p.size.z * 1m) = 0.2 * w * 1m
  when k == one { align p.left = body.left } else { align p.size.y = w / 3 }
""")


def ledger(text: str, part: str | None = None) -> list[str]:
    return [" ".join(line.split()) for line in entries(compiled(text).lowering, part)]  # type: ignore[arg-type]


def test_each_case_of_a_guard_has_its_line() -> None:
    found = ledger(TEXT, "p")
    assert (
        "size.y where k = one: align p.left = body.left, together with the position of `p` along y <text>:16:19"
        in found
    )
    assert "where k is not one: align p.size.y = w / 3 <text>:16:53" in found
    assert "along z nothing: centred <text>:12:8" in found


MOUNTED = category("""
  count k in 1 .. 2
  part arm : Cuboid(size = [9cm, 1cm, 1cm])
  when k == 1 { connect arm.back to body.front } else { connect arm.back to body.left }
  part lid : Cuboid(size = [_, 9cm, 1cm])
  when k == 2 { align lid.front = body.front } else { align lid.front = body.front - 1cm }
  align lid.back = body.back
  joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
  when k == 2 {
    part peg : Cylinder(radius = 1cm)
    connect peg.bottom to arm.top
    align peg.height = 2cm
  }
""")


def test_what_fixes_a_whole_pose_is_told() -> None:
    found = ledger(MOUNTED, "arm")
    assert "pose where k = 1: arm.back on body.front <text>:9:17" in found
    assert "where k is not 1: arm.back on body.left <text>:9:57" in found
    assert not any(line.startswith("pose") for line in ledger(MOUNTED, "lid"))


FLAGGED = category("""
  count k in 1 .. 2
  count j in 1 .. 2
  when not (k == 1 and j == 1) {
    part peg : Cuboid(size = [1cm, 1cm, _])
    connect peg.bottom to body.top
    align peg.size.z = 2cm
  }
""")


def test_a_branch_is_named_by_its_condition() -> None:
    assert ledger(MOUNTED, "peg")[0] == "peg with k = 2"
    assert ledger(FLAGGED, "peg")[0] == "peg with not (k = 1 and j = 1)"


def test_coupled_unknowns_name_one_another_and_searched_ones_their_start() -> None:
    found = ledger(TEXT)
    assert any(line.startswith("a align a - b = w / 5, together with `b`") for line in found)
    assert any("size.z align" in line and "(searched from 0.1)" in line for line in found)


def test_the_graph_shows_the_blocks_and_reads_back() -> None:
    text = emit_graph(compiled(TEXT))
    assert text is not None
    remarks = [line for line in text.splitlines() if line.startswith("# ")]
    assert any(r.startswith("# a, b by elimination: align") for r in remarks)
    assert any(r.startswith("# p.size.z by search: align") for r in remarks)
    assert any("by elimination where k = one" in r for r in remarks)
    assert to_text(from_text(text)) in text


# ---------------------------------------------------------------- on which link, and why

CARRIED = category("""
  param k : choice held | hinged = held
  part lid : Cuboid(size = [1cm, 9cm, 9cm])
  part knob : Cuboid(size = [1cm, 1cm, 1cm])
  connect knob.bottom on lid.top
  when k == held { connect lid.back on body.front } else { joint turn : revolute body -> lid about lid.left.back range 0deg .. 9deg }
""")


def test_the_ledger_tells_the_link_of_a_part_and_why() -> None:
    found = ledger(CARRIED)
    assert "where k = held: `body`, as it is attached to `body` <text>:11:20" in found
    assert "link where k is not held: its own, which the joint `turn` moves <text>:11:60" in found
    knob = ledger(CARRIED, "knob")
    assert knob[0] == "knob" and knob[1].startswith("link `lid` or `body`, as it is attached to `lid`")


def test_the_ledger_tells_the_link_of_a_port() -> None:
    from artipg_dsl.session import Session

    lowering = Session.of("Kettle").lowering
    assert lowering is not None
    found = [" ".join(line.split()) for line in entries(lowering, "lid.seat")]
    assert found[0] == "lid.seat" and found[1].startswith("link `lid`, as it lies on `lid.cover` library/pots.apg:")


# ---------------------------------------------------------------- who yields is nobody else's business

PARTS = (
    "  part {n} : Cuboid(size = [1cm, _, 2cm])\n  connect {n}.back on body.front\n"
    "  align {n}.left = body.left - 1cm\n  align {n}.right = body.right",
    "  part {n} : Cuboid(size = [1cm, 2cm, _])\n  connect {n} to body\n  align {n}.top = body.top\n  align {n}.size.z = w / 2",
    "  param {n} : length in 1cm .. 90cm derived\n  align {n} * {n} + {n} * sqrt({n} * 1m) = 0.3 * w * 1m",
    "  param {n} : length in 1cm .. 90cm\n  part {n}x : Cuboid(size = [{n}, 1cm, 1cm])\n  connect {n}x to body\n"
    "  align {n}x.center.z = body.top + {n}",
    "  part {n}a : Cuboid(size = [1cm, 1cm, 1cm])\n  part {n}b : Cuboid(size = [1cm, 1cm, 1cm])\n  connect {n}a to body\n"
    "  connect {n}b to body\n  align {n}a.center.x = {n}b.center.x + 1cm",
    "  part {n} : Cuboid(size = [1cm, 1cm, _]) | none\n  connect {n}.back on body.front fit top, bottom",
)


def reasons(text: str) -> dict[str, list[str]]:
    lowering = compiled(text).lowering
    assert lowering is not None
    found = {}
    for _, unknown in lowering.context.ledger:
        found[unknown.column.name] = [
            one.reason if one.equation is None else one.equation.text for one in unknown.settled
        ]
    return found


@pytest.mark.parametrize("seed", range(8))
def test_an_unrelated_equation_never_changes_who_yields_elsewhere(seed: int) -> None:
    chance = random.Random(seed)
    pieces = [chance.choice(PARTS).format(n=f"p{k}") for k in range(4)]
    extra = chance.choice(PARTS).format(n="extra")
    plain = reasons(category("\n".join(pieces)))
    at = chance.randrange(len(pieces) + 1)
    wider = reasons(category("\n".join([*pieces[:at], extra, *pieces[at:]])))
    assert plain and {name: wider[name] for name in plain} == plain
    assert len(wider) > len(plain)
