"""Every statement acts where its guard holds and nowhere else: under `when`, by the index of a repeat, in a template used
twice, in alternatives of a role. Each is looked at in the objects that are made."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from artipg_dsl.annotate.annotation import annotate
from artipg_dsl.annotate.cloud import Points, sample_points
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.graph.text import from_text, to_text
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session, check_text
from artipg_dsl.source import Source
from artipg_dsl.validity.faults import find_faults
from artipg_dsl.validity.tree import Tree

HEAD = """apg 1
use primitives   { Cuboid, Cylinder }
use materials    { oak, steel }
use vocabularies { semantic, affordance }
role Peg { inherit long : length }
template Square : Peg { part peg : Cuboid(size = [5mm, 5mm, long]) }
template Round : Peg { part peg : Cylinder(radius = 3mm, height = long) }
"""
STAND = "part stand : Cuboid(size = [10cm, 10cm, 10cm])\n"
ROOT = "root part body : Cuboid(size = [4m, 4m, 1cm])\n"
MADE = 12

Look = Callable[[Batch, int, str], Any]
"""What an object shows of the part of it whose names begin with a prefix."""


def when(parts: str, yes: str, no: str, roles: str = "") -> str:
    return f"""category T {{
  {ROOT}  param a : choice yes | no = yes
  {STAND}  connect stand.bottom on body.top at center
  {parts}
  when a == yes {{ {yes} }} else {{ {no} }}
}}"""


def repeat(parts: str, yes: str, no: str, roles: str = "") -> str:
    return f"""category T {{
  {ROOT}  repeat e[i] in 0 ..< 2 {{
    {STAND}    connect stand.bottom on body.top at y = (i - 1/2) * 1m, x = 0
    {parts}
    when i == 0 {{ {yes} }} else {{ {no} }}
  }}
}}"""


def twice(parts: str, yes: str, no: str, roles: str = "") -> str:
    uses = "".join(
        f"  part {name} : Unit(a = {a})\n  connect {name} to body\n  align {name}.stand.bottom = body.top\n"
        f"  align {name}.stand.center.y = {y}\n"
        for name, a, y in (("one", "yes", "-50cm"), ("two", "no", "50cm"))
    )
    return f"""template Unit {{
  param a : choice yes | no = yes
  {STAND}  {parts}
  when a == yes {{ {yes} }} else {{ {no} }}
}}
category T {{
  {ROOT}{uses}}}"""


def role(parts: str, yes: str, no: str, roles: str = "") -> str:
    return f"""role Unit {{ slot stand {roles} }}
