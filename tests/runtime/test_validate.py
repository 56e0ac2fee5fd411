"""Penetrations between links: small programs whose answer is plain, and an exact checker on the exported pieces."""

import os

import numpy as np
import pytest

from artipg_dsl.geometry import pieces
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.sampling.statistics import Exhausted, Statistics
from artipg_dsl.session import Session
from artipg_dsl.validity import turns
from artipg_dsl.validity.bodies import turn_points
from artipg_dsl.validity.evidence import find_evidence, random_states
from artipg_dsl.validity.tree import Tree
from artipg_dsl.validity.validate import find_collisions, find_meetings_in_states

HEAD = "apg 1\nuse primitives { Cuboid, Cylinder }\ncategory Case {\n"


def program(body: str) -> Sampler:
    return Session.of_text(HEAD + body + "\n}\n").sampler


def found(body: str, n: int = 1) -> list[tuple[str, str, str]]:
    """The pairs of links, by path, with the joint that makes them meet."""
    batch = program(body).batch(np.arange(n), 0)
    return sorted(Tree(batch).named(find_collisions(batch)))


WALL = "root part body : Cuboid(size = [40cm, 5cm, 60cm])\n"
DOOR = """
  part door : Cuboid(size = [4cm, 50cm, 60cm])
  align door.front = body.front
  align door.right = body.left + 1mm
  align door.bottom = body.bottom
  joint open : revolute body -> door about door.{edge}.right range {range}
"""


@pytest.mark.parametrize(("edge", "turn", "meets"), [("back", "-90deg .. 0", True), ("front", "0 .. 90deg", False)])
def test_door_inset_beside_a_post(edge: str, turn: str, meets: bool) -> None:
    """About its back edge the front corner swings into the post; about the front edge it swings clear."""
    body = WALL + DOOR.format(edge=edge, range=turn)
    batch = program(body).batch(np.arange(1), 0)
    hits = find_collisions(batch)
    assert batch.joints().axis[0, 2] == (1.0 if edge == "back" else -1.0)  # either range opens to the front
    assert (len(hits) > 0) == meets


SLIDE = """
  root part body : Cuboid(size = [40cm, 40cm, 2cm])
  part wall : Cuboid(size = [2mm, 40cm, 30cm])
  align wall.center.x = body.front {wall}
  connect wall.bottom on body.top
  part crate : Cuboid(size = [10cm, 10cm, 10cm])
  align crate.bottom = body.top {gap}
  align crate.back = body.back + 5cm
  joint pull : prismatic body -> crate along x range 0 .. {travel}
"""


def slide(wall: str = "- 5cm", gap: str = "+ 1mm", travel: str = "10cm") -> list[tuple[str, str, str]]:
    return found(SLIDE.format(wall=wall, gap=gap, travel=travel))


def test_a_drawer_with_too_long_a_travel_meets_the_wall() -> None:
    assert slide() == []
    assert slide(travel="22cm") == [("body", "crate", "pull")]


def test_a_thin_wall_between_the_ends_is_found() -> None:
    assert slide(wall="- 15cm", travel="30cm") == [("body", "crate", "pull")]


@pytest.mark.parametrize(("gap", "meets"), [("+ 0mm", False), ("- 0.01mm", True), ("+ 0.01mm", False)])
def test_flush_faces_touch_and_an_overlap_of_a_hundredth_counts(gap: str, meets: bool) -> None:
    pairs = slide(gap=gap)
    assert (("body", "crate", "") in pairs) == meets and bool(pairs) == meets


def test_an_allowed_overlap_is_silent() -> None:
    text = SLIDE.format(wall="- 5cm", gap="- 5mm", travel="1cm")
    assert found(text)
    assert found(text + 'allow overlap body, crate because "it is let in"\n') == []


def test_a_turning_arm_beside_a_post() -> None:
    text = """
  root part body : Cuboid(size = [40cm, 40cm, 2cm])
  part post : Cuboid(size = [2cm, 2cm, 10cm])
  align post.right = body.right
  connect post.bottom on body.top
  part arm : Cuboid(size = [{long}, 2cm, 1cm])
  align arm.bottom = body.top + 1mm
  joint spin : continuous body -> arm about line(at = body.center, along = z)
"""
    assert found(text.format(long="35cm")) == []
    assert found(text.format(long="37cm")) == [("arm", "body", "spin")]


