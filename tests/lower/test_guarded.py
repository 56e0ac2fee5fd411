"""Every statement acts where its guard holds and nowhere else: under `when`, by the index of a repeat, in a template used
twice, in alternatives of a role. Each is looked at in the objects that are made."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from artipg_dsl.graph.reading import from_text
from artipg_dsl.graph.writing import to_text
from artipg_dsl.session import Session

from .guarded import (
    HEAD,
    MADE,
    MOVING,
    ROOT,
    STAND,
    WAYS,
    Look,
    P,
    Q,
    cm,
    joints,
    labelled,
    material,
    names_of,
    role,
    rows,
    size,
    units,
    when,
)


@pytest.mark.some
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("parts", "yes", "no", "look", "holds", "fails"),
    [
        pytest.param("", Q.format("1cm"), Q.format("2cm"), size, [10], [20], id="part"),
        pytest.param(
            "",
            "param s : length in 1cm .. 1cm\n" + Q.format("s"),
            "param t : length in 2cm .. 2cm\n" + Q.format("t"),
            size,
            [10],
            [20],
            id="param",
        ),
        pytest.param(
            "",
            "count s in 1 .. 1\n" + Q.format("s * 1cm"),
            "count t in 2 .. 2\n" + Q.format("t * 1cm"),
            size,
            [10],
            [20],
            id="count",
        ),
        pytest.param(
            "", "let s = 1cm\n" + Q.format("s"), "let s(k) = k * 1cm\n" + Q.format("s(2)"), size, [10], [20], id="let"
        ),
        pytest.param(
            "",
            "style s : Peg = Square\npart q : s(long = 1cm)\nconnect q.bottom on stand.top at center",
            "style s : Peg = Round\npart q : s(long = 2cm)\nconnect q.bottom on stand.top at center",
            size,
            [10],
            [20],
            id="style",
        ),
        pytest.param(
            "",
            f"repeat r in 0 ..< 2 {{ {Q.format('1cm')} }}",
            f"repeat r in 0 ..< 3 {{ {Q.format('1cm')} }}",
            size,
            [10, 10],
            [10, 10, 10],
            id="repeat",
        ),
        pytest.param(
            "part q : Cuboid(size = [1cm, 1cm, _])\n connect q to stand\n align q.bottom = stand.top\n",
            "align q.top = stand.top + 1cm",
            "align q.top = stand.top + 2cm",
            size,
            [10],
            [20],
            id="align",
        ),
        pytest.param(
            "param s : length in 1cm .. 4cm\n" + Q.format("s"),
            "require s <= 14mm",
            "require s >= 36mm",
            cm,
            [1],
            [4],
            id="require",
        ),
        pytest.param(
            P,
            "connect p.bottom on stand.top at center",
            "joint pull : prismatic stand.top -> p.bottom at center gap 1mm range 0 .. 1cm",
            joints("type"),
            [],
            ["prismatic"],
            id="connect",
        ),
        pytest.param(
            P,
            "joint pull : prismatic stand.top -> p.bottom at center gap 1mm range 0 .. 1cm",
            "joint pull : revolute stand.top -> p.bottom at center gap 1mm range 0deg .. 9deg",
            rows("joints", "type", "child"),
            ["prismatic"],
            ["revolute"],
            id="joint",
        ),
        pytest.param(
            MOVING,
            "limit pull 0 .. 2cm",
            "limit pull 1cm .. 4cm",
            joints("range"),
            [[0.0, 0.02]],
            [[0.01, 0.04]],
            id="limit",
        ),
        pytest.param(
            MOVING,
            "label affordance.lift on p",
            "label affordance.press on p",
            labelled("affordance.lift"),
            [1],
            [0],
            id="label",
        ),
        pytest.param(
            MOVING,
            "label semantic.lid on p",
            "label semantic.button on p",
            rows("parts", "semantic"),
            ["lid"],
            ["button"],
            id="semantic",
        ),
        pytest.param(
            MOVING,
            "field wear : ratio on p = 0.25",
            "field wear : ratio on p = 0.75",
            labelled("field.wear"),
            [0.25],
            [0.75],
            id="field",
        ),
        pytest.param(
            MOVING,
            "keypoint tip on p at [0, 0, 1cm]",
            "keypoint end on p at [0, 0, 0]",
            rows("keypoints", "name", "link"),
            ["tip"],
            ["end"],
            id="keypoint",
        ),
        pytest.param(
            MOVING,
            "grasp above on p { at [0, 0, 0]  approach -z  close y  opening size.y + 1cm }",
            "grasp across on p { at [0, 0, 0]  approach -z  close x  opening size.x + 1cm }",
            names_of("grasps"),
            {"above"},
            {"across"},
            id="grasp",
        ),
        pytest.param(MOVING, "material oak on p", "material steel on p", material, {"oak"}, {"steel"}, id="material"),
        pytest.param(
            MOVING,
            "symmetry p : turn 2 about z",
            "symmetry p : any about x",
            rows("parts", "symmetry"),
            ["2 about z"],
            ["any about x"],
            id="symmetry",
        ),
    ],
)
def test_both_branches_act(
    way: Callable[..., str], parts: str, yes: str, no: str, look: Look, holds: Any, fails: Any
) -> None:
    sampler = Session.of_text(HEAD + way(parts, yes, no)).sampler
    batch = sampler.batch(np.arange(MADE if way in (when, role) else 1), seed=2)
    seen = units(way, batch)
    assert {truth for _, _, truth in seen} == {True, False}
    for number, prefix, truth in seen:
        assert look(batch, number, prefix) == (holds if truth else fails), (number, prefix)


@pytest.mark.some
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("declared", "said", "look", "holds", "fails"),
    [
        pytest.param(
            "param s : ratio in {} .. {}",
            "field wear : ratio on p = s",
            labelled("field.wear"),
            [0.25],
            [0.75],
            id="field",
        ),
        pytest.param(
            "count s in {} .. {}",
            "label affordance.lift on p where s == 1",
            labelled("affordance.lift"),
            [1],
            [0],
            id="label",
        ),
        pytest.param(
            "count s in {} .. {}",
            "label affordance.lift on p = 1 / (3 * s - 1)",
            labelled("affordance.lift"),
            [0.5],
            [0.2],
            id="degree",
        ),
        pytest.param(
            "count s in {} .. {}",
            "label semantic.lid on p where s == 1",
            rows("parts", "semantic"),
            ["lid"],
            [None],
            id="semantic",
        ),
        pytest.param("style s : material = {}", "material s on p", material, {"oak"}, {"steel"}, id="material"),
        pytest.param(
            "count s in {} .. {}",
            "symmetry p : turn 2 * s about z",
            rows("parts", "symmetry"),
            ["2 about z"],
            ["4 about z"],
            id="symmetry",
        ),
        pytest.param(
            "param s : length in {} .. {}",
            "keypoint tip on p at [0, 0, s]",
            rows("keypoints", "name", "link"),
            ["tip"],
            ["tip"],
            id="keypoint",
        ),
        pytest.param(
            "param s : length in {} .. {}",
            "grasp above on p {{ at [0, 0, s - 1cm]  approach -z  close y  opening size.y + s }}",
            names_of("grasps"),
            {"above"},
            {"above"},
            id="grasp",
        ),
    ],
)
def test_what_a_branch_declares_is_used_on_a_part_outside(
    way: Callable[..., str], declared: str, said: str, look: Look, holds: Any, fails: Any
) -> None:
    pairs = {"ratio": (0.25, 0.75), "count": (1, 2), "length": ("1cm", "2cm"), "material": ("oak", "steel")}
    values = next(pair for word, pair in pairs.items() if word in declared)
    one, two = (f"{declared.format(value, value)}\n{said.format()}\n" for value in values)
    sampler = Session.of_text(HEAD + way(MOVING, one, two)).sampler
    batch = sampler.batch(np.arange(MADE if way in (when, role) else 1), seed=2)
    for number, prefix, truth in units(way, batch):
        assert look(batch, number, prefix) == (holds if truth else fails), (number, prefix)
    again = from_text(to_text(sampler.program))  # what has been made reads back
    assert [str(label) for label in again.labels] == [str(label) for label in sampler.program.labels]


@pytest.mark.parametrize(
    "said",
    [
        "field wear : ratio on stand = s / 10cm",
        "label affordance.lift on stand where p.x < s",
        "symmetry stand : turn ceil(s / 1cm) about z",
        "keypoint tip on stand at [0, 0, s]",
        "style m : material = oak | steel\nmaterial m on stand",
        "grasp above on stand { at [0, 0, 0]  approach -z  close y  opening s }",
    ],
)
def test_what_each_element_has_is_not_used_on_a_part_that_they_share(said: str) -> None:
    program = f"""{HEAD}category T {{
  {ROOT}  {STAND}  connect stand.bottom on body.top at center
  repeat e[i] in 0 ..< 2 {{
    param s : length in 1cm .. 2cm
    {said}
  }}
}}"""
    session = Session.of_text(program)
    assert session.lowering is None
    (found,) = [d for d in session.report.diagnostics if d.code == "unrelated-rows"]
    assert "each element of the repeat `e` has a value of its own" in found.message
    assert found.span is not None and said.endswith(found.span.source.text[found.span.start : found.span.end])