template One : Unit {{ {STAND}  {parts}\n {yes}\n }}
template Two : Unit {{ {STAND}  {parts}\n {no}\n }}
category T {{
  {ROOT}  part u : Unit = One | Two
  connect u to body
  align u.stand.bottom = body.top
}}"""


WAYS = [when, repeat, twice, role]


def units(way: Callable[..., str], batch: Batch) -> list[tuple[int, str, bool]]:
    """(object, prefix of its names, whether the first branch holds there)."""
    if way is repeat:
        return [(0, "e[0].", True), (0, "e[1].", False)]
    if way is twice:
        return [(0, "one.", True), (0, "two.", False)]
    drawn = [batch.drawn(k) for k in range(len(batch))]
    if way is role:
        return [(k, "u.", values["u"] == "One") for k, values in enumerate(drawn)]
    return [(k, "", values["a"] == "yes") for k, values in enumerate(drawn)]


def plain(name: str) -> str:
    return name.replace("[", "_").replace("]", "")


def rows(what: str, field: str, key: str = "name") -> Look:
    def look(batch: Batch, number: int, prefix: str) -> Any:
        own = plain(prefix) + "p"
        return [
            row[field] for row in annotate(batch)[number][what] if re.fullmatch(rf"{own}(ull)?", plain(str(row[key])))
        ]

    return look


def names_of(what: str) -> Look:
    return lambda batch, number, prefix: set(rows(what, "name", "link")(batch, number, prefix))


def size(batch: Batch, number: int, prefix: str) -> list[int]:
    """The size along z of each part `q` in millimetres."""
    parts = annotate(batch)[number]["parts"]
    found = [
        p["size"][2] * 1e3 for p in parts if p["name"].startswith(prefix) and p["name"].split(".")[-1].startswith("q")
    ]
    return [round(f) for f in found]


def pool(batch: Batch, number: int, prefix: str) -> tuple[Points, int]:
    """Points, and the row of those that lie on the part `p` of a unit."""
    found = sample_points(batch, Sampling(64, per="primitive"))
    path, element = re.sub(r"\[.\]", "", prefix) + "p", int((re.findall(r"\d", prefix) or [0])[0])
    for row, owner in enumerate(found.object.tolist()):
        site = batch.program.sites[found.primitive[row, 0]].path
        if (owner, site, found.element[row, 0]) == (number, path, element):
            return found, row
    raise AssertionError(path)


def labelled(key: str) -> Look:
    def look(batch: Batch, number: int, prefix: str) -> Any:
        found, row = pool(batch, number, prefix)
        return sorted(set(np.round(found.labels[key][row].astype(float), 6).tolist()))

    return look


def given(key: str) -> Look:
    """What a field says, where it says something."""
    return lambda batch, number, prefix: [v for v in labelled(key)(batch, number, prefix) if v == v]


def material(batch: Batch, number: int, prefix: str) -> Any:
    found, row = pool(batch, number, prefix)
    made = [m.name for m in batch.program.materials.values()]
    return {made[k] for k in found.material[row].tolist()}


def joints(field: str) -> Look:
    return rows("joints", field, "name")


def cm(batch: Batch, number: int, prefix: str) -> list[int]:
    return [round(k / 10) for k in size(batch, number, prefix)]


P = "part p : Cuboid(size = [4cm, 4cm, 4cm])\n"
MOVING = P + "  joint pull : prismatic stand.top -> p.bottom at center gap 1mm range 0 .. 5cm\n"
Q = "part q : Cuboid(size = [1cm, 1cm, {}])\n connect q.bottom on stand.top at center\n"


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


# ---------------------------------------------------------------- one element of a repeat, by its number


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


# ---------------------------------------------------------------- what makes objects invalid


def blamed(batch: Batch) -> set[tuple[int, str]]:
    """The objects, and of those with several units the unit, in which links collide."""
    found = find_faults(batch)
    names, first = batch.links().name, np.searchsorted(batch.links().owner, np.arange(len(batch)))
    hits = found.collisions
    return {
        (k, names[first[k] + link])
        for k, *pair in zip(hits.owner.tolist(), hits.first.tolist(), hits.second.tolist(), strict=True)
        for link in pair
    }


MIDDLE = "  align p.center.x = stand.center.x\n  align p.center.y = stand.center.y\n"
LOW = MIDDLE + P + "  joint pull : prismatic stand -> p along z range 0 .. 5cm\n  align p.bottom = stand.top - 1cm\n"


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    "said", ['allow overlap stand, p because "it is meant"', "free p, stand"], ids=["overlap", "free"]
)
def test_what_may_overlap_under_a_guard(way: Callable[..., str], said: str) -> None:
    batch = Session.of_text(HEAD + way(LOW, said, "")).sampler.batch(
        np.arange(MADE if way in (when, role) else 1), seed=2
    )
    wrong = blamed(batch)
    for number, prefix, truth in units(way, batch):
        assert ((number, plain(prefix) + "p") in wrong) == (not truth), (number, prefix)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("parts", "said", "word"),
    [
        (
            MIDDLE + P + "  connect p to stand\n  align p.bottom = stand.top + {}\n",
            'allow floating p because "it is meant"',
            "touches nothing",
        ),
        (
            MIDDLE
            + P
            + "  joint pull : prismatic stand -> p along z range 0 .. 5cm\n  align p.bottom = stand.top + 2mm + {}\n",
            "clear p from stand by 5mm",
            "clear",
        ),
    ],
    ids=["floating", "clear"],
)
def test_faults_under_a_guard(way: Callable[..., str], parts: str, said: str, word: str) -> None:
    """Of two units one is at fault: that for which the statement holds, then the other."""
    excuses = word != "clear"
    for at_fault in (True, False) if way in (repeat, twice) else (True,):
        far = {when: "{}", role: "{}", repeat: "({0} if i == 0 else {1})", twice: "({0} if a == yes else {1})"}[way]
        bad, good = ("5mm", "0mm") if excuses else ("0mm", "2cm")
        pair = (bad, good) if at_fault else (good, bad)
        body = parts.format(far.format(*pair) if way in (repeat, twice) else bad)
        batch = Session.of_text(HEAD + way(body, said, "")).sampler.batch(
            np.arange(MADE if way in (when, role) else 1), seed=2
        )
        wrong = {k for fault in find_faults(batch).others if word in fault.words for k in fault.objects.tolist()}
        if way in (repeat, twice):
            assert (0 in wrong) == (at_fault != excuses), at_fault
        else:
            for number, _, truth in units(way, batch):
                assert (number in wrong) == (truth != excuses)


@pytest.mark.parametrize("way", WAYS)
def test_stability_under_a_guard(way: Callable[..., str]) -> None:
    lean = (
        P.replace("4cm", "40cm") + "  connect p.bottom on stand.top at x = stand.center.x + 30m, y = stand.center.y\n"
    )
    batch = Session.of_text(HEAD + way(lean, "require stable", "")).sampler.batch(
        np.arange(MADE if way in (when, role) else 1), seed=2
    )
    wrong = {k for fault in find_faults(batch).others if "tips" in fault.words for k in fault.objects.tolist()}
    assert wrong == {number for number, _, truth in units(way, batch) if truth}


ARMS = """part one : Cuboid(size = [1cm, 1cm, 1cm])
  joint turn : revolute stand -> one about line(at = stand.center, along = z) range -30deg .. 30deg
  part p : Cuboid(size = [1cm, 1cm, 1cm])
  joint pull : revolute stand -> p about line(at = stand.center, along = z) range -30deg .. 30deg
  align one.center.x = stand.center.x + 20cm
  align p.center.x = stand.center.x + 20cm