def test_sampling_draws_again_what_collides() -> None:
    text = SLIDE.replace("{travel}", "travel").format(wall="- 5cm", gap="+ 1mm")
    sampler = program("param travel : length in 10cm .. 30cm\n" + text)
    statistics = Statistics()
    numbers = np.arange(40)
    batch = sampler.batch(numbers, 1, checked=True, statistics=statistics)
    assert len(find_collisions(batch)) == 0
    free = sampler.batch(numbers, 1)
    struck = find_collisions(free).objects()
    assert 0 < len(struck) < 40
    assert statistics.first_valid == 40 - len(struck)
    assert statistics.collided[("body", "crate", "pull")] == statistics.attempts - 40
    kept = np.setdiff1d(numbers, struck)
    assert (free.values()["travel"][kept] == batch.values()["travel"][kept]).all()
    alone = sampler.batch(struck[:1], 1, checked=True)
    assert alone.values()["travel"][0] == batch.values()["travel"][struck[0]]


def test_what_always_collides_ends_soon() -> None:
    sampler = program(SLIDE.format(wall="- 5cm", gap="+ 1mm", travel="30cm"))
    statistics = Statistics()
    with pytest.raises(Exhausted):
        sampler.batch(np.arange(100), 1, checked=True, statistics=statistics)
    assert statistics.attempts < 1000


def test_boxes_that_meet_only_together_block() -> None:
    text = """
  root part body : Cuboid(size = [40cm, 60cm, 2cm])
  part near : Cuboid(size = [10cm, 10cm, 10cm])
  align near.bottom = body.top + 1mm
  align near.right = body.right
  joint a : prismatic body -> near along y range 0 .. 30cm
  part far : Cuboid(size = [10cm, 10cm, 10cm])
  align far.bottom = body.top + 1mm
  align far.left = body.left
  joint b : prismatic body -> far along y range -30cm .. 0
"""
    report = find_evidence(program(text).batch(np.arange(3), 0))
    assert report.pairs == () and report.colliding == 0
    assert [(p.first, p.second, p.objects) for p in report.blocking] == [("far", "near", 3)]


def test_the_microwave_is_valid_at_first(microwave: Sampler) -> None:
    statistics = Statistics()
    microwave.batch(np.arange(100), 5, checked=True, statistics=statistics)
    assert statistics.first_valid >= 99


# ------------------------------------------------------------------ an exact checker


def exact_pairs(batch, states: np.ndarray) -> set[tuple[int, int]]:
    """Pairs of links (rows of the table) whose convex pieces penetrate by more than 1e-6 m, by fcl."""
    fcl = pytest.importorskip("fcl", reason="python-fcl is not installed")
    tree = Tree(batch)
    turn, shift = batch.pose(states)
    solids: dict[int, list[tuple[object, np.ndarray]]] = {}
    for table in batch.sites():
        for group in pieces.build(table.primitive, table.params) if len(table) else ():
            rows = group.rows
            sign = np.stack([np.ones(len(rows)), table.mirror[rows], np.ones(len(rows))], axis=-1)
            placed = (
                turn_points(table.rotation[rows], group.vertices * sign[:, None]) + table.translation[rows][:, None]
            )
            link = tree.first[table.owner[rows]] + table.link[rows]
            placed = turn_points(turn[link], placed) + shift[link][:, None]
            faces = np.concatenate([np.full((len(group.faces), 1), 3), group.faces], axis=1).flatten()
            for points, k in zip(placed, link.tolist(), strict=True):
                hull = fcl.CollisionObject(fcl.Convex(points, len(group.faces), faces), fcl.Transform())
                solids.setdefault(k, []).append((hull, points))
    found = set()
    for a in solids:
        for b in solids:
            if a < b and tree.links.owner[a] == tree.links.owner[b]:
                if any(_deep(fcl, p, q) for p in solids[a] for q in solids[b]):
                    found.add((a, b))
    return found


def _deep(fcl, first, second) -> bool:
    (one, p), (two, q) = first, second
    low, high = np.maximum(p.min(axis=0), q.min(axis=0)), np.minimum(p.max(axis=0), q.max(axis=0))
    if (high - low <= 1e-6).any():
        return False
    result = fcl.CollisionResult()
    fcl.collide(one, two, fcl.CollisionRequest(num_max_contacts=1, enable_contact=True), result)
    return result.is_collision and max(abs(c.penetration_depth) for c in result.contacts) > 1e-6


