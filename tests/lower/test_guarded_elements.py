"""A statement that names one element of a repeat by its number acts there alone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from artipg_dsl.session import Session, check_text
from artipg_dsl.source import Source

from .guarded import HEAD, MOVING, ROOT, STAND, Look, given, labelled, material, names_of, rows


def elements(parts: str, said: str) -> str:
    return f"""category T {{
  {ROOT}  count n in 2 .. 3
  repeat e[i] in 0 ..< n {{
    {STAND}    connect stand.bottom on body.top at y = i * 1m, x = 0
    {parts}
  }}
  {said}
}}"""


@pytest.mark.parametrize(("index", "which"), [("0", 0), ("last", -1), ("n - 2", -2)])
@pytest.mark.parametrize(
    ("said", "look", "holds", "fails"),
    [
        ("label affordance.lift on {}.p", labelled("affordance.lift"), [1], [0]),
        ("label affordance.lift on {}.p.top", labelled("affordance.lift"), [0, 1], [0]),
        ("label affordance.lift on {}", labelled("affordance.lift"), [1], [0]),
        ("label affordance.lift for {}.pull on e.p", labelled("affordance.lift"), [1], [0]),
        ("label semantic.lid on {}.p", rows("parts", "semantic"), ["lid"], [None]),
        ("field wear : ratio on {}.p = 0.25", given("field.wear"), [0.25], []),
        ("keypoint tip on {}.p at [0, 0, 1cm]", rows("keypoints", "name", "link"), ["tip"], []),
        ("keypoint tip on {}.p.top.center", rows("keypoints", "name", "link"), ["tip"], []),
        (
            "grasp above on {}.p {{ at [0, 0, 0]  approach -z  close y  opening size.y + 1cm }}",
            names_of("grasps"),
            {"above"},
            set(),
        ),
        ("material oak on e.p\n  material steel on {}.p", material, {"steel"}, {"oak"}),
        ("symmetry {}.p : any about x", rows("parts", "symmetry"), ["any about x"], ["2 about z"]),
    ],
)
def test_an_index_means_one_element(index: str, which: int, said: str, look: Look, holds: Any, fails: Any) -> None:
    text = elements(MOVING + "  symmetry p : turn 2 about z\n", said.format(f"e[{index}]"))
    batch = Session.of_text(HEAD + text).sampler.batch(np.arange(4), seed=2)
    assert {batch.drawn(k)["n"] for k in range(4)} == {2, 3}
    for number in range(4):
        count = batch.drawn(number)["n"]
        for rank in range(count):
            expected = holds if rank == which % count else fails
            assert look(batch, number, f"e[{rank}].") == expected, (number, rank)


def test_a_formula_asks_about_the_joint_of_one_element() -> None:
    text = elements(MOVING, "label affordance.lift on e.p where pulls(e[1].pull) or pushes(e[1].pull)")
    batch = Session.of_text(HEAD + text).sampler.batch(np.arange(2), seed=2)
    for number in range(2):
        assert labelled("affordance.lift")(batch, number, "e[0].") == [0]
        assert labelled("affordance.lift")(batch, number, "e[1].") == [0, 1]


def test_a_slot_binds_no_single_element() -> None:
    text = """role Row { slot grip }
template Two : Row {
  part bar : Cuboid(size = [1cm, 40cm, 1cm])
  repeat e[i] in 0 ..< 2 { part rod : Cuboid(size = [1cm, 1cm, 1cm])  connect rod.bottom on bar.top at y = i * 10cm, x = 0 }
  slot grip = e[0].rod
}
category T {
  root part row : Two
  label semantic.lid on row.grip
}"""
    (found,) = (d for d in check_text(Source("t.apg", HEAD + text)).diagnostics if d.severity == "error")
    assert "a slot must bind all elements of a repeat" in found.message


@pytest.mark.parametrize(
    ("said", "holds"),
    [
        ("require e[0].p or n > 9", lambda first, last: first),
        ("require not e[0].p or e[last].p is Cylinder", lambda first, last: not first or last == "Cylinder"),
        (
            "when e[last].p is Cuboid { require e[0].p is Cylinder }",
            lambda first, last: last != "Cuboid" or first == "Cylinder",
        ),
        ("require (2 if e[0].p else 0) + (1 if e[last].p else 0) == 2", lambda first, last: first and not last),
    ],
)
def test_a_condition_asks_what_one_element_has(said: str, holds: Any) -> None:
    part = "part p : Cuboid(size = [1cm, 1cm, 1cm]) | Cylinder(radius = 1cm, height = 1cm) | none\n    connect p.bottom on stand.top"
    session = Session.of_text(f"{HEAD}{elements(part, said)}", "t.apg")
    batch = session.sampler.batch(np.arange(60), 0)
    number, draw = next((k, d) for k, d in enumerate(batch.program.draws) if d.kind == "choice")
    words = np.array([*draw.options[:2], ""])[batch.state.values[number].astype(int)]
    owner = batch.owner(draw.column.scope)
    each = [words[owner == k].tolist() for k in range(60)]
    assert all(holds(found[0], found[-1]) for found in each) and len({(e[0], e[-1]) for e in each}) > 1


def test_a_condition_asks_what_the_element_before_has() -> None:
    part = """part p : Cuboid(size = [1cm, 1cm, 1cm]) | none
    connect p.bottom on stand.top
    when i > 0 { when previous.p { require not p } }"""
    batch = Session.of_text(f"{HEAD}{elements(part, '')}", "t.apg").sampler.batch(np.arange(60), 0)
    number, draw = next((k, d) for k, d in enumerate(batch.program.draws) if d.kind == "choice")
    there, owner = batch.state.values[number] == 0, batch.owner(draw.column.scope)
    assert not (there[1:] & there[:-1] & (owner[1:] == owner[:-1])).any() and there.any()