"""


@pytest.mark.parametrize("way", WAYS)
def test_a_loop_is_closed_under_a_guard(way: Callable[..., str]) -> None:
    batch = Session.of_text(HEAD + way(ARMS, "close one.center on p.center", "")).sampler.batch(
        np.arange(MADE if way in (when, role) else 1), seed=2
    )
    leader, joints = Tree(batch).leader, batch.joints()
    for number, prefix, truth in units(way, batch):
        row = next(
            k for k, name in enumerate(joints.name) if joints.owner[k] == number and name == plain(prefix) + "pull"
        )
        assert (leader[row] != row) == truth


def test_prefer_under_a_guard() -> None:
    parts = "count q in 0 .. 1\n"
    batch = Session.of_text(HEAD + when(parts, "prefer q == 1 weight 6", "prefer q == 0 weight 6")).sampler.batch(
        np.arange(60), seed=2, candidates=8
    )
    drawn = [batch.drawn(k) for k in range(60)]
    assert np.mean([(v["a"] == "yes") == (v["q"] == 1) for v in drawn]) > 0.9


# ---------------------------------------------------------------- what a template hands out


HANDED = """role Hold {{ port tip : frame  slot grip  out tall : length }}
template Post : Hold {{
  param a : choice yes | no = yes
  part low : Cuboid(size = [1cm, 1cm, 1cm])
  part high : Cuboid(size = [1cm, 1cm, 1cm])
  align high.bottom = low.top
  when a == yes {{
    port tip = frame(at = low.front.center, out = x, up = z)
    slot grip = low
    let tall = 1cm
  }} else {{
    port tip = frame(at = high.front.center, out = x, up = z)
    slot grip = high
    let tall = 2cm
  }}
}}
category T {{
  {root}  param a : choice yes | no = yes
  part post : Post(a = a)
  connect post.low.bottom on body.top
  part p : Cuboid(size = [1cm, 1cm, post.tall])
  connect p.back to post.tip
  label affordance.lift on post.grip
}}"""


def test_ports_slots_and_outputs_under_a_guard() -> None:
    batch = Session.of_text(HEAD + HANDED.format(root=ROOT)).sampler.batch(np.arange(MADE), seed=2)
    for number, told in enumerate(annotate(batch)):
        parts = {row["name"]: row for row in told["parts"]}
        named = "post.low" if batch.drawn(number)["a"] == "yes" else "post.high"
        assert parts["p"]["center"][2] == pytest.approx(parts[named]["center"][2])
        assert parts["p"]["size"][2] == pytest.approx(0.01 if named == "post.low" else 0.02)
        for name in ("post.low", "post.high"):
            part = sample_points(batch, Sampling(64, per="primitive"))
            row = next(
                k
                for k, owner in enumerate(part.object.tolist())
                if owner == number and batch.program.sites[part.primitive[k, 0]].path == name
            )
            assert (
                part.labels["affordance.lift"][row].all()
                == (name == named)
                == part.labels["affordance.lift"][row].any()
            )


@pytest.mark.parametrize("first", [True, False], ids=["before", "after"])
@pytest.mark.parametrize(
    ("plain_one", "guarded", "look"),
    [
        ("label semantic.lid on p", "label semantic.button on p", rows("parts", "semantic")),
        ("material oak on p", "material steel on p", material),
    ],
    ids=["semantic", "material"],
)
def test_of_equals_the_later_one_counts_where_its_guard_holds(
    plain_one: str, guarded: str, look: Look, first: bool
) -> None:
    said = [plain_one, f"when a == yes {{ {guarded} }}"]
    text = when(MOVING, "", "").removesuffix("}") + "\n".join(said if first else said[::-1]) + "\n}"
    batch = Session.of_text(HEAD + text).sampler.batch(np.arange(MADE), seed=2)
    shown = {truth: look(batch, number, prefix) for number, prefix, truth in units(when, batch)}
    assert (shown[True] != shown[False]) == first


def test_a_limit_in_one_alternative_leaves_the_joint_of_the_other_alone() -> None:
    text = f"""role Lid {{ joint motion  slot p }}
template One : Lid {{ {P}  joint motion : prismatic base -> p along z range 0 .. 5cm  limit motion 0 .. 2cm }}
template Two : Lid {{ {P}  joint motion : prismatic base -> p along z range 0 .. 5cm }}
category T {{
  {ROOT}  part u : Lid = One | Two
  connect u to body
  align u.p.bottom = body.top
}}"""
    batch = Session.of_text(HEAD + text).sampler.batch(np.arange(MADE), seed=2)
    ranges = {batch.drawn(k)["u"]: told["joints"][0]["range"] for k, told in enumerate(annotate(batch))}
    assert ranges == {"One": [0.0, 0.02], "Two": [0.0, 0.05]}