@pytest.mark.slow
def test_an_exact_checker_agrees_on_microwaves(microwave: Sampler) -> None:
    """At rest and in random configurations: nothing missed, nothing invented. ``ARTIPG_EVERY=1``: 30 objects in 20 each."""
    from artipg_dsl.validity.bodies import gather

    objects, configurations = (30, 20) if os.environ.get("ARTIPG_EVERY") == "1" else (12, 6)
    batch = microwave.batch(np.arange(objects), 3)
    tree = Tree(batch)
    body = gather(batch, tree.first, tree.turn, tree.shift)
    wide = tree.low + 1.3 * (random_states(batch, 0) - tree.low)  # past its end, some links do meet
    seen = 0
    for states in (batch.rest(), wide, *(random_states(batch, k) for k in range(1, configurations))):
        first, second = next(find_meetings_in_states(tree, body, states[None]))
        ours = {(int(min(a, b)), int(max(a, b))) for a, b in zip(first, second, strict=True)}
        assert ours == exact_pairs(batch, states)
        seen += len(ours)
    assert seen > 0  # the comparison is of something


def test_a_screw_advances_into_what_lies_ahead() -> None:
    text = """
  root part body : Cuboid(size = [10cm, 10cm, 2cm])
  part roof : Cuboid(size = [10cm, 10cm, 1cm])
  align roof.bottom = body.top + 5cm
  connect roof to body
  part bolt : Cuboid(size = [2cm, 2cm, 2cm])
  align bolt.bottom = body.top + 1mm
  joint drive : screw body -> bolt about line(at = body.center, along = z) range 0turn .. {turns}turn pitch 5mm
"""
    assert found(text.format(turns="5.7")) == []  # 1 mm + 2 cm + 28.5 mm
    assert found(text.format(turns="5.9")) == [("body", "bolt", "drive")]


# ------------------------------------------------------------------ clear a from b by d


def nearer(body: str, n: int = 1) -> list[str]:
    from artipg_dsl.validity.faults import find_faults

    return [fault.words for fault in find_faults(program(body).batch(np.arange(n), 0)).others]


@pytest.mark.parametrize(("gap", "near"), [("+ 0.9mm", True), ("+ 1mm", False), ("+ 1.1mm", False)])
def test_clear_is_measured_at_rest(gap: str, near: bool) -> None:
    text = SLIDE.format(wall="- 5cm", gap=gap, travel="10cm") + "clear crate from body by 1mm\n"
    place = f"<text>:{text.count(chr(10)) + 3}: `clear crate from body by 1mm` does not hold "
    assert nearer(text) == [place + "at rest", place + "while pull moves"] * near


@pytest.mark.parametrize(("travel", "near"), [("18.5cm", False), ("19.5cm", True)])
def test_clear_holds_on_the_way_of_a_slide(travel: str, near: bool) -> None:
    """From 15 cm the crate slides to a wall whose near side is at 34.9 cm: 19.9 cm later they touch."""
    text = SLIDE.format(wall="- 5cm", gap="+ 9mm", travel=travel) + "clear crate from wall by 8mm\n"
    assert [w.partition("hold ")[2] for w in nearer(text)] == ["while pull moves"] * near


@pytest.mark.parametrize(("gap", "near"), [("4.9mm", False), ("5.1mm", True)])
def test_clear_holds_while_a_joint_turns(gap: str, near: bool) -> None:
    """The corner of an arm, 10.0499 cm from its axis, passes a post 10.5499 cm from it at 5 mm."""
    text = f"""
  root part body : Cuboid(size = [40cm, 40cm, 2cm])
  part post : Cuboid(size = [2cm, 2cm, 10cm])
  align post.back = 105.4988mm
  connect post.bottom on body.top
  part arm : Cuboid(size = [20cm, 2cm, 1cm])
  align arm.bottom = body.top + 2cm
  joint spin : revolute body -> arm about line(at = body.center, along = z) range 3deg .. 90deg rest 90deg
  clear arm from post by {gap}
"""
    assert bool(nearer(text)) == near


def test_clear_asks_parts_and_not_their_links() -> None:
    text = SLIDE.format(wall="- 5cm", gap="+ 1mm", travel="5cm")
    assert nearer(text + "clear crate from wall by 5cm\n") == []
    assert len(nearer(text + "clear crate from wall by 25cm\n")) == 2
    assert len(nearer(text + "clear body from wall by 1mm\n")) >= 1  # one link: they touch


# ------------------------------------------------------------------ parts and places of what meets

CRANE = """
  root part body : Cuboid(size = [60cm, 60cm, 2cm])
  part post : Cuboid(size = [2cm, 2cm, 10cm])
  connect post.bottom on body.top
  align post.center.x = 10cm
  align post.center.y = 12cm
  part bar : Cuboid(size = [25cm, 2cm, 4cm])
  align bar.bottom = body.top + 1mm
  align bar.center.y = 0
  align bar.back = 0
  part tip : Cuboid(size = [2cm, 2cm, 2cm])
  connect tip.bottom on bar.top
  align tip.front = bar.front
  align tip.center.y = 0
  joint swing : revolute body -> bar about line(at = [0, 0, 0], along = z) range 0deg .. 90deg
  part crate : Cuboid(size = [4cm, 4cm, 4cm])
  align crate.bottom = body.top + 1mm
  align crate.center.y = -20cm
  align crate.center.x = -20cm
  joint slide : prismatic body -> crate along y range 0cm .. 40cm
  part wall : Cuboid(size = [4cm, 4cm, 4cm])
  connect wall.bottom on body.top
  align wall.center.y = 10cm
  align wall.center.x = -20cm
"""


def test_a_collision_names_parts_place_and_value() -> None:
    pairs = {pair.joint: pair for pair in find_evidence(program(CRANE).batch(np.arange(2), 0), 0).pairs}
    bar, crate = pairs["swing"].example, pairs["slide"].example
    assert bar.parts == ("bar", "post") and crate.parts == ("wall", "crate") and bar.object == crate.object == 0
    first = np.pi / 4 - np.arcsin(
        0.01 / np.hypot(0.11, 0.11)
    )  # where the side of the bar reaches the corner of the post
    assert first <= bar.value < first + np.pi / 2 / 64 and bar.at[:2] == pytest.approx((0.1, 0.12), abs=0.02)
    assert crate.value == pytest.approx(0.2625, abs=0.01) and crate.at[1] == pytest.approx(0.08, abs=0.01)


def test_what_cannot_be_made_names_the_parts() -> None:
    from artipg_dsl.errors import NoObject
    from artipg_dsl.run.job import prepare
    from artipg_dsl.run.request import Request

    with pytest.raises(NoObject) as caught:
        prepare(program(CRANE), Request("crane")).batch(np.arange(1))
    assert "`bar` and `post` at " in caught.value.message and "in object 0" in caught.value.message


def test_points_common_to_bodies() -> None:
    from artipg_dsl.geometry.collide import Corners, common_point

    cube = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], dtype=float)
    first = np.stack([cube, cube, cube])
    second = np.stack([cube + (0.9, 0.9, 0.2), cube * 0.1 + 0.4, cube + (3, 0, 0)])
    at = common_point(Corners(first), Corners(second))
    for k in range(2):
        for body in (first, second):
            assert ((at[k] >= body[k].min(axis=0) - 1e-9) & (at[k] <= body[k].max(axis=0) + 1e-9)).all()
    assert at[2, 0] == pytest.approx(2.0)


@pytest.mark.parametrize("name", ["Laptop", "Microwave", "WashingMachine"])
def test_boxes_about_many_pieces_rule_out_none_that_meet(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Joints that go farther than they may; with the pieces asked one by one the same meet."""
    batch = Session.of(name).sampler.batch(np.arange(6), 5)
    joint, table = np.random.default_rng(2), []
    tree = Tree(batch)
    width = tree.high - tree.low
    tree.low, tree.high = tree.low - 0.5 * joint.random(len(width)) * width, tree.high + 0.5 * width
    for many in (turns._MANY, 1, 10**9):
        monkeypatch.setattr(turns, "_MANY", many)
        hits = find_collisions(batch, tree)
        table.append(np.stack([hits.owner, hits.first, hits.second, hits.joint, hits.value], axis=1).tolist())
    assert table[0] == table[1] == table[2] and len(table[0]) > 0
